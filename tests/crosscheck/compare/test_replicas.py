"""The odd one out of many runs, and when it left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pairs_of_runs import from_state, liquid, run, trajectory

from crosscheck.compare.replicas import replicas
from crosscheck.compare.trajectories import compare_trajectories
from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import SINGLE, Units
from crosscheck.trajectories.memory import in_memory


def copies(count: int, frames: int = 10) -> list[np.ndarray]:
    base = np.random.default_rng(1).random((frames, 4, 3))
    return [base.copy() for _ in range(count)]


def test_twenty_runs_of_which_one_parts_at_a_known_step() -> None:
    scene = liquid().changed(duration=4.0)
    base = run(scene)
    half = run(scene.changed(duration=1.6))
    velocities = half["velocities"][-1].copy()
    velocities[11, 2] += 1e-14  # a few of the last bits, at step 320
    rest = run(from_state(scene, half["positions"][-1], velocities, duration=2.4))
    odd = {name: np.concatenate([half[name], rest[name][1:]]) for name in ("positions", "velocities")}
    odd["velocities"][16] = velocities
    sources = [trajectory(scene, base, f"run-{number:02d}") for number in range(20)]
    sources[6] = trajectory(scene, odd | {"time": base["time"]}, "run-06")
    found = replicas(sources)
    assert found.left == {6: 16}
    assert found.groups == (19, 1)
    assert found.times[16] == pytest.approx(1.6)
    pair = compare_trajectories(sources[found.reference], sources[6])
    assert pair.classed == "chaos_only"
    assert pair.bits is not None
    assert (pair.bits.pair, pair.bits.particle, pair.bits.axis) == (16, 12, 2)
    assert pair.steps is not None
    assert pair.steps[16] == 320


def test_those_that_are_the_same_never_leave() -> None:
    times = np.arange(10.0)
    told: list[tuple[int, int]] = []
    sources = [in_memory(str(k), times, x) for k, x in enumerate(copies(3))]
    found = replicas(sources, lambda done, total: told.append((done, total)))
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert found.left == {}
    assert found.groups == (3,)
    assert found.frames == 10


def test_groups_leave_one_after_the_other() -> None:
    times, arrays = np.arange(10.0), copies(6)
    for k in (0, 3):  # the first run belongs to the smaller group
        arrays[k][4:, 2, 1] += 1e-16 + np.spacing(arrays[k][4:, 2, 1])
    arrays[5][7:, 0, 0] += 1.0
    found = replicas([in_memory(str(k), times, x) for k, x in enumerate(arrays)])
    assert found.left == {0: 4, 3: 4, 5: 7}
    assert found.reference == 1
    assert found.groups == (3, 2, 1)


def test_of_two_the_second_leaves() -> None:
    times, arrays = np.arange(10.0), copies(2)
    arrays[1][3:] += 1e-9
    assert replicas([in_memory(str(k), times, x) for k, x in enumerate(arrays)]).left == {1: 3}


def test_frames_that_all_have_may_be_the_last_of_the_first_run() -> None:
    arrays = copies(3)
    arrays[2][8:] += 1.0
    sources = [in_memory("0", np.arange(10.0), arrays[0])]
    sources += [in_memory(str(k), np.arange(5.0, 10.0), arrays[k][5:]) for k in (1, 2)]
    found = replicas(sources)
    assert (found.frames, found.left) == (5, {2: 3})
    assert found.when(3) == "t = 8"


def test_one_frame_is_enough() -> None:
    arrays = copies(3, 1)
    arrays[1] += 1.0
    found = replicas([in_memory(str(k), np.zeros(1), x) for k, x in enumerate(arrays)])
    assert (found.left, found.frames) == ({1: 0}, 1)


def test_minus_zero_is_zero() -> None:
    times, arrays = np.arange(10.0), copies(2)
    arrays[0][5, 1, 1], arrays[1][5, 1, 1] = 0.0, -0.0
    assert replicas([in_memory(str(k), times, x) for k, x in enumerate(arrays)]).left == {}


def test_what_not_all_files_hold_does_not_count() -> None:
    times, (x, y, z) = np.arange(10.0), copies(3)
    sources = [in_memory("a", times, x, x), in_memory("b", times, y, y + 1), in_memory("c", times, z)]
    assert replicas(sources).left == {}
    assert replicas(sources).remarks == ("velocity is not in all files, and is not compared.",)
    sources[2] = in_memory("c", times, z, z)
    assert replicas(sources).left == {1: 0}
    assert replicas(sources).remarks == ()


def test_files_that_are_written_in_other_ways_are_told() -> None:
    times, (x, y, z) = np.arange(10.0), copies(3)
    rounded = y.astype(np.float32).astype(np.float64)
    sources = [
        in_memory("a", times, x),
        in_memory("b.gsd", times, rounded, rounding=SINGLE),
        in_memory("c.xtc", times, z, wrapping="wrapped"),
    ]
    found = replicas([replace(sources[0], units=Units("nm")), replace(sources[1], units=Units("Angstrom")), sources[2]])
    assert "b.gsd is written in another way than a (positions of float32 against float64; converted" in found.remarks[0]
    assert "c.xtc is written in another way than a (wrapped against unwrapped positions)" in found.remarks[1]


def test_frames_are_told_by_their_clock() -> None:
    arrays, times, steps = copies(3), np.arange(10.0), 50 * np.arange(10)
    arrays[2][4:] += 1.0
    timed = replicas([in_memory(str(k), times, x, steps=steps) for k, x in enumerate(arrays)])
    assert timed.when(timed.left[2]) == "t = 4 (step 200)"
    sources = [in_memory(str(k), np.full(10, np.nan), x, steps=steps) for k, x in enumerate(arrays)]
    stepped = replicas(sources)
    assert stepped.when(stepped.left[2]) == "step 200"
    sources[1] = in_memory("1", times, arrays[1])
    assert replicas(sources).when(4) == "frame 4 (step 200)"


def test_runs_without_a_common_frame_are_refused() -> None:
    arrays = copies(3, 4)
    times = [np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.0, 8.0, 9.0]), np.array([2.0, 3.0, 4.0, 5.0])]
    with pytest.raises(UsageError, match="no frame is common to all runs"):
        replicas([in_memory(str(k), t, x) for k, (t, x) in enumerate(zip(times, arrays, strict=True))])
