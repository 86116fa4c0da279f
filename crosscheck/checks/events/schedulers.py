"""The schedulers of refimpl, queues of events of three kinds, against each other."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant, full
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.checks.operations import counted, counting
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.scene import Floats, HardSpheres, Method, Observable, Output, Scene, Well
from crosscheck.verdict import Judged, bounded, round_off, worst

#: Schemes by the name of their queue; the first is what the others are compared with.
SCHEDULERS = {
    "tree": "event_driven",
    "lists": "event_driven_lists",
    "calendar queue": "event_driven_calendar",
    "lists of neighbours": "event_driven_neighbours",
}


def _judge(laboratory: Laboratory, dimension: int) -> Judged:
    """Final states of the schedulers after 1e5 collisions: not a bit may differ."""
    scene = spheres(
        1000,
        0.5,
        laboratory.seed() % 2**31,
        dimension=dimension,
        hard_spheres=HardSpheres(restitution=0.999),
        duration=1e6,
        output=Output(collisions=(100_000,), observables=("collisions",)),
    )
    runs = {name: laboratory.run(scene, Method(scheme=scheme)) for name, scheme in SCHEDULERS.items()}
    first, *others = runs
    tree = runs[first]
    judgements = [
        bounded(
            f"numbers that differ between the {first} and the {name}",
            float(
                np.sum(runs[name]["final_positions"] != tree["final_positions"])
                + np.sum(runs[name]["time"] != tree["time"])
            ),
            0.0,
            "a pair's time is a function of the two states alone: the scheduler does not enter, not even by rounding",
        )
        for name in others
    ]
    return worst(judgements, f"100000 collisions of 1000 particles, to t = {tree['time'][-1]:.6g}")


class _Crowd(NamedTuple):
    """Particles of two sizes and masses: dimension, number, particles per sigma^d, duration; with wells about them."""

    dimension: Literal[2, 3]
    number: int
    density: float
    duration: float
    well: bool = False


def _crowd(crowd: _Crowd, seed: int) -> Scene:
    """Grains, every other one smaller and lighter, in a periodic box."""
    d, number = crowd.dimension, crowd.number
    observables: tuple[Observable, ...] = ("collisions", "events", "operation_counts")
    sizes = tuple(1.0 - 0.15 * (i % 2) for i in range(number))
    law = HardSpheres(diameter=sizes, restitution=0.99)
    if crowd.well:
        law = HardSpheres(diameter=sizes, well=Well(depth=1.0, range=1.4))
    return spheres(
        number,
        crowd.density,
        seed,
        dimension=d,
        species=tuple(i % 2 for i in range(number)),
        masses=tuple(1.0 - 0.5 * (i % 2) for i in range(number)),
        hard_spheres=law,
        duration=crowd.duration,
        output=Output(interval=crowd.duration / 2, observables=observables, trace=True),
    )


def _events(run: Run) -> Floats:
    """The trace as rows: time and partners, the lower number first, and the states of both in that order."""
    partners = run["event_partners"]
    swap = (partners[:, 0] > partners[:, 1]) & (partners[:, 1] >= 0)
    columns = [partners, run["event_positions"], run["event_velocities"]]
    ordered = [np.where(swap.reshape(-1, *[1] * (c.ndim - 1)), c[:, ::-1], c).reshape(len(c), -1) for c in columns]
    return np.column_stack([run["event_times"], *ordered])


def _judge_lists(laboratory: Laboratory, crowd: _Crowd) -> Judged:
    """Every event of a run with lists of neighbours, and of one with cells: not a bit may differ."""
    scene = _crowd(crowd, laboratory.seed() % 2**31)
    cells = laboratory.run(scene, EVENT_DRIVEN)
    lists = laboratory.run(scene, Method(scheme=SCHEDULERS["lists of neighbours"]))
    one, other = _events(cells), _events(lists)
    short = min(len(one), len(other))
    differing = int(np.sum((one[:short] != other[:short]).any(axis=1))) + abs(len(one) - len(other))
    made = counted(lists.cost, "list_builds")
    judged = [
        round_off("events that differ, by a bit or more", float(differing), 0.5, _WHY_SAME),
        round_off("passages of cells' faces with lists", counted(lists.cost, "cell_crossings"), 0.5, _WHY_LISTS),
        round_off("lists of neighbours with cells", counted(cells.cost, "list_builds"), 0.5, _WHY_LISTS),
        bounded("lists of neighbours made", made, float(crowd.number), "else lists are not judged", at_least=True,
                control=True),
    ]  # fmt: skip
    return worst(judged, f"{len(one)} events of {crowd.number} particles, {made:.0f} lists")


_WHY_SAME = "lists change which pairs are looked at, and never a state, nor the time of a pair's event"
_WHY_LISTS = "a count: exact"
_SHELLS = "events/kernels/shells.py"

CHECKS = (
    Check(
        name="events/neighbour-lists",
        title="Lists of neighbours and cells give the same events",
        equation="t_ij = f(r_i, v_i, tau_i, r_j, v_j, tau_j)",
        criterion="not one bit of any event differs: times, partners, states",
        citation="Donev, Torquato & Stillinger, J. Comput. Phys. 202, 737 (2005); Smallenburg, EPJ E 45, 22 (2022)",
        judge=_judge_lists,
        variants=(
            Variant("2d", _Crowd(2, 64, 0.7, 2.0), needs=event_driven("dimension=2 hard_spheres.restitution")),
            Variant("3d", _Crowd(3, 108, 0.7, 0.7), needs=event_driven("dimension=3 hard_spheres.restitution")),
            Variant(
                "wells-2d", _Crowd(2, 81, 0.5, 1.5, well=True), needs=event_driven("dimension=2 hard_spheres.well")
            ),
        ),
        needs=counting(
            event_driven(
                "box.boundaries=periodic hard_spheres.diameter[] masses[]",
                "collisions events operation_counts event_times event_partners event_positions event_velocities",
                tuple(SCHEDULERS[name] for name in ("tree", "lists of neighbours")),
            )
        ),
        interpreted=True,
        faults=(
            (
                "2d",
                Fault(
                    "short-lists",
                    _SHELLS,
                    "return distance * shells.reach + 2.0 * shells.width",
                    "return distance * shells.reach + 0.5 * shells.width",
                    "lists lack those that may come near while both are in their shells",
                ),
            ),
            (
                "3d",
                Fault(
                    "late-lists",
                    _SHELLS,
                    "width = (1.0 - SLACK) * shells.width",
                    "width = (2.0 - SLACK) * shells.width",
                    "particles get a new list only far beyond their shells",
                ),
            ),
            (
                "2d",
                Fault(
                    "same-shift",
                    _SHELLS,
                    "lists[j, lists[j, 0]] = ((LAST_SHIFT - code) << NUMBER_BITS) | i",
                    "lists[j, lists[j, 0]] = (code << NUMBER_BITS) | i",
                    "a neighbour across the edge of the box is looked for on the wrong side by one of the two",
                ),
            ),
        ),
    ),
    Check(
        name="events/schedulers",
        title="The tree, the documented lists, the calendar queue and lists of neighbours give the same events",
        equation="t_ij = f(r_i, v_i, tau_i, r_j, v_j, tau_j)",
        criterion="not one bit of the state differs after 100000 collisions",
        citation="Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993); Marin & Cordero, CPC 92, 214 (1995); "
        "Brown, Commun. ACM 31, 1220 (1988); Paul, J. Comput. Phys. 221, 615 (2007)",
        judge=_judge,
        variants=full(**{"3d": 3, "2d": 2}),
        needs=event_driven(
            "box.boundaries=periodic hard_spheres.restitution output.collisions",
            "collisions",
            tuple(SCHEDULERS.values()),
        ),
        faults=(
            (
                "3d",
                Fault(
                    "calendar-bucket",
                    "events/kernels/schedule.py",
                    "if queue.day[i] <= today:",
                    "if queue.day[i] <= today + 8 * queue.heads.size:",
                    "the calendar takes events of later rounds for today's",
                ),
            ),
        ),
    ),
)
