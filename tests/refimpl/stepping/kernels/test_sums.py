"""Sums with the same bits in Python and within a compiled loop."""

import numpy as np

from refimpl.compilation import compiled
from refimpl.stepping.kernels.sums import add_to, kick_drift, sum_of_squares


def test_sums_are_added_up_in_order() -> None:
    values = np.random.default_rng(1).normal(size=1001)
    total = 0.0
    for value in values.tolist():
        total += value * value
    assert sum_of_squares(values) == total
    assert sum_of_squares(values[:0]) == 0.0


def test_sums_of_arrays_are_those_of_numpy_and_of_the_compiled_loop() -> None:
    r, v, a = np.random.default_rng(2).normal(size=(3, 37))
    v_half, moved = kick_drift(r, v, a, 0.3)
    assert (v_half == v + 0.5 * 0.3 * a).all()
    assert (moved == r + 0.3 * v_half).all()
    assert all((one == other).all() for one, other in zip((v_half, moved), _in_a_loop(r, v, a, 0.3), strict=True))
    there = v_half.copy()
    assert add_to(there, 0.2, a) is there
    assert (there == v_half + 0.2 * a).all()
    assert (there == _added(v_half.copy(), 0.2, a)).all()


@compiled()
def _in_a_loop(r, v, a, dt):  # type: ignore[no-untyped-def]
    return kick_drift(r, v, a, dt)


@compiled()
def _added(x, factor, y):  # type: ignore[no-untyped-def]
    return add_to(x, factor, y)
