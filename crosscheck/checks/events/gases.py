"""Scenes of elastic hard spheres that several checks share, what these need of an engine, and rates from their runs.

sigma = m = 1; T = 2K/f with f = d N between hard walls, d (N - 1) in a periodic box whose total momentum is zero.
"""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.references.hard_spheres import collision_rate, number_density
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Observable, Output, Scene

#: Observables of every `gas`: the same everywhere, so that all scenes share one compiled loop.
TALLIES: tuple[Observable, ...] = ("collisions", "collisional_virial", "wall_impulse", "wall_collisions")
#: Intervals of a run that are left out while it settles, and those whose averages are taken: many, for the correlation
#: time of the averages, and with it their error, is known the better.
SETTLING, BLOCKS = 40, 200
#: Lattices of the start, which melt soon: neither fluid nor close-packed.
LATTICE = {2: "square", 3: "sc"}
#: Numbers of particles of the periodic gases, by dimension.
PERIODIC = {2: 1024, 3: 1000}


def event_driven(words: str = "", observables: str = "", schemes: tuple[str, ...] = ()) -> Needs:
    """Needs of a check of event-driven hard spheres.

    words, observables: entries of `Needs`, each in one text, separated by spaces. schemes: that an engine must have.
    """
    return Needs(
        "hard_spheres",
        (EVENT_DRIVEN,),
        words=frozenset(words.split()),
        observables=frozenset(observables.split()),
        schemes=schemes,
    )


def spheres(number: int, density: float, seed: int, **more: object) -> Scene:
    """Elastic spheres, or disks with dimension = 2, on a close-packed lattice in a periodic box, at temperature 1.

    number: of particles. density: particles per sigma^d. seed: of the velocities. more: entries of the `Scene` instead
    of these.
    """
    entries: dict[str, object] = {
        "name": f"hard-spheres-{number}",
        "dimension": 3,
        "duration": 1.0,
        "hard_spheres": HardSpheres(),
        "box": Box(density=density),
    }
    entries |= more
    start = Lattice(
        kind="lattice",
        structure="fcc" if entries["dimension"] == 3 else "triangular",
        number=number,
        temperature=1.0,
        seed=seed,
    )
    return Scene(**{"initial": start, **entries})  # type: ignore[arg-type]


def gas(
    dimension: int,
    number: int,
    density: float,
    seed: int,
    output: Output,
    duration: float,
    *,
    hard: bool = False,
    speed: float | None = None,
) -> Scene:
    """Disks or spheres of one size from a square (simple cubic) lattice: T = 1, or all of one speed.

    dimension: 2 or 3. number: of particles. density: particles per sigma^d. seed: of the velocities. output: what is
    measured. duration: of the run (time). hard: between hard walls, else in a periodic box. speed: of all particles;
    None: T = 1.
    """
    return Scene(
        name=f"hard-gas-{dimension}d",
        dimension=dimension,  # type: ignore[arg-type]
        duration=duration,
        hard_spheres=HardSpheres(),
        box=Box(density=density, boundaries=("hard" if hard else "periodic",) * dimension),
        initial=Lattice(
            kind="lattice",
            structure=LATTICE[dimension],  # type: ignore[arg-type]
            number=number,
            temperature=1.0 if speed is None else None,
            speed=speed,
            seed=seed,
        ),
        output=output,
    )


def duration_of(collisions: float, number: int, eta: float, dimension: int, temperature: float = 1.0) -> float:
    """Time in which `number` particles have so many pair collisions: 2 collisions/(number omega), omega by Enskog.

    eta: packing fraction. dimension: 2 or 3. temperature: T, with mass and diameter 1.
    """
    return 2 * collisions / (number * collision_rate(eta, dimension, temperature).value)


def in_blocks(duration: float, trajectory: bool = False) -> Output:
    """The sums of `TALLIES` at the ends of the settling intervals and of the blocks.

    duration: of the run (time). trajectory: positions and velocities too.
    """
    return Output(interval=duration / (SETTLING + BLOCKS), observables=TALLIES, trajectory=trajectory)


def rates(run: Run, tally: Floats) -> Floats:
    """Growth per time of a cumulative sum in each interval after the run has settled, (intervals,).

    run: gives the times. tally: the sum at the samples, (samples,).
    """
    return np.asarray((np.diff(tally) / np.diff(run["time"]))[SETTLING:])


def run_periodic(laboratory: Laboratory, dimension: int, eta: float, number: int, collisions: float) -> Run:
    """Runs a periodic gas in equilibrium, T = 1, for so many pair collisions, in blocks.

    laboratory: runs it on the engine under judgement. dimension: 2 or 3. eta: packing fraction. number: of particles.
    """
    duration = duration_of(collisions, number, eta, dimension)
    density = number_density(eta, dimension)
    scene = gas(dimension, number, density, laboratory.seed(), in_blocks(duration), duration)
    return laboratory.run(scene, EVENT_DRIVEN)
