"""The frequency that velocity Verlet gives a swing, found from its samples."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.checks.granular.mindlin_stiffness import _DT, _frequency_squared


@pytest.mark.parametrize("square", [100.0, 2000.0, 1e5])
def test_frequency_of_a_stepped_swing(square: float) -> None:
    x, v, a = 0.3, 1.0, -square * 0.3
    found = []
    for _ in range(100):
        found.append(v)
        v += 0.5 * _DT * a
        x += _DT * v
        a = -square * x
        v += 0.5 * _DT * a
    assert _frequency_squared(np.array(found)) == pytest.approx(square, rel=1e-8)
    # not that of the exact swing, whose phase is ahead by (w dt)^2/24
    exact = np.cos(math.sqrt(square) * _DT * np.arange(100))
    assert _frequency_squared(exact) == pytest.approx(2 * (1 - math.cos(math.sqrt(square) * _DT)) / _DT**2, rel=1e-8)
