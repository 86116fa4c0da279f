"""Files and directories of the user: what cannot be read or written is refused in one line, before a run."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from crosscheck.errors import UsageError
from crosscheck.text import printable

_KINDS = {
    stat.S_IFDIR: "a directory",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def shown_path(path: str | Path) -> str:
    """The path as messages show it, on one line. path: of any file."""
    return printable(str(path))


def unreadable(path: Path) -> str:
    """Why a file cannot be read, in a few words; "" if it can, as far as this is known without opening it.

    Only a regular file can: a pipe would block, and a device need not end. path: of the file.
    """
    try:
        kind = stat.S_IFMT(path.stat().st_mode)
    except OSError as error:
        return error.strerror or "no such file"
    except ValueError:  # a null character, or a surrogate that stands for no byte
        return "it cannot be the name of a file"
    if kind != stat.S_IFREG:
        return f"it is {_KINDS.get(kind, 'no regular file')}"
    return "" if os.access(path, os.R_OK) else "Permission denied"


def refuse_unwritable(path: Path) -> None:
    """UsageError if a file cannot be written here, as far as this is known beforehand. Nothing is made or changed.

    path: of the file, which need not exist, nor its directories.
    """
    found = _status(path)
    if found is not None:
        if stat.S_ISDIR(found.st_mode):
            raise UsageError(f"{shown_path(path)}: is a directory, and a file is to be written: give another path")
        if not os.access(path, os.W_OK):
            raise UsageError(f"{shown_path(path)}: cannot be written (permission denied): give another path")
        return
    refuse_no_directory(path.parent, path.name)


def refuse_no_directory(path: Path, what: str) -> None:
    """UsageError if files cannot be written in this directory, as far as this is known beforehand.

    path: of the directory. It need not exist if it can be made. what: is to be written in it.
    """
    for place in (path, *path.parents):
        found = _status(place)
        if found is None:
            continue
        if not stat.S_ISDIR(found.st_mode):
            raise UsageError(
                f"{shown_path(path)}: cannot be a directory for {what} ({shown_path(place)} is a file): take another"
            )
        if not os.access(place, os.W_OK | os.X_OK):
            raise UsageError(
                f"{shown_path(path)}: no place for {what} (permission denied in {shown_path(place)}): give another path"
            )
        return


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Gives an OSError within the block the name of the file that is written, where it has none, as of a full disk.

    path: of the file.
    """
    try:
        yield
    except OSError as error:
        if error.filename is None:
            error.filename = str(path)
        raise


def _status(path: Path) -> os.stat_result | None:
    """What the system says of a path; None if there is nothing. UsageError for a path that cannot be one."""
    try:
        return path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise UsageError(f"{shown_path(path)}: {error.strerror}; give another path") from None
    except ValueError:  # a null character, or a surrogate that stands for no byte
        raise UsageError(f"{shown_path(path)}: cannot be the name of a file; give another path") from None
