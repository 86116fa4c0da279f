"""The directory of compiled kernels, and the lock that keeps two workers from compiling the same one."""

import os
import runpy
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from crosscheck.engines.workers import cache
from crosscheck.engines.workers.cache import kernel_cache, one_at_a_time, refusal_of

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


# -- whose it is -------------------------------------------------------------------------------------------------


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The directory of a user's caches, with the directory of temporary files beside it."""
    for function in (cache._tell, cache._of_this_session):
        function.cache_clear()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    temporary.chmod(0o1777)
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    return tmp_path / "home" / "particle-crosscheck"


def test_a_new_cache_is_for_its_user_alone(home: Path) -> None:
    assert kernel_cache().parent == home
    assert home.stat().st_mode & 0o777 == kernel_cache().stat().st_mode & 0o777 == 0o700


def test_a_cache_that_others_can_read_is_closed(home: Path) -> None:
    home.mkdir(parents=True)
    home.chmod(0o755)
    assert kernel_cache().parent == home
    assert home.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("how", ["group", "all", "link", "above"])
def test_a_cache_that_others_can_write_is_not_used(home: Path, how: str, capfd: pytest.CaptureFixture[str]) -> None:
    if how == "link":
        home.parent.mkdir()
        (home.parent / "elsewhere").mkdir(mode=0o700)
        home.symlink_to(home.parent / "elsewhere")
    else:
        home.mkdir(parents=True)
        (home.parent if how == "above" else home).chmod({"group": 0o770, "all": 0o777, "above": 0o777}[how])
    found = kernel_cache()
    assert found.parent == home.parent.parent / "tmp" / f"particle-crosscheck-{os.geteuid()}"
    assert kernel_cache() == found
    said = capfd.readouterr().err
    assert said.count("compiled kernels in") == 1, "it is said, once"
    assert str(home) in said


def test_a_directory_that_waits_under_the_temporary_ones_is_not_used(home: Path) -> None:
    """Its name can be foreseen: whoever makes it first would have their code run."""
    home.parent.write_text("")  # no directory can be made there
    planted = home.parent.parent / "tmp" / f"particle-crosscheck-{os.geteuid()}"
    planted.mkdir()
    planted.chmod(0o777)
    found = kernel_cache()
    assert found.name.startswith("crosscheck-kernels-")
    assert found.stat().st_mode & 0o777 == 0o700
    assert kernel_cache() == found, "one for the whole session"


def test_a_cache_that_cannot_be_written_is_replaced(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a file system that is full or read-only; what is there already is left alone."""
    kept = kernel_cache() / "kernel"
    kept.write_text("as it was")
    write = tempfile.TemporaryFile

    def full(dir: Path) -> Any:
        if dir.is_relative_to(home):
            raise OSError(30, "Read-only file system")
        return write(dir=dir)

    monkeypatch.setattr("tempfile.TemporaryFile", full)
    assert kernel_cache().parent == home.parent.parent / "tmp" / f"particle-crosscheck-{os.geteuid()}"
    assert kept.read_text() == "as it was"


class State(NamedTuple):
    """What `os.lstat` says, as far as it matters here."""

    st_mode: int
    st_uid: int


@pytest.mark.parametrize(
    ("states", "reason"),
    [
        ({}, None),
        ({"/home/me": State(0o040755, 7)}, None),
        ({"/home": State(0o041777, 0)}, None),
        ({"/home/me/kernels": State(0o040700, 8)}, "it belongs to user 8"),
        ({"/home/me/kernels": State(0o040700, 0)}, "it belongs to user 0"),
        ({"/home/me/kernels": State(0o040770, 7)}, "other users can write to it"),
        ({"/home/me/kernels": State(0o120777, 7)}, "no directory, but a link"),
        ({"/home/me": State(0o040700, 8)}, "/home/me belongs to user 8"),
        ({"/home": State(0o040777, 0)}, "all users can write to /home"),
    ],
)
def test_whose_a_directory_must_be(
    states: dict[str, State], reason: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = {"/": State(0o040755, 0), "/home": State(0o040755, 0), "/home/me": State(0o040755, 7)}
    usual |= {"/home/me/kernels": State(0o040700, 7)} | states
    monkeypatch.setattr("os.geteuid", lambda: 7)
    monkeypatch.setattr("os.lstat", lambda path: usual[str(path)])
    monkeypatch.setattr(Path, "resolve", lambda path: path)
    found = refusal_of(Path("/home/me/kernels"))
    assert (found is None) if reason is None else (found is not None and reason in found)


def test_a_relative_cache_home_is_ignored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert kernel_cache().is_relative_to(tmp_path / "home" / ".cache" / "particle-crosscheck")
    assert not (tmp_path / "relative").exists()


# -- damage ------------------------------------------------------------------------------------------------------

KERNEL = """
from numba import njit

@njit(cache=True)
def double(x):
    return x + x
"""
DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "truncated": lambda content: content[: len(content) // 2],
    "without its last byte": lambda content: content[:-1],
    "garbage": lambda content: b"\x80\x04" + bytes(range(256)) * 9,
    "empty": lambda content: b"",
    "a wrong bit": lambda content: content[:-80] + bytes([content[-80] ^ 1]) + content[-79:],
}


@pytest.fixture
def compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], bool]:
    """Calls a kernel as a new process does: True if it was compiled, False if it was loaded."""
    (tmp_path / "kernel.py").write_text(KERNEL)
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path / "kernels"))
    cache.take_care_of_damage()

    def call() -> bool:
        module = runpy.run_path(str(tmp_path / "kernel.py"))
        assert module["double"](21.0) == 42.0
        return not module["double"].stats.cache_hits

    return call


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_kernel_is_compiled_again(
    compiled: Callable[[], bool], tmp_path: Path, suffix: str, damage: str
) -> None:
    assert compiled()
    assert not compiled()
    (kernel,) = (tmp_path / "kernels").rglob(f"*.{suffix}")
    kernel.write_bytes(DAMAGES[damage](kernel.read_bytes()))
    assert compiled()
    assert not compiled(), "and stored again"


def test_a_kernel_that_cannot_be_stored_runs(compiled: Callable[[], bool], monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    assert compiled()
    assert compiled()
