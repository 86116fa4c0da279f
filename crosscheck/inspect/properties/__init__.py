"""The properties of a trajectory, a file each; one is found by being here, with its record `PROPERTY`."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from crosscheck.inspect.property import CHAPTERS, Property


def properties() -> list[Property]:
    """All properties, by chapters, and in a chapter by the names of their files."""
    modules = (import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__))
    found: list[Property] = [module.PROPERTY for module in sorted(modules, key=lambda module: module.__name__)]
    return sorted(found, key=lambda one: CHAPTERS.index(one.chapter))
