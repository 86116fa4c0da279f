"""The event loop as a whole: one result for all schedulers, conservation, reversal, collapse, errors, memory."""

from __future__ import annotations

import gc
import math
import sys
import tracemalloc
from typing import Any

import numpy as np
import pytest
from event_scenes import full, scatter, spheres, thermal
from numpy.testing import assert_array_equal

from refimpl.events.kernels.schedule import COUNT
from refimpl.events.model import Face, Floats, Friction, Oscillation, RandomPhase, hard_spheres
from refimpl.events.naive import Naive
from refimpl.events.simulation import Scheduler, Simulation
from refimpl.events.state import State

SCHEDULERS: tuple[Scheduler, ...] = ("tree", "lists", "calendar")
EPS = float(np.finfo(float).eps)


def shaken(scheduler: Scheduler = "tree", number: int = 60, alpha: float = 0.9) -> Simulation:
    """Rough disks of all sizes and masses under gravity; the walls keep them warm."""
    rng = np.random.default_rng(7)
    sizes = rng.uniform(0.5, 1.0, number)
    rough = Friction(0.2, 0.5, 0.3)
    faces = [
        Face(temperature=2.0), Face(0.9, random_phase=RandomPhase(2.0, "flux"), friction=rough),
        Face(0.9, oscillation=Oscillation(0.2, 20.0), friction=rough), Face(0.9),
    ]  # fmt: skip
    model = full(
        number, lengths=(12.0, 12.0), periodic=(False, False), faces=faces, restitution=alpha, friction=rough,
        acceleration=(0.1, -1.0), diameters=sizes, masses=rng.uniform(0.5, 2.0, number), contact_duration=1e-4, seed=3,
    )  # fmt: skip
    x = scatter(rng, model.lengths, model.periodic, sizes, number, clearance=0.25)
    v, spins = 2 * thermal(rng, number, 2), rng.normal(size=(number, 1))
    return Simulation(model, x, v, spins, scheduler=scheduler, trace=True)


def plain_disks(
    x: Any, v: Any, side: float, number: int, scheduler: Scheduler = "tree", **arguments: Any
) -> Simulation:
    """Periodic disks by the kernel that can do everything."""
    model = full(number, lengths=(side, side), periodic=(True, True), **arguments)
    return Simulation(model, x, v, scheduler=scheduler, trace=True)


def gas(scheduler: Scheduler) -> Simulation:
    """64 elastic disks of unit temperature in a dilute gas."""
    rng = np.random.default_rng(7)
    x = scatter(rng, (16.0, 16.0), (True, True), 1.0, 64)
    return plain_disks(x, thermal(rng, 64, 2), 16.0, 64, scheduler)


def inward(scheduler: Scheduler) -> Simulation:
    """Disks of a dilute gas that all fly to the middle of the box."""
    rng = np.random.default_rng(4)
    side, number = 80.0, 300
    x = scatter(rng, (side,) * 2, (True,) * 2, 1.0, number)
    v = side / 2 - x + 0.1 * rng.normal(size=x.shape)
    return plain_disks(x, v, side, number, scheduler)


def pair(who: list[int]) -> list[int]:
    return who if who[1] < 0 else sorted(who)


def assert_same(one: Simulation, other: Simulation) -> None:
    """To the last bit, each event too; who of a pair finds it is left open."""
    assert [(time, pair(who)) for time, *who in one.trace()] == [(time, pair(who)) for time, *who in other.trace()]
    for mine, yours in zip(one.state(), other.state(), strict=True):
        if mine is not None:
            assert_array_equal(mine, yours)
    assert (one.collisions, one.interactions) == (other.collisions, other.interactions)


# -- schedulers -----------------------------------------------------------------------------------


def test_schedulers_agree_with_everything() -> None:
    runs = [shaken(scheduler) for scheduler in SCHEDULERS]
    for run in runs:
        run.run(collisions=20_000)
        assert run.interactions > 22_000
        assert_same(runs[0], run)


def test_schedulers_agree_when_the_clock_is_renewed() -> None:
    runs = [gas(scheduler) for scheduler in SCHEDULERS]
    for run in runs:
        run.run(collisions=70_000)
        assert run._rebases > 0
        assert run._now < 0.5 * run.time
        assert_same(runs[0], run)


