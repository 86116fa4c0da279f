"""The directory of compiled kernels, one for each state of the sources of `refimpl`."""

from __future__ import annotations

import fcntl
import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def kernel_cache(directory: Path | None = None) -> Path:
    """A writable directory for numba's cache.

    directory: returned as it is; None: a directory in the user's cache directory, or else in that of temporary files,
    whose name is a hash of all sources of `refimpl`. numba compares only the time stamp of a kernel's own file, so it
    would load a stale kernel after a change in a function that the kernel calls; with a new name it cannot.
    """
    if directory is not None:
        return directory
    import refimpl

    sources = Path(refimpl.__path__[0])
    digest = hashlib.sha256()
    for file in sorted(sources.rglob("*.py")):
        digest.update(file.relative_to(sources).as_posix().encode() + file.read_bytes())
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    cache = home / "particle-crosscheck" / digest.hexdigest()[:16]
    try:
        cache.mkdir(parents=True, exist_ok=True)
    except OSError:
        cache = Path(tempfile.gettempdir()) / f"particle-crosscheck-{os.getuid()}" / digest.hexdigest()[:16]
        cache.mkdir(parents=True, exist_ok=True)
    return cache


@contextmanager
def one_at_a_time(what: str) -> Iterator[None]:
    """Lets one worker at a time compile a kernel: the others wait, and then load it from the cache.

    what: name of the kernel. The lock is a file in numba's cache directory; without NUMBA_CACHE_DIR no cache is shared,
    and nothing is locked.
    """
    directory = os.environ.get("NUMBA_CACHE_DIR")
    if directory is None:
        yield
        return
    Path(directory).mkdir(parents=True, exist_ok=True)
    name = hashlib.sha256(what.encode()).hexdigest()[:16]
    with (Path(directory) / f"{name}.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # released when the file closes, or its process ends
        yield
