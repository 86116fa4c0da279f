"""Lattice gases that move: plain NumPy, table look-up and bit planes are one gas, and it does what its rules say.

What a rule does is tested on plain NumPy; that the other evolvers do the same, bit for bit, on random states. Kernels
of bit planes are compiled for each model, without anything and with everything, no more.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numba import typeof, types
from scipy.stats import chisquare

from refimpl.lattice import bitplanes
from refimpl.lattice.bitplanes import PlaneGas, _tiling
from refimpl.lattice.gas import (
    BOUNCE_BACK,
    DIFFUSIVE_X,
    DIFFUSIVE_Y,
    DRAW_X,
    DRAW_Y,
    REVERSE_X,
    REVERSE_Y,
    SPECULAR_X,
    SPECULAR_Y,
    Forcing,
    LatticeGas,
    drawn_sites,
    filled_cells,
    places,
)
from refimpl.lattice.kernels.planes import advance
from refimpl.lattice.lookup import LookupGas
from refimpl.lattice.models import MODELS, Model
from refimpl.lattice.plain import PlainGas

EVOLVERS: dict[str, Callable[..., LatticeGas]] = {
    "plain": PlainGas,
    "lookup": LookupGas,
    "planes": PlaneGas,
    "planes step by step": lambda *scene, **more: PlaneGas(*scene, block=1, **more),
    "planes of two threads": lambda *scene, **more: PlaneGas(*scene, threads=2, **more),
    "planes of three threads": lambda *scene, **more: PlaneGas(*scene, threads=3, **more),
}
HPP, FHP = MODELS["hpp"], MODELS["fhp1"]
#: Standard errors: by chance, one of 3e7 tests is further off with another seed.
LIMIT = 5.5
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS.keys())
every_evolver = pytest.mark.parametrize("evolver", EVOLVERS.values(), ids=EVOLVERS.keys())
plain_and_planes = pytest.mark.parametrize("evolver", [PlainGas, PlaneGas])
models = st.sampled_from(list(MODELS.values()))
each_set = pytest.mark.parametrize("model", [HPP, FHP, MODELS["fhp3"]], ids=["hpp", "fhp1", "fhp3"])


def against(model: Model) -> int:
    """The channel -x."""
    return model.velocities.image(-1, 1)[0]


def random_sites(model: Model, rows: int, columns: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, model.velocities.states, (rows, columns), dtype=np.uint8)


def everything(model: Model, rows: int, columns: int) -> dict[str, Any]:
    """Walls of all rules at a sixth of the sites, and a force to the left."""
    rng = np.random.default_rng(2)
    walls = np.where(rng.random((rows, columns)) < 1 / 6, rng.integers(1, 16, (rows, columns)), 0)
    walls[0, 0] = DIFFUSIVE_Y
    return {"walls": walls.astype(np.uint8), "forcing": Forcing(against(model), 0.3)}


def channels_of(model: Model, sites: np.ndarray) -> np.ndarray:
    """Occupations, (rows, columns, b)."""
    return sites[..., None] >> np.arange(model.channels) & 1


def totals(model: Model, sites: np.ndarray) -> np.ndarray:
    """Mass and momentum in the units of the set: whole numbers."""
    counts = channels_of(model, sites).sum(axis=(0, 1))
    return np.array([counts.sum(), *(counts @ np.array(model.velocities.integers))])


def assert_same(gases: list[LatticeGas]) -> None:
    first = gases[0]
    for gas in gases[1:]:
        np.testing.assert_array_equal(gas.sites, first.sites)
        np.testing.assert_array_equal(gas.impulses, first.impulses)
        assert gas.time == first.time


# -- one gas ---------------------------------------------------------------------------------------------------------


@every_model
@pytest.mark.parametrize("columns", [37, 64, 133, 513])
@pytest.mark.parametrize("scene", ["free", "everything"])
def test_evolvers_agree(model: Model, columns: int, scene: str) -> None:
    rows = 10
    more = everything(model, rows, columns) if scene == "everything" else {}
    sites = random_sites(model, rows, columns)
    gases = [evolver(model, sites, seed=2**63 - 5, **more) for evolver in EVOLVERS.values()]
    assert_same(gases)
    for steps in (1, 6, 0, 4):
        for gas in gases:
            gas.advance(steps)
        assert_same(gases)
    assert gases[0].time == 11
    assert (gases[0].sites != sites).mean() > 0.5
    assert gases[0].impulses.any() == (scene == "everything")


@pytest.mark.parametrize("model", [HPP, FHP], ids=["hpp", "fhp1"])
@pytest.mark.parametrize(("rows", "columns"), [(2, 1), (2, 2), (4, 63), (4, 512), (2, 1025), (1, 5)])
def test_evolvers_agree_on_lattices_of_any_shape(model: Model, rows: int, columns: int) -> None:
    rows += rows % 2 if model.velocities.half_rows else 0
    sites = random_sites(model, rows, columns)
    gases = [evolver(model, sites) for evolver in EVOLVERS.values()]
    for gas in gases:
        gas.advance(5)
    assert_same(gases)


@pytest.mark.parametrize("probability", [0.0, 2.0**-24, 0.5, 1 - 2.0**-24, 1.0])
@pytest.mark.parametrize("channel", [0, 3])
def test_evolvers_agree_on_any_force(channel: int, probability: float) -> None:
    sites = random_sites(FHP, 8, 133)
    more = everything(FHP, 8, 133) | {"forcing": Forcing(channel, probability)}
    gases = [evolver(FHP, sites, **more) for evolver in EVOLVERS.values()]
    for gas in gases:
        gas.advance(5)
    assert_same(gases)
    assert gases[0].impulses.any() == (probability > 0.1)


@given(data=st.data())
def test_blocks_of_steps_and_threads_change_no_bit_and_no_work(data: st.DataObject) -> None:
    model = data.draw(models)
    rows = data.draw(st.integers(1, 45)) * (2 if model.velocities.half_rows else 1)
    columns = data.draw(st.sampled_from([1, 2, 63, 64, 65, 200, 511, 512, 513, 1100]))
    more = everything(model, rows, columns) if data.draw(st.booleans()) else {}
    sites = random_sites(model, rows, columns, data.draw(st.integers(0, 99)))
    block = data.draw(st.none() | st.integers(1, 50))
    plain = PlainGas(model, sites, seed=5, **more)
    threads = data.draw(st.integers(1, 5))
    planes = PlaneGas(model, sites, seed=5, threads=threads, block=block, **more)
    fetched = 0
    for steps in data.draw(st.lists(st.integers(0, 30), min_size=1, max_size=3)):
        plain.advance(steps)
        planes.advance(steps)
        assert_same([plain, planes])
        assert planes.passes.sum() == rows * plain.time
        # each block of steps fetches all rows once, and once more those of the triangles between the stretches
        lengths = [min(planes._block, steps - start) for start in range(0, steps, planes._block)]
        fetched += sum(rows + 2 * threads * (length - 1) for length in lengths)
        assert planes.fetches.sum() == fetched


@pytest.mark.parametrize("columns", [9000, 70_000])
def test_rows_as_wide_as_a_cache(columns: int) -> None:
    """Bands of few rows, and blocks of few steps."""
    sites = random_sites(FHP, 24, columns)
    gases = [PlaneGas(FHP, sites, block=1), PlaneGas(FHP, sites), PlaneGas(FHP, sites, threads=2)]
    assert 2 < gases[1]._band < 16
    for gas in gases:
        gas.advance(25)
    assert_same(list(gases))


@given(st.integers(1, 300), st.integers(1, 9), st.integers(1, 40))
def test_tiles_of_a_block_hold_each_row_of_each_step_once_and_after_its_neighbours(
    rows: int, threads: int, most: int
) -> None:
    block, phases = _tiling(rows, threads, most)
    assert 1 <= block <= most
    steps_of = np.zeros(rows, dtype=int)
    for tiles in phases:
        before = steps_of.copy()  # tiles of one phase know nothing of each other
        for first, last, slope in tiles:
            here = before.copy()
            for step in range(block):
                moved = np.arange(first + slope * (step + 1), last - slope * (step + 1)) % rows
                needed = np.concatenate([moved - 1, moved, moved + 1]) % rows
                if slope:
                    assert (here[moved] == step).all()
                    assert ((here[needed] == step) | (here[needed] == step + 1)).all()
                here[moved] += 1
            steps_of += here - before
    assert (steps_of == block).all()


@every_evolver
def test_pieces_of_a_run_and_seeds(evolver: Callable[..., LatticeGas]) -> None:
    sites = random_sites(FHP, 6, 100)
    whole, cut, other = (evolver(FHP, sites, seed=seed) for seed in (3, 3, 4))
    whole.advance(7)
    other.advance(7)
    for steps in (3, 0, 1, 3):
        cut.advance(steps)
    assert_same([whole, cut])
    assert (other.sites != whole.sites).any()


@every_evolver
def test_states_go_in_and_out_and_stay(evolver: Callable[..., LatticeGas]) -> None:
    sites = random_sites(FHP, 6, 100)
    given_sites = sites.copy()
    gas = evolver(FHP, given_sites)
    found = gas.sites
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, sites)
    gas.advance(2)
    assert (gas.sites != sites).any()
    for kept in (given_sites, found):
        np.testing.assert_array_equal(kept, sites)


@plain_and_planes
@given(data=st.data())
def test_populations_are_counts(evolver: Callable[..., LatticeGas], data: st.DataObject) -> None:
    down, across = data.draw(st.integers(1, 4)), data.draw(st.integers(1, 6))
    tall, wide = 2 * data.draw(st.integers(1, 2)), data.draw(st.integers(1, 90))
    sites = random_sites(FHP, down * tall, across * wide, data.draw(st.integers(0, 99)))
    blocks = channels_of(FHP, sites).reshape(down, tall, across, wide, FHP.channels)
    np.testing.assert_array_equal(evolver(FHP, sites).populations(down, across), blocks.sum(axis=(1, 3)))


@every_evolver
def test_populations_leave_out_what_lies_beside_the_rows(evolver: Callable[..., LatticeGas]) -> None:
    gas = evolver(FHP, random_sites(FHP, 4, 133))
    gas.advance(3)
    for blocks in ((1, 1), (2, 7), (4, 133)):
        expected = channels_of(FHP, gas.sites).reshape(blocks[0], 4 // blocks[0], blocks[1], -1, FHP.channels)
        np.testing.assert_array_equal(gas.populations(*blocks), expected.sum(axis=(1, 3)))


def test_a_gas_without_walls_and_force_has_a_kernel_without_them() -> None:
    PlaneGas(FHP, random_sites(FHP, 2, 5)).advance(1)
    everywhere = [signature for signature in advance.signatures if signature[0] == typeof(FHP)]
    absent = [[place for place in range(3, 6) if signature[place] == types.none] for signature in everywhere]
    assert [3, 4, 5] in absent
    assert all(signature[place] != types.none for signature in everywhere for place in (1, 2, 6))


# -- what is conserved -------------------------------------------------------------------------------------------------


@st.composite
def lattices(draw: st.DrawFn, model: Model) -> np.ndarray:
    shape = (2 * draw(st.integers(1, 3)), draw(st.integers(1, 70)))
    return draw(arrays(np.uint8, shape, elements=st.integers(0, model.velocities.states - 1)))


@every_evolver
@given(model=models, data=st.data())
def test_mass_and_momentum_are_conserved(model: Model, evolver: Callable[..., LatticeGas], data: st.DataObject) -> None:
    sites = data.draw(lattices(model))
    gas = evolver(model, sites, seed=data.draw(st.integers(0, 9)))
    gas.advance(data.draw(st.integers(1, 5)))
    np.testing.assert_array_equal(totals(model, gas.sites), totals(model, sites))


@given(model=models, data=st.data())
def test_walls_of_any_rule_and_a_force_keep_the_mass(model: Model, data: st.DataObject) -> None:
    sites = data.draw(lattices(model))
    walls = data.draw(arrays(np.uint8, sites.shape, elements=st.integers(0, 15)))
    gas = PlainGas(model, sites, walls=walls, forcing=Forcing(0, 0.5))
    gas.advance(data.draw(st.integers(1, 5)))
    assert totals(model, gas.sites)[0] == totals(model, sites)[0]


@given(model=models, data=st.data())
def test_momentum_along_smooth_walls_is_what_the_force_gave(model: Model, data: st.DataObject) -> None:
    sites = data.draw(lattices(model))
    walls = np.zeros(sites.shape, dtype=np.uint8)
    walls[data.draw(st.integers(0, len(walls) - 1))] = SPECULAR_Y
    channel = data.draw(st.sampled_from([0, against(model)]))
    gas = PlainGas(model, sites, walls=walls, forcing=Forcing(channel, 0.5))
    gas.advance(data.draw(st.integers(1, 5)))
    gained = totals(model, gas.sites)[1] - totals(model, sites)[1]
    assert gained == 2 * model.velocities.integers[channel][0] * gas.impulses.sum()


@plain_and_planes
@given(data=st.data())
def test_hpp_runs_backwards_to_where_it_came_from(evolver: type[LatticeGas], data: st.DataObject) -> None:
    sites = data.draw(lattices(HPP))
    walls = data.draw(arrays(np.uint8, sites.shape, elements=st.sampled_from([0, 0, 0, *range(4)])))
    walls[0, 0] = BOUNCE_BACK  # else some had none, and another kernel
    gas = evolver(HPP, sites, walls=walls)
    steps = data.draw(st.integers(0, 9))
    gas.advance(steps)
    there = gas.sites.copy()
    gas.reverse()
    once = gas.sites.copy()
    gas.reverse()
    np.testing.assert_array_equal(gas.sites, there)
    gas.reverse()
    np.testing.assert_array_equal(gas.sites, once)
    gas.advance(steps)
    gas.reverse()
    np.testing.assert_array_equal(gas.sites, sites)


def test_reversal_reverses_the_momentum() -> None:
    gas = PlainGas(HPP, random_sites(HPP, 6, 50))
    before = totals(HPP, gas.sites)
    assert before[1:].all()
    gas.reverse()
    np.testing.assert_array_equal(totals(HPP, gas.sites), before * [1, -1, -1])


# -- propagation -------------------------------------------------------------------------------------------------------


@each_set
@plain_and_planes
def test_a_lone_particle_flies_straight_and_comes_back(model: Model, evolver: Callable[..., LatticeGas]) -> None:
    rows, columns = 6, 9
    period = math.lcm(rows, 2 * columns)
    v = model.velocities
    box = np.array([columns, rows * v.row_height])
    where = np.stack(places(model, rows, columns), axis=-1)
    for channel, row in product(range(model.channels), (2, 5)):
        sites = np.zeros((rows, columns), dtype=np.uint8)
        sites[row, 4] = 1 << channel
        gas = evolver(model, sites)
        for step in range(1, period + 1):
            gas.advance(1)
            (here,) = np.argwhere(gas.sites)
            assert gas.sites[tuple(here)] == 1 << channel
            away = where[tuple(here)] - where[row, 4] - step * v.cartesian[channel]
            np.testing.assert_allclose(away - box * np.round(away / box), 0, atol=1e-12)
        np.testing.assert_array_equal(gas.sites, sites)


@pytest.mark.parametrize("name", MODELS)
def test_places_of_neighbours(name: str) -> None:
    x, y = places(MODELS[name], 4, 7)
    assert x.shape == y.shape == (4, 7)
    (right, up), odd = (x[0, 1] - x[0, 0], y[1, 0] - y[0, 0]), x[1, 0] - x[0, 0]
    assert right == 1
    assert math.hypot(odd, up) == pytest.approx(1, rel=1e-15)
    assert (odd, x[2, 0]) == ((0, 0) if name == "hpp" else (0.5, 0))


# -- collisions --------------------------------------------------------------------------------------------------------


@every_model
def test_outcomes_are_equally_frequent(model: Model) -> None:
    """A lattice in one state stays uniform as it propagates. p < 1e-7 is a false alarm once in 2e5 sets of seeds."""
    for state in range(model.velocities.states):
        outcomes = model.outcomes[state]
        size = (64, 512) if len(outcomes) > 1 else (2, 64)
        gas = PlainGas(model, np.full(size, state, dtype=np.uint8), seed=state)
        gas.advance(1)
        counts = np.bincount(gas.sites.ravel(), minlength=model.velocities.states)
        assert counts[list(outcomes)].sum() == counts.sum()
        assert chisquare(counts[list(outcomes)]).pvalue > 1e-7 if len(outcomes) > 1 else True


def test_outcomes_of_steps_and_rows_are_independent() -> None:
    """Two outcomes of head-on pairs: agreement of a site at two steps, and of neighbours, in half of the cases."""
    found = []
    for start in (0, 1):
        gas = PlainGas(FHP, np.full((64, 512), 9, dtype=np.uint8))
        gas.time = start
        gas.advance(1)
        found.append(gas.sites == 18)
    first, second = found
    for one, other in ((first, second), (first[1:], first[:-1]), (first[:, 1:], first[:, :-1])):
        assert abs(2 * (one == other).mean() - 1) * one.size**0.5 < LIMIT


# -- walls -------------------------------------------------------------------------------------------------------------


def at_a_wall(model: Model, rule: int, channel: int, size: tuple[int, int] = (2, 4)) -> np.ndarray:
    """What leaves wall sites at which particles have arrived in this channel."""
    gas = PlainGas(model, np.full(size, 1 << channel, dtype=np.uint8), walls=np.full(size, rule))
    gas.advance(1)
    return gas.sites


@each_set
@pytest.mark.parametrize(("rule", "signs"), [(BOUNCE_BACK, (-1, -1)), (SPECULAR_X, (-1, 1)), (SPECULAR_Y, (1, -1))])
def test_walls_reverse_components(model: Model, rule: int, signs: tuple[int, int]) -> None:
    for channel, reversed_ in enumerate(model.velocities.image(*signs)):
        np.testing.assert_array_equal(at_a_wall(model, rule, channel), 1 << reversed_)


@each_set
@pytest.mark.parametrize(
    ("rule", "signs"),
    [
        (DIFFUSIVE_X, ((-1, 1), (-1, -1))),
        (DIFFUSIVE_Y, ((1, -1), (-1, -1))),
        (DRAW_X, ((1, 1), (-1, 1))),
        (DRAW_Y, ((1, 1), (1, -1))),
        (REVERSE_X | DRAW_X, ((-1, 1), (-1, 1))),
        (REVERSE_Y | DRAW_Y, ((1, -1), (1, -1))),
    ],
)
def test_diffusive_walls_draw_one_of_two_channels(model: Model, rule: int, signs: Any) -> None:
    images = [model.velocities.image(*both) for both in signs]
    for channel in range(model.channels):
        left = {1 << image[channel] for image in images}
        found = at_a_wall(model, rule, channel, (40, 500))
        assert set(np.unique(found)) == left
        if len(left) == 2:
            assert abs(2 * (found == min(left)).mean() - 1) * found.size**0.5 < LIMIT


@each_set
def test_a_particle_bounces_back_to_where_it_came_from(model: Model) -> None:
    v = model.velocities
    for channel, opposite in enumerate(v.image(-1, -1)):
        walls = np.full((6, 9), BOUNCE_BACK, dtype=np.uint8)
        walls[2, 4] = 0
        sites = np.zeros((6, 9), dtype=np.uint8)
        sites[2, 4] = 1 << channel
        gas = PlainGas(model, sites, walls=walls)
        gas.advance(2)
        expected = np.zeros_like(sites)
        expected[2, 4] = 1 << opposite
        np.testing.assert_array_equal(gas.sites, expected)


def test_walls_do_not_collide_nor_feel_the_force() -> None:
    """Head-on pairs and particles against the force go through walls that reverse nothing in the end."""
    sites = np.full((2, 64), 0b001001, dtype=np.uint8)
    gas = PlainGas(FHP, sites, walls=np.full(sites.shape, BOUNCE_BACK), forcing=Forcing(0, 1.0))
    gas.advance(3)
    np.testing.assert_array_equal(gas.sites, sites)
    assert not gas.impulses.any()


# -- the force ---------------------------------------------------------------------------------------------------------


@each_set
@pytest.mark.parametrize("probability", [0.1, 0.5, 2.0**-7])
def test_the_force_turns_its_share(model: Model, probability: float) -> None:
    """p f_opp (1 - f) of independent channels; what arrives in the first step is independent."""
    size = (200, 500)
    for channel, back in ((0, against(model)), (against(model), 0)):
        f = np.full(model.channels, 0.25)
        f[channel], f[back] = 0.3, 0.6
        sites = drawn_sites(np.broadcast_to(f, (*size, model.channels)), np.random.default_rng(channel))
        gas = PlainGas(model, sites, forcing=Forcing(channel, probability))
        gas.advance(1)
        share, number = probability * 0.6 * (1 - 0.3), size[0] * size[1]
        assert abs(gas.impulses.sum() - share * number) < LIMIT * (share * (1 - share) * number) ** 0.5


@pytest.mark.parametrize("channel", [0, 2])
def test_a_certain_force_turns_all_it_can_and_counts_it_by_row(channel: int) -> None:
    sites = np.zeros((4, 10), dtype=np.uint8)
    sites[1, :7] = 1 << 2 - channel  # against the force
    sites[2] = 1 << 0 | 1 << 2  # no room
    sites[3, :3] = 1 << channel
    gas = PlainGas(HPP, sites, forcing=Forcing(channel, 1.0))
    gas.advance(1)
    np.testing.assert_array_equal(gas.impulses, [0, 7, 0, 0])
    np.testing.assert_array_equal(np.bincount(gas.sites[1], minlength=16)[[0, 1 << channel]], [3, 7])
    gas.advance(1)
    np.testing.assert_array_equal(gas.impulses[[1, 3]], [7, 0])


# -- states of the start -----------------------------------------------------------------------------------------------


def test_channels_are_filled_independently() -> None:
    f = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    number = 200 * 500
    sites = drawn_sites(np.broadcast_to(f, (200, 500, 5)), np.random.default_rng(3))
    filled = (sites[..., None] >> np.arange(5) & 1).reshape(-1, 5)
    deviation = np.sqrt(f * (1 - f))
    assert (np.abs(filled.mean(axis=0) - f) <= LIMIT * deviation / number**0.5).all()
    covariance = (filled - f).T @ (filled - f) / number
    off = covariance - np.diag(np.diag(covariance))
    assert (np.abs(off) <= LIMIT * np.outer(deviation, deviation) / number**0.5).all()


@given(data=st.data())
def test_cells_have_exact_numbers(data: st.DataObject) -> None:
    model = data.draw(models)
    cell = data.draw(st.integers(1, 5))
    shape = (data.draw(st.integers(1, 4)), data.draw(st.integers(1, 4)))
    density = data.draw(arrays(np.float64, shape, elements=st.floats(0, 1)))
    sites = filled_cells(model, density, cell, np.random.default_rng(data.draw(st.integers(0, 99))))
    assert sites.dtype == np.uint8
    blocks = channels_of(model, sites).reshape(shape[0], cell, shape[1], cell, model.channels)
    expected = [[round(d * cell**2 * model.channels) for d in row] for row in density.tolist()]
    np.testing.assert_array_equal(blocks.sum(axis=(1, 3, 4)), expected)


def test_particles_of_a_cell_are_anywhere_in_it() -> None:
    """Each of the 24 channels of a cell is filled in a quarter of the cells, and with any other in 6 x 5/(24 x 23)."""
    cells, cell, d = 200 * 200, 2, 0.25
    sites = filled_cells(FHP, np.full((200, 200), d), cell, np.random.default_rng(4))
    blocks = channels_of(FHP, sites).reshape(200, cell, 200, cell, 6).transpose(0, 2, 1, 3, 4).reshape(cells, 24)
    together = blocks.T @ blocks / cells
    for share, found in ((d, np.diag(together)), (30 / (24 * 23), together[~np.eye(24, dtype=bool)])):
        assert np.abs(found - share).max() < LIMIT * (share * (1 - share) / cells) ** 0.5


# -- refused -----------------------------------------------------------------------------------------------------------

GOOD = np.zeros((4, 6), dtype=np.uint8)


@plain_and_planes
@pytest.mark.parametrize(
    ("model", "sites", "more", "message"),
    [
        (HPP, GOOD[0], {}, r"sites must be a \(rows, columns\) array of uint8, got uint8 \(6,\)"),
        (HPP, GOOD[:, :0], {}, r"sites must be a \(rows, columns\) array of uint8, got uint8 \(4, 0\)"),
        (HPP, GOOD.astype(int), {}, r"array of uint8, got int64 \(4, 6\)"),
        (HPP, GOOD + np.uint8(16), {}, "state 16 is beyond the 4 channels of hpp"),
        (FHP, GOOD + np.uint8(64), {}, "state 64 is beyond the 6 channels of fhp1"),
        (FHP, GOOD[:3], {}, "3 rows: a periodic triangular lattice needs an even number"),
        (HPP, GOOD, {"walls": GOOD[:3]}, r"walls must have the shape of the sites, \(4, 6\), got \(3, 6\)"),
        (HPP, GOOD, {"walls": GOOD + np.uint8(16)}, r"walls are rules 0 ... 15, got \d+ ... \d+"),
        (HPP, GOOD, {"seed": -1}, r"seed = -1 must be in 0 ... 2\^63 - 1"),
        (HPP, GOOD, {"seed": 2**63}, "seed = 9223372036854775808 must be in"),
        (HPP, GOOD, {"forcing": Forcing(1, 0.5)}, r"a force along channel 1: it must be \+x or -x"),
        (MODELS["fhp3"], GOOD, {"forcing": Forcing(6, 0.5)}, "a force along channel 6"),
        (HPP, GOOD, {"forcing": Forcing(0, 1.5)}, r"forcing.probability = 1.5 is not in \[0, 1\]"),
        (HPP, GOOD, {"forcing": Forcing(0, -0.5)}, r"forcing.probability = -0.5 is not"),
        (HPP, GOOD, {"forcing": Forcing(0, math.nan)}, r"forcing.probability = nan is not"),
    ],
)
def test_gases_that_there_are_not(
    evolver: Callable[..., LatticeGas], model: Model, sites: np.ndarray, more: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        evolver(model, sites, **more)


def test_threads_share_a_phase_at_the_same_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each waits for the others where the kernel runs: one after the other they would wait in vain."""
    meeting = threading.Barrier(3, timeout=60)

    def kernel(*arguments: Any) -> None:
        steps = arguments[-3]
        if steps:
            meeting.wait()

    monkeypatch.setattr(bitplanes, "advance", kernel)
    gas = PlaneGas(FHP, random_sites(FHP, 24, 5), threads=3)
    gas.advance(9)
    assert gas.time == 9
    assert advance.targetoptions["nogil"]


