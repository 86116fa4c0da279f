"""How the functions inside the kernels of time-step-driven dynamics are compiled.

A division by zero gives an infinity, as in numpy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

_F = TypeVar("_F", bound=Callable[..., Any])

#: No entries for Python and C: they would take as long again to compile.
INTERNAL: dict[str, Any] = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def internal(function: _F) -> _F:
    """For compiled callers only: a call from Python crashes the process."""
    return cast(_F, njit(**INTERNAL)(function))


def inline_internal(function: _F) -> _F:
    """As `internal`, and always inlined."""
    return cast(_F, njit(forceinline=True, **INTERNAL)(function))
