"""Order, duplicates, gaps and steps of the times of frames."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from inspected import flying, judged, said

from crosscheck.scene import Box, Lattice, LennardJones, Output, Scene

NAME = "time axis"
TIMES = 0.5 * np.arange(40)


def outcomes(times: Any, **more: Any) -> dict[str, float | None]:
    """Quantity -> what was measured, of the judgements that are red."""
    found = judged(flying(frames=len(times), times=np.asarray(times, dtype=np.float64), **more), NAME)
    return {one.quantity: one.measured for one in found if one.outcome == "fail"}


@pytest.mark.parametrize(
    "times",
    [
        TIMES,
        TIMES.astype(np.float32) * np.float32(1.1),
        1e4 + TIMES,
        np.round(np.arange(200) * 0.0123, 4) + 7.0,
        -TIMES[::-1],
    ],
)
def test_equal_intervals_are_right_whatever_their_rounding(times: Any) -> None:
    assert outcomes(times) == {}


def test_decimals_that_are_few_count_as_rounding() -> None:
    assert outcomes(np.round(np.arange(100) * 0.123, 2)) == {}


def test_the_interval_of_the_scene() -> None:
    lattice = Lattice(kind="lattice", structure="sc", number=27, temperature=1.0, seed=1)
    scene = Scene(name="s", dimension=3, duration=10.0, box=Box(density=0.5), initial=lattice,
        lennard_jones=LennardJones(cutoff=1.5), output=Output(interval=0.5))  # fmt: skip
    for factor, outcome in ((1.0, "pass"), (1.001, "fail")):
        found = judged(flying(frames=40, number=27, times=factor * TIMES), NAME, scene)
        (one,) = (one for one in found if one.quantity == "interval of frames")
        assert (one.outcome, one.expected) == (outcome, 0.5)
        assert one.measured == pytest.approx(0.5 * factor)


def test_a_frame_out_of_order() -> None:
    times = TIMES.copy()
    times[[20, 21]] = times[[21, 20]]
    found = outcomes(times)
    assert found["frames earlier than the one before"] == 1
    assert found["intervals that differ from the others"] == 2
    assert not any("missing" in one.note for one in judged(flying(frames=40, times=times), NAME))


def test_two_frames_of_one_time_also_in_32_bits() -> None:
    assert outcomes(np.insert(TIMES, 8, TIMES[7])) == {"frames at the time of the one before": 1}
    near = np.insert(TIMES, 8, TIMES[7] * (1 + 1e-7))
    assert outcomes(near)["frames at the time of the one before"] == 1


def test_missing_frames_are_counted() -> None:
    (one,) = [
        one for one in judged(flying(frames=37, times=np.delete(TIMES, [10, 11, 30])), NAME) if one.outcome == "fail"
    ]
    assert one.measured == 2
    assert "3 frames are missing" in one.note
    assert "frame 10 (counted from 0) is at time 6, after 4.5" in one.note


def test_intervals_that_all_differ_are_told() -> None:
    source = flying(frames=12, times=1.5 ** np.arange(12))
    assert all(one.outcome == "pass" for one in judged(source, NAME))
    assert "most intervals differ" in said(source, NAME)


def test_times_go_with_steps() -> None:
    assert outcomes(TIMES, steps=np.arange(40) * 100) == {}
    steps = np.arange(40) * 100
    steps[25:] += 50
    (quantity,) = outcomes(TIMES, steps=steps)
    assert quantity == "largest distance of a time from its step times dt"


def test_steps_stand_in_for_times_and_frames_say_nothing() -> None:
    nothing = np.full(40, np.nan)
    assert outcomes(nothing, steps=np.arange(40)) == {}
    assert outcomes(nothing, steps=np.r_[np.arange(39), 3])["frames earlier than the one before"] == 1
    assert "neither times nor steps" in said(flying(frames=40, times=nothing), NAME)
    assert "there is one frame" in said(flying(frames=1), NAME)


@pytest.mark.parametrize(("interval", "red"), [(0.5, 0), (0.25, 1)])
def test_the_interval_is_that_of_the_scene(interval: float, red: int) -> None:
    lattice = Lattice(kind="lattice", structure="fcc", number=32, temperature=1.0, seed=1)
    scene = Scene(
        name="s",
        dimension=3,
        duration=20.0,
        lennard_jones=LennardJones(cutoff=1.5),
        box=Box(density=0.5),
        initial=lattice,
        output=Output(interval=interval, trajectory=True),
    )
    found = judged(flying(number=32, frames=40, times=TIMES), NAME, scene)
    assert sum(one.outcome == "fail" for one in found) == red
