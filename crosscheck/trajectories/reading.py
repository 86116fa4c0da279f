"""Opens result files, whatever program wrote them: trajectories as a `Source`, tables in time as a `Series`."""

from __future__ import annotations

import warnings
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

from crosscheck.errors import UsageError
from crosscheck.files import shown_path, unreadable
from crosscheck.trajectories import readers
from crosscheck.trajectories.frames import Series, Source, first_line

#: What a file holds, as it is preferred where a directory has several: a trajectory, one frame, a table in time.
_KINDS = ("frames", "frame", "table")


def formats() -> list[ModuleType]:
    """The readers: modules with FORMAT, its name; HOLDS, one of `_KINDS`; knows(path); open_file(path, topology).

    In the order of their names. A reader is found by being in the folder `readers`.
    """
    return [
        import_module(f"{readers.__name__}.{module.name}")
        for module in sorted(iter_modules(readers.__path__), key=lambda module: module.name)
        if not module.name.startswith("_")
    ]


def reader_of(path: Path) -> ModuleType | None:
    """The reader that knows a file; None if there is none. path: of a regular file."""
    return next((reader for reader in formats() if reader.knows(path)), None)


def open_results(path: Path, topology: Path | None = None) -> Source | Series:
    """Opens a file of results.

    path: of the file. topology: a file with the masses and types of the particles, for formats that hold coordinates
    alone (XTC, TRR, DCD ...); None: there is none. UsageError, of one line, if it cannot be read, or its format is none
    of those known.
    """
    for file in (path,) if topology is None else (path, topology):
        reason = unreadable(file)
        if reason:
            raise UsageError(f"{shown_path(file)}: cannot be read ({reason}): give a file of results")
    reader = reader_of(path)
    if reader is None:
        names = ", ".join(reader.FORMAT for reader in formats())
        raise UsageError(f"{shown_path(path)}: none of the formats that are read: {names}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of libraries, on what is not asked for
            return reader.open_file(path, topology)
    except (UsageError, MemoryError):
        raise
    except Exception as error:  # the libraries raise what they like for a damaged file
        raise UsageError(f"{shown_path(path)}: cannot be read as {reader.FORMAT} ({first_line(error)})") from None


def results_in(path: Path) -> Path:
    """The file of results that a path names: itself, or that in a directory.

    In a directory: arrays-*.npz of `simulate`; without it, the trajectory; without one, a file of one frame; else a
    table. path: of a file or a directory. UsageError if there is none of these in it, or if there are several.
    """
    if not path.is_dir():
        return path
    files = sorted(file for file in path.iterdir() if file.is_file() and not file.name.startswith("."))
    found = [file for file in files if file.match("arrays-*.npz")]
    held = [(file, _held(file)) for file in files]
    for kind in _KINDS:
        found = found or [file for file, what in held if what == kind]
    if len(found) == 1:
        return found[0]
    names = ", ".join(file.name for file in found[:5])
    reason = f"several files of results ({names}): name one of them" if found else "no file of results in it"
    raise UsageError(f"{shown_path(path)}: {reason}")


def _held(file: Path) -> str:
    """What a file holds; "" if no reader knows it, or if it cannot be read."""
    reader = None if unreadable(file) else reader_of(file)
    return "" if reader is None else reader.HOLDS
