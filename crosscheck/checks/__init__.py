"""Checks: a folder per group, a file per phenomenon, each with a tuple `CHECKS`. A new file is found by being there.

A check is called `group/phenomenon`, and lives in the folder of its group.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from functools import cache
from types import ModuleType

from crosscheck.checks.base import Check


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every file of the groups' folders, by name."""
    found = [check for module in _modules() for check in getattr(module, "CHECKS", ())]
    return tuple(sorted(found, key=lambda check: check.name))


@cache
def declared_in() -> dict[str, str]:
    """The name of the module whose `CHECKS` holds a check, by the check's name."""
    return {check.name: module.__name__ for module in _modules() for check in getattr(module, "CHECKS", ())}


def _modules() -> Iterator[ModuleType]:
    """Every file of the groups' folders."""
    for module in pkgutil.walk_packages(__path__, f"{__name__}."):
        if not module.ispkg:
            yield importlib.import_module(module.name)
