"""Angles of heaps in a drum, on data whose outcome is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.granular.drum import fall_angles, nearest
from crosscheck.statistics import Mean


@given(angle=st.floats(-89, 89), radius=st.floats(0.1, 5))
def test_fall_angle_is_that_of_the_centre_of_mass(angle: float, radius: float) -> None:
    turn = math.radians(angle)
    centre = np.array([10 + radius * math.sin(turn), 10 - radius * math.cos(turn)])
    offsets = np.array([[-1.0, 2.0], [1.0, -2.0]])
    assert fall_angles([centre + offsets], [10.0, 10.0]) == pytest.approx([angle], abs=1e-6)


_LOW, _HIGH = Mean(1.0, 0.3, 10.0, 2.0), Mean(2.0, 0.4, 20.0, 4.0)


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.5, _LOW), (1.2, Mean(1.2, 0.3, 10.0, 2.0)), (1.9, Mean(1.9, 0.4, 20.0, 4.0)), (2.25, _HIGH)],
)
def test_nearest_point_between_two_means(value: float, expected: Mean) -> None:
    assert nearest(value, _LOW, _HIGH) == nearest(value, _HIGH, _LOW) == expected
