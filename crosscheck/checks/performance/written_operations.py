"""All operations of an event that are written in the kernels: needless ones too, which nobody thought to count.

The counts of `events/operations` are of what is known to cost time. A call that is done twice, or a loop that nobody
needs, has no counter. So a copy of the sources counts every operation where it is written (`counted_sources`): a small
scene must need the known number of them, exactly; and an event must need no more of them where there are more
particles, but for what the tree climbs, how cells fit into the box, and hints to fetch memory ahead, which must be few.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.checks.operations import exactly
from crosscheck.checks.performance.counted_sources import Work, work_of
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault, sources
from crosscheck.figure import Figure, Series
from crosscheck.scene import (
    Box,
    Cylinder,
    Face,
    Floats,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Method,
    Observable,
    Oscillation,
    Output,
    RandomPhase,
    Scene,
    Well,
)
from crosscheck.scene.observables import OPERATIONS
from crosscheck.verdict import Judged, bounded, worst

_COUNTED: tuple[Observable, ...] = ("operation_counts", "events")
_SUMS: tuple[Observable, ...] = (*_COUNTED, "collisional_virial", "kinetic_energy_integral")

# -- a known number ----------------------------------------------------------------------------------------------------


class Known(NamedTuple):
    """A run and its known number of operations. scheme: of the engine. scene: what runs."""

    scheme: str
    scene: Scene
    operations: float


def _output(duration: float, observables: tuple[Observable, ...] = _COUNTED) -> Output:
    return Output(interval=duration, observables=observables)


def _gas(dimension: int, duration: float) -> Scene:
    return spheres(64, 0.5, 3, dimension=dimension, duration=duration, output=_output(duration))


def _grains(name: str, **more: Any) -> Scene:
    """Rough disks of two sizes that lose energy, in a field of force."""
    entries: dict[str, Any] = {
        "dimension": 2,
        "duration": 2.0,
        "acceleration": (0.0, -0.5),
        "hard_spheres": HardSpheres(
            diameter=(1.0, 0.7),
            restitution=0.9,
            contact_duration=1e-3,
            friction=GrainFriction(tangential_restitution=0.5, static=0.5, sliding=0.4),
        ),
        "species": tuple(i % 2 for i in range(36)),
        "initial": Lattice(kind="lattice", structure="square", number=36, temperature=1.0, seed=3),
        "output": _output(2.0, _SUMS),
    }
    return Scene(name=name, **(entries | more))


_FRICTION = Friction(tangential_restitution=0.0, static=0.8, sliding=0.8)
_IN_A_BOX = _grains(
    "grains-in-a-box",
    box=Box(
        lengths=(9.0, 9.0),
        boundaries=("hard", "hard"),
        faces={
            "x-": Face(temperature=1.0),
            "x+": Face(random_phase=RandomPhase(speed=0.5)),
            "y-": Face(oscillation=Oscillation(amplitude=0.1, frequency=6.0), friction=_FRICTION),
            "y+": Face(restitution=0.9, friction=_FRICTION),
        },
    ),
)
_IN_A_DRUM = _grains(
    "grains-in-a-drum",
    box=Box(
        lengths=(12.0, 12.0),
        boundaries=("open", "open"),
        cylinder=Cylinder(radius=6.0, angular_velocity=0.25, restitution=0.6, friction=_FRICTION),
    ),
)
_IN_CELLS = spheres(
    64,
    0.3,
    3,
    name="rough-spheres-in-cells",
    duration=0.7,
    hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.5, static=0.5, sliding=0.4)),
    output=Output(interval=0.7, observables=_SUMS, fields=(2, 2, 2)),
)
_WELLS = spheres(
    64,
    0.3,
    3,
    name="square-wells",
    duration=0.5,
    hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.5)),
    output=_output(0.5, _SUMS),
)
_DILUTE = spheres(16, 1e-3, 3, name="dilute-spheres", duration=300.0, output=_output(300.0))
_WALLED = spheres(
    64,
    0.3,
    3,
    name="disks-between-walls",
    dimension=2,
    duration=3.0,
    hard_spheres=HardSpheres(fixed=(1,)),
    species=tuple(int(i % 4 == 0) for i in range(64)),
    box=Box(density=0.3, boundaries=("hard", "periodic")),
    output=_output(3.0, _SUMS),
)
KNOWN = {
    "schedulers": (
        Known("event_driven", _gas(2, 3.0), 1403117),
        Known("event_driven_lists", _gas(2, 3.0), 1502432),
        Known("event_driven_calendar", _gas(2, 3.0), 1341201),
        Known("event_driven_neighbours", _gas(2, 3.0), 2193797),
    ),
    "spheres": (
        Known("event_driven", _gas(3, 1.0), 1847506),
        Known("event_driven_neighbours", _gas(3, 1.0), 2468482),
    ),
    "features": (
        Known("event_driven", _WELLS, 3497549),
        Known("event_driven", _WALLED, 697049),
        Known("event_driven", _IN_A_BOX, 436042),
        Known("event_driven", _IN_A_DRUM, 545384),
        Known("event_driven", _DILUTE, 2432432),
        Known("event_driven", _IN_CELLS, 901714),
    ),
}


def _judge_known(laboratory: Laboratory, known: tuple[Known, ...]) -> Judged:
    """The number of operations of each run."""
    runs = [(one.scene, Method(scheme=one.scheme)) for one in known]
    for scene, method in runs:
        laboratory.demand(scene, method)
    judged = []
    for one, work in zip(known, work_of(sources(laboratory.pool.overlay), runs, interpreted=True), strict=True):
        judged.append(
            exactly(f"operations of {one.scene.name}, {one.scheme}", work.work[-1] + work.ahead[-1], one.operations)
        )
    return worst(judged, f"{len(known)} runs")


# -- growth ------------------------------------------------------------------------------------------------------------

#: Spheres per diameter^3, and batches of events.
_DENSITY, _BATCHES = 0.5, 20
#: Share of an event's operations at the largest N that may seem to grow.
_GROWN = 0.05
_WHY_GROWN = (
    "5 %, as in the checks */operations: how cells fit into their box leaves half of that as growth like sqrt N"
)
#: What only fetches memory ahead, over all else.
_FETCHED = 0.1
_WHY_FETCHED = "a hint for each line of memory that an event needs is little beside what is done there: a tenth"
_GROWTH: dict[str, Callable[[Floats], Floats]] = {"sqrt N": np.sqrt, "N": lambda n: n}


class _Queue(NamedTuple):
    """A scheduler. scheme: its name. sizes: numbers of particles. climbs: whether its comparisons grow as ln N."""

    scheme: str
    sizes: tuple[int, ...]
    climbs: bool


def _batches(number: int, seed: int) -> Scene:
    size = max(number // 4, 500)
    counts = tuple(4 * number + size * k for k in range(_BATCHES + 1))
    return spheres(number, _DENSITY, seed, duration=1e6, output=Output(collisions=counts, observables=_COUNTED))


def _judge_growth(laboratory: Laboratory, queue: _Queue) -> Judged:
    """Operations of an event against N, beside those for what is counted, which depends on how cells fit."""
    seed, method = laboratory.seed() % 2**31, Method(scheme=queue.scheme)
    runs = [(_batches(number, seed), method) for number in queue.sizes]
    laboratory.demand(*runs[0])
    found = work_of(sources(laboratory.pool.overlay), runs, interpreted=False)
    work, ahead, counts = (np.array(column) for column in zip(*map(_per_event, found), strict=True))
    n = np.array(queue.sizes, dtype=float)
    beside = [np.ones_like(n), counts[:, OPERATIONS.index("predictions")], _at_faces(n)]
    if queue.climbs:
        beside.append(counts[:, OPERATIONS.index("tree_comparisons")])
    judged = [
        bounded(
            "operations that fetch memory ahead, over all others, at the N where they are the most",
            float((ahead / work).max()),
            _FETCHED,
            _WHY_FETCHED,
        )
    ]
    for law, function in _GROWTH.items():
        terms, scatter = _fitted([*beside, function(n)], work)
        judged.append(
            bounded(
                f"share of an event's operations at the largest N that grows as {law}",
                float(terms[-1] * (function(n[-1]) - function(n[0])) / work[-1]),
                _GROWN,
                _WHY_GROWN,
                note=f"{work[0]:.0f} operations at N = {n[0]:.0f}, {work[-1]:.0f} at {n[-1]:.0f}; {terms[1]:.0f} a "
                f"prediction; {scatter:.2%} unexplained",
            )
        )
    figure = Figure(
        "Operations written in the kernels, per event",
        "N",
        "operations per event",
        x_scale="log",
        series=(Series(queue.scheme, n.tolist(), work.tolist()),),
    )
    return worst(judged, f"N = {queue.sizes[0]} to {queue.sizes[-1]}", (figure,))


def _per_event(run: Work) -> tuple[float, float, Floats]:
    """Operations of an event after the start, those that fetch ahead, and those that are counted, (operations,)."""
    counted = np.array(run.counted)
    work, ahead, events = (column[-1] - column[1] for column in (run.work, run.ahead, run.events))
    return work / events, ahead / events, (counted[-1] - counted[1]) / events


def _at_faces(n: Floats) -> Floats:
    """Share of the cells that are at a face of the box, whose neighbours are across it; n: numbers of spheres."""
    across = np.floor((n / _DENSITY) ** (1 / 3))
    return np.asarray(1 - (1 - 2 / across) ** 3)


def _fitted(columns: list[Floats], work: Floats) -> tuple[Floats, float]:
    """Coefficients of the columns, by least squares, and the root mean square of what is left, relative."""
    design = np.stack(columns, axis=1)
    scale = np.linalg.norm(design, axis=0)
    terms = np.linalg.lstsq(design / scale, work)[0] / scale
    return terms, float(np.sqrt(np.mean((work / (design @ terms) - 1) ** 2)))


# -- checks ------------------------------------------------------------------------------------------------------------

_SIZES = tuple(2**k for k in range(7, 15))
_LARGE = (*(2**k for k in range(7, 18)), 10**6)
_GROWING = {
    "tree": _Queue("event_driven", _SIZES, climbs=True),
    "lists": _Queue("event_driven_lists", _SIZES, climbs=True),
    "calendar": _Queue("event_driven_calendar", _SIZES, climbs=False),
}


def _needs(words: str, observables: tuple[Observable, ...] = _COUNTED) -> Needs:
    schemes = tuple(dict.fromkeys(one.scheme for known in KNOWN.values() for one in known))
    return replace(
        event_driven(words, " ".join(observables), schemes),
        promises=("cut_to_the_scene", "operations", "interpretable"),
    )


_CITATION = "Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993); Paul, J. Comput. Phys. 221, 615 (2007)"
_PERIODIC = "dimension=3 box.boundaries=periodic output.collisions"

CHECKS = (
    Check(
        name="performance/written-operations",
        title="All operations that are written in the kernels of events: none is needless",
        equation="operations = those that the algorithm needs",
        criterion="exactly the known numbers of small scenes, which change with the text of the kernels alone",
        citation=_CITATION,
        judge=_judge_known,
        interpreted=True,
        variants=(
            Variant("schedulers", KNOWN["schedulers"]),
            Variant("spheres", KNOWN["spheres"], needs=_needs("dimension=3")),
            Variant(
                "features",
                KNOWN["features"],
                needs=_needs(
                    "hard_spheres.well hard_spheres.friction hard_spheres.contact_duration hard_spheres.restitution "
                    "hard_spheres.fixed acceleration box.boundaries=hard box.cylinder box.faces output.fields "
                    "dimension=3",
                    _SUMS,
                ),
            ),
        ),
        needs=_needs(""),
        faults=(
            (
                "schedulers",
                Fault(
                    "own-event-twice",
                    "events/kernels/loop.py",
                    "                own_event(model, grid, particles, one, now)\n",
                    "                own_event(model, grid, particles, one, now)\n"
                    "                own_event(model, grid, particles, one, now)\n",
                    "the passage of a cell's face is predicted twice at each event, which changes no result",
                ),
            ),
            (
                "features",
                Fault(
                    "wells-looked-through",
                    "events/kernels/loop.py",
                    "    status = PAUSED\n",
                    "    status = PAUSED\n"
                    "    if particles.bonds is not None:\n"
                    "        for k in range(particles.bonds.shape[1]):\n"
                    "            if particles.bonds[i, k] < -1:\n"
                    "                status = COLLAPSED\n",
                    "at each event the whole row of partners in a well is looked through, for nothing",
                ),
            ),
        ),
    ),
    Check(
        name="performance/scaling-written-operations",
        title="All operations that are written in the kernels, per event, against the number of particles",
        equation="operations = a + p predictions(N) + c comparisons(N) + s (share of cells at faces)(N)",
        criterion=f"what grows as sqrt N or N beside these is below {_GROWN:.0%} at the largest N",
        citation=_CITATION,
        judge=_judge_growth,
        variants=(
            *(Variant(name, queue, "full") for name, queue in _GROWING.items()),
            *(Variant(f"{name}-1e6", queue._replace(sizes=_LARGE), "full") for name, queue in _GROWING.items()),
        ),
        needs=_needs(_PERIODIC),
        faults=(
            (
                "tree",
                Fault(
                    "square-root-of-all",
                    "events/kernels/loop.py",
                    "        pair_time, own_time = rows[i, NEXT], own[i]\n",
                    "        pair_time, own_time = rows[i, NEXT], own[i]\n"
                    "        k = 0\n"
                    "        while k * k < own.size:\n"
                    "            if own[k] < -1.0:\n"
                    "                progress[FIRST] = k\n"
                    "            k += 1\n",
                    "at each event the times of sqrt N particles are looked at, for nothing",
                ),
            ),
        ),
    ),
)
