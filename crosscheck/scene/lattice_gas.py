"""Lattice gases: checks of their entries, their wall sites, and the initial states of their sites."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError
from crosscheck.scene.observables import named
from crosscheck.scene.parts import Floats, LatticeGas, Obstacle, Occupations, SceneEntries
from crosscheck.text import shortened

if TYPE_CHECKING:
    from refimpl.lattice.models import Model


def check_lattice_gas(scene: SceneEntries) -> None:
    """ValueError if entries of a lattice gas contradict each other, or are given in a scene without one.

    scene: all entries of the scene.
    """
    gas, output = scene.lattice_gas, scene.output
    if gas is None:
        if isinstance(scene.initial, Occupations):
            raise ValueError("initial.kind = 'occupations' fills a lattice: add [lattice_gas]")
        for name in named("lattice_gas"):
            if name in output.observables:
                raise ValueError(f"output.observables: '{name}' goes with [lattice_gas] only: remove it")
        return
    if not isinstance(scene.initial, Occupations):
        raise ValueError(f"initial.kind = '{scene.initial.kind}': a lattice gas starts from kind = 'occupations'")
    if scene.dimension != 2:
        raise ValueError(f"dimension = {scene.dimension}: lattice gases are in dimension 2")
    entries = {
        "masses": scene.masses != 1.0,
        "species": scene.species is not None,
        "acceleration": scene.acceleration is not None,
        "output.collisions": output.collisions is not None,
        "output.trajectory": output.trajectory,
        "output.forces": output.forces,
    }
    for entry, given in entries.items():
        if given:
            raise ValueError(f"{entry} does not go with [lattice_gas]: remove it")
    for name in output.observables:
        if name not in named("lattice_gas"):
            known = ", ".join(named("lattice_gas"))
            raise ValueError(f"output.observables: '{name}' is of particles; a lattice gas has {known}")
    _check_lattice(scene, gas, scene.initial)


def _check_lattice(scene: SceneEntries, gas: LatticeGas, initial: Occupations) -> None:
    from refimpl.lattice.models import MODELS

    if gas.model not in MODELS:
        raise ValueError(f"lattice_gas.model = '{shortened(gas.model)}' is unknown: take one of {', '.join(MODELS)}")
    model = MODELS[gas.model]
    if model.velocities.half_rows and gas.rows % 2:
        raise ValueError(f"lattice_gas.rows = {gas.rows}: a periodic triangular lattice needs an even number")
    for name, steps in (("duration", scene.duration), ("output.interval", scene.output.interval)):
        if steps is not None and steps != int(steps):
            raise ValueError(f"{name} = {steps:g}: a lattice gas takes whole steps of 1")
    blocks = scene.output.fields
    if blocks is not None and (len(blocks) != 2 or gas.columns % blocks[0] or gas.rows % blocks[1]):
        raise ValueError(f"output.fields = {list(blocks)} must divide {gas.columns} columns and {gas.rows} rows evenly")
    if "force_impulse" in scene.output.observables and gas.force is None:
        raise ValueError("output.observables: 'force_impulse' needs lattice_gas.force")
    for name in ("density", "velocity_x", "velocity_y"):
        values = getattr(initial, name)
        if isinstance(values, tuple) and len(values) != gas.rows:
            raise ValueError(f"initial.{name} has {len(values)} values for {gas.rows} rows: give one, or one per row")
    if initial.channels is not None and len(initial.channels) != model.channels:
        raise ValueError(f"initial.channels has {len(initial.channels)} values, {gas.model} has {model.channels}")
    if initial.cells is not None and (gas.columns % initial.cells or gas.rows % initial.cells):
        raise ValueError(
            f"initial.cells = {initial.cells} must divide {gas.columns} columns and {gas.rows} rows evenly"
        )
    if initial.cells is not None and isinstance(initial.density, tuple):
        raise ValueError("initial.cells goes with one density: give one, and waves")
    _check_reversals(scene, gas, model)


def _check_reversals(scene: SceneEntries, gas: LatticeGas, model: Model) -> None:
    if gas.reversals is None:
        return
    if not gas.reversals:
        raise ValueError("lattice_gas.reversals is empty: give steps, as [100, 200], or remove it")
    drawn = any(obstacle.rule.startswith("diffusive") for obstacle in gas.obstacles)
    if not model.deterministic or drawn or gas.force is not None:
        raise ValueError("lattice_gas.reversals: only dynamics without random numbers can be reversed: remove it")
    if list(gas.reversals) != sorted(set(gas.reversals)) or gas.reversals[-1] > scene.duration:
        raise ValueError("lattice_gas.reversals must increase and lie within the duration")


def gas_model(scene: SceneEntries) -> Model:
    """The collision model of the lattice gas of `scene`."""
    from refimpl.lattice.models import MODELS

    assert scene.lattice_gas is not None
    return MODELS[scene.lattice_gas.model]


def wall_rules(scene: SceneEntries) -> NDArray[np.uint8] | None:
    """Rules of the wall sites of `scene`, (rows, columns), the constants of `refimpl.lattice.gas`; 0: no wall.

    None without obstacles; where they overlap, the last one counts. UsageError if one is not on the lattice.
    """
    from refimpl.lattice import gas as rules

    gas = scene.lattice_gas
    assert gas is not None
    if not gas.obstacles:
        return None
    walls = np.zeros((gas.rows, gas.columns), dtype=np.uint8)
    for number, obstacle in enumerate(gas.obstacles):
        where = _covered(gas, gas_model(scene), obstacle, f"lattice_gas.obstacles[{number}]")
        walls[where] = getattr(rules, obstacle.rule.upper())
    return walls


def _covered(gas: LatticeGas, model: Model, obstacle: Obstacle, name: str) -> NDArray[np.bool_]:
    """Which sites the obstacle covers, (rows, columns). name: of the obstacle, for messages."""
    from refimpl.lattice.gas import places

    where = np.zeros((gas.rows, gas.columns), dtype=bool)
    if obstacle.centre is not None and obstacle.radius is not None:
        x, y = places(model, gas.rows, gas.columns)
        where = (x - obstacle.centre[0]) ** 2 + (y - obstacle.centre[1]) ** 2 <= obstacle.radius**2
        if not where.any():
            raise UsageError(f"{name}: the disk covers no site: make it larger, or move it onto the lattice")
        return where
    columns, rows = obstacle.columns or (0, gas.columns - 1), obstacle.rows or (0, gas.rows - 1)
    sites = obstacle.sites or ((columns[1], rows[1]),)
    for column, row in sites:
        if column >= gas.columns or row >= gas.rows:
            raise UsageError(
                f"{name}: column {column}, row {row} is not on the lattice of {gas.columns} columns, {gas.rows} rows"
            )
    if obstacle.sites is None:
        where[rows[0] : rows[1] + 1, columns[0] : columns[1] + 1] = True
    else:
        where[tuple(np.array(obstacle.sites).T[::-1])] = True
    return where


def _profile(initial: Occupations, name: str, x: Floats, y: Floats) -> Floats:
    """Density or velocity component of the initial state, with its waves, at positions x/L_x, y/L_y."""
    base = np.asarray(getattr(initial, name))
    field = base[:, None] if base.ndim else base
    for wave in initial.waves:
        if wave.of == name:
            field = field + wave.amplitude * np.cos(2 * np.pi * (wave.mode[0] * x + wave.mode[1] * y) + wave.phase)
    return np.asarray(field, dtype=np.float64)


def initial_occupations(scene: SceneEntries) -> Floats:
    """Mean occupations of the channels of `scene` at the start, (rows, columns, channels), 0 at walls.

    UsageError if no occupations between 0 and 1 have the density and velocity of some site.
    """
    walls, f = wall_rules(scene), _occupations(scene)
    return f if walls is None else np.where(walls[..., None] > 0, 0.0, f)


def _occupations(scene: SceneEntries) -> Floats:
    from refimpl.lattice.equilibrium import fermi_dirac
    from refimpl.lattice.gas import places

    gas, initial, model = scene.lattice_gas, scene.initial, gas_model(scene)
    assert gas is not None
    assert isinstance(initial, Occupations)
    shape = (gas.rows, gas.columns, model.channels)
    if initial.channels is not None:
        return np.broadcast_to(np.array(initial.channels), shape)
    x, y = places(model, gas.rows, gas.columns)
    x, y = x / gas.columns, y / (gas.rows * model.velocities.row_height)
    if not any(wave.mode[0] for wave in initial.waves):
        x, y = x[:, :1], y[:, :1]  # all columns are equal
    velocity = np.stack(
        np.broadcast_arrays(_profile(initial, "velocity_x", x, y), _profile(initial, "velocity_y", x, y)), axis=-1
    )
    try:
        occupations = fermi_dirac(model.velocities, _profile(initial, "density", x, y), velocity)
    except ValueError as error:
        raise UsageError(f"scene {scene.name}: initial: {error}: take a smaller amplitude or velocity") from None
    return np.broadcast_to(occupations, shape)


def initial_sites(scene: SceneEntries) -> NDArray[np.uint8]:
    """States of the sites of `scene` at the start, (rows, columns): bit i says that channel i is occupied.

    Wall sites start empty; with `cells` they are filled like the others. UsageError as from `initial_occupations`.
    """
    from refimpl.lattice.gas import drawn_sites, filled_cells

    gas, initial, model = scene.lattice_gas, scene.initial, gas_model(scene)
    assert gas is not None
    assert isinstance(initial, Occupations)
    generator = np.random.default_rng(initial.seed)
    if initial.cells is not None:
        down, across = gas.rows // initial.cells, gas.columns // initial.cells
        x, y = np.arange(across) / max(across - 1, 1), np.arange(down)[:, None] / max(down - 1, 1)
        density = np.broadcast_to(_profile(initial, "density", x, y), (down, across))
        if density.min() < 0 or density.max() > 1:
            raise UsageError(f"scene {scene.name}: initial: the density is not in [0, 1] everywhere: change the waves")
        return filled_cells(model, density, initial.cells, generator)
    return drawn_sites(initial_occupations(scene), generator)
