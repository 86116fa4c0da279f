"""Scenes of square wells that several checks share, what these need of an engine, and temperatures of their runs.

Units: diameter, mass and depth of the well are 1.
"""

from __future__ import annotations

import numpy as np

from crosscheck.checks.events.gases import event_driven
from crosscheck.engines.protocol import Run
from crosscheck.references import EPSILON
from crosscheck.references.square_well import WIDTH
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Observable, Output, Scene, Well
from crosscheck.verdict import Judgement, round_off

#: Observables of every scene: the same everywhere, so that all scenes share one compiled loop.
OBSERVABLES: tuple[Observable, ...] = (
    "kinetic_energy",
    "potential_energy",
    "events",
    "collisional_virial",
    "kinetic_energy_integral",
    "potential_energy_integral",
)
WORDS = "hard_spheres.well box.boundaries=periodic"
#: Needs of the checks that use positions.
NEEDS_STATES = event_driven(WORDS, " ".join((*OBSERVABLES, "positions", "velocities")))


def fluid(dimension: int, number: int, density: float, temperature: float, seed: int, depth: float = 1.0) -> Scene:
    """A periodic cube (square) of particles that start on a lattice; diameter and mass 1.

    dimension: 2 or 3. number: of particles. density: per sigma^d. temperature: at the start. seed: of the velocities.
    depth: of the well; negative: a shoulder.
    """
    structure = "square" if dimension == 2 else "fcc"
    return Scene(
        name=f"square-well-{dimension}d-{number}",
        dimension=dimension,  # type: ignore[arg-type]
        duration=0.0,
        hard_spheres=HardSpheres(well=Well(depth=depth, range=WIDTH)),
        box=Box(density=density),
        initial=Lattice(kind="lattice", structure=structure, number=number, temperature=temperature, seed=seed),  # type: ignore[arg-type]
        output=Output(interval=1.0, observables=OBSERVABLES),
    )


def constant_energy(scene: Scene, run: Run) -> Judgement:
    """The time integral of K + U over E t: K gives the temperature that pressures are divided by.

    E is that of the start: K of its velocities, and the wells' energy. scene: gives them. run: with `OBSERVABLES`, from
    the start on.
    """
    state = scene.initial_state()
    kinetic, wells = 0.5 * float((state.velocities**2).sum()), float(run["potential_energy"][0])
    integral = float(run["kinetic_energy_integral"][-1] + run["potential_energy_integral"][-1])
    return round_off(
        "time integral of K + U over t, less K + U of the start, over their size",
        abs(integral / float(run["time"][-1]) - kinetic - wells) / (kinetic + abs(wells)),
        2 * EPSILON * float(run["events"][-1]),
        "every event rounds both sums by a unit of the last place of their size, at worst all alike",
    )


def temperatures(scene: Scene, run: Run) -> Floats:
    """Averages over each interval of 2 K/(d (N - 1)), total momentum zero, (intervals,).

    scene: gives d and N. run: with `OBSERVABLES`.
    """
    freedoms = scene.dimension * (scene.number - 1)
    return np.asarray(2 * np.diff(run["kinetic_energy_integral"]) / (freedoms * np.diff(run["time"])))
