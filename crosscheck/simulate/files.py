"""The directory to which a simulation writes: complete results or none, and no files of an earlier one beside them."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from crosscheck.errors import UsageError

#: The list of the files that a simulation wrote, with their hashes.
MANIFEST = "simulate-files.json"
_LONGEST_LABEL = 150


class Results:
    """Where the files of a simulation are prepared, and then put in their place.

    scratch: a directory to write them to. out: the directory in which they end.
    """

    def __init__(self, scratch: Path, out: Path) -> None:
        self.scratch, self._out = scratch, out

    def put(self, files: Sequence[Path]) -> list[Path]:
        """Moves files of `scratch` to `out`, and removes those of the simulation before; returns the new paths.

        files: all that were written. A file with the name of a new one is replaced; a link is replaced too, and what it
        points to is left as it is. Of other files, those are removed that the list of the last simulation names, and
        that have not changed since.
        UsageError if a directory has the name of a file.
        """
        for name in (*(file.name for file in files), MANIFEST):
            place = self._out / name
            if place.is_dir() and not place.is_symlink():
                raise UsageError(
                    f"{place}: is a directory, where a file must be written: move it, or take another --out"
                )
        hashes = {file.name: _hash(file) for file in files}
        with _locked(self._out):
            for name, digest in _manifest(self._out / MANIFEST).items():
                old = self._out / name
                if name not in hashes and old.is_file() and not old.is_symlink() and _hash(old) == digest:
                    old.unlink()
            (self.scratch / MANIFEST).write_text(json.dumps(hashes, indent=1) + "\n", encoding="utf-8")
            # a rename replaces a link, it does not follow it
            (self.scratch / MANIFEST).replace(self._out / MANIFEST)
            for file in files:
                file.replace(self._out / file.name)
        return [self._out / file.name for file in files]


@contextmanager
def results_in(out: Path) -> Iterator[Results]:
    """The results of a simulation for the directory `out`, which is made if it is not there.

    UsageError, before anything is computed, if files cannot be written there.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        scratch = tempfile.TemporaryDirectory(prefix=".simulate-", dir=out)
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written to ({error.strerror}): take another directory") from None
    with scratch as path:
        yield Results(Path(path), out)


@contextmanager
def _locked(directory: Path) -> Iterator[None]:
    """Lets one process at a time put its files into the directory."""
    handle = os.open(directory, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _manifest(path: Path) -> dict[str, str]:
    """Name -> hash of the files of the last simulation; empty if there is no list that can be read."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(found, dict):
        return {}
    return {name: digest for name, digest in found.items() if name == Path(name).name}


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def file_labels(engines: Sequence[str]) -> dict[str, str]:
    """A label for the results of each engine, which can be part of a file's name; no two are equal.

    engines: names, or path.py:Class. Of a file, the label has its name and the class, and as many directories as tell
    it from the others.
    """
    for depth in range(1, 1 + max(len(_parts(engine)) for engine in engines)):
        labels = {engine: clean("-".join(_parts(engine)[-depth:])) for engine in engines}
        if len({label.casefold() for label in labels.values()}) == len(labels):
            return labels
    # names that differ in signs alone, which do not go into a file's name
    return {engine: f"{number}-{clean(_parts(engine)[-1])}" for number, engine in enumerate(engines, 1)}


def _parts(engine: str) -> tuple[str, ...]:
    """The name of an engine; of a file, the parts of its whole path, the last with the class."""
    return Path(os.path.abspath(engine)).parts[1:] if ".py:" in engine else (engine,)


def clean(text: str) -> str:
    """`text` as a part of a file's name, which may have 255 bytes in all; of a longer one, its end."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "-", text)[-_LONGEST_LABEL:]
