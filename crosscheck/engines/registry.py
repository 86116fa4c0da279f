"""Engines by name: entry points of group `crosscheck.engines`, or a class in a file, `path.py:Class`."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from crosscheck.engines.protocol import Engine
from crosscheck.engines.workers.border import declared, described
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing, UsageError

GROUP = "crosscheck.engines"
#: Seconds that the import of an engine may take.
_SECONDS_TO_IMPORT = 120.0
#: What the names of the modules of engine files start with.
_MODULE = "crosscheck_engine_"


def engine_names() -> list[str]:
    """Names of the installed engines, the reference implementation first, then in alphabetical order."""
    return sorted(_installed(), key=engine_order)


@cache
def _installed() -> dict[str, EntryPoint]:
    """The entry points of engines, by name; cached, since this reads the metadata of all installed packages."""
    return {point.name: point for point in entry_points(group=GROUP)}


def shipped_engines() -> list[str]:
    """Names of the engines that come with the suite, in the order of `engine_names`."""
    return [name for name in engine_names() if _installed()[name].value.startswith("crosscheck.")]


def engine_order(name: str) -> tuple[bool, str]:
    """Key by which engines are sorted: the reference implementation first. name: of an engine."""
    return name != "refimpl", name


def engine_class(name: str) -> type[Engine]:
    """The class of an engine; of one that does not come with the suite, a class with its declarations alone.

    Code from elsewhere is imported by a worker process, never by the suite's own, whatever it does to its process.

    name: of an installed engine, or `path.py:Class`. UsageError if there is no such engine, or if it cannot be imported
    or does not declare what it should.
    """
    if name in _installed() and name in shipped_engines():
        return load_class(name)
    if ".py:" not in name:
        return _declared(name, 0)
    file = Path(name.rpartition(":")[0])
    return _declared(name, file.stat().st_mtime_ns if file.is_file() else 0)


@cache
def _declared(name: str, changed: int) -> type[Engine]:
    """The declarations of an engine, from a worker process. changed: time of the last change of its file, ns."""
    if ".py:" not in name:
        _entry_point(name)
    worker = Worker(name, time_limit=_SECONDS_TO_IMPORT)
    try:
        return declared(worker.declarations())
    except (EngineError, EngineMissing) as error:
        message = str(error).removeprefix(name).removeprefix(":").strip()
        raise UsageError(f"engine '{name}': {message}") from None
    finally:
        worker.close()


def load_class(name: str) -> type[Engine]:
    """The class itself, with its code; for worker processes.

    name, UsageError: as in `engine_class`; whatever it declares is not looked at. An engine's file can import those
    beside it.
    """
    if ".py:" in name:
        return _from_file(name)
    found: type[Engine] = _entry_point(name).load()
    return found


def _entry_point(name: str) -> EntryPoint:
    if name not in _installed():
        raise UsageError(f"unknown engine '{name}'; known: {', '.join(engine_names())}; or give path.py:Class")
    return _installed()[name]


def _file(name: str) -> Path:
    """The file of the engine `path.py:Class`."""
    return Path(name.rpartition(":")[0]).resolve()


def _from_file(name: str) -> type[Engine]:
    file, _, class_name = name.rpartition(":")
    path = _file(name)
    if not path.is_file():
        raise UsageError(f"engine '{name}': there is no file {file}")
    # files of one name in different directories are different modules
    digest = hashlib.sha256(str(path).encode(errors="surrogateescape")).hexdigest()[:16]
    spec = importlib.util.spec_from_file_location(f"{_MODULE}{digest}_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    sys.path.append(str(path.parent))  # at the end: what lies beside it hides no package
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise UsageError(f"engine '{name}': {file} cannot be imported ({described(error)})") from None
    found = getattr(module, class_name, None)
    if not isinstance(found, type):
        raise UsageError(f"engine '{name}': {file} has no class {class_name}")
    return found
