"""Sums that have the same bits in plain Python, as at the start of a run, and within compiled loops."""

from __future__ import annotations

import numpy as np

from refimpl.compilation import compiled


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
