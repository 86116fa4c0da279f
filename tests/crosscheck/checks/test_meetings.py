"""What is said of a run that goes on where no force is finite, and of one that ends there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from crosscheck.checks.meetings import DT, MEETING, MEETINGS, STEPS, judged_meeting
from crosscheck.engines.protocol import Run
from crosscheck.scene import Gravity, Method, Scene

MEETING_OF_TWO = MEETINGS["first-of-few"]


def _scene() -> Scene:
    return MEETING_OF_TWO.scene(gravity=Gravity(G=1e-90))


def _free_run(ends: int, diverged: bool) -> Run:
    """Particles that feel nothing, and no numbers from the sample `ends` on."""
    scene = _scene()
    state, times = scene.initial_state(), DT * np.arange(STEPS + 1)
    x = state.positions + times[:, None, None] * state.velocities
    x[ends:] = np.nan
    return Run({"time": times, "positions": x}, diverged=diverged)


def _red(run: Run) -> list[str]:
    laboratory: Any = SimpleNamespace(engine="ase", run=lambda *_, **__: run)
    method = Method(scheme="velocity_verlet", dt=DT)
    judgements, _ = judged_meeting(laboratory, _scene(), method, 1e-80, MEETING)
    return [one.quantity for one in judgements if one.outcome != "pass"]


def test_the_two_meet_in_one_point() -> None:
    one, other = _free_run(STEPS + 1, False)["positions"][MEETING][list(MEETING_OF_TWO.pair)]
    assert (one == other).all()


@pytest.mark.parametrize(
    ("ends", "diverged", "red"),
    [
        (MEETING, True, []),
        (MEETING, False, ["runs that do not say that they diverged"]),
        (MEETING + 1, True, ["samples with numbers from the meeting on"]),
        (MEETING - 1, True, ["distance from the free path before"]),
        (STEPS + 1, False, ["runs that do not say that they diverged", "samples with numbers from the meeting on"]),
    ],
)
def test_what_is_red(ends: int, diverged: bool, red: list[str]) -> None:
    assert _red(_free_run(ends, diverged)) == red