def test_schedulers_agree_over_many_box_sides() -> None:
    """Each disk flies over some hundred of them between collisions."""
    rng, number, side = np.random.default_rng(1), 64, 80_000.0
    x, v = scatter(rng, (side,) * 2, (True,) * 2, 1.0, number), thermal(rng, number, 2)
    runs = [plain_disks(x, v, side, number, scheduler) for scheduler in SCHEDULERS]
    for run in runs:
        run.run(collisions=30)
        assert run._rebases > 10
        assert_same(runs[0], run)


def test_schedulers_agree_when_memory_is_enlarged() -> None:
    runs = [inward(scheduler) for scheduler in SCHEDULERS]
    for run in runs:
        slots, size = run._particles.cells.shape[1], run.memory()
        run.run(collisions=5_000)
        assert run._particles.cells.shape[1] > slots
        assert run.memory() > size
        assert run.smallest_gap()[0] > -1e-12
        assert_same(runs[0], run)
    assert runs[1]._store.time.size > 4 * runs[1].number + 256


def test_events_are_counted_once() -> None:
    """Where cells had to be enlarged, too."""
    narrow, wide = inward("tree"), inward("tree")
    for _ in range(3):
        wide._widen_cells()
    for run in (narrow, wide):
        run.run(collisions=3_000)
    assert_same(narrow, wide)
    assert narrow.events == wide.events


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_counts_of_changes_may_wrap(scheduler: Scheduler) -> None:
    """They are compared only, and only over short times: the same bits across 2^31, and across 2^32."""
    plain = gas(scheduler)
    plain.run(collisions=1000)
    for start in (2**31 - 3, -3):
        late = gas(scheduler)
        late._particles.ints[:, COUNT] = start
        late.run(collisions=1000)
        assert late.trace() == plain.trace()
        assert_array_equal(late.state().positions, plain.state().positions)


# -- conservation ---------------------------------------------------------------------------------


def test_energy_and_momentum_of_elastic_spheres() -> None:
    """Each collision rounds a velocity by EPS of itself; roundings of the same sign would add up to this."""
    gas = spheres(3, 0.3)
    before, momentum = gas.kinetic_energy(), gas.state().velocities.sum(axis=0)
    gas.run(collisions=5_000)
    fastest = np.abs(gas.state().velocities).max()
    assert abs(gas.kinetic_energy() - before) < 2 * 5_000 * EPS * 4 * fastest**2
    assert np.abs(gas.state().velocities.sum(axis=0) - momentum).max() < 2 * 5_000 * EPS * fastest


def dilute_gas(seed: int = 2) -> tuple[Floats, Floats, float]:
    rng = np.random.default_rng(seed)
    side, number = 9.0, 200
    return scatter(rng, (side,) * 3, (True,) * 3, 1.0, number), thermal(rng, number, 3), side


def free_gas(x: Floats, v: Floats, side: float) -> Simulation:
    return Simulation(hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3), x, v, trace=True)


def test_time_reversal() -> None:
    """Backwards to the start; a collision's rounding, of a position in the box, grows as a shift at the start does."""
    x, v, side = dilute_gas()
    there, shift = free_gas(x, v, side), 1e-10
    there.run(collisions=300)
    shifted = free_gas(x + shift * np.random.default_rng(0).choice([-1.0, 1.0], x.shape), v, side)
    shifted.run(until=there.time)
    growth = np.abs(shifted.state().positions - there.state().positions).max() / shift
    assert growth > 1
    state = there.state()
    back = free_gas(state.positions, -state.velocities, side)
    back.run(until=there.time)
    assert back.collisions == 300
    away = back.state().positions - x
    away -= side * np.round(away / side)
    assert np.abs(away).max() < 2 * 300 * growth * side * EPS
    assert [pair(who) for _, *who in back.trace()] == [pair(who) for _, *who in reversed(there.trace())]


# -- pieces ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [spheres, shaken])
def test_pieces_of_a_run(make: Any) -> None:
    whole, cut = make(), make()
    whole.run(until=3.0)
    for end in np.sort(np.random.default_rng(1).uniform(0, 3, 200)):
        cut.run(until=float(end))
        assert cut.time == end
    cut.run(until=3.0)
    cut.run(until=3.0)
    assert_same(whole, cut)


