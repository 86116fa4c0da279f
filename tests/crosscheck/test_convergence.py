"""Extrapolation to no step."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.convergence import extrapolate


def test_even_polynomials_are_extrapolated_exactly() -> None:
    steps = 0.1 / np.array([1, 2, 3, 4])
    values = [np.array([1.0 + 3 * h**2 - 50 * h**4 + 7 * h**6, -2.0 + h**2]) for h in steps]
    limit = extrapolate(steps, values)
    assert limit.value == pytest.approx([1.0, -2.0], abs=1e-14)
    assert limit.weights.sum() == pytest.approx(1.0)


def test_the_error_estimate_is_not_too_small() -> None:
    def scheme(n: int) -> float:
        """Velocity Verlet's cosine after one radian: cos(n w), sin(w/2) = h/2."""
        return float(np.cos(2 * n * np.arcsin(0.5 / n)))

    numbers = np.array([2, 4, 6])
    limit = extrapolate(1 / numbers, [scheme(n) for n in numbers])
    true = abs(float(limit.value) - np.cos(1.0))
    assert true < limit.error < 1000 * true


def test_three_runs_at_least() -> None:
    with pytest.raises(ValueError, match="at least 3 runs"):
        extrapolate([0.2, 0.1], [1.0, 1.0])
