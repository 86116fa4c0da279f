"""The directory of compiled kernels, and the lock that keeps two workers from compiling the same one."""

import subprocess
import sys
from pathlib import Path

import pytest

from crosscheck.engines.workers.cache import kernel_cache, one_at_a_time

TRY = """
import fcntl, pathlib, sys
for path in pathlib.Path(sys.argv[1]).glob("*.lock"):
    with path.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            print("free")
        except BlockingIOError:
            print("held")
"""


def _state(directory: Path) -> list[str]:
    done = subprocess.run([sys.executable, "-c", TRY, str(directory)], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_the_lock_keeps_other_processes_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    with one_at_a_time("a kernel"):
        assert _state(tmp_path / "kernels") == ["held"]
    assert _state(tmp_path / "kernels") == ["free"]


def test_without_a_shared_cache_nothing_is_locked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    with one_at_a_time("a kernel"):
        assert not list(tmp_path.iterdir())


def test_the_cache_is_named_by_the_sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = kernel_cache()
    assert first == kernel_cache()
    assert first.is_dir()
    package = tmp_path / "refimpl"
    package.mkdir()
    (package / "one.py").write_text("x = 1\n")
    monkeypatch.setattr("refimpl.__path__", [str(package)])
    changed = kernel_cache()
    assert changed != first
    (package / "one.py").write_text("x = 2\n")
    assert kernel_cache() != changed


def test_a_home_that_cannot_be_written_is_no_obstacle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert kernel_cache().is_dir()