def test_pieces_of_a_run_across_a_renewal() -> None:
    whole, cut = spheres(2, 0.2), spheres(2, 0.2)
    whole.run(until=1_000.0)
    for end in range(1, 1_001):
        cut.run(until=float(end))
    assert whole._rebases > 0
    assert_same(whole, cut)


@pytest.mark.parametrize("scheduler", SCHEDULERS)
@pytest.mark.parametrize(
    ("make", "first", "last"), [(shaken, 3_000, 6_000), (gas, 50_000, 70_000), (inward, 900, 3_000)]
)
def test_a_run_goes_on_from_a_snapshot(make: Any, first: int, last: int, scheduler: Scheduler) -> None:
    """With the bits of every event: random walls, oscillation, histories; across a renewal; with larger arrays."""
    whole, before, after = make(scheduler), make(scheduler), make(scheduler)
    whole.run(collisions=last)
    before.run(collisions=first)
    arrays = before.snapshot()
    before.run(collisions=first + 10)  # changes no snapshot
    after.run(collisions=5)
    after.resume(arrays)
    seen = len(after.trace())
    after.run(collisions=last)
    assert after.trace()[seen:] == whole.trace()[len(whole.trace()) - len(after.trace()) + seen :]
    assert len(after.trace()) - seen >= last - first
    for mine, yours in zip(after.state(), whole.state(), strict=True):
        if mine is not None:
            assert_array_equal(mine, yours)
    assert (after.collisions, after.interactions, after.events) == (last, whole.interactions, whole.events)
    assert after._rebases == whole._rebases


def test_a_snapshot_of_another_simulation_is_refused() -> None:
    arrays = shaken().snapshot()
    with pytest.raises(ValueError, match=r"array .* is missing|has no place"):
        shaken("lists").resume(arrays)
    with pytest.raises(ValueError, match=r"array rows has the shape \(60, 8\), not \(40, 8\)"):
        shaken(number=40).resume(arrays)


def test_the_naive_algorithm_goes_on_from_a_snapshot() -> None:
    start = shaken(number=20)
    arguments = (start.model, *start.state()[1:])
    whole, before, after = (Naive(*arguments) for _ in range(3))
    before.run(until=1.0)
    after.resume(before.snapshot())
    after.run(until=3.0)
    whole.run(until=1.0)
    whole.run(until=3.0)
    assert after.trace == whole.trace[len(before.trace) :]
    assert len(after.trace) > 20
    for mine, yours in zip(after.state(), whole.state(), strict=True):
        assert_array_equal(mine, yours)


def test_a_cut_at_a_renewal() -> None:
    """A ball between two walls, hit once in h, at h/2, 3h/2 ...: 64 diameters take 32 h, the renewal is due at 512 h.

    It takes place before the hit at 512.5 h, also where the run is cut between the two.
    """
    h = 1.0 + 1e-3 / 3
    model = full(1, lengths=(3.0, 3.0), periodic=(True, False), faces=[None, None, Face(), Face()])
    whole, cut = (Simulation(model, [[1.0, 1.5]], [[0.0, 2 / h]], trace=True) for _ in range(2))
    for end in (511.9 * h, 512.2 * h):
        cut.run(until=end)
        assert cut._rebases == 0
    for ball in (whole, cut):
        ball.run(until=520 * h)
    assert whole._rebases == cut._rebases == 1
    assert_same(whole, cut)


def test_number_of_collisions() -> None:
    gas = spheres(2, 0.3)
    for number in (1, 2, 50, 50):
        gas.run(collisions=number)
        assert gas.collisions == len(gas.trace()) == number
        assert gas.time == gas.trace()[-1][0]
    gas.run(until=gas.time + 1e-9, collisions=1_000)
    assert gas.collisions < 1_000


def test_what_run_refuses() -> None:
    gas = spheres(2, 0.3)
    with pytest.raises(ValueError, match="give a time, or a number"):
        gas.run()
    gas.run(until=1.0)
    with pytest.raises(ValueError, match=r"until = 0\.5 is over, it is t = 1\.0"):
        gas.run(until=0.5)


# -- collapse -------------------------------------------------------------------------------------


