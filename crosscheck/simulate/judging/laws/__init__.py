"""The laws, one file each, with a tuple `LAWS`; a law is found by its file being there."""

from __future__ import annotations

import importlib
import pkgutil

from crosscheck.simulate.judging.law import Law


def all_laws() -> tuple[Law, ...]:
    """All laws, in the order of their files' names."""
    found: list[Law] = []
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda module: module.name):
        found += importlib.import_module(f"{__name__}.{module.name}").LAWS
    return tuple(found)
