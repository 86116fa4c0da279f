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


def kick_drift(r: Any, v: Any, a: Any, dt: float) -> tuple[Any, Any]:
    """v + dt a/2 and r + dt (v + dt a/2), new; of arrays of one shape, or of coordinates in registers.

    In compiled code one loop: numba makes vector instructions of that, and none of expressions of arrays.
    """
    v_half = v + 0.5 * dt * a
    return v_half, r + dt * v_half


@overload(kick_drift, strict=False)
def _choose_kick_drift(r: Any, v: Any, a: Any, dt: Any) -> Callable[..., Any]:
    if isinstance(r, Coordinates):

        def in_registers(r, v, a, dt):  # type: ignore[no-untyped-def]
            v_half = v + 0.5 * dt * a
            return v_half, r + dt * v_half

        return in_registers

    def in_a_loop(r, v, a, dt):  # type: ignore[no-untyped-def]
        v_half, r_new, half = np.empty_like(v), np.empty_like(r), 0.5 * dt
        for q in range(r.size):
            v_half[q] = v[q] + half * a[q]
            r_new[q] = r[q] + dt * v_half[q]
        return v_half, r_new

    return in_a_loop


def add_to(x: Any, factor: float, y: Any) -> Any:
    """x + factor y, in the place of the array x, which nobody else may need: that is in the cache, a new one is not.

    Of coordinates in registers: a new value.
    """
    x += factor * y
    return x


@overload(add_to, strict=False)
def _choose_addition(x: Any, factor: Any, y: Any) -> Callable[..., Any]:
    if isinstance(x, Coordinates):
        return lambda x, factor, y: x + factor * y

    def in_a_loop(x, factor, y):  # type: ignore[no-untyped-def]
        for q in range(x.size):
            x[q] += factor * y[q]
        return x

    return in_a_loop
