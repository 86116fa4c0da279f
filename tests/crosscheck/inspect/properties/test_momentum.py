"""Momentum along each axis: rounding of the file is let through, and what is larger is not."""

from __future__ import annotations

import numpy as np
import pytest
from hard_disks import disks
from inspected import flying, judged, said

from crosscheck.scene import Box
from crosscheck.trajectories.frames import SINGLE, Rounding

NAME = "momentum"


def kicked(size: float, axis: int = 1) -> np.ndarray:
    v = np.array(flying().velocities)
    v[40:, 7, axis] += size
    return v


def test_momentum_of_a_closed_system_is_conserved_to_the_last_bits() -> None:
    assert [one.outcome for one in judged(flying(), NAME, ensemble="nve")] == ["pass"] * 3
    for size, outcome in ((1e-15, "pass"), (1e-9, "fail")):
        found = judged(flying(velocities=kicked(size)), NAME, ensemble="nve")
        assert [one.outcome for one in found] == ["pass", outcome, "pass"]
    assert "in frame 4" in found[1].note
    assert found[1].sensitivity < 1e-11


@pytest.mark.parametrize("digits", [4, 6, 9])
def test_digits_of_the_file_are_let_through(digits: int) -> None:
    rounding = Rounding(0.0, 0.5 * 10.0 ** (1 - digits), f"{digits} digits")
    rng = np.random.default_rng(1)
    v = rng.normal(size=(60, 20, 3))
    v -= v.mean(axis=1, keepdims=True)  # exact momentum 0 in each frame
    scale = 10.0 ** (digits - 1 - np.floor(np.log10(np.abs(v))))
    found = judged(flying(velocities=np.round(v * scale) / scale, rounding=rounding), NAME, ensemble="nve")
    assert [one.outcome for one in found] == ["pass"] * 3
    v[30:, 3] += 100 * 10.0 ** (1 - digits)
    found = judged(flying(velocities=np.round(v * scale) / scale, rounding=rounding), NAME, ensemble="nve")
    assert [one.outcome for one in found] == ["fail"] * 3


def test_single_precision_of_the_run_lets_more_through() -> None:
    source = flying(velocities=kicked(1e-7), rounding=SINGLE)
    assert judged(source, NAME, ensemble="nve", arithmetic="single")[1].outcome == "pass"
    source = flying(velocities=kicked(1e-2), rounding=SINGLE)
    assert judged(source, NAME, ensemble="nve", arithmetic="single")[1].outcome == "fail"


def test_it_is_told_and_not_judged_where_nothing_says_that_it_is_conserved() -> None:
    assert judged(flying(), NAME) == ()
    assert "momentum along y changes by" in said(flying(), NAME)
    scene = disks(box=Box(lengths=(6.0, 5.0), boundaries=("hard", "periodic")))
    source = flying(number=3)
    assert ["momentum along y" in one.quantity for one in judged(source, NAME, scene)] == [True]
    assert "[box.boundaries=hard] takes momentum" in said(source, NAME, scene)


def test_what_is_told_is_a_share_of_all_momenta() -> None:
    v = kicked(0.5)
    share = 0.5 / np.abs(v[..., 1]).sum(axis=1).max()
    assert f"along y changes by {share:.2e}" in said(flying(velocities=v), NAME)


def test_masses_are_needed() -> None:
    assert "states no masses" in said(flying(masses=None, types=np.array([1, 2] * 10)), NAME)
    assert "no velocities" in said(flying(velocities=None), NAME)
