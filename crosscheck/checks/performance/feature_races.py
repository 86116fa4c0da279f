"""What features cost: a bare scene, and the same with one feature after the other, in turns; time and bytes.

The time of a turn with the feature over that without it is its price; all turns do the same work. Bytes are those of
all arrays that decide how a run goes on: state, lists, queues, histories.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.events.gases import spheres
from crosscheck.checks.lattice.gases import filled, gas_scene
from crosscheck.checks.performance.races import OURS, Race, Ready, Side, Start, alone
from crosscheck.checks.performance.stepping_races import HISTORY, cloud
from crosscheck.checks.stepping.fluids import STEP, fluid
from crosscheck.engines.protocol import Run
from crosscheck.scene import (
    Box,
    Contact,
    GrainFriction,
    Gravity,
    HardSpheres,
    LennardJones,
    Method,
    Obstacle,
    Output,
    Scene,
    Wall,
    Well,
)


class Feature(NamedTuple):
    """One feature; name: in tables. added: the bare scene with it. method: how that is run; None: as the bare one."""

    name: str
    added: Callable[[Scene], Scene]
    method: Method | None = None


def _bare(scene: Scene) -> Scene:
    return scene


def _side(feature: Feature, method: Method) -> Side:
    """A scene with a feature as a side, whose turns all go on from the state at the end of a first run."""

    def prepare(laboratory: Laboratory, scene: Scene) -> Ready:
        worker, how = laboratory.pool.worker(OURS), feature.method or method
        with_it = feature.added(scene)
        directory = tempfile.TemporaryDirectory(prefix="crosscheck-race-")
        state = Path(directory.name) / "state.npz"
        worker.run(with_it, how, keep=state)
        with np.load(state) as arrays:
            held = sum(arrays[name].nbytes for name in arrays.files)

        def run() -> Run:
            assert directory  # the state lives as long as its side
            return worker.run(with_it, how, restart=state)

        # of a lattice gas, the state is not what it is held in
        return Ready(run, held=0.0 if scene.lattice_gas else held / scene.number)

    return Side(feature.name, prepare)


def _race(
    name: str, unit: str, start: Callable[[Laboratory], Start], method: Method, features: tuple[Feature, ...]
) -> Race:
    sides = tuple(_side(feature, method) for feature in (Feature("bare", _bare), *features))
    return Race(f"{name}: what features cost", unit, start, sides, alone, turns=5)


def _observing(scene: Scene, samples: int, *observables: str, trajectory: bool = False) -> Scene:
    output = Output(interval=scene.duration / samples, observables=observables, trajectory=trajectory)
    return scene.changed(output=output)


# -- schemes that take time steps --------------------------------------------------------------------------------------


def gravity_features(number: int = 256, steps: int = 1000) -> Race:
    """Gravity of a cloud, leap-frog; the unit is a pair. number: of bodies. steps: of a turn."""
    method = Method(scheme="leapfrog", dt=1e-6)

    def start(laboratory: Laboratory) -> Start:
        scene = cloud(number, laboratory.seed()).changed(gravity=Gravity(), duration=steps * method.step)
        return Start(scene, lambda run: run.cost.steps * number * (number - 1) / 2)

    features = (
        Feature("softening", lambda scene: scene.changed(gravity=Gravity(softening=0.01))),
        Feature("energies, 1 step in 10", lambda scene: _observing(scene, steps // 10, "kinetic_energy")),
        Feature("trajectory, 1 step in 10", lambda scene: _observing(scene, steps // 10, trajectory=True)),
    )
    return _race("gravity", "pairs", start, method, features)


def lennard_jones_features(number: int = 4000, steps: int = 200) -> Race:
    """A Lennard-Jones melt; the unit is a particle step. number: of particles. steps: of a turn."""

    def start(laboratory: Laboratory) -> Start:
        scene = fluid(number, 0.8442, 1.44, laboratory.seed(), duration=steps * STEP.step)
        return Start(scene, lambda run: run.cost.steps * number)

    def pairs(**entries: object) -> Callable[[Scene], Scene]:
        return lambda scene: scene.changed(lennard_jones=LennardJones(**{"cutoff": 2.5, **entries}))  # type: ignore[arg-type]

    def masses(scene: Scene) -> Scene:
        return scene.changed(masses=tuple(1.0 + 0.5 * (i % 2) for i in range(number)))

    def mixture(scene: Scene) -> Scene:
        kinds = LennardJones(cutoff=2.5, epsilon=(1.0, 0.9), length=(1.0, 0.9))
        return scene.changed(lennard_jones=kinds, species=tuple(i % 2 for i in range(number)))

    def walls(scene: Scene) -> Scene:
        box = Box(density=0.8442, boundaries=("periodic", "periodic", "wall"), wall=Wall(sigma=0.4, cutoff=1.0))
        return scene.changed(box=box)

    features = (
        Feature("energy shifted to 0 at the cutoff", pairs(truncation="shifted")),
        Feature("force shifted to 0 at the cutoff", pairs(truncation="force_shifted")),
        Feature("two masses", masses),
        Feature("two species", mixture),
        Feature("two walls", walls),
        Feature("energies, 1 step in 10", lambda scene: _observing(scene, steps // 10, "potential_energy")),
        Feature("trajectory, 1 step in 10", lambda scene: _observing(scene, steps // 10, trajectory=True)),
    )
    return _race("Lennard-Jones", "particle steps", start, STEP, features)


def grains_features(number: int = 4000, steps: int = 400) -> Race:
    """Smooth soft spheres, n = 0.9; the unit is a particle step. number: of grains. steps: of a turn."""
    smooth = Method(scheme="velocity_verlet", dt=HISTORY.step, contact=Contact(duration=0.01))

    def start(laboratory: Laboratory) -> Start:
        scene = spheres(number, 0.9, laboratory.seed() % 2**31, duration=steps * HISTORY.step)
        return Start(scene, lambda run: run.cost.steps * number)

    def grains(**entries: object) -> Callable[[Scene], Scene]:
        return lambda scene: scene.changed(hard_spheres=HardSpheres(**entries))  # type: ignore[arg-type]

    rough = grains(friction=GrainFriction(tangential_restitution=0.5, static=0.5, sliding=0.5))
    hertz = Contact(law="hertz", stiffness=1e5)
    features = (
        Feature("restitution", grains(restitution=0.9)),
        Feature("friction by dashpots", rough, HISTORY.model_copy(update={"contact": _contact("dashpot")})),
        Feature("friction with history", rough, HISTORY),
        Feature("Hertz's law", _bare, Method(scheme="velocity_verlet", dt=HISTORY.step, contact=hertz)),
        Feature("a field", lambda scene: scene.changed(acceleration=(0.0, 0.0, -0.01))),
        Feature("six walls", lambda scene: scene.changed(box=Box(density=0.9, boundaries=("hard",) * 3))),
        Feature("contacts counted", lambda scene: _observing(scene, 10, "contact_time")),
    )
    return _race("soft grains", "particle steps", start, smooth, features)


def _contact(friction: str) -> Contact:
    return Contact(duration=0.01, friction=friction)  # type: ignore[arg-type]


# -- from event to event -----------------------------------------------------------------------------------------------


def event_features(number: int = 4000, collisions: int = 100_000) -> Race:
    """Elastic spheres, n = 0.5; the unit is a collision. number: of spheres. collisions: of a turn, and before it."""

    def start(laboratory: Laboratory) -> Start:
        output = Output(collisions=(collisions,), observables=("collisions",))
        scene = spheres(number, 0.5, laboratory.seed() % 2**31, duration=1e6, output=output)
        return Start(scene, lambda run: float(run["collisions"][-1]))

    def grains(**entries: object) -> Callable[[Scene], Scene]:
        return lambda scene: scene.changed(hard_spheres=HardSpheres(**entries))  # type: ignore[arg-type]

    def seeing(*observables: str, **more: object) -> Callable[[Scene], Scene]:
        output = {"collisions": (collisions,), "observables": ("collisions", *observables), **more}
        return lambda scene: scene.changed(output=Output(**output))  # type: ignore[arg-type]

    def species(scene: Scene) -> Scene:
        kinds = tuple(i % 2 for i in range(number))
        return scene.changed(
            species=kinds,
            masses=tuple((1.0, 0.7)[kind] for kind in kinds),
            hard_spheres=HardSpheres(diameter=(1.0, 0.9)),
        )

    rough = GrainFriction(tangential_restitution=0.5, static=0.5, sliding=0.5)
    features = (
        Feature("restitution", grains(restitution=0.999)),
        Feature("two species", species),
        Feature("friction", grains(friction=rough)),
        Feature("square wells", grains(well=Well(depth=1.0, range=1.5))),
        Feature("six walls", lambda scene: scene.changed(box=Box(density=0.5, boundaries=("hard",) * 3))),
        Feature("a field", lambda scene: scene.changed(acceleration=(0.0, 0.0, -0.01))),
        Feature("averages", seeing("collisional_virial")),
        Feature("fields of 4 x 4 x 4 cells", seeing(fields=(4, 4, 4))),
    )
    return _race("hard spheres", "collisions", start, Method(scheme="event_driven"), features)


# -- lattice gases -----------------------------------------------------------------------------------------------------


def lattice_features(size: int = 512, steps: int = 4096) -> Race:
    """FHP-I on size x size sites; the unit is a site update. steps: of a turn."""

    def start(laboratory: Laboratory) -> Start:
        scene = gas_scene("features", "fhp1", size, size, steps, filled(0.3, laboratory.seed()), Output())
        return Start(scene, lambda run: float(size * size * run.cost.steps))

    def gas(**entries: object) -> Callable[[Scene], Scene]:
        return lambda scene: scene.changed(lattice_gas=scene.lattice_gas.model_copy(update=entries))  # type: ignore[union-attr]

    def obstacle(rule: str) -> Obstacle:
        return Obstacle(centre=(size / 2, size / 2), radius=size / 8, rule=rule)  # type: ignore[arg-type]

    features = (
        Feature("an obstacle, bounce-back", gas(obstacles=(obstacle("bounce_back"),))),
        Feature("an obstacle, diffusive", gas(obstacles=(obstacle("diffusive_x"),))),
        Feature("a force", gas(force=0.01)),
        Feature(
            "populations, 1 step in 64",
            lambda scene: scene.changed(output=Output(interval=64.0, observables=("populations",))),
        ),
    )
    return _race("FHP-I", "site updates", start, Method(scheme="lattice_planes"), features)
