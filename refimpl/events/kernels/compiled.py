"""How the functions of event-driven dynamics are compiled.

All kinds do without numba's counting of references: the arrays belong to the caller, and the event loop allocates
nothing. Counting costs the loop a quarter of its speed. A division by zero gives an infinity, as in numpy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

from refimpl.compilation import compiled

_F = TypeVar("_F", bound=Callable[..., Any])

_ALL: dict[str, Any] = {"_nrt": False, "no_cfunc_wrapper": True}
#: Options of a function that is always inlined.
INLINE: dict[str, Any] = {**_ALL, "error_model": "numpy", "forceinline": True}
#: The same without an entry for Python, which would have to unpack whole records: a third of the time of compilation.
INTERNAL: dict[str, Any] = {**INLINE, "no_cpython_wrapper": True}


def kernel(function: _F) -> _F:
    """Compiled on its own, and kept on disk."""
    return compiled(cache=True, **_ALL)(function)


def inline(function: _F) -> _F:
    """Always inlined; an argument that is `None` prunes the branches that test it."""
    return cast(_F, njit(**INLINE)(function))


def inline_internal(function: _F) -> _F:
    """As `inline`, for compiled callers only: a call from Python crashes the process."""
    return cast(_F, njit(**INTERNAL)(function))
