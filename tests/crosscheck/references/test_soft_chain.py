"""A column of soft beads, against closed forms of one and of two impacts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.references.soft_chain import soft_chain
from crosscheck.references.soft_impact import HookeImpact, stiffness


def test_soft_chain_of_one_bead_bounces_by_its_restitution() -> None:
    # without gravity alpha; with it, to the first order in g t_c/v: 1e-4
    t_c, alpha = 1e-3, 0.9
    heights, speeds = soft_chain(1, alpha, t_c, 0.0, 10.0, 5 * t_c)
    assert speeds[0] == pytest.approx(alpha * 10.0, rel=5e-3 * 0.1)
    assert heights[0] > 0.5


def test_soft_chain_of_two_beads_far_apart_meets_twice() -> None:
    # the lower bead turns round at the floor, then both meet: relative speed alpha of that before
    t_c, alpha, speed = 1e-3, 0.9, 100.0
    gap = 20 * speed * t_c
    _, speeds = soft_chain(2, alpha, t_c, gap, speed, 0.015)
    relative = alpha * (1 + alpha) * speed
    centre = 0.5 * (alpha - 1) * speed
    assert speeds == pytest.approx([centre - relative / 2, centre + relative / 2], rel=1e-3)


@pytest.mark.parametrize("alpha", [1.0, 0.9, 0.3])
def test_soft_chain_of_one_bead_follows_the_closed_form(alpha: float) -> None:
    t_c, speed = 1e-3, 100.0
    # m = 1 at the floor: a contact there lasts sqrt(2) t_c
    exact = HookeImpact(1.0, stiffness(alpha, 0.5, t_c), speed, alpha)
    assert exact.contact_time == pytest.approx(math.sqrt(2) * t_c)
    for share in (0.1, 0.5, 0.9):
        time = share * exact.contact_time
        heights, velocities = soft_chain(1, alpha, t_c, 0.0, speed, time)
        # gravity changes velocities by the time, 1e-5 of the speed
        assert 0.5 - heights[0] == pytest.approx(float(exact.overlap(time)), abs=speed * t_c * 1e-4)
        assert velocities[0] == pytest.approx(-float(exact.velocity(time)), abs=speed * 1e-4)


def test_soft_chain_keeps_energy_without_dashpots() -> None:
    number, speed = 5, 10.0
    heights, velocities = soft_chain(number, 1.0, 1e-3, 1e-3, speed, 0.1)
    apart = np.diff(heights, prepend=-0.5)
    assert (apart > 1 - 1e-9).all()
    start = 0.5 * number * speed**2 + (0.5 + 1.001 * np.arange(number)).sum()
    assert 0.5 * (velocities**2).sum() + heights.sum() == pytest.approx(start, rel=1e-6)
