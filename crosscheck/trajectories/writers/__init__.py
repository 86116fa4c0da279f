"""Writers of trajectories: a file a format, whose record is its `FORMAT`. A new file is found by being there."""

from __future__ import annotations

import pkgutil


def names() -> tuple[str, ...]:
    """The names of the formats, those of the files in this folder, sorted."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))
