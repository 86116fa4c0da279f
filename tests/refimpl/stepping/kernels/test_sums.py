"""Sums with the same bits in Python and within a compiled loop."""

import numpy as np

from refimpl.stepping.kernels.sums import sum_of_squares


def test_sums_are_added_up_in_order() -> None:
    values = np.random.default_rng(1).normal(size=1001)
    total = 0.0
    for value in values.tolist():
        total += value * value
    assert sum_of_squares(values) == total
    assert sum_of_squares(values[:0]) == 0.0
