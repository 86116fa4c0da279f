"""The angle of the surface of heaps that are drawn at random."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.events.drum import _mean_angle, _second_halving, fall_angles, surface_angle
from crosscheck.statistics import Mean


@given(angle=st.floats(-60, 60), seed=st.integers(0, 1000))
def test_surface_angle_of_a_half_full_drum(angle: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = rng.uniform(-10, 10, size=(20_000, 2))
    x = x[(np.hypot(*x.T) < 10) & (x[:, 1] < 0)]
    turn = np.radians(angle)
    turned = x @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert surface_angle(turned + 10, np.full(2, 10.0), 10.0) == pytest.approx(angle, abs=1.5)


def test_surface_angle_needs_four_strips() -> None:
    assert math.isnan(surface_angle(np.array([[10.0, 5.0], [11.0, 5.0]]), np.full(2, 10.0), 10.0))


@given(angle=st.floats(-89, 89), radius=st.floats(0.1, 5))
def test_fall_angle_is_that_of_the_centre_of_mass(angle: float, radius: float) -> None:
    turn = math.radians(angle)
    centre = np.array([10 + radius * math.sin(turn), 10 - radius * math.cos(turn)])
    offsets = np.array([[-1.0, 2.0], [1.0, -2.0]])
    assert fall_angles([centre + offsets], [10.0, 10.0]) == pytest.approx([angle], abs=1e-6)


def test_the_second_halving_of_t_c_continues_the_straight_line() -> None:
    """Centres of mass that swing about angles on a line pass; a bend by more than their scatter does not."""
    rng, middle = np.random.default_rng(1), np.full(2, 10.0)

    def mean(angle: float) -> Mean:
        turn = np.radians(angle + rng.normal(0, 2.0, (570, 1)))
        return _mean_angle(middle + 4.4 * np.stack([np.sin(turn), -np.cos(turn)], axis=-1), middle)

    straight, bent = (_second_halving([mean(angle) for angle in angles]) for angles in ((29, 31, 32), (29, 31, 35)))
    assert (straight.outcome, bent.outcome) == ("pass", "fail")
    assert straight.expected == pytest.approx(32, abs=0.5)
    assert bent.measured == pytest.approx(35, abs=0.5)
