"""Scenes of lattice gases: to TOML and back, one message for each mistake, walls, and sites as the scene says.

Sites are drawn with fixed seeds; by chance, one of 3e7 mean values is off by more than LIMIT standard errors with
another.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_files import assert_survives_files

from crosscheck.errors import UsageError
from crosscheck.references.lattice_models import fermi_dirac
from crosscheck.scene import (
    LatticeGas,
    Method,
    Obstacle,
    Occupations,
    Output,
    Scene,
    Wave,
)
from crosscheck.scene.observables import named
from refimpl.lattice.gas import BOUNCE_BACK, DIFFUSIVE_X, DIFFUSIVE_Y, SPECULAR_X, SPECULAR_Y, places
from refimpl.lattice.models import MODELS

LIMIT = 5.5
RULES = {
    "bounce_back": BOUNCE_BACK,
    "specular_x": SPECULAR_X,
    "specular_y": SPECULAR_Y,
    "diffusive_x": DIFFUSIVE_X,
    "diffusive_y": DIFFUSIVE_Y,
}
finite = st.floats(-1e100, 1e100)


def gas_scene(model: str = "fhp1", rows: int = 10, columns: int = 20, **changes: Any) -> Scene:
    """A gas at rest; `initial` and `lattice_gas` add to the entries of these tables."""
    gas = {"model": model, "rows": rows, "columns": columns} | changes.pop("lattice_gas", {})
    start = {"kind": "occupations", "seed": 1} | changes.pop("initial", {"density": 0.3})
    entries: dict[str, Any] = {"name": "gas", "dimension": 2, "duration": 10.0}
    return Scene(**(entries | changes), lattice_gas=LatticeGas(**gas), initial=Occupations(**start))


# -- there and back ----------------------------------------------------------------------------------------------------


def ends(size: int) -> st.SearchStrategy[tuple[int, int]]:
    return st.lists(st.integers(0, size - 1), min_size=2, max_size=2).map(sorted).map(tuple)


@st.composite
def obstacles(draw: st.DrawFn, rows: int, columns: int) -> Obstacle:
    row, column, length = st.integers(0, rows - 1), st.integers(0, columns - 1), st.floats(0.01, 1e3)
    where: dict[str, Any] = draw(
        st.fixed_dictionaries({"columns": ends(columns)}, optional={"rows": ends(rows)})
        | st.fixed_dictionaries({"rows": ends(rows)})
        | st.fixed_dictionaries({"centre": st.tuples(finite, finite), "radius": length})
        | st.fixed_dictionaries({"sites": st.lists(st.tuples(column, row), min_size=1, max_size=3).map(tuple)})
    )
    return Obstacle(**where, rule=draw(st.sampled_from(list(RULES))))


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """Any valid scene of a lattice gas; the initial state may be impossible."""
    name = draw(st.sampled_from(list(MODELS)))
    blocks, cells = draw(st.tuples(st.integers(1, 4), st.integers(1, 4))), draw(st.integers(1, 3))
    columns, rows = (2 * cells * number for number in blocks)
    duration = draw(st.integers(0, 1000))
    force = draw(st.none() | st.floats(-1, 1))
    walls = draw(st.lists(obstacles(rows, columns), max_size=3).map(tuple))
    drawn = any(wall.rule.startswith("diffusive") for wall in walls)
    reversals = None
    if name == "hpp" and force is None and not drawn and duration > 0:
        times = st.sets(st.integers(1, duration), min_size=1, max_size=3).map(sorted).map(tuple)
        reversals = draw(st.none() | times)
    one_or_rows = finite | st.lists(finite, min_size=rows, max_size=rows).map(tuple)
    kinds = ["density"]
    start: dict[str, Any] = {"seed": draw(st.integers(0, 2**63 - 1))}
    match draw(st.sampled_from(["channels", "cells", "rows"])):
        case "channels":
            filling, number = st.floats(0, 1), MODELS[name].channels
            start["channels"] = draw(st.lists(filling, min_size=number, max_size=number).map(tuple))
            kinds = []
        case "cells":
            start |= {"density": draw(finite), "cells": cells}
        case "rows":
            start |= {key: draw(one_or_rows) for key in ("density", "velocity_x", "velocity_y")}
            kinds += ["velocity_x", "velocity_y"]
    if kinds:
        modes = st.tuples(finite, finite)
        waves = st.builds(Wave, of=st.sampled_from(kinds), amplitude=finite, mode=modes, phase=finite)
        start["waves"] = draw(st.lists(waves, max_size=2).map(tuple))
    tallies = [tally for tally in named("lattice_gas") if tally != "force_impulse" or force is not None]
    return Scene(
        name=draw(st.sampled_from(["", "gas", "ein Gas \u03c3"])),
        dimension=2,
        duration=duration,
        seed=draw(st.none() | st.integers(0, 2**63 - 1)),
        lattice_gas=LatticeGas(
            model=name, rows=rows, columns=columns, obstacles=walls, force=force, reversals=reversals
        ),
        initial=Occupations(kind="occupations", **start),
        output=Output(
            interval=draw(st.integers(1, 99)),
            observables=tuple(draw(st.lists(st.sampled_from(tallies), unique=True))),
            fields=draw(st.none() | st.just(blocks)),
        ),
        method=draw(st.none() | st.builds(Method, scheme=st.text())),
    )


@given(scene=scenes())
def test_toml_and_json_give_back_an_equal_scene(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> None:
    assert_survives_files(scene, tmp_path_factory.getbasetemp())
    assert scene.number == 0


# -- mistakes ----------------------------------------------------------------------------------------------------------

GAS: dict[str, Any] = {
    "name": "a",
    "dimension": 2,
    "duration": 10.0,
    "lattice_gas": {"model": "hpp", "rows": 10, "columns": 20},
    "initial": {"kind": "occupations", "density": 0.3, "seed": 1},
}
OTHER: dict[str, Any] = {
    "name": "a",
    "dimension": 1,
    "duration": 1.0,
    "spring": {"k": 1.0},
    "initial": {"kind": "explicit", "positions": [[1.0]]},
}


def changed(table: dict[str, Any], *changes: tuple[str, Any]) -> dict[str, Any]:
    """A copy with other values at these paths, or without the key, if the value is ..."""
    for path, value in changes:
        key, _, rest = path.partition(".")
        new = changed(table.get(key, {}), (rest, value)) if rest else value
        table = {k: v for k, v in (table | {key: new}).items() if v is not ...}
    return table


def message_of(table: dict[str, Any], do: str = "changed") -> str:
    """The one message of the UsageError from reading the table, and from this method of its scene."""
    with pytest.raises(UsageError) as error:
        getattr(Scene.from_json(json.dumps(table)), do)()
    (line,) = str(error.value).splitlines()
    return line


INTERVAL = ("output.interval", 1)


@pytest.mark.parametrize(
    ("table", "changes", "message"),
    [
        (OTHER, [("initial", GAS["initial"])], "initial.kind = 'occupations' fills a lattice: add [lattice_gas]"),
        (OTHER, [INTERVAL, ("output.observables", ["populations"])],
         "output.observables: 'populations' goes with [lattice_gas] only: remove it"),
        (OTHER, [("output.observables", ["sites"])], "output.observables: 'sites' goes with [lattice_gas] only"),
        (GAS, [("initial", {"kind": "explicit", "positions": [[1.0, 1.0]]})],
         "initial.kind = 'explicit': a lattice gas starts from kind = 'occupations'"),
        (GAS, [("dimension", 3)], "dimension = 3: lattice gases are in dimension 2"),
        (GAS, [("spring", {"k": 1.0})], "found spring and lattice_gas"),
        (GAS, [("masses", 2.0)], "masses does not go with [lattice_gas]: remove it"),
        (GAS, [("species", [0])], "species does not go with [lattice_gas]"),
        (GAS, [("acceleration", [0.0, 1.0])], "acceleration does not go with [lattice_gas]"),
        (GAS, [("box", {"lengths": [1.0, 1.0]})], "[box]"),
        (GAS, [("output.collisions", [1])], "output.collisions does not go with [lattice_gas]"),
        (GAS, [INTERVAL, ("output.trajectory", True)], "output.trajectory does not go with [lattice_gas]"),
        (GAS, [INTERVAL, ("output.forces", True)], "output.forces does not go with [lattice_gas]"),
        (GAS, [INTERVAL, ("output.observables", ["virial"])],
         "output.observables: 'virial' is of particles; a lattice gas has populations, force_impulse, h_function, sit"),
        (GAS, [("output.observables", ["populations"])], "output.interval is missing: say how often to record"),
        (GAS, [("lattice_gas.model", "fhp")], "lattice_gas.model = 'fhp' is unknown: take one of hpp, fhp1, fhp2, "),
        (GAS, [("lattice_gas.model", "fhp1"), ("lattice_gas.rows", 9)],
         "lattice_gas.rows = 9: a periodic triangular lattice needs an even number"),
        (GAS, [("lattice_gas.rows", 0)], "lattice_gas.rows: Input should be greater than 0 (found 0)"),
        (GAS, [("lattice_gas.columns", 2.5)], "lattice_gas.columns: Input should be a valid integer"),
        (GAS, [("duration", 2.5)], "duration = 2.5: a lattice gas takes whole steps of 1"),
        (GAS, [("output.interval", 0.5)], "output.interval = 0.5: a lattice gas takes whole steps of 1"),
        (GAS, [("output.fields", [3, 2])], "output.fields = [3, 2] must divide 20 columns and 10 rows evenly"),
        (GAS, [("output.fields", [2, 4])], "output.fields = [2, 4] must divide 20 columns and 10 rows evenly"),
        (GAS, [("output.fields", [2])], "output.fields = [2] must divide"),
        (GAS, [INTERVAL, ("output.observables", ["force_impulse"])],
         "output.observables: 'force_impulse' needs lattice_gas.force"),
        (GAS, [("lattice_gas.force", 1.5)], "lattice_gas.force: Input should be less than or equal to 1 (found 1.5)"),
        (GAS, [("initial.density", "thin")], "initial.density: Input should be a valid number (found 'thin')"),
        (GAS, [("initial.density", [0.1, "thin"])], "initial.density.1: Input should be a valid number (found 'thin')"),
        (GAS, [("initial.density", [0.1] * 9)], "initial.density has 9 values for 10 rows: give one, or one per row"),
        (GAS, [("initial.velocity_x", [0.1])], "initial.velocity_x has 1 values for 10 rows"),
        (GAS, [("initial.velocity_y", [0.1] * 20)], "initial.velocity_y has 20 values for 10 rows"),
        (GAS, [("initial.density", ...), ("initial.channels", [0.1] * 6)],
         "initial.channels has 6 values, hpp has 4"),
        (GAS, [("initial.density", ...), ("initial.channels", [0.1, 0.2, 0.3, 1.5])],
         "initial.channels.3: Input should be less than or equal to 1 (found 1.5)"),
        (GAS, [("initial.cells", 4)], "initial.cells = 4 must divide 20 columns and 10 rows evenly"),
        (GAS, [("initial.cells", 3)], "initial.cells = 3 must divide 20 columns and 10 rows evenly"),
        (GAS, [("initial.cells", 5), ("initial.density", [0.1] * 10)], "density"),
        (GAS, [("initial.density", ...)], "initial: give exactly one of density and channels"),
        (GAS, [("initial.channels", [0.1] * 4)], "initial: give exactly one of density and channels"),
        (GAS, [("initial.seed", ...)], "'initial.seed' is missing: add it"),
        *(
            (GAS, [("initial.density", ...), ("initial.channels", [0.1] * 4), (f"initial.{key}", value)],
             "initial: channels gives all mean occupations: remove velocity_x, velocity_y, waves and cells")
            for key, value in (
                ("velocity_x", 0.1), ("velocity_y", [0.1] * 10), ("cells", 5),
                ("waves", [{"of": "density", "amplitude": 0.1, "mode": [1.0, 0.0]}]),
            )
        ),
        *(
            (GAS, [("initial.cells", 5), (f"initial.{key}", value)],
             "initial: cells fixes numbers of particles, not velocities: remove cells, or the velocities")
            for key, value in (
                ("velocity_x", 0.1), ("velocity_y", [0.1] * 10),
                ("waves", [{"of": "velocity_x", "amplitude": 0.1, "mode": [1.0, 0.0]}]),
            )
        ),
        (GAS, [("initial.waves", [{"of": "pressure", "amplitude": 0.1, "mode": [1.0, 0.0]}])],
         "initial.waves.0.of: Input should be 'density', 'velocity_x' or 'velocity_y' (found 'pressure')"),
        (GAS, [("lattice_gas.model", "fhp1"), ("lattice_gas.reversals", [5])],
         "lattice_gas.reversals: only dynamics without random numbers can be reversed: remove it"),
        (GAS, [("lattice_gas.force", 0.1), ("lattice_gas.reversals", [5])], "only dynamics without random numbers"),
        *(
            (GAS, [("lattice_gas.obstacles", [{"rows": [0, 0], "rule": rule}]), ("lattice_gas.reversals", [5])],
             "only dynamics without random numbers")
            for rule in ("diffusive_x", "diffusive_y")
        ),
        *(
            (GAS, [("lattice_gas.reversals", times)], "lattice_gas.reversals must increase and lie within the duration")
            for times in ([5, 4], [5, 5], [5, 11])
        ),
        (GAS, [("lattice_gas.reversals", [])], "lattice_gas.reversals"),
        (GAS, [("lattice_gas.reversals", [0])], "lattice_gas.reversals.0: Input should be greater than 0 (found 0)"),
        *(
            (GAS, [("lattice_gas.obstacles", [obstacle])], f"lattice_gas.obstacles.0: {message}")
            for obstacle, message in (
                ({"centre": [1.0, 1.0]}, "centre and radius go together: give both for a disk, or neither"),
                ({"radius": 1.0}, "centre and radius go together"),
                ({}, "give one of: columns and rows (or one of them), centre and radius, sites"),
                ({"rows": [0, 1], "sites": [[1, 1]]}, "give one of: columns and rows"),
                ({"columns": [0, 1], "centre": [1.0, 1.0], "radius": 1.0}, "give one of: columns and rows"),
                ({"sites": [[1, 1]], "centre": [1.0, 1.0], "radius": 1.0}, "give one of: columns and rows"),
                ({"columns": [3, 2]}, "columns = [3, 2]: the first exceeds the last; swap them"),
                ({"rows": [3, 2]}, "rows = [3, 2]: the first exceeds the last; swap them"),
            )
        ),
        (GAS, [("lattice_gas.obstacles", [{"sites": []}])], "lattice_gas.obstacles.0"),
        (GAS, [("lattice_gas.obstacles", [{"centre": [1.0, 1.0], "radius": 0.0}])],
         "lattice_gas.obstacles.0.radius: Input should be greater than 0 (found 0.0)"),
        (GAS, [("lattice_gas.obstacles", [{"rows": [0, 0], "rule": "sticky"}])],
         "lattice_gas.obstacles.0.rule: Input should be 'bounce_back', 'specular_x', 'specular_y', "),
        (GAS, [("lattice_gas.obstacles", [{"sites": [[-1, 0]]}])], "Input should be greater than or equal to 0"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message(table: dict[str, Any], changes: list[tuple[str, Any]], message: str) -> None:
    line = message_of(changed(table, *changes))
    assert line.startswith("scene: ")
    assert message in line


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ([("lattice_gas.modle", "hpp")], "unknown key 'lattice_gas.modle'; did you mean 'model'?"),
        ([("lattice_gas.obstacle", [])], "unknown key 'lattice_gas.obstacle'; did you mean 'obstacles'?"),
        ([("initial.densty", 0.1)], "unknown key 'initial.densty'; did you mean 'density'?"),
        ([("initial.wave", [])], "unknown key 'initial.wave'; did you mean 'waves'?"),
        ([("latice_gas", {})], "unknown key 'latice_gas'; did you mean 'lattice_gas'?"),
        ([("lattice_gas.obstacles", [{"row": [0, 0], "sites": [[0, 0]]}])],
         "unknown key 'lattice_gas.obstacles.0.row'; did you mean 'rows'?"),
        ([("initial.waves", [{"of": "density", "amplitud": 0.1, "mode": [1.0, 0.0]}])],
         "unknown key 'initial.waves.0.amplitud'; did you mean 'amplitude'?"),
    ],
)  # fmt: skip
def test_a_misspelt_key_gets_a_hint(changes: list[tuple[str, Any]], message: str) -> None:
    assert message in message_of(changed(GAS, *changes))


@pytest.mark.parametrize(
    ("obstacle", "message"),
    [
        ({"rows": (0, 10)}, "column 19, row 10 is not on the lattice of 20 columns, 10 rows"),
        ({"columns": (20, 20)}, "column 20, row 9 is not on the lattice"),
        ({"sites": ((0, 0), (3, 10))}, "column 3, row 10 is not on the lattice"),
        ({"sites": ((20, 0), (3, 1))}, "column 20, row 0 is not on the lattice"),
        ({"centre": (-5.0, 3.0), "radius": 4.0},
         "the disk covers no site: make it larger, or move it onto the lattice"),
        ({"centre": (2.5, 2.5), "radius": 0.5}, "the disk covers no site"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("do", ["wall_rules", "initial_sites"])
def test_obstacles_off_the_lattice(obstacle: dict[str, Any], message: str, do: str) -> None:
    good = {"sites": [[0, 0]]}
    assert f"lattice_gas.obstacles[1]: {message}" in message_of(
        changed(GAS, ("lattice_gas.obstacles", [good, obstacle])), do
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ([("initial.density", 1.5)], "the mean occupation must be between 0 and 1, got 1.5"),
        ([("initial.density", [0.1] * 9 + [-0.1])], "the mean occupation must be between 0 and 1, got -0.1"),
        ([("initial.velocity_x", 0.9)], "no occupations have mean 0.3 and velocity (0.9, 0.0)"),
        ([("initial.waves", [{"of": "density", "amplitude": 0.4, "mode": [1.0, 0.0]}])],
         "the mean occupation must be between 0 and 1"),
        ([("initial.waves", [{"of": "density", "amplitude": 0.4, "mode": [0.5, 0.0]}]), ("initial.cells", 5)],
         "the density is not in [0, 1] everywhere: change the waves"),
        ([("initial.density", 1.1), ("initial.cells", 5)], "the density is not in [0, 1] everywhere"),
    ],
)  # fmt: skip
def test_states_that_cannot_be(changes: list[tuple[str, Any]], message: str) -> None:
    line = message_of(changed(GAS, *changes), "initial_sites")
    assert line.startswith("scene a: initial: ")
    assert message in line


# -- walls -------------------------------------------------------------------------------------------------------------


def test_no_obstacles_are_no_walls() -> None:
    assert gas_scene().wall_rules() is None


@pytest.mark.parametrize("rule", RULES)
def test_blocks_and_sites(rule: Any) -> None:
    def walls(**where: Any) -> np.ndarray:
        found = gas_scene(lattice_gas={"obstacles": (Obstacle(**where, rule=rule),)}).wall_rules()
        assert found is not None
        return found

    expected = np.zeros((10, 20), dtype=np.uint8)
    expected[2:4, 5:8] = RULES[rule]
    np.testing.assert_array_equal(walls(columns=(5, 7), rows=(2, 3)), expected)
    np.testing.assert_array_equal(walls(sites=((5, 2), (6, 2), (7, 2), (5, 3), (6, 3), (7, 3))), expected)
    expected = np.zeros((10, 20), dtype=np.uint8)
    expected[9] = RULES[rule]
    np.testing.assert_array_equal(walls(rows=(9, 9)), expected)
    np.testing.assert_array_equal(walls(columns=(0, 0))[:, 0], RULES[rule])
    assert (walls(columns=(0, 0)) > 0).sum() == 10


@pytest.mark.parametrize("model", ["hpp", "fhp1"])
@given(
    x=st.floats(0, 20),
    y=st.floats(0, 8),
    radius=st.floats(1, 30),
)
def test_a_disk_is_round_in_links(model: str, x: float, y: float, radius: float) -> None:
    disk = Obstacle(centre=(x, y), radius=radius)
    walls = gas_scene(model, lattice_gas={"obstacles": (disk,)}).wall_rules()
    assert walls is not None
    for row, column in np.ndindex(10, 20):
        offset, height = (0.5 * (row % 2), math.sqrt(3) / 2) if model == "fhp1" else (0.0, 1.0)
        distance = math.hypot(column + offset - x, row * height - y)
        if abs(distance - radius) > 1e-12:
            assert (walls[row, column] > 0) == (distance < radius)


def test_of_obstacles_that_overlap_the_last_one_counts() -> None:
    floor, side = Obstacle(rows=(0, 0)), Obstacle(columns=(0, 0), rule="specular_x")
    for obstacles, corner in (((floor, side), SPECULAR_X), ((side, floor), BOUNCE_BACK)):
        walls = gas_scene(lattice_gas={"obstacles": obstacles}).wall_rules()
        assert walls is not None
        assert (walls[0, 0], walls[0, 1], walls[1, 0]) == (corner, BOUNCE_BACK, SPECULAR_X)
        assert (walls > 0).sum() == 20 + 10 - 1


def test_walls_start_empty() -> None:
    scene = gas_scene(initial={"density": 0.9}, lattice_gas={"obstacles": (Obstacle(rows=(3, 4)),)})
    free = gas_scene(initial={"density": 0.9}).initial_sites()
    sites = scene.initial_sites()
    assert not sites[3:5].any()
    np.testing.assert_array_equal(np.delete(sites, (3, 4), axis=0), np.delete(free, (3, 4), axis=0))


# -- sites -------------------------------------------------------------------------------------------------------------


def filling(scene: Scene) -> np.ndarray:
    """Occupations of the initial sites, (rows, columns, b)."""
    assert scene.lattice_gas is not None
    channels = MODELS[scene.lattice_gas.model].channels
    sites = scene.initial_sites()
    assert sites.dtype == np.uint8
    assert sites.shape == (scene.lattice_gas.rows, scene.lattice_gas.columns)
    return sites[..., None] >> np.arange(channels) & 1


def assert_mean(values: np.ndarray, expected: float, variance: float) -> None:
    """The mean of independent values of this variance."""
    assert abs(values.mean() - expected) < LIMIT * (variance / values.size) ** 0.5


def test_sites_are_those_of_the_seed() -> None:
    for more in ({}, {"cells": 5}, {"velocity_x": 0.1}):
        one, again, other = (
            gas_scene(initial={"density": 0.3, "seed": seed} | more).initial_sites() for seed in (1, 1, 2)
        )
        np.testing.assert_array_equal(one, again)
        assert (one != other).any()
    # the seed of the run is another thing
    np.testing.assert_array_equal(gas_scene(seed=7).initial_sites(), gas_scene().initial_sites())


@pytest.mark.parametrize("model", MODELS)
def test_a_moving_gas_has_its_density_and_velocity(model: str) -> None:
    velocity = (0.2, -0.1)
    scene = gas_scene(model, 200, 300, initial={"density": 0.3, "velocity_x": 0.2, "velocity_y": -0.1})
    n, c = filling(scene), MODELS[model].velocities.cartesian
    f = fermi_dirac(model, 0.3, velocity)
    np.testing.assert_allclose(scene.initial_occupations(), np.broadcast_to(f, n.shape), rtol=1e-12)
    variances = f * (1 - f)
    assert_mean(n.sum(axis=-1), 0.3 * len(c), variances.sum())
    for axis in (0, 1):
        expected = 0.3 * len(c) * velocity[axis]
        assert_mean(n @ c[:, axis], expected, variances @ c[:, axis] ** 2)


@pytest.mark.parametrize("model", ["hpp", "fhp3"])
def test_profiles_are_those_of_the_rows(model: str) -> None:
    density, speed = np.linspace(0.1, 0.6, 10), np.linspace(-0.2, 0.2, 10)
    scene = gas_scene(model, 10, 20_000, initial={"density": tuple(density), "velocity_x": tuple(speed)})
    n, c = filling(scene), MODELS[model].velocities.cartesian
    for row, d, u in zip(n, density, speed, strict=True):
        f = fermi_dirac(model, d, (u, 0.0))
        for i in range(len(c)):
            assert_mean(row[:, i], f[i], f[i] * (1 - f[i]))


@pytest.mark.parametrize("model", ["hpp", "fhp1"])
@pytest.mark.parametrize(("mode", "phase"), [((0.0, 1.0), 0.0), ((1.0, 0.0), -math.pi / 2), ((2.0, 3.0), 0.4)])
@pytest.mark.parametrize("of", ["density", "velocity_x", "velocity_y"])
def test_waves_have_their_amplitude_mode_and_phase(model: str, mode: Any, phase: float, of: Any) -> None:
    """Mean occupations at Cartesian places; those are what the sites are drawn from."""
    wave = Wave(of=of, amplitude=0.1, mode=mode, phase=phase)
    scene = gas_scene(model, 60, 80, initial={"density": 0.3, "waves": (wave,)})
    v = MODELS[model].velocities
    f = scene.initial_occupations()
    x, y = places(MODELS[model], 60, 80)
    expected = 0.1 * np.cos(2 * np.pi * (mode[0] * x / 80 + mode[1] * y / (60 * v.row_height)) + phase)
    rho = f.sum(axis=-1)
    fields = {"density": rho / v.channels - 0.3}
    fields |= {name: f @ v.cartesian[:, axis] / rho for axis, name in enumerate(("velocity_x", "velocity_y"))}
    for name, field in fields.items():
        np.testing.assert_allclose(field, expected if name == of else np.zeros_like(field), atol=1e-13)
    projection = (filling(scene).sum(axis=-1) - rho) * expected / 0.1
    assert_mean(projection, 0.0, float((f * (1 - f)).sum(axis=-1).max()))


def test_waves_add_up() -> None:
    waves = tuple(Wave(of="density", amplitude=a, mode=(0.0, m)) for a, m in ((0.1, 1.0), (0.05, 2.0)))
    both = gas_scene("hpp", 12, 4, initial={"density": 0.3, "waves": waves}).initial_occupations()
    y = 2 * np.pi * np.arange(12) / 12
    np.testing.assert_allclose(both[:, 0, 0], 0.3 + 0.1 * np.cos(y) + 0.05 * np.cos(2 * y), rtol=1e-12)


def test_channels_are_filled_one_by_one() -> None:
    f = (0.0, 0.1, 0.5, 1.0)
    n = filling(gas_scene("hpp", 200, 300, initial={"channels": f}))
    for i, mean in enumerate(f):
        assert abs(n[..., i].mean() - mean) <= LIMIT * (mean * (1 - mean) / n[..., i].size) ** 0.5


@pytest.mark.parametrize("model", ["hpp", "fhp_saturated"])
def test_cells_count_places_from_the_first_to_the_last(model: str) -> None:
    wave = Wave(of="density", amplitude=0.1, mode=(0.5, 1.0))
    walls = (Obstacle(rows=(0, 0)),)
    start = {"density": 0.3, "cells": 5, "waves": (wave,)}
    n = filling(gas_scene(model, 20, 30, initial=start, lattice_gas={"obstacles": walls}))
    counts = n.sum(axis=-1).reshape(4, 5, 6, 5).sum(axis=(1, 3))
    for row, column in np.ndindex(4, 6):
        density = 0.3 + 0.1 * math.cos(2 * math.pi * (0.5 * column / 5 + row / 3))
        assert counts[row, column] == round(density * 25 * MODELS[model].channels)
    assert n[0].any()  # walls too


def test_one_cell_is_at_the_start_of_the_wave() -> None:
    wave = Wave(of="density", amplitude=0.1, mode=(1.0, 1.0))
    scene = gas_scene("hpp", 10, 10, initial={"density": 0.3, "cells": 10, "waves": (wave,)})
    assert filling(scene).sum() == 160
