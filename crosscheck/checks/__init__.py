"""Checks: a folder per group, a file per phenomenon, each with a tuple `CHECKS`. A new file is found by being there.

A check is called `group/phenomenon`, and lives in the folder of its group.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from crosscheck.checks.base import Check


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of every file of the groups' folders, by name."""
    found: list[Check] = []
    for module in pkgutil.walk_packages(__path__, f"{__name__}."):
        if not module.ispkg:
            found += getattr(importlib.import_module(module.name), "CHECKS", ())
    return tuple(sorted(found, key=lambda check: check.name))
