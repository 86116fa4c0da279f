"""Races of schemes that take time steps: gravity, Lennard-Jones, soft grains, and the schemes beside each other."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory
from crosscheck.checks.events.gases import spheres
from crosscheck.checks.performance.races import (
    EPSILON,
    OURS,
    Race,
    Side,
    Start,
    alone,
    engine_side,
    near,
)
from crosscheck.checks.stepping.fluids import STEP, fluid
from crosscheck.engines.protocol import Run
from crosscheck.engines.registry import engine_class
from crosscheck.references.hard_spheres import number_density
from crosscheck.scene import (
    Box,
    Contact,
    GrainFriction,
    Gravity,
    HardSpheres,
    Method,
    Scene,
    Spring,
    explicit,
)
from crosscheck.scene.overlaps import wrapped

# -- gravity -----------------------------------------------------------------------------------------------------------


_LEAP_FROG = "leapfrog"
#: So many bodies or fewer circle a heavy one: a cloud of them would not last for as many steps as a turn needs.
_FEW = 16


def gravity_race(number: int, pairs: float = 4e7) -> Race:
    """Gravity between all pairs by leap-frog, beside REBOUND's `basic` gravity; the unit is a pair of bodies.

    number: of bodies. pairs: of a turn, roughly; a step is counted as 20 more.
    """
    steps = max(4, int(pairs / (number * (number - 1) / 2 + 20)))
    few = number <= _FEW
    method = Method(scheme=_LEAP_FROG, dt=1e-4 if few else 1e-6)

    def start(laboratory: Laboratory) -> Start:
        scene = _planets(number) if few else cloud(number, laboratory.seed())
        scene = scene.changed(duration=steps * method.step)
        return Start(scene, lambda run: run.cost.steps * number * (number - 1) / 2)

    def alike(scene: Scene, runs: Mapping[str, Run]) -> None:
        """To the order of the schemes, which differ in where a step begins, and rounding."""
        positions = scene.initial_state().positions
        size = float(np.abs(positions).max())
        if few:  # of the radius: (omega dt)^2/8 by where a step begins, and a third of it for each radian
            allowed = size * ((1 + scene.duration) * method.step**2 / 8 + steps * EPSILON * scene.duration)
        else:  # of a displacement of n steps from rest, less than the share 1/n^2 depends on where they begin
            moved = float(np.abs(next(iter(runs.values()))["final_positions"] - positions).max())
            allowed = moved / steps**2 + steps * EPSILON * size
        near(scene, runs, allowed)

    return Race(
        f"gravity, N = {number}",
        "pairs",
        start,
        (engine_side(OURS, OURS, method), engine_side("REBOUND", "rebound", method)),
        alike,
    )


def cloud(number: int, seed: int) -> Scene:
    """A softened cloud of equal masses at rest, total mass 1; number: of bodies. seed: of their places."""
    positions = np.random.default_rng(seed).normal(size=(number, 3))
    return Scene(
        name=f"cloud-{number}",
        dimension=3,
        duration=1.0,
        masses=1.0 / number,
        gravity=Gravity(softening=0.01),
        initial=explicit(positions, np.zeros_like(positions)),
    )


def _planets(number: int) -> Scene:
    """A heavy body and light ones on circles around it, the innermost with radius and frequency 1."""
    light = 1e-9
    radii = 1.0 + 0.5 * np.arange(number - 1)
    angles = 2.4 * np.arange(number - 1)  # radians; no two are near each other
    towards = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    along = np.stack([-np.sin(angles), np.cos(angles), np.zeros_like(angles)], axis=1)
    positions = np.vstack([np.zeros(3), radii[:, None] * towards])
    velocities = np.vstack([np.zeros(3), along / np.sqrt(radii)[:, None]])
    return Scene(
        name=f"planets-{number}",
        dimension=3,
        duration=1.0,
        masses=(1.0, *[light] * (number - 1)),
        gravity=Gravity(),
        initial=explicit(positions, velocities),
    )


# -- Lennard-Jones -----------------------------------------------------------------------------------------------------


#: Largest rate at which rounding grows in the melt, 1/time: three times its Lyapunov exponent, which is about 1.
_CHAOS = 3.0


def lennard_jones_race(number: int, peers: tuple[Side, ...], steps: int | None = None) -> Race:
    """The melt of LAMMPS's own benchmark, rho = 0.8442, cutoff 2.5, velocity Verlet; the unit is a particle step.

    number: of particles. peers: sides beside ours. steps: of a turn; None: as many as take a fraction of a second.
    """
    taken = steps or max(25, 1_600_000 // number)

    def start(laboratory: Laboratory) -> Start:
        return Start(melt(laboratory, number).changed(duration=taken * STEP.step), lambda run: run.cost.steps * number)

    def alike(scene: Scene, runs: Mapping[str, Run]) -> None:
        """To rounding, which chaos lets grow."""
        lengths = scene.lengths()
        assert lengths is not None
        near(scene, runs, taken * EPSILON * float(lengths.max()) * math.exp(_CHAOS * scene.duration))

    return Race(f"Lennard-Jones, N = {number}", "particle steps", start, (engine_side(OURS, OURS, STEP), *peers), alike)


def melt(laboratory: Laboratory, number: int) -> Scene:
    """A Lennard-Jones lattice at rho = 0.8442 that has melted, about T = 0.72; laboratory: runs it. number: of them."""
    lattice = fluid(number, 0.8442, 1.44, laboratory.seed(), duration=1.0)
    laboratory.demand(lattice, STEP)
    run = laboratory.run(lattice, STEP, engine=OURS)
    return lattice.changed(initial=explicit(run["final_positions"], run["final_velocities"]))


# -- soft grains -------------------------------------------------------------------------------------------------------


#: Rough soft grains: contacts of 0.01 with tangential springs, 50 steps each.
HISTORY = Method(scheme="velocity_verlet", dt=2e-4, contact=Contact(duration=0.01, friction="history"))
_ROUGH = HardSpheres(restitution=0.9, friction=GrainFriction(tangential_restitution=0.5, static=0.5, sliding=0.5))


def grains_race(number: int, steps: int = 400, settling: float = 0.5) -> Race:
    """Rough soft spheres at the packing 0.5, beside LAMMPS's `gran/hooke/history`; the unit is a particle step.

    number: of grains. steps: of a turn. settling: time before them (elastic spheres, event-driven).
    """

    def start(laboratory: Laboratory) -> Start:
        return Start(
            rough_grains(laboratory, number, settling).changed(duration=steps * HISTORY.step),
            lambda run: run.cost.steps * number,
        )

    def alike(scene: Scene, runs: Mapping[str, Run]) -> None:
        """To rounding: in a few contact times a grain collides once or twice, and each may magnify it tenfold."""
        lengths = scene.lengths()
        assert lengths is not None
        near(scene, runs, steps * EPSILON * float(lengths.max()) * 100)

    return Race(
        f"soft grains with history, N = {number}",
        "particle steps",
        start,
        (engine_side(OURS, OURS, HISTORY), engine_side("LAMMPS", "lammps", HISTORY)),
        alike,
    )


def rough_grains(laboratory: Laboratory, number: int, settling: float) -> Scene:
    """Rough spheres at the packing 0.5 with the places and velocities of elastic ones that have run for a while.

    laboratory: runs those. number: of grains. settling: time of that run.
    """
    elastic = spheres(number, number_density(0.5, 3), laboratory.seed() % 2**31, duration=settling)
    run = laboratory.run(elastic, EVENT_DRIVEN, engine=OURS)
    lengths = elastic.lengths()
    assert lengths is not None
    return elastic.changed(
        name=f"rough-grains-{number}",
        hard_spheres=_ROUGH,
        initial=explicit(wrapped(run["final_positions"], elastic.periods()), run["final_velocities"]),
        box=Box(lengths=tuple(lengths.tolist())),
    )


# -- springs, for the schemes ------------------------------------------------------------------------------------------


def schemes_race(number: int, steps: int) -> Race:
    """All schemes that take time steps on damped springs, velocity Verlet first; the unit is a particle step.

    number: of particles in three dimensions. steps: of a turn.
    """
    names = [name for name, claims in engine_class(OURS).schemes.items() if claims.kind == "stepping"]
    names.sort(key=lambda name: name != "velocity_verlet")
    dt = 0.01

    def start(laboratory: Laboratory) -> Start:
        rng = np.random.default_rng(laboratory.seed())
        scene = Scene(
            name=f"springs-{number}",
            dimension=3,
            duration=steps * dt,
            spring=Spring(k=1.0, gamma=0.1),
            initial=explicit(rng.normal(size=(number, 3)), rng.normal(size=(number, 3))),
        )
        return Start(scene, lambda run: run.cost.steps * number)

    sides = tuple(engine_side(name, OURS, Method(scheme=name, dt=dt)) for name in names)
    return Race(f"schemes on springs, N = {number}", "particle steps", start, sides, alone)
