"""The distance between speeds and Maxwell's distribution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest, kstwo

from crosscheck.checks.events import maxwell
from crosscheck.verdict import FALSE_ALARM


def test_distance_is_that_of_scipy() -> None:
    speeds = np.random.default_rng(1).rayleigh(1.1, size=500)
    expected = kstest(speeds, "rayleigh").statistic  # of scale 1: Maxwell in two dimensions, T = 1
    assert maxwell._distance(speeds, 2, 1.0) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_maxwell_is_no_further_from_itself_than_allowed(dimension: int) -> None:
    speeds = np.linalg.norm(np.random.default_rng(2).normal(size=(40000, dimension)), axis=1)
    largest = kstwo(40000).isf(FALSE_ALARM)
    assert maxwell._distance(speeds, dimension, 1.0) < largest
    assert maxwell._distance(1.05 * speeds, dimension, 1.0) > largest
