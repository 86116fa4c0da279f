"""Pairs of real runs, each with what they are to each other."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from pairs_of_runs import NUMBER, from_state, kicked, liquid, run, trajectory

from crosscheck.compare.growth import Rate
from crosscheck.compare.pairing import pair
from crosscheck.compare.samples import FEWEST, compare_samples
from crosscheck.compare.trajectories import Comparison, compare_trajectories
from crosscheck.engines.workers.pool import Worker
from crosscheck.trajectories.frames import Floats, Units
from crosscheck.trajectories.memory import InMemory


@cache
def scene() -> Any:
    return liquid()


@cache
def base() -> dict[str, Floats]:
    return run(scene())


@cache
def displaced(distance: float) -> dict[str, Floats]:
    """A run whose particle 18 starts at another place."""
    start = scene().own_start()
    positions = start.positions.copy()
    positions[17, 0] = positions[17, 0] + distance
    return run(from_state(scene(), positions, start.velocities))


@cache
def kick(size: float) -> dict[str, Floats]:
    return kicked(scene(), 5.0, particle=20, axis=1, kick=size)


def compared(arrays: dict[str, Floats], rounding: str = "", **known: Any) -> Comparison:
    one = trajectory(scene(), base(), "one", rounding)
    return compare_trajectories(one, trajectory(scene(), arrays, "two", rounding, **known))


def test_the_same_bits() -> None:
    found = compared(base())
    assert found.classed == "same_bits"
    assert found.bits is None
    assert found.growth is None


def test_wrapped_positions_are_the_same_within_rounding() -> None:
    # adding and taking off the edge of the box rounds
    found = compared(base(), wrapped=True)
    assert found.classed == "same_within_rounding"
    assert not all(gap.same for gap in found.gaps)
    assert found.beyond is None


@pytest.mark.parametrize("rounding", ["float32", "%g"])
def test_a_rounded_file_is_the_same_within_its_rounding(rounding: str) -> None:
    whole, rounded = trajectory(scene(), base(), "one"), trajectory(scene(), base(), "two", rounding)
    for both in ((whole, rounded), (rounded, whole)):
        found = compare_trajectories(*both)
        assert found.classed == "same_within_rounding"
        assert found.bits is not None


@pytest.mark.parametrize("rounding", ["", "float32", "%g"])
def test_a_last_bit_grows_as_chaos_does(rounding: str) -> None:
    start = scene().own_start().positions[17, 0]
    found = compared(displaced(float(np.spacing(start))), rounding)
    assert found.classed == "chaos_only"
    assert found.growth is not None
    law = found.growth.law
    assert law is not None
    assert law.start < law.limit
    assert 4 < law.horizon < 12


def test_a_displacement_of_1e_12_is_a_disturbed_start_and_chaos() -> None:
    found = compared(displaced(1e-12))
    assert found.classed == "chaos_only"
    assert found.beyond is not None
    assert (found.beyond.particle, found.beyond.axis, found.beyond.pair) == (18, 0, 0)
    assert "starts differ by 1.0e-12" in found.sentence


def test_a_displacement_of_1e_3_is_another_set_up() -> None:
    found = compared(displaced(1e-3))
    assert found.classed == "different_setup"
    assert "position x of particle 18" in found.sentence


@pytest.mark.parametrize("rounding", ["", "float32", "%g"])
def test_half_the_time_step_is_too_early(rounding: str) -> None:
    found = compared(run(scene(), 0.0025), rounding)
    assert found.classed == "different_dynamics"
    assert found.growth is not None
    assert found.growth.kind == "early"
    assert found.neighbourhood is not None


def test_a_mass_off_by_1e_3_is_another_set_up_where_masses_are_stated() -> None:
    masses = np.ones(NUMBER)
    masses[4] = 1.001
    heavy = scene().changed(masses=tuple(masses))
    start = scene().own_start()
    arrays = run(from_state(heavy, start.positions, start.velocities))
    found = compared(arrays)
    assert found.classed == "different_dynamics"  # nothing is known of masses
    assert found.growth is not None
    assert found.growth.kind == "early"
    one = replace(trajectory(scene(), base()), masses=np.ones(NUMBER))
    stated = compare_trajectories(one, replace(trajectory(scene(), arrays), masses=masses))
    assert stated.classed == "different_setup"
    assert "mass of particle 5 is 1 against 1.001" in stated.sentence


@pytest.mark.parametrize(("rounding", "size"), [("", 1e-6), ("float32", 1e-3), ("%g", 3e-2)])
def test_a_kick_in_mid_run_is_found_with_its_frame_and_particle(rounding: str, size: float) -> None:
    found = compared(kick(size), rounding)
    assert found.classed == "different_dynamics"
    assert found.growth is not None
    assert found.growth.kind == ("momentum" if rounding else "jump")
    assert found.growth.parting is not None
    assert found.gaps[found.growth.parting.frame].farthest["velocities"] == 21
    assert "particle 21" in found.sentence
    assert "(step 1020)" in found.sentence


def test_a_kick_after_rounding_has_grown_is_a_jump_too() -> None:
    start = scene().own_start()
    positions = start.positions.copy()
    positions[17, 0] = np.nextafter(positions[17, 0], 9)
    arrays = kicked(from_state(scene(), positions, start.velocities), 2.0, particle=20, axis=1, kick=0.1)
    found = compared(arrays)
    assert found.classed == "different_dynamics"
    assert found.growth is not None
    assert found.growth.kind == "jump"
    assert found.growth.parting is not None
    assert found.gaps[found.growth.parting.frame].time == pytest.approx(2.1)


def test_velocities_alone_are_compared_too() -> None:
    # velocities of half a step later, as leap-frog writes them
    arrays = dict(base())
    arrays["velocities"] = arrays["velocities"] * 1.0
    arrays["velocities"][25:] *= 1 + 1e-6
    found = compared(arrays)
    assert found.classed == "different_dynamics"
    assert found.growth is not None
    assert found.growth.kind == "velocities"
    assert "t = 2.5 (step 500)" in found.sentence


def test_other_codes_agree_up_to_chaos() -> None:
    worker = Worker("lammps", time_limit=120)
    try:
        assert scene().method is not None
        arrays = dict(worker.run(scene(), scene().method))
    finally:
        worker.close()
    found = compared(arrays)
    assert found.classed == "chaos_only"
    assert found.growth is not None
    assert found.growth.law is not None
    assert found.growth.law.start < 1e-14


def shuffled(source: InMemory, order: list[int]) -> InMemory:
    """The frames in another order, or some of them twice or not at all."""
    assert source.steps is not None
    assert source.velocities is not None
    return replace(
        source,
        times=source.times[order],
        steps=source.steps[order],
        positions=source.positions[order],
        velocities=source.velocities[order],
    )


def test_frames_may_be_cut_double_and_in_any_order() -> None:
    one = trajectory(scene(), base(), "one")
    frames = list(range(len(one)))
    rng = np.random.default_rng(1)
    cases = {
        "cut": (frames[:20], 20, "101 of 121 frames of one have no counterpart"),
        "begun late": (frames[9:], 112, "9 of 121 frames of one have no counterpart"),
        "double": ([*frames[:10], 9, *frames[10:]], 121, "are of one time"),
        "shuffled": (list(rng.permutation(frames)), 121, "frames are sorted"),
        "thinned": (frames[::3], 41, "no counterpart"),
    }
    for order, common, told in cases.values():
        found = compare_trajectories(one, shuffled(trajectory(scene(), base(), "two"), order))
        assert found.classed == "same_bits"
        assert len(found.gaps) == common
        assert any(told in remark for remark in found.remarks), found.remarks


def test_chaos_is_told_from_frames_that_begin_late() -> None:
    start = scene().own_start().positions[17, 0]
    late = trajectory(scene(), displaced(float(np.spacing(start))), "two")
    late = shuffled(late, list(range(60, 121)))
    found = compare_trajectories(trajectory(scene(), base(), "one"), late)
    assert found.classed == "chaos_only"
    assert found.separation.origin == 0.0
    assert compare_trajectories(late, trajectory(scene(), base(), "one")).separation.origin == 0.0


def test_particles_may_be_in_another_order_and_lost() -> None:
    one = trajectory(scene(), base(), "one")
    assert one.velocities is not None
    order = np.random.default_rng(2).permutation(NUMBER)

    class Reordered(InMemory):
        """A file whose particles are written in another order, with their ids."""

        def _frame(self, index: int) -> Any:
            from crosscheck.trajectories.frames import ordered

            frame = super()._frame(index)
            held = order[order != 11] if index >= 75 and self.format == "lossy" else order
            return ordered(
                frame._replace(ids=frame.ids[held], positions=frame.positions[held], velocities=frame.velocities[held])
            )

    fields = {name: getattr(one, name) for name in InMemory.__dataclass_fields__}
    assert compare_trajectories(one, Reordered(**fields)).classed == "same_bits"
    lossy = compare_trajectories(one, Reordered(**fields | {"format": "lossy"}))
    assert lossy.classed == "different_dynamics"
    assert "t = 7.5 (step 1500), 1 particles of the first" in lossy.sentence


def test_numbers_that_are_not_finite_are_a_difference() -> None:
    arrays = {name: values.copy() for name, values in base().items()}
    arrays["positions"][75:] = np.nan
    found = compared(arrays)
    assert found.classed == "different_dynamics"
    assert "t = 7.5 (step 1500), a number is not finite" in found.sentence


def test_what_the_files_leave_open_is_said_with_their_names() -> None:
    one, two = (
        replace(trajectory(scene(), base(), name), remarks=(text,))
        for name, text in (("one", "it is red."), ("two", "x."))
    )
    assert compare_trajectories(one, two).remarks == ("one: it is red.", "two: x.")


def test_masses_that_one_file_has_rounded_are_the_same_set_up() -> None:
    exact = replace(trajectory(scene(), base(), "one"), masses=np.full(NUMBER, 1.1))
    single = replace(trajectory(scene(), base(), "two", "float32"), masses=np.full(NUMBER, float(np.float32(1.1))))
    for both in ((exact, single), (single, exact)):
        assert compare_trajectories(*both).classed == "same_within_rounding"


def test_particles_around_the_place_where_runs_part_are_those_of_both() -> None:
    arrays = run(scene(), 0.0025)
    place = compared(arrays).neighbourhood
    assert place is not None
    rows = np.array(place.ids) - 1
    apart = arrays["positions"][place.pair, rows] - base()["positions"][place.pair, rows]
    assert np.abs(place.second - place.first - apart).max() < 1e-12
    assert place.ids[0] == place.particle
    assert np.abs(place.first[0]).max() == 0.0
    distances = np.linalg.norm(place.first, axis=1)
    assert (np.diff(distances) >= 0).all()
    assert distances[1] > 0.7


def test_a_tolerance_is_a_distance() -> None:
    one = trajectory(scene(), base(), "one")
    moved = dict(base())
    moved["positions"] = moved["positions"] + 1e-5 / 3**0.5
    for tolerance, classed in ((1.1e-5, "same_within_rounding"), (0.9e-5, "different_setup")):
        found = compare_trajectories(one, trajectory(scene(), moved, "two"), "tolerance", tolerance=tolerance)
        assert found.classed == classed


def test_chaos_is_told_from_files_that_state_steps_in_place_of_times() -> None:
    start = scene().own_start().positions[17, 0]
    pairs = [trajectory(scene(), arrays, "run") for arrays in (base(), displaced(float(np.spacing(start))))]
    stepped = [replace(one, times=one.steps.astype(float), units=Units("", "step", "")) for one in pairs]
    timed, found = compare_trajectories(*pairs), compare_trajectories(*stepped)
    assert found.classed == "chaos_only"
    assert found.clock == "step"
    assert found.growth is not None
    assert timed.growth is not None
    assert found.growth.law is not None
    assert timed.growth.law is not None
    assert found.growth.law.rate == pytest.approx(0.005 * timed.growth.law.rate)
    assert found.growth.law.limit == pytest.approx(timed.growth.law.limit)


def test_too_few_frames_are_inconclusive_unless_the_rate_is_known() -> None:
    start = scene().own_start().positions[17, 0]
    few = [
        shuffled(trajectory(scene(), arrays, name), [0, 40, 80, 120])
        for name, arrays in (("one", base()), ("two", displaced(float(np.spacing(start)))))
    ]
    assert compare_trajectories(few[0], few[1]).classed == "inconclusive"
    assert compare_trajectories(few[0], few[1], rate=Rate(3.6, 0.4, 30.0)).classed == "chaos_only"
    half = shuffled(trajectory(scene(), run(scene(), 0.0025), "two", dt=0.0025), [0, 40, 80, 120])
    assert compare_trajectories(few[0], half, rate=Rate(3.6, 0.4, 30.0)).classed == "different_dynamics"


def test_statistics_begin_where_chaos_has_made_the_runs_strangers() -> None:
    one, two = trajectory(scene(), base(), "one"), trajectory(scene(), displaced(1e-12), "two")
    told: list[tuple[int, int]] = []
    found = compare_trajectories(one, two, progress=lambda done, total: told.append((done, total)))
    assert told == [(k, 121) for k in range(1, 122)]
    first = int(np.flatnonzero(found.separation.values > found.separation.spacing)[0])
    assert 0.2 * 121 < first < 121 - FEWEST
    assert str(found.tested) == str(compare_samples(one, two, pair(one, two), first / 121))
    early = compare_trajectories(one, two, "statistics").tested
    assert str(early) == str(compare_samples(one, two, pair(one, two), 0.2))
