"""Velocities against displacements: units and times that do not fit show as a slope."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from inspected import PLANTED, flying, judged, said

from crosscheck.trajectories.frames import Units

NAME = "velocities against displacements"


@pytest.mark.parametrize("seed", range(3))
def test_exact_motion_has_the_slope_1_within_its_doubt(seed: int) -> None:
    run = PLANTED.ornstein_uhlenbeck(seed, frames=150, dt=0.05)
    (one,) = judged(PLANTED.source_of(run), NAME)
    assert one.outcome == "pass"
    assert one.doubt == pytest.approx(1 - np.exp(-0.05), rel=0.1)
    assert abs(one.measured - 1) < one.doubt / 6, "the trapezoid is better than the doubt"
    (one,) = judged(PLANTED.source_of(PLANTED._wrong_unit(run, np.random.default_rng(1))), NAME)
    assert one.outcome == "fail"
    assert one.measured == pytest.approx(1 / 1.2, rel=0.02)


def test_wrapped_positions_move_to_the_nearest_image() -> None:
    run = PLANTED.wrapped(PLANTED.ornstein_uhlenbeck(1, frames=150, dt=0.05))
    assert judged(PLANTED.source_of(run), NAME)[0].outcome == "pass"


def test_free_flight_is_exact() -> None:
    (one,) = judged(flying(), NAME)
    assert one.measured == pytest.approx(1, abs=1e-9)
    assert one.criterion.tolerance < 1e-9
    (one,) = judged(flying(times=0.0101 * np.arange(60)), NAME)
    assert one.outcome == "fail"


def test_what_keeps_it_from_being_said() -> None:
    run = PLANTED.ornstein_uhlenbeck(1, frames=60, dt=2.0)
    assert "velocities lose 8" in said(PLANTED.source_of(run), NAME)
    assert "no velocities" in said(flying(velocities=None), NAME)
    assert "no time in the unit" in said(replace(flying(), units=Units("nm", "step", "nm/ps")), NAME)
    assert "repeat itself" in said(flying(number=5), NAME)
