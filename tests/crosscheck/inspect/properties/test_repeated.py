"""Frames with the positions of the one before, and particles that are at rest."""

from __future__ import annotations

import numpy as np
from inspected import flying, judged, said

from crosscheck.trajectories.frames import Rounding

NAME = "repeated frames"


def repeated(at: int = 30) -> np.ndarray:
    x = np.array(flying().positions)
    x[at] = x[at - 1]
    return x


def test_a_frame_that_was_written_twice() -> None:
    (one,) = judged(flying(positions=repeated()), NAME)
    assert (one.outcome, one.measured) == ("fail", 1.0)
    assert "frame 30 (counted from 0)" in one.note
    (one,) = judged(flying(positions=repeated(), velocities=None), NAME)
    assert one.outcome == "fail"
    (one,) = judged(flying(), NAME)
    assert one.outcome == "pass"


def test_one_particle_that_moves_is_enough() -> None:
    x = repeated()
    x[30, 3, 2] = np.nextafter(x[30, 3, 2], 9)
    (one,) = judged(flying(positions=x), NAME)
    assert one.outcome == "pass"


def test_rest_and_motion_below_the_rounding_are_told() -> None:
    source = flying(positions=repeated(), velocities=np.zeros((60, 20, 3)))
    (one,) = judged(source, NAME)
    assert one.outcome == "pass"
    assert "whether the particles are at rest" in said(source, NAME)
    coarse = flying(positions=repeated(), rounding=Rounding(0.5, 0.0, "whole numbers"))
    assert judged(coarse, NAME)[0].outcome == "pass"
    assert judged(flying(positions=repeated(), velocities=None), NAME, ensemble="none")[0].outcome == "pass"
