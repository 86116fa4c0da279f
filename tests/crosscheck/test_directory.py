"""One run at a time in an output directory, and no trace of it afterwards."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from crosscheck.directory import LOCK, locked
from crosscheck.errors import UsageError

HOLDER = """
import sys
from pathlib import Path
from crosscheck.directory import locked
with locked(Path(sys.argv[1])):
    print("locked", flush=True)
    sys.stdin.read()
"""


def test_it_is_made_and_unlocked_afterwards(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with locked(out):
        (out / "file").write_text("kept")
    assert [path.name for path in out.iterdir()] == ["file"]
    with locked(out):
        pass
    assert (out / "file").read_text() == "kept"


def test_a_directory_that_stays_empty_does_not_stay(tmp_path: Path) -> None:
    with locked(tmp_path / "out"):
        pass
    assert not (tmp_path / "out").exists()
    (tmp_path / "old").mkdir()
    with locked(tmp_path / "old"):
        pass
    assert (tmp_path / "old").exists()


def test_a_second_run_is_refused_by_the_number_of_the_first(tmp_path: Path) -> None:
    with locked(tmp_path):
        for _ in range(2):  # the refusal does not take the lock away
            with pytest.raises(UsageError, match=f"{tmp_path}: another run .process {os.getpid()}. is writing to it"):
                locked(tmp_path).__enter__()
        link = tmp_path.parent / f"{tmp_path.name}-link"
        link.symlink_to(tmp_path)
        with pytest.raises(UsageError, match="another run"):
            locked(link).__enter__()


def test_the_lock_of_a_killed_run_keeps_nobody_out(tmp_path: Path) -> None:
    words = [sys.executable, "-c", HOLDER, str(tmp_path)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "locked\n"
        with pytest.raises(UsageError, match=f"process {holder.pid}"):
            locked(tmp_path).__enter__()
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    assert (tmp_path / LOCK).exists()
    with locked(tmp_path):
        pass
    assert not (tmp_path / LOCK).exists()


def test_an_exception_unlocks(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), locked(tmp_path):
        raise ZeroDivisionError
    with locked(tmp_path):
        pass


def test_what_cannot_be_a_directory_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file", tmp_path / "file" / "out", tmp_path / ("x" * 300)):
        with pytest.raises(UsageError, match="cannot be a directory for the record and other output"):
            locked(path).__enter__()
