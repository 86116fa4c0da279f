"""Engines by name: entry points of group `crosscheck.engines`, or a class in a file, `path.py:Class`."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from crosscheck.engines.protocol import Engine
from crosscheck.errors import UsageError

GROUP = "crosscheck.engines"


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
        return _from_file(name)
    if name in _installed():
        found: type[Engine] = _installed()[name].load()
        return found
    raise UsageError(f"unknown engine '{name}'; known: {', '.join(engine_names())}; or give path.py:Class")


def load_engine(name: str) -> Engine:
    """An instance of the engine. name, UsageError: as in `engine_class`."""
    return engine_class(name)()


def _from_file(name: str) -> type[Engine]:
    file, _, class_name = name.rpartition(":")
    path = Path(file).resolve()
    if not path.is_file():
        raise UsageError(f"engine '{name}': there is no file {file}")
    spec = importlib.util.spec_from_file_location(f"crosscheck_engine_{path.stem}", path)
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
