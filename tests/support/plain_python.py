"""Modules whose kernels run as plain Python in this process, beside the compiled ones.

For scenes so small that compiling takes longer than running; `refimpl.compilation` says how one text runs both ways.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

#: Their classes and kernels exist twice, as all modules that import them at their top.
_TWICE = ("refimpl", *(path.stem for path in Path(__file__).parent.glob("*.py") if path != Path(__file__)))

_plain: dict[str, ModuleType] = {}


@contextmanager
def _swapped() -> Iterator[None]:
    """While this lasts, imports are of the plain modules."""
    from numba import config  # not before tests/conftest.py has said where kernels are kept

    compiled = {name: sys.modules.pop(name) for name in list(sys.modules) if name.partition(".")[0] in _TWICE}
    before, config.DISABLE_JIT = config.DISABLE_JIT, 1
    sys.modules.update(_plain)
    try:
        # the first import turns numpy's warnings off
        with np.errstate():
            yield
    finally:
        config.DISABLE_JIT = before
        for name in list(sys.modules):
            if name.partition(".")[0] in _TWICE:
                _plain[name] = sys.modules.pop(name)
        sys.modules.update(compiled)


def plain_python(name: str) -> ModuleType:
    """The module `name` of `refimpl` or of tests/support as plain Python; the same one at each call."""
    with _swapped():
        return import_module(name)