def three_in_a_row(alpha: float, contact_duration: float | None = None) -> Simulation:
    """The outer two fly at the middle one.

    Three on a line can collapse for alpha < 7 - 4 sqrt(3) = 0.072: McNamara and Young, Phys. Fluids A 4, 496 (1992).
    """
    x, v = [[2.0, 5.0], [5.0, 5.0], [7.5, 5.0]], [[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]]
    return plain_disks(x, v, 20.0, 3, restitution=alpha, contact_duration=contact_duration)


def test_collapse_of_three() -> None:
    row = three_in_a_row(0.05)
    row.run(until=20.0)
    assert row.stopped.startswith("inelastic collapse of particles ")
    assert {"0", "1", "2"} & set(row.stopped.split())
    assert "1 and" in row.stopped or "and 1" in row.stopped  # the middle one is in all collisions
    assert f"at t = {row.time!r}" in row.stopped
    assert 1.5 < row.time < 20
    assert np.abs(row.state().velocities.sum(axis=0)).max() < 1e-13
    stop = row.time
    row.run(until=30.0)
    assert row.time == stop


def test_no_collapse_of_three() -> None:
    row = three_in_a_row(0.2)
    row.run(until=20.0)
    assert (row.stopped, row.time) == ("", 20.0)
    v = row.state().velocities[:, 0]
    assert v[0] <= v[1] <= v[2]


def test_contact_duration_avoids_a_collapse() -> None:
    row = three_in_a_row(0.05, contact_duration=1e-3)
    row.run(until=20.0)
    assert (row.stopped, row.time) == ("", 20.0)
    assert row.smallest_gap()[0] > -1e-9


def test_collapse_on_a_floor() -> None:
    """Heights h, alpha^2 h, ...: at rest at sqrt(2 h/g) (1 + alpha)/(1 - alpha)."""
    faces = [None, None, Face(0.5), None]
    model = full(1, lengths=(5.0, 5.0), periodic=(True, False), acceleration=(0.0, -1.0), faces=faces)
    ball = Simulation(model, [[1.0, 2.5]], [[0.0, 0.0]], trace=True)
    ball.run(until=20.0)
    assert ball.stopped.startswith("inelastic collapse of particle 0 with a wall at t = ")
    assert ball.time == pytest.approx(2 * 3, abs=1e-6)


@pytest.mark.parametrize(("strength", "frequency"), [(0.5, 3.0), (0.5, 100.0), (10.0, 20.0)])
def test_collapse_on_an_oscillating_floor(strength: float, frequency: float) -> None:
    """strength: A omega^2/g. A ball at rest on the floor would hit it some 1e8 times in a unit of time."""
    amplitude = strength / frequency**2
    faces = [None, None, Face(0.3, oscillation=Oscillation(amplitude, frequency, 0.0)), None]
    model = full(1, lengths=(5.0, 5.0), periodic=(True, False), acceleration=(0.0, -1.0), faces=faces)
    ball = Simulation(model, [[1.0, 1.5]], [[0.0, 0.0]], trace=True)
    ball.run(until=200.0)
    assert ball.stopped.startswith("inelastic collapse of particle 0 with a wall at t = ")
    assert ball.interactions < 2000
    (_, x, v, _), angle = ball.state(), frequency * ball.time
    assert abs(x[0, 1] - 0.5 - amplitude * np.cos(angle)) < 1e-13
    assert abs(v[0, 1] + amplitude * frequency * np.sin(angle)) < 1e-6
    assert amplitude * frequency**2 * np.cos(angle) < 1  # g presses it on


# -- points ---------------------------------------------------------------------------------------


def test_points_never_meet() -> None:
    """30 pairs of points head-on: each flies straight through the other."""
    rng = np.random.default_rng(5)
    one = rng.uniform(0, 10, (30, 2))
    v = rng.normal(size=(30, 2))
    x, v = np.concatenate((one, one + v)), np.concatenate((v, -v))  # at the same place at t = 1/2
    points = plain_disks(x, v, 10.0, 60, diameters=0.0)
    points.run(until=5.0)
    assert points.collisions == 0
    assert points.trace() == []
    assert_array_equal(points.state().velocities, v)
    assert np.abs(points.state().positions - x - 5 * v).max() < 1e-13


# -- errors ---------------------------------------------------------------------------------------

