"""Sums that have the same bits in plain Python, as at the start of a run, and within compiled loops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.extending import overload

from refimpl.compilation import compiled
from refimpl.stepping.kernels.registers import Coordinates


@compiled(cache=True)
def sum_of_squares(x: np.ndarray) -> float:
    """The sum of x^2, added up in the order of the array `x`: numpy's own sum adds parts of it first."""
    total = 0.0
    for value in x:
        total += value * value
    return total


@compiled(cache=True)
def sum_in_order(x: np.ndarray) -> float:
    """The sum of the array `x`, added up in its order."""
    total = 0.0
    for value in x:
        total += value
    return total


def add_scaled(x: Any, factor: float, y: Any) -> Any:
    """x + factor y of two arrays of one shape, or of coordinates in registers; new.

    In compiled code a loop: numba makes vector instructions of that, and none of an expression of arrays.
    """
    return x + factor * y


@overload(add_scaled, strict=False)
def _choose_sum(x: Any, factor: Any, y: Any) -> Callable[..., Any]:
    if isinstance(x, Coordinates):
        return lambda x, factor, y: x + factor * y

    def in_a_loop(x, factor, y):  # type: ignore[no-untyped-def]
        total = np.empty_like(x)
        for q in range(x.size):
            total[q] = x[q] + factor * y[q]
        return total

    return in_a_loop