def test_threads_and_blocks_that_there_are_not() -> None:
    with pytest.raises(ValueError, match="threads = 0 must be at least 1"):
        PlaneGas(HPP, GOOD, threads=0)
    with pytest.raises(ValueError, match="block = 0 must be at least 1"):
        PlaneGas(HPP, GOOD, block=0)


@plain_and_planes
@pytest.mark.parametrize("blocks", [(3, 2), (2, 4), (0, 1), (1, 0), (8, 1), (-1, 1)])
def test_blocks_that_do_not_fit(evolver: Callable[..., LatticeGas], blocks: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match=f"{blocks[0]} x {blocks[1]} blocks do not divide 4 rows and 6 columns evenly"):
        evolver(HPP, GOOD).populations(*blocks)


RANDOM = "only dynamics without random numbers can be reversed"


@pytest.mark.parametrize(
    ("model", "more", "message"),
    [
        (FHP, {}, RANDOM),
        (HPP, {"forcing": Forcing(0, 0.1)}, RANDOM),
        (HPP, {"walls": GOOD + np.uint8(DIFFUSIVE_X)}, RANDOM),
        (HPP, {"walls": GOOD + np.uint8(DIFFUSIVE_Y)}, RANDOM),
        (
            Model("wheel", HPP.velocities, ((0,), (2,), (4,), (3,), (8,), *((s,) for s in range(5, 8)), (1,),
                  *((s,) for s in range(9, 16)))),
            {},
            "the collisions of wheel are not their own inverse",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_reversed(model: Model, more: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        PlainGas(model, GOOD, **more).reverse()