PERIODIC: dict[str, Any] = {"lengths": (10.0, 10.0), "periodic": (True, True)}
WALLED: dict[str, Any] = {"lengths": (10.0, 10.0), "periodic": (False, False), "faces": [Face()] * 4}
APART, STILL = [[1.0, 1.0], [4.0, 4.0], [7.0, 7.0]], [[0.0, 0.0]] * 3


@pytest.mark.parametrize(
    ("model", "positions", "velocities", "message"),
    [
        (PERIODIC, [[1, 1], [4, 4], [4.5, 4.5]], STILL, r"particles (1 and 2|2 and 1) overlap by 0\.29"),
        (PERIODIC, [[0.2, 5], [5, 5], [9.8, 5]], STILL, r"particles (0 and 2|2 and 0) overlap by 0\.6"),
        (PERIODIC, [[1, 1], [math.nan, 4], [7, 7]], STILL, r"positions\[1\] is not finite"),
        (PERIODIC, APART, [[0, 0], [0, 0], [0, math.inf]], r"velocities\[2\] is not finite"),
        (WALLED, [[1, 1], [4, 9.6], [7, 7]], STILL, "particle 1 at .* beyond the wall of face 3"),
        (WALLED, [[0.4, 1], [4, 4], [7, 7]], STILL, "particle 0 at .* beyond the wall of face 0"),
        (PERIODIC, APART, [[0, 0, 0]] * 3, "velocities: shape"),
        (PERIODIC, APART, STILL[:2], "velocities: shape"),
        (PERIODIC, [[1, 1, 1]] * 3, STILL, "positions: shape"),
        (PERIODIC, np.zeros((0, 2)), np.zeros((0, 2)), "no particles"),
        (PERIODIC | {"diameters": [1.0, 0.5]}, APART, STILL, "diameters: 2 values for 3"),
        (PERIODIC | {"masses": [1.0, 0.5]}, APART, STILL, "masses: 2 values for 3"),
        (PERIODIC | {"masses": [1, math.inf, 1]}, APART, [[0, 0], [0, 1], [0, 0]], r"velocities\[1\]: .* at rest"),
        (PERIODIC | {"diameters": [1, -1, 1]}, APART, STILL, r"diameters\[1\]: must be not negative"),
    ],
)  # fmt: skip
def test_refused(model: dict[str, Any], positions: Any, velocities: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Simulation(hard_spheres(**model), positions, velocities)


def test_angular_velocities_of_wrong_shape() -> None:
    with pytest.raises(ValueError, match=r"angular_velocities: .* got \(3, 3\)"):
        Simulation(hard_spheres(**PERIODIC, friction=Friction()), APART, STILL, np.zeros((3, 3)))


def test_state_of_the_start() -> None:
    """Not wrapped; only the rounding to the grid of positions, half a quantum, is lost."""
    x, v = np.array([[-13.0, 1.2], [4.1, 27.3], [7.0, 7.0]]), np.array([[1.0, 2.0], [0.0, 0.0], [-1.0, 0.5]])
    time, positions, velocities, spins = State(*Simulation(hard_spheres(**PERIODIC), x, v).state())
    assert (time, spins) == (0.0, None)
    assert np.abs(positions - x).max() <= 2.0**-48
    assert_array_equal(velocities, v)


# -- memory ---------------------------------------------------------------------------------------


def test_bytes_per_particle() -> None:
    gas = spheres(10, 0.3)
    assert gas.number == 4_000
    assert gas.memory() <= 200 * gas.number


def test_long_runs_keep_no_memory() -> None:
    """Kernels are compiled without counting of references: none may be lost or gained."""
    gas, runs = spheres(2, 0.3), 2_000

    def references() -> list[int]:
        return [sys.getrefcount(array) for array in (gas._rows, *gas._particles, *gas._queue, *gas._scratch)]

    def run() -> tuple[int, list[int]]:
        for _ in range(runs):
            gas.run(collisions=gas.collisions + 10)
            gas._traced.clear()
            del gas._traced_states[1:]
        gc.collect()
        return tracemalloc.get_traced_memory()[0], references()

    tracemalloc.start()
    try:
        run()
        used, counts = run()
        later, counts_later = run()
    finally:
        tracemalloc.stop()
    assert counts_later == counts
    assert abs(later - used) < 24 * runs  # the smallest object, a number, lost by each run
