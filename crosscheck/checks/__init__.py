"""Checks: one module per phenomenon, each with a tuple `CHECKS`. A new module is found by being here."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from crosscheck.checks.base import Check


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every module of this package, by name."""
    found: list[Check] = []
    for module in pkgutil.iter_modules(__path__):
        if module.name != "base":
            found += importlib.import_module(f"{__name__}.{module.name}").CHECKS
    return tuple(sorted(found, key=lambda check: check.name))
