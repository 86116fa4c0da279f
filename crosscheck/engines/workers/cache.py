"""The directory of compiled kernels, one for each state of the sources of `refimpl`, and the care it needs.

numba loads what it finds there as code: so it must be nobody else's to write. What is damaged is compiled again.
"""

from __future__ import annotations

import atexit
import fcntl
import hashlib
import os
import pickle
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

#: Bytes of the hash that follows what is stored of a kernel.
_HASH_BYTES = hashlib.sha256().digest_size


def kernel_cache(directory: Path | None = None) -> Path:
    """A writable directory for numba's cache.

    directory: returned as it is; None: a directory in the user's cache directory, or else in that of temporary files,
    whose name is a hash of all sources of `refimpl`. numba compares only the time stamp of a kernel's own file, so it
    would load a stale kernel after a change in a function that the kernel calls; with a new name it cannot.

    A directory that others could write to is not used, see `refusal_of`, and stderr says so. If no place is left, the
    directory is a new one, which is removed when this process ends.
    """
    if directory is not None:
        return directory
    import refimpl

    sources = Path(refimpl.__path__[0])
    digest = hashlib.sha256()
    for file in sorted(sources.rglob("*.py")):
        digest.update(file.relative_to(sources).as_posix().encode() + file.read_bytes())
    for place in _places():
        found = _usable(place, digest.hexdigest()[:16])
        if found is not None:
            return found
    return _of_this_session()


def _places() -> Iterator[Path]:
    """Where the caches of a user may be, the best place first. A relative XDG_CACHE_HOME is ignored, as XDG says."""
    home = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(home):
        yield Path(home) / "particle-crosscheck"
    else:
        with suppress(RuntimeError):  # there is no home
            yield Path.home() / ".cache" / "particle-crosscheck"
    with suppress(OSError):  # there is no directory of temporary files
        yield Path(tempfile.gettempdir()).absolute() / f"particle-crosscheck-{os.geteuid()}"


def _usable(place: Path, name: str) -> Path | None:
    """The directory of this name in `place`, made if it is not there; None if we, or not we alone, can write to it."""
    directory = place / name
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        for one in (place, directory):
            one.mkdir(mode=0o700, exist_ok=True)
            refusal = refusal_of(one)
            if refusal is not None:
                _tell(f"crosscheck: compiled kernels in {one} are not used: {refusal}")
                return None
            if stat.S_IMODE(one.stat().st_mode) != 0o700:
                one.chmod(0o700)
        with tempfile.TemporaryFile(dir=directory) as probe:
            probe.write(b"x")
            probe.flush()
    except OSError:
        return None
    return directory


def refusal_of(directory: Path) -> str | None:
    """None, or why what is in this directory may have been put there by another user.

    directory: an absolute path. It must be a directory of this user's own that no other user can write to. So must the
    ones above it, which may also be root's, or sticky, as /tmp is: there, nobody renames what is another's.
    """
    state = os.lstat(directory)
    if not stat.S_ISDIR(state.st_mode):
        return "it is no directory, but a link or a file: remove it"
    if state.st_uid != os.geteuid():
        return f"it belongs to user {state.st_uid}: remove it, or set XDG_CACHE_HOME"
    if state.st_mode & 0o022:
        return f"other users can write to it: remove it, or chmod 700 it if all in it is yours ({directory})"
    for above in {*directory.parents, *directory.resolve().parents}:
        state = os.lstat(above)
        if state.st_uid not in (0, os.geteuid()):
            return f"{above} belongs to user {state.st_uid}: set XDG_CACHE_HOME to a directory of your own"
        open_to_all = state.st_mode & stat.S_IWOTH and not stat.S_ISLNK(state.st_mode)
        if open_to_all and not state.st_mode & stat.S_ISVTX:
            return f"all users can write to {above}: set XDG_CACHE_HOME to a directory of your own"
    return None


@cache
def _tell(message: str) -> None:
    """Prints the message to stderr, once."""
    print(message, file=sys.stderr, flush=True)


@cache
def _of_this_session() -> Path:
    """A new directory, which is removed at the end of this process."""
    directory = Path(tempfile.mkdtemp(prefix="crosscheck-kernels-"))
    atexit.register(shutil.rmtree, directory, ignore_errors=True)
    return directory


@contextmanager
def one_at_a_time(what: str) -> Iterator[None]:
    """Lets one worker at a time compile a kernel: the others wait, and then load it from the cache.

    what: name of the kernel. The lock is a file in numba's cache directory; without NUMBA_CACHE_DIR no cache is shared,
    and nothing is locked.
    """
    take_care_of_damage()
    directory = os.environ.get("NUMBA_CACHE_DIR")
    if directory is None:
        yield
        return
    name = hashlib.sha256(what.encode()).hexdigest()[:16]
    with ExitStack() as stack:
        with suppress(OSError):  # where no lock can be had, a kernel may be compiled twice
            Path(directory).mkdir(parents=True, exist_ok=True)
            file = stack.enter_context((Path(directory) / f"{name}.lock").open("w"))
            fcntl.flock(file, fcntl.LOCK_EX)  # released when the file closes, or its process ends
        yield


@cache
def take_care_of_damage() -> None:
    """Makes numba compile again what it cannot read from its cache, and go on where it cannot write to it.

    numba itself fails on a truncated file, and runs machine code in which a bit is wrong. So what is stored ends with
    its hash, and what does not is not loaded; a file is written again when its kernel is compiled again.
    """
    from numba.core import caching

    files, functions = caching.IndexDataCacheFile, caching.Cache
    dump, save_overload = files._dump, functions.save_overload

    def dump_with_hash(self: Any, obj: Any) -> bytes:
        stored: bytes = dump(self, obj)
        return stored + hashlib.sha256(stored).digest()

    def load_index(self: Any) -> dict[Any, str]:
        with suppress(Exception), open(self._index_path, "rb") as file:
            if pickle.load(file) == self._version:
                stamp, overloads = _intact(file.read())
                if stamp == self._source_stamp:
                    return dict(overloads)
        return {}

    def load(self: Any, key: Any) -> Any:
        name = self._load_index().get(key)
        with suppress(Exception):
            return None if name is None else _intact(Path(self._data_path(name)).read_bytes())
        return None

    def save(self: Any, sig: Any, data: Any) -> None:
        with suppress(OSError):
            save_overload(self, sig, data)

    for owner, name, method in (
        (files, "_dump", dump_with_hash),
        (files, "_load_index", load_index),
        (files, "load", load),
        (functions, "save_overload", save),
    ):
        setattr(owner, name, method)


def _intact(stored: bytes) -> Any:
    """The object that is stored; ValueError if the hash at its end is not that of what is before it."""
    content, digest = stored[:-_HASH_BYTES], stored[-_HASH_BYTES:]
    if hashlib.sha256(content).digest() != digest:
        raise ValueError("a damaged file of compiled kernels")
    return pickle.loads(content)
