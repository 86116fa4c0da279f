"""Frames that are exchanged, reversed or missing show in how all particles move."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import PLANTED, flying, judged, said

NAME = "order of frames"


def source(order: np.ndarray, dt: float, wrapped: bool = False, seed: int = 1) -> object:
    """Frames in this order, with the times of an equal interval."""
    run = PLANTED.ornstein_uhlenbeck(seed, frames=len(order) + 4, dt=dt)
    run = PLANTED.wrapped(run) if wrapped else run
    return PLANTED.source_of(
        run._replace(times=run.times[: len(order)], positions=run.positions[order], velocities=run.velocities[order])
    )


def outcomes(order: np.ndarray, dt: float, **more: bool) -> list[str]:
    return [one.outcome for one in judged(source(order, dt, **more), NAME)]


@pytest.mark.parametrize(("dt", "wrapped"), [(0.02, False), (0.3, False), (3.0, False), (0.02, True), (0.3, True)])
def test_exchanged_frames(dt: float, wrapped: bool) -> None:
    """In flight, and where velocities are forgotten from frame to frame."""
    order = np.arange(200)
    assert outcomes(order, dt, wrapped=wrapped) == ["pass", "pass"]
    order[[120, 121]] = 121, 120
    assert outcomes(order, dt, wrapped=wrapped)[0] == "fail"
    turns = judged(source(order, dt, wrapped), NAME)[0]
    assert "at frame 12" in turns.note


@pytest.mark.parametrize("dt", [0.02, 0.3])
def test_missing_frames_with_times_written_anew(dt: float) -> None:
    order = np.delete(np.arange(204), [120, 121, 122])
    pace = judged(source(order, dt), NAME)[1]
    assert pace.outcome == "fail"
    assert "to 120 (counted from 0)" in pace.note


def test_free_flight_keeps_its_pace_to_rounding() -> None:
    assert [one.outcome for one in judged(flying(frames=80), NAME)] == ["pass", "pass"]


def test_what_keeps_it_from_being_said() -> None:
    assert "driven" in said(flying(), NAME, ensemble="none")
    assert "10 or more" in said(flying(number=9), NAME)
    assert "too few" in said(flying(frames=6), NAME)
    assert "fewer than 20" in said(flying(frames=20), NAME)
