"""Lists of neighbours: the events of cells to the last bit, complete lists at any time, and when they are chosen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from event_scenes import disks, fcc, scatter, thermal
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from refimpl.events.kernels.loop import FEW
from refimpl.events.kernels.schedule import LIST_BUILDS, LIST_TESTS, RENEWALS
from refimpl.events.kernels.shells import NUMBER_BITS
from refimpl.events.model import Face, Floats, Well, hard_spheres
from refimpl.events.simulation import MANY, SHELL, Simulation, shell_width
from refimpl.events.state import radii_of


def pair(time: float, i: int, j: int) -> tuple[float, int, int]:
    return time, min(i, j), max(i, j)


def assert_same(one: Simulation, other: Simulation) -> None:
    """Every event and every state, to the last bit; who of a pair finds it is left open."""
    assert [pair(*event) for event in one.trace()] == [pair(*event) for event in other.trace()]
    swap = np.array([a[1:] != b[1:] for a, b in zip(one.trace(), other.trace(), strict=True)], bool)
    ours = np.where(swap[:, None, None], one.traced_states()[:, ::-1], one.traced_states())
    assert_array_equal(ours, other.traced_states())
    for mine, yours in zip(one.state(), other.state(), strict=True):
        if mine is not None:
            assert_array_equal(mine, yours)
    assert one.simultaneous.number == other.simultaneous.number == 0


def both(model: Any, x: Floats, v: Floats, width: float, **options: Any) -> tuple[Simulation, Simulation]:
    """With cells alone, and with lists."""
    options = {"trace": True, "counting": True} | options
    return Simulation(model, x, v, shell=0.0, **options), Simulation(model, x, v, shell=width, **options)


def assert_complete(run: Simulation) -> None:
    """Every pair within its contact range is in both lists, with the shift that brings it there."""
    shells, rows = run._particles.shells, run._particles.rows
    d, lengths = run.dimension, np.array(run.model.lengths)
    here = rows[:, :d] + rows[:, 3 : 3 + d] * (run._now - rows[:, 6])[:, None]
    reach = shells.reach * np.add.outer(radii_of(run.model, run.number), radii_of(run.model, run.number))
    listed: dict[tuple[int, int], int] = {}
    for i in range(run.number):
        for entry in shells.lists[i, 1 : 1 + shells.lists[i, 0]]:
            j, code = int(entry) & ((1 << NUMBER_BITS) - 1), int(entry) >> NUMBER_BITS
            assert (i, j) not in listed
            listed[i, j] = code
    for (i, j), code in listed.items():
        assert listed[j, i] == 26 - code
        gap = here[j] - here[i] + run._grid.shifts[code, :d]
        # both are in their shells, and their centres were near enough
        assert np.linalg.norm(gap) < reach[i, j] + 4 * shells.width + 1e-9
    gaps = here[None] - here[:, None]
    gaps -= np.where(run.model.periodic, lengths * np.round(gaps / lengths), 0.0)
    near = np.argwhere(np.linalg.norm(gaps, axis=2) < reach)
    assert {(i, j) for i, j in near.tolist() if i != j} <= set(listed)
    away = np.linalg.norm(here - shells.centres[:, :d], axis=1)
    assert away.max() <= shells.width


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 2**32 - 1), st.floats(0.05, 0.7), st.floats(0.05, 0.4), st.floats(0.7, 1.0), st.floats(0.9, 1.0),
    st.sampled_from([(True, True), (True, False), (False, False)]),
)  # fmt: skip
def test_disks(seed: int, packing: float, width: float, small: float, alpha: float, periodic: Any) -> None:
    """From a square lattice; along an axis that is not periodic they fly away."""
    number = 64
    sizes = np.where(np.arange(number) % 2 == 0, 1.0, small)
    side = max(math.sqrt(np.sum(math.pi / 4 * sizes**2) / packing), 8.01)
    model = disks(lengths=(side, side), periodic=periodic, restitution=alpha)
    model = model._replace(diameter=1.0, radii=sizes / 2, inverse_masses=1 / sizes**2)
    grid = np.stack(np.meshgrid(np.arange(8), np.arange(8), indexing="ij"), -1).reshape(-1, 2)
    v = thermal(np.random.default_rng(seed), number, 2)
    cells, lists = both(model, (grid + 0.5) * side / 8, v, min(width, (side / 3 - 1) / 2 - 1e-6))
    for collisions in (30, 200, 500):
        for run in (cells, lists):
            run.run(until=50.0, collisions=collisions)
        assert_complete(lists)
    assert_same(cells, lists)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.68), st.floats(0.03, 0.4))
def test_spheres(seed: int, packing: float, width: float) -> None:
    cells_along = 3 if packing < 0.2 else 4
    x, side = fcc(cells_along, packing)
    width = min(width, (side / 3 - 1) / 2 - 1e-6)
    v = thermal(np.random.default_rng(seed), len(x), 3)
    cells, lists = both(hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3), x, v, width)
    for run in (cells, lists):
        run.run(collisions=1500)
    assert_complete(lists)
    assert_same(cells, lists)


def test_lists_and_cells_grow() -> None:
    """All fly to the middle of the box: nothing is lost where a list, or a cell, is full."""
    rng, side, number = np.random.default_rng(4), 80.0, 300
    x = scatter(rng, (side,) * 2, (True,) * 2, 1.0, number)
    v = side / 2 - x + 0.1 * rng.normal(size=x.shape)
    model = disks(lengths=(side, side), periodic=(True, True))
    model = model._replace(radii=np.full(number, 0.5), inverse_masses=np.ones(number))
    cells, lists = both(model, x, v, 1.5)
    slots, shape = lists._particles.cells.shape[1], lists._particles.shells.lists.shape[1]
    for run in (cells, lists):
        run.run(collisions=3000)
    assert lists._particles.cells.shape[1] > slots
    assert lists._particles.shells.lists.shape[1] > shape
    assert lists.memory() > cells.memory() - cells._particles.cells.nbytes
    assert_complete(lists)
    assert_same(cells, lists)


def test_flights_over_many_box_sides() -> None:
    """States are taken anew at the same times, whatever else happens in between; the clock is renewed too."""
    rng, side, number = np.random.default_rng(1), 4000.0, 64
    model = disks(lengths=(side,) * 2, periodic=(True,) * 2)
    model = model._replace(radii=np.full(number, 0.5), inverse_masses=np.ones(number))
    x, v = scatter(rng, (side,) * 2, (True,) * 2, 1.0, number), thermal(rng, number, 2)
    cells, lists = both(model, x, v, 40.0)
    for run in (cells, lists):
        run.run(collisions=20)
        assert run._rebases > 0
        assert run.operation_counts()[RENEWALS] > 100
    assert cells.operation_counts()[RENEWALS] == lists.operation_counts()[RENEWALS]
    assert_same(cells, lists)


def test_lists_in_a_calendar() -> None:
    x, side = fcc(4, 0.45)
    model, v = hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3), thermal(np.random.default_rng(3), len(x), 3)
    for run in (runs := both(model, x, v, 0.2, scheduler="calendar")):
        run.run(collisions=1000)
    assert_same(*runs)


def test_what_is_fetched_ahead_changes_nothing() -> None:
    """Of so many particles the next events are guessed."""
    x, side = fcc(9, 0.45)
    assert len(x) > FEW
    model, v = hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3), thermal(np.random.default_rng(3), len(x), 3)
    for run in (runs := both(model, x, v, 0.2)):
        run.run(collisions=3000)
    assert_same(*runs)


def test_lists_go_on_later_with_the_same_bits() -> None:
    x, side = fcc(4, 0.45)
    model, v = hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3), thermal(np.random.default_rng(3), len(x), 3)
    whole, first, second = (Simulation(model, x, v, shell=0.2, trace=True, counting=True) for _ in range(3))
    whole.run(collisions=2000)
    first.run(collisions=1000)
    second.resume(first.snapshot())
    second.run(collisions=2000)
    assert_array_equal(second.state().positions, whole.state().positions)
    assert second.trace() == whole.trace()[1000:]


@pytest.mark.parametrize("packing", [0.26, 0.35])
def test_how_long_a_list_is_good(packing: float) -> None:
    """After x (1 + x/5) collisions, x = width over mean free path: what `_lists_pay` reckons with, to a tenth."""
    x, side = fcc(6, packing)
    v = thermal(np.random.default_rng(3), len(x), 3)
    run = Simulation(
        hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3), x, v, shell=0.25, counting=True, trace=True
    )
    run.run(collisions=8 * run.number)
    before = run.operation_counts()
    run.run(collisions=28 * run.number)
    made, looked = (run.operation_counts() - before)[[LIST_BUILDS, LIST_TESTS]]
    contact = (1 - packing / 2) / (1 - packing) ** 3
    ratio = 0.25 * math.sqrt(2) * math.pi * (6 * packing / math.pi) * contact
    assert 2 * 20 * run.number / made == pytest.approx(ratio * (1 + ratio / 5), rel=0.1)
    in_cells = 27 * run.number / math.prod(run._grid.counts)
    assert looked / made == pytest.approx(in_cells, rel=0.02)


def chosen(packing: float, number: int = 4000, scheduler: Any = "tree", fields: Any = None, **laws: Any) -> float:
    side = (number * math.pi / 6 / packing) ** (1 / 3)
    model = hard_spheres(lengths=(side,) * 3, **({"periodic": (True,) * 3} | laws))
    return shell_width(model, number, scheduler, fields)


def test_where_lists_are_taken() -> None:
    assert chosen(0.1) == chosen(0.2) == chosen(0.26) == 0.0
    assert chosen(0.4) == pytest.approx(SHELL)
    assert chosen(0.45) == chosen(0.6) == chosen(0.73) == pytest.approx(SHELL)
    assert chosen(0.45, restitution=0.9, masses=np.ones(4000), diameters=np.full(4000, 1.0)) > 0.0
    assert chosen(0.26, well=Well(1.0, 1.5)) == pytest.approx(SHELL)
    assert chosen(0.45, MANY - 1) == 0.0
    assert chosen(0.1, scheduler="neighbours") == chosen(0.45, 300, "neighbours") == pytest.approx(SHELL)


def test_where_lists_are_not_possible() -> None:
    for scheduler in ("tree", "neighbours"):
        assert chosen(0.45, scheduler=scheduler, faces=[Face()] * 6, periodic=(False,) * 3) == 0.0
        assert chosen(0.45, scheduler=scheduler, acceleration=(0.0, 0.0, -1.0)) == 0.0
        assert chosen(0.45, scheduler=scheduler, fields=(2, 2, 2)) == 0.0
        assert chosen(0.45, 30, scheduler) == 0.0
        assert chosen(0.01, scheduler=scheduler, diameters=np.where(np.arange(4000) == 0, 3.0, 1.0)) == 0.0
        assert chosen(0.45, scheduler=scheduler, diameters=np.zeros(4000)) == 0.0
    assert chosen(0.45, scheduler="lists") == chosen(0.45, scheduler="calendar") == 0.0
    assert chosen(0.45, masses=np.where(np.arange(4000) % 2 == 0, np.inf, 1.0)) == 0.0
    x, side = fcc(4, 0.45)
    model = hard_spheres(lengths=(side,) * 3, periodic=(False,) * 3, acceleration=(0.0, 0.0, -1.0))
    with pytest.raises(ValueError, match="shell"):
        Simulation(model, x, np.zeros_like(x), shell=0.2)
