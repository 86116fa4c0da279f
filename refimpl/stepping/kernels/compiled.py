"""How the functions inside the kernels of time-step-driven dynamics are compiled.

A division by zero gives an infinity, as in numpy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit

_F = TypeVar("_F", bound=Callable[..., Any])

#: No entries for Python and C: they would take as long again to compile.
INTERNAL: dict[str, Any] = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def internal(function: _F) -> _F:
    """For compiled callers only: a call from Python crashes the process. It may make arrays whoever calls it."""
    return cast(_F, njit(_nrt=True, **INTERNAL)(function))


def inline_internal(function: _F) -> _F:
    """As `internal`, and always inlined."""
    return cast(_F, njit(forceinline=True, **INTERNAL)(function))


@inline_internal
def at(i: int) -> Any:
    """The index i, which the caller knows not to be negative: numba would look whether it counts from the end."""
    return np.uint64(i)


def piece_of_work(function: _F) -> _F:
    """As `internal`, for what threads call again and again: it counts no references to arrays.

    Two atomic additions for each array that it gets would be half a microsecond, and threads would contend for them. So
    it may neither make arrays nor return one, and nothing that is inlined in it may.
    """
    return cast(_F, njit(_nrt=False, **INTERNAL)(function))


def inline_piece_of_work(function: _F) -> _F:
    """As `piece_of_work`, and always inlined."""
    return cast(_F, njit(forceinline=True, _nrt=False, **INTERNAL)(function))
