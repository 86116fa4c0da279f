"""The output directory of a run: made if need be, and used by one run at a time."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from crosscheck.errors import UsageError

#: Held for as long as a run writes to the directory; removed at its end.
LOCK = ".crosscheck-lock"


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Makes the output `directory` if need be, and keeps other runs out of it for the `with` block.

    The lock is one of the operating system (`flock`), which ends with the process that holds it, however that ends: a
    lock file that a killed run leaves behind keeps nobody out. A directory that was made, and stays empty, is removed.
    UsageError if another run is in there, or if the directory cannot be made or written to.
    """
    new = not os.path.exists(directory)  # not Path.exists, which raises for names that are too long
    try:
        directory.mkdir(parents=True, exist_ok=True)
        descriptor = _lock(directory / LOCK)
    except BlockingIOError:
        holder = _holder(directory / LOCK)
        raise UsageError(
            f"{directory}: {holder} is writing to it; wait for its end, or give another directory with --out"
        ) from None
    except OSError as error:
        raise UsageError(
            f"{directory}: cannot be a directory for the record and other output ({error.strerror})"
        ) from None
    try:
        yield
    finally:
        # while it is still held: nobody else can then hold a lock on the file that goes
        with suppress(OSError):
            (directory / LOCK).unlink(missing_ok=True)
        os.close(descriptor)
        if new:
            with suppress(OSError):  # it is not empty
                directory.rmdir()


def _lock(path: Path) -> int:
    """A descriptor of the file at `path`, which this process alone has locked; BlockingIOError if another one has."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(descriptor, path):
                os.truncate(descriptor, 0)
                os.write(descriptor, str(os.getpid()).encode())
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # the run before removed this file between the two calls


def _is_at(descriptor: int, path: Path) -> bool:
    """Whether the open file is still the one at `path`."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path, follow_symlinks=False))
    except FileNotFoundError:
        return False


def _holder(path: Path) -> str:
    """Who holds the lock, as far as its file tells."""
    try:
        number = path.read_text(encoding="ascii", errors="replace").strip()
    except OSError:
        number = ""
    return f"another run (process {number})" if number.isdigit() else "another run"
