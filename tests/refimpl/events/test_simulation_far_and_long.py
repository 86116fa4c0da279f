"""Flights over many box sides, boxes of many diameters, and counts and clocks of long runs.

What takes every scheduler is in test_simulation.py, whose kernels it shares.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from event_scenes import full, scatter, spheres, thermal
from numpy.testing import assert_array_equal

from refimpl.events.model import Face, Floats, hard_spheres
from refimpl.events.naive import Naive
from refimpl.events.simulation import Simulation
from refimpl.events.state import two_sum

EPS = 2.0**-52
#: Roundings of a coordinate of the box that a contact may be off by: the clock goes up to 16 times to cross the box
#: before it is renewed, half a rounding of that is 8 of a coordinate, at a relative speed of up to four times the mean.
ROUNDINGS = 64


def dilute(density: float, number: int = 64, **options: Any) -> Simulation:
    """Spheres of unit temperature, near the places of a cubic lattice."""
    rng = np.random.default_rng(1)
    side, cells = (number / density) ** (1 / 3), round(number ** (1 / 3))
    at = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    x = (at + 0.5 + rng.uniform(-0.2, 0.2, at.shape)) * side / cells
    model = hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3)
    return Simulation(model, x, thermal(rng, number, 3), **({"trace": True} | options))


def started(kind: Any, model: Any, x: Any, v: Any) -> Any:
    """Traced, as most tests are: one more type would be one more kernel."""
    return Simulation(model, x, v, trace=True) if kind is Simulation else Naive(model, x, v)


def gap(run: Simulation, i: int, j: int) -> float:
    """Between the surfaces of two that have just collided, nearest images, inside the box: the rows are of now."""
    apart, lengths = np.subtract(*run._rows[[i, j], : run.dimension]), np.array(run.model.lengths)
    return float(np.linalg.norm(apart - lengths * np.round(apart / lengths))) - run.model.diameter


# -- precision ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("density", "collisions"), [(1e-3, 200), (1e-5, 60), (1e-6, 30), (1e-7, 15), (1e-8, 8)])
def test_contacts_of_a_dilute_gas(density: float, collisions: int) -> None:
    """Neither too deep nor too early; each collision is looked at when it has just been."""
    gas = dilute(density)
    bound = ROUNDINGS * EPS * gas.model.lengths[0]
    for number in range(1, collisions + 1):
        gas.run(collisions=number)
        _, i, j = gas.trace()[-1]
        assert abs(gap(gas, i, j)) <= bound


def test_naive_and_fast_agree_in_a_dilute_gas() -> None:
    """Until a particle collides for the second time: then a rounding has grown by free paths in diameters, 1e7."""
    fast = dilute(1e-8)
    naive = Naive(fast.model, fast.state().positions, fast.state().velocities)
    fast.run(collisions=20)
    seen: set[int] = set()
    first = []
    for time, i, j in fast.trace():
        if {i, j} & seen:
            break
        seen |= {i, j}
        first.append((time, *sorted((i, j))))
    assert len(first) >= 4
    naive.run(changes=len(first))
    for (time, *who), (slow, i, j) in zip(first, naive.trace, strict=True):
        assert who == sorted((i, j))
        assert abs(time - slow) <= ROUNDINGS * EPS * (fast.model.lengths[0] + time)


def test_disks_in_a_long_channel() -> None:
    model = full(2, lengths=(1e5, 3.0), periodic=(True, True))
    rng = np.random.default_rng(0)
    for _ in range(5):
        v = [[1.0, 0.3 * rng.normal()], [-1.0, 0.3 * rng.normal()]]
        pair = Simulation(model, [[1e4, 1.5], [6e4, 1.2]], v, trace=True)
        for number in range(1, 11):
            pair.run(collisions=number)
            assert abs(gap(pair, 0, 1)) <= ROUNDINGS * EPS * 1e5


@pytest.mark.parametrize("miss", [-1e-5, 1e-5])
@pytest.mark.parametrize("kind", [Simulation, Naive])
def test_grazing_from_a_million_diameters(kind: Any, miss: float) -> None:
    model = full(2, lengths=(3e6, 3e6), periodic=(False, False))
    pair = started(kind, model, [[1e5, 1e6], [1.1e6, 1e6 + 1 + miss]], [[1.0, 0.0], [0.0, 0.0]])
    pair.run(until=2e6)
    assert pair.collisions == (miss < 0)


def test_well_of_a_pair_that_is_far_from_its_edge_beyond_rounding(plain_module: Any) -> None:
    """In a box of 1e9 diameters positions are rounded by 1e-6: the bond, not the place, says who is inside."""
    model, simulation = (plain_module(f"refimpl.events.{name}") for name in ("model", "simulation"))
    sticky = model.hard_spheres(lengths=(1e9, 1e9), periodic=(True, True), well=model.Well(1.0, 1.5))
    pair = simulation.Simulation(sticky, [[1e8, 5e8], [1.1e8, 5e8 + 0.3]], [[0.5, 0.0], [0.0, 0.0]], trace=True)
    pair.run(until=4e7)
    # in through the edge, the core, and out
    assert [sorted(who) for _, *who in pair.trace()] == [[0, 1]] * 3
    assert pair.collisions == 1
    assert not pair._particles.bonds[:, 0].any()
    assert pair.kinetic_energy() == pytest.approx(0.125, rel=1e-9)


# -- the clock ------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [Simulation, Naive])
def test_clock_of_two_particles_in_a_huge_box(kind: Any) -> None:
    """An event in 1e9 units of time: each disk runs to and fro between its wall and the other one."""
    side, room = 2.0**31, 2.0**30 - 1
    model = full(2, lengths=(side, 10.0), periodic=(False, False), faces=[Face(), Face(), None, None])
    pair = started(kind, model, [[0.5 + 0.25 * room, 5.0], [side - 0.5 - 0.25 * room, 5.0]], [[1.0, 0.0], [-1.0, 0.0]])
    flights = 2000
    for event in (1, 10, 100, flights):
        # the whole numbers of a quarter room are exact
        pair.run(until=event * room)
        assert pair.time == event * room
        error = abs(pair.state().positions[0, 0] - (0.5 + room * (0.25 if event % 2 == 0 else 0.75)))
        # of the clock, up to 16 sides over the speed, at each event
        assert error <= 2 * ROUNDINGS * EPS * side * math.sqrt(event)


def test_free_flight_does_not_renew_the_clock_for_ever() -> None:
    """Without a box nothing happens any more: one step to the end."""
    model = full(2, lengths=(5.0, 5.0), periodic=(False, False))
    pair = started(Simulation, model, [[1.0, 2.0], [3.0, 2.5]], [[1.0, 0.0], [0.0, 0.0]])
    pair.run(until=1e12)
    assert pair.collisions == 1
    assert pair._rebases < 3


def test_two_sum_keeps_what_rounding_loses() -> None:
    clock, step = (0.0, 0.0), 0.1
    for _ in range(1000):
        clock = two_sum(*clock, step)
    assert clock[0] == pytest.approx(100.0, abs=0)  # 1000 times the number next to 0.1, rounded once
    assert clock == two_sum(*two_sum(0.0, 0.0, clock[0]), clock[1])


# -- counts ---------------------------------------------------------------------------------------


def test_images_beyond_2_to_the_31() -> None:
    model = full(1, lengths=(8.0, 8.0), periodic=(True, True))
    ball = started(Simulation, model, [[4.0, 4.0]], [[1.0, -1.0]])
    ball._particles.images[0] = [2**31 - 2, -(2**31) + 1, 0]
    before = ball.state().positions
    ball.run(until=80.0)
    assert_array_equal(ball.state().positions - before, [[80.0, -80.0]])


def test_draws_of_random_walls_beyond_2_to_the_31() -> None:
    """No draw comes again: the naive algorithm, whose counts are whole numbers, draws the same."""
    faces = [Face(temperature=1.0), Face(temperature=2.0), None, None]
    model = full(3, lengths=(6.0, 6.0), periodic=(False, True), faces=faces, seed=5)
    x, v = [[1.0, 1.0], [3.0, 3.0], [5.0, 5.0]], [[1.0, 0.1], [-1.0, 0.3], [0.3, 1.0]]
    for start in (2**31 - 2, 2**32 - 2):
        fast, naive = Simulation(model, x, v, trace=True), Naive(model, x, v, hits=start)
        fast._particles.hits[:] = start
        fast.run(until=12.0)
        naive.run(until=12.0)
        assert fast._particles.hits.min() >= start + 2
        assert [sorted(who) for _, *who in fast.trace()] == [sorted(who) for _, *who in naive.trace]
        assert np.abs(fast.state().velocities - naive.state().velocities).max() < 1e-6


@pytest.mark.parametrize("kind", ["Simulation", "Naive"])
def test_the_edge_of_a_well_is_not_a_collision(plain_module: Any, kind: str) -> None:
    """TC model: a pair falls into its well less than t_c before it meets the core, and loses energy there."""
    model = plain_module("refimpl.events.model")
    sticky = model.hard_spheres(
        lengths=(20.0, 20.0), periodic=(True, True), well=model.Well(1.0, 1.5), restitution=0.5, contact_duration=10.0
    )
    start = getattr(plain_module(f"refimpl.events.{kind.lower()}"), kind)
    pair = start(sticky, [[5.0, 10.0], [9.0, 10.0]], [[1.0, 0.0], [-1.0, 0.0]])
    pair.run(until=1.5)
    # reduced mass 1/2: the relative velocity g becomes sqrt(g^2 + 4 depth) = sqrt 8, at the core half of that
    assert pair.collisions == 1
    v = pair.state().velocities
    assert v[1, 0] - v[0, 0] == pytest.approx(math.sqrt(8) / 2, rel=1e-12)


# -- simultaneous events --------------------------------------------------------------------------


def ring(reverse: bool) -> tuple[Any, Floats, Floats]:
    """24 beads that fly at a disk in their middle, all at one distance; the beads in one or the other order."""
    angles = 2 * np.pi * np.arange(24) / 24
    way = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    way = way[::-1] if reverse else way
    model = full(
        25, lengths=(20.0, 20.0), periodic=(False, False), diameters=[4.0] + [0.2] * 24, masses=[10.0] + [1.0] * 24
    )
    return model, np.vstack([[0.0, 0.0], 3 * way]) + 10.0, np.vstack([[0.0, 0.0], -way])


@pytest.mark.parametrize("kind", [Simulation, Naive])
def test_a_ring_of_beads_meets_at_one_time(kind: Any) -> None:
    """The middle takes 24 impacts at t = 0.9, and goes where the order of particles has it."""
    ends = []
    for reverse in (False, True):
        ring_of_24 = started(kind, *ring(reverse))
        ring_of_24.run(until=0.89)
        assert ring_of_24.simultaneous.number == 0
        assert math.isnan(ring_of_24.simultaneous.first)
        ring_of_24.run(until=10.0)
        assert ring_of_24.simultaneous.number >= 23
        assert ring_of_24.simultaneous.first == pytest.approx(0.9, abs=1e-13)
        ends.append(ring_of_24.state().velocities[0])
    assert np.abs(np.subtract(*ends)).max() > 0.01


def test_pairs_that_meet_at_one_time_share_nothing() -> None:
    """Columns that close in on each other by pairs: each disk has one partner at a time."""
    side = 8
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)
    v = np.zeros(grid.shape)
    v[:, 0] = np.where(grid[:, 0] % 2 == 0, 1.0, -1.0)
    model = full(side * side, lengths=(12.0, 12.0), periodic=(True, True))
    for kind in (Simulation, Naive):
        columns: Any = started(kind, model, 1.5 * grid + 0.75, v)
        columns.run(until=3.0)
        assert columns.collisions == side * side / 2 * 6
        assert columns.simultaneous.number == 0


def test_a_corner_is_not_an_order_of_particles() -> None:
    """A ball that meets two walls at once is alone."""
    model = full(1, lengths=(5.0, 5.0), periodic=(False, False), faces=[Face()] * 4)
    for kind in (Simulation, Naive):
        ball: Any = started(kind, model, [[2.5, 2.5]], [[1.0, 1.0]])
        ball.run(until=20.0)
        assert ball.simultaneous.number == 0


def test_no_two_collisions_of_a_gas_are_simultaneous() -> None:
    """1e6 events."""
    gas = spheres(5, 0.3)
    while gas.events < 1_000_000:
        gas.run(collisions=gas.collisions + 100_000)
        gas.trace().clear()
    assert gas.simultaneous.number == 0


def test_times_of_simultaneous_events_are_kept_across_a_renewal() -> None:
    """The first one stays the first; later ones are counted."""
    row = scatter(np.random.default_rng(0), (40.0, 10.0), (False, False), 1.0, 1) * 0 + [[3.0, 5.0]]
    x = np.vstack([row, [[8.0 + k, 5.0] for k in range(3)]])
    v = np.zeros((4, 2))
    v[0, 0] = 1.0
    model = full(4, lengths=(40.0, 10.0), periodic=(False, False), faces=[Face(), Face(), None, None])
    counts = []
    cradle = started(Simulation, model, x, v)
    for end in (5.0, 100.0, 4000.0):
        cradle.run(until=end)
        counts.append(cradle.simultaneous.number)
        assert cradle.simultaneous.first == 4.0
    assert cradle._rebases > 0
    assert all(fewer < more for fewer, more in pairwise(counts))


# -- sums over many events ------------------------------------------------------------------------


def test_what_is_added_to_a_large_sum_loses_no_digits(plain_module: Any) -> None:
    """A heavy point gives the floor 1e10 times what a light one does at each of its 60 bounces after that."""
    speed, bounces, high, heavy = 0.7, 60, 1e3, 7e6
    model = plain_module("refimpl.events.model")
    scene = model.hard_spheres(
        lengths=(4.0, 4.0), periodic=(True, False), diameters=0.0, masses=[heavy, 1.0],
        acceleration=(0.0, -1.0), faces=[None, None, model.Face(), None],
    )  # fmt: skip
    start = [[1.0, 1.0], [3.0, 0.5 * speed**2]], [[0.0, -high], [0.0, 0.0]]
    simulation = plain_module("refimpl.events.simulation").Simulation(scene, *start, tallies=True)
    simulation.run(until=2 * speed * (bounces + 0.25))
    sums = simulation.tallies()
    first = 2 * heavy * math.sqrt(high**2 + 2.0)
    assert sums["wall_collisions"][2] == bounces + 1
    assert abs(sums["wall_impulse"][2, 1] + first + bounces * 2 * speed) <= 2 * EPS * first
