"""Density, velocity, temperature and fluxes on cells, from what a run counted and integrated there."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.scene import AXES, Floats, Scene
from crosscheck.scene.lattice_gas import gas_model


class Derived(NamedTuple):
    """A quantity on cells. values: along the axes of the cells. unit: the scene's. equation: its definition, a text."""

    values: Floats
    unit: str
    equation: str


def cell_edges(scene: Scene) -> tuple[Floats, ...]:
    """Edges of the cells of `output.fields` of `scene` along each axis, (cells + 1,), in units of length.

    Of a lattice gas without output.fields: the one block that is the whole lattice.
    """
    if scene.lattice_gas is not None:
        gas, counts = scene.lattice_gas, scene.output.fields or (1, 1)
        lengths = (float(gas.columns), gas.rows * float(gas_model(scene).velocities.row_height))
    else:
        box = scene.lengths()
        assert box is not None
        assert scene.output.fields is not None
        lengths, counts = tuple(box.tolist()), scene.output.fields
    return tuple(np.linspace(0.0, length, n + 1) for length, n in zip(lengths, counts, strict=True))


def on_cells(scene: Scene, run: Run) -> dict[str, Derived]:
    """Means over the run on the cells of hard spheres, by name; empty if the run recorded no fields.

    scene: what was run. run: what the engine returned.

    density, velocity, temperature, and energy_flux through the lower face of each cell. The temperature, an energy, is
    that of the velocities about the mean velocity of the cell: m (<v^2> - <v>^2)/d. With several masses it is not
    known, since cells count mass, not particles: then thermal_energy is given, per mass.
    """
    mass = run.get("field_mass")
    if mass is None:
        return {}
    momentum, kinetic, flux = run["field_momentum"], run["field_kinetic"], run["field_flux_energy"]
    d, edges, span = scene.dimension, cell_edges(scene), _span(scene, run)
    sides = [float(along[1] - along[0]) for along in edges]
    cell = math.prod(sides)
    moving = _moving_masses(scene)
    with np.errstate(all="ignore"):
        velocity = momentum / mass[..., None]
        thermal = kinetic / mass - 0.5 * (velocity**2).sum(axis=-1)
        found = {"density": Derived(mass / (cell * span), "mass/length^d", "field_mass/(cell volume, duration)")}
        found |= {
            f"velocity.{AXES[k]}": Derived(velocity[..., k], "length/time", f"field_momentum.{AXES[k]}/field_mass")
            for k in range(d)
        }
        if np.unique(moving).size == 1:
            found["temperature"] = Derived(
                2 * float(moving[0]) * thermal / d, "energy", "m (<v^2> - <v>^2)/d, from the fields"
            )
        else:
            found["thermal_energy"] = Derived(thermal, "energy/mass", "(<v^2> - <v>^2)/2, from the fields")
        found |= {
            f"energy_flux.{AXES[k]}": Derived(
                flux[k] / (cell / sides[k] * span),
                "energy/(time length^(d-1))",
                f"field_flux_energy[{AXES[k]}]/(area, duration), through the lower face of the cell along {AXES[k]}",
            )
            for k in range(d)
        }
    return found


def _moving_masses(scene: Scene) -> Floats:
    """Masses of the particles that are not fixed."""
    masses = np.broadcast_to(np.asarray(scene.masses, dtype=np.float64), (scene.number,))
    return masses[~scene.fixed()]


def _span(scene: Scene, run: Run) -> float:
    """The time over which the fields were integrated."""
    if run.stopped:  # its end is no sample: all mass is in the cells all the time
        return float(run["field_mass"].sum() / _moving_masses(scene).sum())
    return scene.duration if scene.output.collisions is None else float(np.nanmax(run["time"]))


def on_blocks(scene: Scene, run: Run) -> dict[str, Derived]:
    """Flow of a lattice gas in its blocks, (samples, across, up), by name; empty if populations were not recorded.

    scene: what was run. run: what the engine returned.

    density: particles per site, walls counted as sites. velocity: momentum per mass, NaN in empty blocks.
    """
    populations = run.get("populations")
    if populations is None:
        return {}
    gas = scene.lattice_gas
    assert gas is not None
    sites = gas.rows * gas.columns / math.prod(populations.shape[1:3])
    mass = populations.sum(axis=-1)
    momentum = populations @ gas_model(scene).velocities.cartesian
    with np.errstate(all="ignore"):
        velocity = momentum / np.where(mass > 0, mass, np.nan)[..., None]
    return {
        "density": Derived(mass / sites, "1/site", "sum of the populations over the sites of the block"),
        "velocity.x": Derived(velocity[..., 0], "link/step", "sum of population times c_x, over the mass"),
        "velocity.y": Derived(velocity[..., 1], "link/step", "sum of population times c_y, over the mass"),
    }
