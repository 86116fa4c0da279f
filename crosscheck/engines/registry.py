"""Engines by name: entry points of group `crosscheck.engines`, or a class in a file, `path.py:Class`."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from crosscheck.engines.protocol import Engine
from crosscheck.errors import UsageError

GROUP = "crosscheck.engines"
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
    """The class of an engine.

    name: of an installed engine, or `path.py:Class`. UsageError if there is no such engine, or if the file cannot be
    imported, has no such class, or the class lacks a member of `Engine`.
    """
    if ".py:" in name:
        with _neighbours(_file(name).parent):
            return _from_file(name)
    if name in _installed():
        found: type[Engine] = _installed()[name].load()
        return found
    raise UsageError(f"unknown engine '{name}'; known: {', '.join(engine_names())}; or give path.py:Class")


def load_engine(name: str) -> Engine:
    """An instance of the engine. name, UsageError: as in `engine_class`.

    Modules beside an engine's file can be imported by its methods too: this process is that engine's alone.
    """
    if ".py:" in name:
        sys.path.insert(0, str(_file(name).parent))
        return _from_file(name)()
    return engine_class(name)()


def _file(name: str) -> Path:
    """The file of the engine `path.py:Class`."""
    return Path(name.rpartition(":")[0]).resolve()


@contextmanager
def _neighbours(directory: Path) -> Iterator[None]:
    """Modules in this directory can be imported in the `with` block, and are forgotten after it.

    A file of the same name beside another engine is another module.
    """
    before = set(sys.modules)
    sys.path.insert(0, str(directory))
    try:
        yield
    finally:
        sys.path.remove(str(directory))
        for name in set(sys.modules) - before:
            place = getattr(sys.modules[name], "__file__", None)
            if place and not name.startswith(_MODULE) and directory in Path(place).resolve().parents:
                del sys.modules[name]


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
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise UsageError(f"engine '{name}': {file} cannot be imported ({type(error).__name__}: {error})") from None
    found = getattr(module, class_name, None)
    if not isinstance(found, type):
        raise UsageError(f"engine '{name}': {file} has no class {class_name}")
    for member in ("name", "schemes", "capabilities", "version", "supports", "run"):
        if not hasattr(found, member):
            raise UsageError(f"engine '{name}': class {class_name} lacks '{member}' (see docs/engines.md)")
    return found
