"""Races of hard particles from event to event: the schedulers beside each other, and beside other programs."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory
from crosscheck.checks.events.gases import spheres
from crosscheck.checks.performance.races import (
    OURS,
    Race,
    Ready,
    Side,
    Start,
    same_state,
)
from crosscheck.engines.protocol import Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import EngineError
from crosscheck.references.hard_spheres import number_density
from crosscheck.scene import (
    Box,
    HardSpheres,
    Method,
    Output,
    Scene,
    Well,
)


def settled_side(name: str, method: Method, settling: float) -> Side:
    """An event-driven scheme of ours whose turns all go on from one state, of a gas that has settled.

    name: in tables. method: how. settling: pair collisions of each particle before that state.
    """

    def prepare(laboratory: Laboratory, scene: Scene) -> Ready:
        worker = laboratory.pool.worker(OURS)
        directory = tempfile.TemporaryDirectory(prefix="crosscheck-race-")
        state = Path(directory.name) / "settled.npz"
        before = Output(collisions=(int(settling * scene.number),), observables=("collisions",))
        worker.run(scene.changed(output=before), method, keep=state)

        def run() -> Run:
            assert directory  # the state lives as long as its side
            done = worker.run(scene, method, restart=state)
            if done.stopped:
                raise EngineError(f"{OURS}, scene {scene.name}: the run stopped: {done.stopped}")
            return done

        return Ready(run)

    return Side(name, prepare)


def event_driven_sides(settling: float, most: int | None = None) -> tuple[Side, ...]:
    """The event-driven schemes of ours that keep events in a queue, the engine's own choice first.

    settling: as of `settled_side`. most: take the first so many; None: all.
    """
    names = [name for name, claims in engine_class(OURS).schemes.items() if claims.kind == EVENT_DRIVEN]
    return tuple(
        settled_side(name.removeprefix("event_driven_").replace("event_driven", OURS), Method(scheme=name), settling)
        for name in [name for name in names if not name.endswith("naive")][:most]
    )


class Gas(NamedTuple):
    """A gas of hard particles.

    name: in tables. density: particles per sigma^d. more: entries of its scene. species: whether every second particle
    is of another one, lighter.
    """

    name: str
    density: float
    more: Mapping[str, object]
    species: bool = False


#: Programs for hard particles that no registry offers, found by environment variables: sides whose `prepare` raises
#: EngineMissing where the variable is not set, Unsupported for a gas that the program does not know.
PROGRAMS: tuple[Side, ...] = ()
_DENSE = number_density(0.45, 3)
_WALLED = Box(density=0.5, boundaries=("hard",) * 3)
#: Scenes whose speed is stated. Packing 0.26 is n = 0.5.
GASES = (
    Gas("spheres, packing 0.26", 0.5, {}),
    Gas("spheres, packing 0.45", _DENSE, {}),
    Gas("square wells, n = 0.5", 0.5, {"hard_spheres": HardSpheres(well=Well(depth=1.0, range=1.5))}),
    Gas("disks, n = 0.5", 0.5, {"dimension": 2}),
    Gas(
        "species, restitution, field, six walls, n = 0.5",
        0.5,
        {
            "hard_spheres": HardSpheres(diameter=(1.0, 0.9), restitution=0.999),
            "box": _WALLED,
            "acceleration": (0.0, 0.0, -0.01),
        },
        species=True,
    ),
)


def gas_named(name: str) -> Gas:
    """The gas of `GASES` with this name."""
    return next(gas for gas in GASES if gas.name == name)


def gas_of(gas: Gas, number: int, seed: int) -> Scene:
    """The scene of a gas on its lattice; number: of particles. seed: of the velocities."""
    more = dict(gas.more)
    if gas.species:
        kinds = tuple(i % 2 for i in range(number))
        more |= {"species": kinds, "masses": tuple((1.0, 0.7)[kind] for kind in kinds)}
    return spheres(number, gas.density, seed, **{"duration": 1e6, **more})


def gas_race(
    gas: Gas, number: int, collisions: int, settling: float = 10.0, most: int | None = None, turns: int = 5
) -> Race:
    """A gas from event to event, our schedulers beside each other and beside `PROGRAMS`; the unit is a pair collision.

    number: of particles. collisions, turns: of a turn; of each side. settling: pair collisions of each particle before
    the first turn. most: of our schedulers; None: all.
    """

    def start(laboratory: Laboratory) -> Start:
        scene = gas_of(gas, number, laboratory.seed() % 2**31)
        output = Output(collisions=(collisions,), observables=("collisions",))
        return Start(scene.changed(output=output), lambda run: float(run["collisions"][-1]))

    ours = event_driven_sides(settling, most)

    def alike(scene: Scene, runs: Mapping[str, Run]) -> None:
        """Our schedulers give the same bits, whatever the order in which they look at events."""
        same_state(scene, {side.name: runs[side.name] for side in ours if side.name in runs})

    return Race(f"{gas.name}, N = {number}", "collisions", start, (*ours, *PROGRAMS), alike, turns)
