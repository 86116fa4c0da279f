"""The share of the kinetic energy in the motion of all particles together."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import PLANTED, flying, judged, said

from crosscheck.trajectories.memory import in_memory

NAME = "common motion"


@pytest.mark.parametrize("seed", range(5))
def test_thermal_motion_of_the_centre_of_mass_is_right(seed: int) -> None:
    """Canonical, it has 3 degrees of freedom as any other; and one constant sample of them may be as large."""
    (one,) = judged(PLANTED.source_of(PLANTED.ornstein_uhlenbeck(seed, frames=100)), NAME)
    assert one.outcome == "pass"
    assert one.measured == pytest.approx(1 / 64, rel=0.5)
    rng = np.random.default_rng(seed)
    v = np.broadcast_to(rng.normal(size=(20, 3)), (60, 20, 3))
    assert judged(flying(velocities=v), NAME)[0].outcome == "pass"


@pytest.mark.parametrize("late", [False, True])
def test_a_flying_ice_cube(late: bool) -> None:
    """From the start, or in the last quarter alone."""
    v = np.array(flying().velocities)
    v[45 if late else 0 :] += np.array([2.0, 0.0, 0.0])
    (one,) = judged(flying(velocities=v), NAME)
    assert one.outcome == "fail"
    assert "in the last" in one.note


def test_the_limit_is_that_of_chance() -> None:
    """The share of one sample of 3 degrees of freedom: red with the level that is stated."""
    (one,) = judged(flying(), NAME)
    limit = one.expected / (1 - one.expected) * 57
    rng = np.random.default_rng(1)
    share = (rng.chisquare(3, 100_000) / (rng.chisquare(57, 100_000) / 57) > limit).mean()
    assert share < 1e-3
    assert one.false_alarm < 1e-3


def rotating(rate: float) -> object:
    """A cluster in open space with thermal velocities and a rotation about z."""
    rng = np.random.default_rng(3)
    x = rng.normal(size=(40, 3))
    v = rng.normal(size=(40, 3)) + rate * np.cross([0.0, 0.0, 1.0], x)
    shape = (30, 40, 3)
    return in_memory(
        "cluster", np.arange(30.0), np.broadcast_to(x, shape), np.broadcast_to(v, shape), masses=np.ones(40)
    )


def test_rigid_rotation_of_a_cluster() -> None:
    thermal, turning = (judged(rotating(rate), NAME) for rate in (0.0, 3.0))
    assert [one.outcome for one in thermal] == ["pass", "pass"]
    assert [one.outcome for one in turning] == ["pass", "fail"]
    assert "rigid rotation" in turning[1].quantity


def test_a_plane_turns_about_one_axis() -> None:
    x, v = np.array(rotating(4.0).positions), np.array(rotating(4.0).velocities)
    x[..., 2] = v[..., 2] = 0.0
    found = judged(in_memory("plane", np.arange(30.0), x, v, masses=np.ones(40)), NAME)
    assert [one.outcome for one in found] == ["pass", "fail"]


def test_motion_that_is_meant_is_told() -> None:
    assert "not taken to be in equilibrium" in said(flying(), NAME, ensemble="none")
    assert judged(flying(), NAME, ensemble="none") == ()
