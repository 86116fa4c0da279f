"""Files that cannot be read or written are known before they are."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from crosscheck.errors import UsageError
from crosscheck.files import naming, refuse_no_directory, refuse_unwritable, unreadable


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "file").write_text("x")
    (tmp_path / "directory").mkdir()
    (tmp_path / "dangling").symlink_to("nowhere")
    (tmp_path / "circle").symlink_to("circle")
    os.mkfifo(tmp_path / "pipe")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("file", ""),
        ("directory", "it is a directory"),
        ("pipe", "it is a pipe"),
        ("/dev/zero", "it is a device"),
        ("dangling", "No such file or directory"),
        ("circle", "Too many levels of symbolic links"),
        ("file/below", "Not a directory"),
        ("x" * 300, "File name too long"),
        ("null\0character", "it cannot be the name of a file"),
        ("\ud800", "it cannot be the name of a file"),
    ],
)
def test_unreadable(place: Path, name: str, reason: str) -> None:
    assert unreadable(place / name) == reason


def test_what_the_user_may_not_read(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert unreadable(place / "file") == "Permission denied"
    with pytest.raises(UsageError, match="file: cannot be written"):
        refuse_unwritable(place / "file")
    with pytest.raises(UsageError, match="no place for the files"):
        refuse_no_directory(place / "new", "the files")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("directory", "directory: is a directory, and a file is to be written"),
        ("file/below", "file: cannot be a directory for below (.*file is a file)"),
        ("file/far/below", "cannot be a directory for below"),
        ("x" * 300, "File name too long"),
        ("null\0character", "cannot be the name of a file"),
    ],
)
def test_unwritable(place: Path, name: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        refuse_unwritable(place / name)


@pytest.mark.parametrize("name", ["file", "new", "directory/new", "far/below/new", "/dev/null"])
def test_writable(place: Path, name: str) -> None:
    before = sorted(place.rglob("*"))
    refuse_unwritable(place / name)
    refuse_no_directory((place / name).parent, "it")
    assert sorted(place.rglob("*")) == before


def test_a_full_disk_has_a_name(place: Path) -> None:
    with (
        pytest.raises(OSError, match=re.escape("[Errno 28] No space left on device: 'here'")),
        naming(Path("here")),
        open("/dev/full", "w") as full,
    ):
        full.write("x")
    with pytest.raises(FileNotFoundError) as error, naming(Path("here")):
        (place / "nowhere").read_bytes()
    assert str(error.value.filename) == str(place / "nowhere")
