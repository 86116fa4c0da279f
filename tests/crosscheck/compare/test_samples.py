"""Statistics of two trajectories: what is the same is said to be, and what is not is seen."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crosscheck.compare.pairing import pair
from crosscheck.compare.samples import LEVEL, compare_samples, compare_series, different, series_of, shell_edges
from crosscheck.trajectories.frames import Box, Floats
from crosscheck.trajectories.memory import InMemory, in_memory

SIDE, NUMBER, FRAMES = 10.0, 200, 120


def gas(seed: int, temperature: float = 1.0, *, axis: float = 1.0, hot: float = 1.0) -> InMemory:
    """Free particles whose velocities are drawn anew now and then, as by a thermostat."""
    rng = np.random.default_rng(seed)
    positions = np.empty((FRAMES, NUMBER, 3))
    velocities = np.empty((FRAMES, NUMBER, 3))
    x = rng.random((NUMBER, 3)) * SIDE
    scale = np.sqrt(temperature) * np.array([1.0, 1.0, axis**0.5]) * np.ones((NUMBER, 1))
    scale[NUMBER // 2 :] *= hot**0.5
    v = rng.standard_normal((NUMBER, 3)) * scale
    for k in range(FRAMES):
        new = rng.random(NUMBER) < 0.9
        v[new] = (rng.standard_normal((NUMBER, 3)) * scale)[new]
        x = x + 0.1 * v
        positions[k], velocities[k] = x, v
    types = np.repeat([1, 2], NUMBER // 2)
    box = Box(SIDE * np.eye(3), np.zeros(3), np.ones(3, dtype=bool))
    return in_memory(f"gas-{seed}", np.arange(FRAMES) * 0.1, positions, velocities, types=types, box=box)


def found(one: InMemory, other: InMemory) -> list[Any]:
    return compare_samples(one, other, pair(one, other), 0.0)


def test_the_same_gas_is_the_same() -> None:
    for seed in range(4):
        tested = found(gas(seed), gas(100 + seed))
        assert different(tested) == []
        names = [one.name for one in tested]
        assert {"mean v_z^2 of type 2", "mean v^4 of type 1", "mean square displacement over 4 frames"} <= set(names)
        assert sum(name.startswith("neighbours") for name in names) >= 10
        best = min(one.sensitivity for one in tested if one.name.startswith("mean v^2"))
        # the error of the difference is (2/300)^1/2 (2/100)^1/2 of the mean: 100 particles, about as many frames
        assert 5 * 0.0115 < best < 20 * 0.0115


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"temperature": 1.3}, "mean v^2"),
        ({"axis": 1.5}, "mean v_z^2"),
        ({"hot": 1.3}, "mean v^2 of type 2"),
    ],
)
def test_other_velocities_are_seen(changes: dict[str, float], name: str) -> None:
    first = different(found(gas(1), gas(2, **changes)))
    assert any(one.name.startswith(name) for one in first[:4]), first
    # the deviation is what its sensitivity said would be seen
    assert all(abs(one.first - one.second) > 0.5 * one.sensitivity * abs(one.first) for one in first)


def test_other_distances_are_seen() -> None:
    rng = np.random.default_rng(5)
    one, other = (
        in_memory(str(k), np.arange(FRAMES) * 0.1, rng.random((FRAMES, NUMBER, 3)) * SIDE, box=gas(1).box)
        for k in range(2)
    )
    closer = other.positions.copy()
    closer[:, ::2] = closer[:, 1::2] + np.array([0.9, 0.0, 0.0])  # pairs
    paired = in_memory("pairs", other.times, closer, box=other.box)
    assert any(one.name.startswith("neighbours at distances 0.8") for one in different(found(one, paired)))


def test_wrapped_positions_have_the_same_displacements() -> None:
    one = gas(3)
    folded = one.positions - np.floor(one.positions / SIDE) * SIDE
    wrapped = in_memory("wrapped", one.times, folded, one.velocities, types=one.types, box=one.box, wrapping="wrapped")
    for tested in found(one, wrapped):
        assert tested.first == pytest.approx(tested.second, rel=1e-4), tested.name


def test_walls_that_one_file_states_hold_for_the_statistics_of_both() -> None:
    one = gas(3)
    assert one.box is not None
    folded = one.positions - np.floor(one.positions / SIDE) * SIDE
    walls, open_ = (one.box._replace(periodic=np.zeros(3, dtype=bool), stated=stated) for stated in (True, False))
    dump = in_memory("dump", one.times, folded, one.velocities, box=walls)
    xtc = in_memory("xtc", one.times, folded, one.velocities, box=open_._replace(periodic=np.ones(3, dtype=bool)),
                    wrapping="wrapped")  # fmt: skip
    for pairs in ((dump, xtc), (xtc, dump)):
        for tested in found(*pairs):
            assert tested.first == tested.second, tested.name


def test_displacements_are_those_of_mdanalysis() -> None:
    from MDAnalysis import Universe
    from MDAnalysis.analysis.msd import EinsteinMSD

    one = gas(4)
    still = one.positions - one.positions.mean(axis=1, keepdims=True)  # it does not take the mean motion away
    universe = Universe.empty(NUMBER, trajectory=True).load_new(still)
    theirs = EinsteinMSD(universe, fft=False).run().results.timeseries
    edges = np.linspace(0.0, 1.0, 3)
    ours = series_of(in_memory("still", one.times, still, one.velocities).frames(), False, edges)
    assert one.velocities is not None
    for lag in (1, 4, 16):
        # their positions have 32 bits
        assert ours[f"mean square displacement over {lag} frames"].mean() == pytest.approx(theirs[lag], rel=1e-5)
        products = [np.sum(one.velocities[k] * one.velocities[k + lag], axis=1).mean() for k in range(FRAMES - lag)]
        assert ours[f"velocity autocorrelation over {lag} frames"] == pytest.approx(products, rel=1e-12)


def test_neighbours_are_those_of_mdanalysis() -> None:
    from MDAnalysis import Universe
    from MDAnalysis.analysis.rdf import InterRDF

    rng = np.random.default_rng(8)
    positions = rng.random((5, NUMBER, 3)) * SIDE
    source = in_memory("gas", np.arange(5.0), positions, box=gas(1).box)
    edges = shell_edges(source.read(0))
    universe = Universe.empty(NUMBER, trajectory=True)
    universe.load_new(positions, dimensions=np.array([SIDE, SIDE, SIDE, 90, 90, 90]))
    rdf = InterRDF(
        universe.atoms, universe.atoms, nbins=len(edges) - 1, range=(0.0, edges[-1]), exclusion_block=(1, 1)
    ).run()
    ours = series_of(source.frames(), False, edges)
    counts = [values.sum() * NUMBER for name, values in ours.items() if name.startswith("neighbours")]
    assert counts == pytest.approx(rdf.results.count.tolist(), rel=1e-9)


def test_in_open_space_distances_are_what_they_are_and_in_a_small_box_shells_end_at_half_of_it() -> None:
    positions = np.random.default_rng(8).random((1, NUMBER, 3)) * SIDE
    source = in_memory("open", np.zeros(1), positions)
    edges = shell_edges(source.read(0))
    found = series_of(source.frames(), False, edges)
    apart = np.linalg.norm(positions[0][:, None] - positions[0], axis=2)[np.triu_indices(NUMBER, 1)]
    counts, _ = np.histogram(apart, bins=edges)
    shown = [float(values[0]) for name, values in found.items() if name.startswith("neighbours")]
    assert [one * NUMBER for one in shown] == pytest.approx((2 * counts).tolist(), rel=1e-9)
    few = in_memory("few", np.zeros(1), positions[:, :8], box=gas(1).box).read(0)
    assert SIDE / 2 * (1 - 1e-4) < shell_edges(few)[-1] < SIDE / 2
    assert few.box is not None
    walls = few._replace(box=few.box._replace(periodic=np.zeros(3, dtype=bool)))
    assert shell_edges(walls)[-1] == pytest.approx(3 * (1000 / 8) ** (1 / 3))


@pytest.mark.parametrize("unit", [1e-10, 1e6])
def test_neighbours_do_not_depend_on_the_unit_of_length(unit: float) -> None:
    positions = np.random.default_rng(8).random((1, NUMBER, 3)) * SIDE
    box = gas(1).box
    assert box is not None
    here = in_memory("a", np.zeros(1), positions, box=box)
    there = in_memory("b", np.zeros(1), positions * unit, box=box._replace(vectors=box.vectors * unit))
    mine, yours = (series_of(one.frames(), False, shell_edges(one.read(0))) for one in (here, there))
    assert [float(one[0]) for one in mine.values()] == pytest.approx([float(one[0]) for one in yours.values()], abs=0.1)
    assert sum(float(one[0]) for one in mine.values()) > 1


def test_of_many_particles_some_are_looked_at() -> None:
    """200,000 pairs of a frame: of 2000 particles, every twentieth."""
    positions = np.random.default_rng(8).random((1, 2000, 3)) * SIDE
    source = in_memory("gas", np.zeros(1), positions, box=gas(1).box)
    found = series_of(source.frames(), False, shell_edges(source.read(0)))
    counts = np.array([float(values[0]) for name, values in found.items() if name.startswith("neighbours")])
    assert counts.sum() > 50
    assert counts * 100 == pytest.approx(np.rint(counts * 100), abs=1e-9)


def series(rng: np.random.Generator, length: int, correlation: float) -> Floats:
    noise = rng.standard_normal(length)
    values = np.empty(length)
    values[0] = noise[0]
    for k in range(1, length):
        values[k] = correlation * values[k - 1] + (1 - correlation**2) ** 0.5 * noise[k]
    return values


def test_correlated_series_are_rarely_called_different() -> None:
    """Of 100 pairs of ten series each, at a level of 1e-4 for all ten, none."""
    rng = np.random.default_rng(7)
    called = 0
    for _ in range(100):
        pairs = [{str(k): series(rng, 200, 0.8) for k in range(10)} for _ in range(2)]
        called += bool(different(compare_series(*pairs)))
    assert LEVEL == 1e-4
    assert called == 0


def test_short_series_are_unclear_and_constants_are_left_out() -> None:
    rng = np.random.default_rng(1)
    tested = compare_series({"a": series(rng, 6, 0.0), "b": np.ones(50)}, {"a": series(rng, 6, 0.0), "b": np.ones(50)})
    assert [(one.name, one.outcome) for one in tested] == [("a", "unclear")]
    (enough,) = compare_series({"a": series(rng, 14, 0.0)}, {"a": series(rng, 14, 0.0)})
    assert 8 < enough.independent < 16
    assert enough.outcome == "same"
