"""Where compiled kernels are kept: a directory that belongs to exactly these sources of `refimpl`."""

from __future__ import annotations

import fcntl
import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def kernel_cache(directory: Path | None = None) -> Path:
    """A writable directory for numba's cache, by default under the user's own, named by the content of `refimpl`.

    numba looks only at the time stamp of a kernel's own file, not at the functions that it calls: it would serve stale
    kernels after a change elsewhere. A name from the content of all sources cannot.
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
    """Lets one worker at a time compile `what`: the others wait, and then load it from the cache.

    The lock is a file in numba's cache directory; without one, nothing is shared and nothing is locked.
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
