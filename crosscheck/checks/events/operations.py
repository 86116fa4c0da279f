"""Operations of event-driven algorithms, per event: predictions, comparisons, events that were not valid any more."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.checks.events.cost import LINEAR_SCAN
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.checks.operations import CRITERION, EQUATION, alike, as_known, at_most, counted, counting, exactly
from crosscheck.engines.protocol import Kind, Run
from crosscheck.faults import Fault
from crosscheck.scene import HardSpheres, Method, Observable, Output, Scene
from crosscheck.scene.observables import OPERATIONS
from crosscheck.verdict import Judged, Judgement, bounded, worst

_DISKS = 64
#: A share of the predictions that the volume which the particle itself takes may save, and its neighbours' order.
_CORRELATED = 0.1
_OBSERVABLES: tuple[Observable, ...] = ("collisions", "events", "operation_counts")


class _Gas(NamedTuple):
    """Disks or spheres: dimension, particles per sigma^d, duration; whether every fourth one never moves."""

    dimension: Literal[2, 3] = 2
    density: float = 0.5
    duration: float = 4.0
    fixed: bool = False


class _Queue(NamedTuple):
    """How the next event is found.

    method: of the run. levels: of comparisons of an update, over log2 N; None: no tree. known: counts of the scene.
    moves: along lists of events, in the scene. gas: which scene.
    """

    method: Method | Kind
    levels: float | None
    known: dict[str, float]
    moves: int = 0
    gas: _Gas = _Gas()


def _scene(gas: _Gas) -> Scene:
    """From the same start whatever the seed: counts are known of it."""
    dimension, density, duration, fixed = gas
    output = Output(interval=duration / 4, observables=_OBSERVABLES)
    entries: dict[str, Any] = {}
    if fixed:
        entries = {"hard_spheres": HardSpheres(fixed=(1,)), "species": tuple(int(i % 4 == 0) for i in range(_DISKS))}
    return spheres(_DISKS, density, 3, dimension=dimension, duration=duration, output=output, **entries)


def _judge(laboratory: Laboratory, queue: _Queue) -> Judged:
    run = laboratory.run(_scene(queue.gas), queue.method)
    cost, collisions = run.cost, float(run["collisions"][-1])
    stale, crossings, events = counted(cost, "stale_events"), counted(cost, "cell_crossings"), float(cost.events)
    events -= _own_work(run, "renewals") + _own_work(run, "list_builds")
    predictions, comparisons = counted(cost, "predictions"), counted(cost, "comparisons")
    judged = [
        bounded(
            "events that are neither collisions, nor crossings, nor were stale",
            events - collisions - crossings - stale,
            _DISKS,
            "no more than the first of each particle",
        ),
        at_most(
            "predictions over those of all pairs",
            predictions / (_DISKS * (events + collisions)),
            0.5,
            "cells: a particle looks at its neighbours only, at an event of its own or of its partner",
        ),
    ]
    if queue.levels is not None:
        updates = float(cost.events) + collisions
        judged.append(
            at_most(
                f"comparisons over {queue.levels:g} ln N/ln 2 of an update",
                comparisons / (updates * queue.levels * math.log2(_DISKS)),
                1.0,
                "a complete binary tree: an update climbs it once, and a collision updates two particles",
            )
        )
    if laboratory.engine == "refimpl":
        moving = _DISKS * 3 // 4 if queue.gas.fixed else _DISKS
        judged.append(exactly("first events of particles", events - collisions - crossings - stale, moving))
        if queue.method == _NEIGHBOURS:
            judged.append(exactly("passages of cells' faces", crossings, 0))
        elif not queue.gas.fixed:  # a collision with a fixed disk updates one particle, which the counts do not tell
            judged.append(_neighbourhoods(queue, predictions, collisions, stale, crossings))
        judged.append(_moves(queue, run))
    return worst([*judged, *as_known(laboratory, cost, queue.known)], f"{collisions:.0f} collisions of {_DISKS} disks")


def _own_work(run: Run, name: str) -> float:
    """The number of events of a kind that an algorithm has for itself alone, by the name of the operation."""
    return float(run["operation_counts"][-1, OPERATIONS.index(name)])


def _neighbourhoods(queue: _Queue, predictions: float, collisions: float, stale: float, crossings: float) -> Judgement:
    """Of cells with one particle in the mean, 3^d are searched, or 3^(d - 1) after a crossing."""
    others, d = (_DISKS - 1) / _DISKS, queue.gas.dimension
    # a store of all events of a particle needs none after an event that was stale
    anew = _DISKS + 2 * collisions + (0.0 if queue.method == _LISTS else stale)
    expected = anew * (1 + 3**d * others) + crossings * 3 ** (d - 1) * others
    return bounded(
        "predictions over those of the cells around: share by which it differs from 1",
        abs(predictions / expected - 1),
        _CORRELATED,
        "on the average over many places, a cell holds N/cells others; a disk's own place holds fewer",
    )


def _moves(queue: _Queue, run: Run) -> Judgement:
    """Steps along lists of events, and nodes of them that are put away; none without such lists."""
    moves = _own_work(run, "list_moves")
    if queue.moves == 0:
        return exactly("steps along lists of events", moves, 0)
    return alike("list moves", moves, queue.moves)


_LISTS = Method(scheme="event_driven_lists")
_CALENDAR = Method(scheme="event_driven_calendar")
_NEIGHBOURS = Method(scheme="event_driven_neighbours")


def _made(lists: float, distances: float) -> dict[str, float]:
    """The known counts of lists of neighbours that were made, and of the distances looked at for them."""
    return {"list_builds": lists, "list_tests": distances}


def _variant(name: str, queue: _Queue, words: str = "") -> Variant:
    schemes = (queue.method.scheme,) if isinstance(queue.method, Method) else ()
    return Variant(name, queue, "quick", event_driven(words, schemes=schemes))


CHECKS = (
    Check(
        name="events/operations",
        title="Operations of the event-driven algorithm, per event",
        equation=EQUATION,
        criterion=CRITERION,
        citation="Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993); Paul, J. Comput. Phys. 221, 615 (2007)",
        judge=_judge,
        variants=(
            _variant(
                "tree",
                _Queue(
                    EVENT_DRIVEN,
                    1.0,
                    {"predictions": 10764, "comparisons": 5791, "stale_events": 41, "cell_crossings": 150},
                ),
            ),
            _variant(
                "lists",
                _Queue(
                    _LISTS,
                    1.0,
                    {"predictions": 10382, "comparisons": 6193, "stale_events": 90, "cell_crossings": 150},
                    moves=3986,
                ),
            ),
            _variant(
                "calendar",
                _Queue(
                    _CALENDAR,
                    None,
                    {"predictions": 10764, "comparisons": 926, "stale_events": 41, "cell_crossings": 150},
                ),
            ),
            _variant(
                "neighbours",
                _Queue(
                    _NEIGHBOURS,
                    1.0,
                    {
                        "predictions": 6657,
                        "comparisons": 9362,
                        "stale_events": 39,
                        "list_builds": 767,
                        "list_tests": 9053,
                    },
                ),
            ),
            _variant(
                "neighbours-3d",
                _Queue(
                    _NEIGHBOURS,
                    1.0,
                    {
                        "predictions": 12999,
                        "comparisons": 7576,
                        "stale_events": 61,
                        "list_builds": 484,
                        "list_tests": 30976,
                    },
                    gas=_Gas(3, 0.5, 2.0),
                ),
                "dimension=3",
            ),
            # most events are crossings of cells
            _variant(
                "dilute",
                _Queue(EVENT_DRIVEN, 1.0, {"predictions": 3819, "cell_crossings": 291}, gas=_Gas(2, 0.05, 20.0)),
            ),
            _variant(
                "spheres",
                _Queue(EVENT_DRIVEN, 1.0, {"predictions": 7468, "cell_crossings": 242}, gas=_Gas(3, 0.05, 6.0)),
                "dimension=3",
            ),
            _variant(
                "fixed",
                _Queue(
                    EVENT_DRIVEN, 1.0, {"predictions": 3256, "cell_crossings": 100}, gas=_Gas(2, 0.3, 4.0, fixed=True)
                ),
                "hard_spheres.fixed",
            ),
        ),
        needs=counting(event_driven(observables=" ".join(_OBSERVABLES))),
        interpreted=True,
        faults=(
            ("tree", LINEAR_SCAN),
            (
                "neighbours",
                Fault(
                    "impatient-lists",
                    "events/kernels/shells.py",
                    "width = (1.0 - SLACK) * shells.width",
                    "width = (0.9 - SLACK) * shells.width",
                    "lists of neighbours are made anew before their particles leave their shells",
                ),
            ),
            (
                "neighbours-3d",
                Fault(
                    "long-lists",
                    "events/kernels/shells.py",
                    "return distance * shells.reach + 2.0 * shells.width",
                    "return distance * shells.reach + 2.3 * shells.width",
                    "lists of neighbours hold some that cannot come near while they are good",
                ),
            ),
            (
                "calendar",
                Fault(
                    "one-day",
                    "events/simulation.py",
                    "self._queue.per_time[0] = self.number / wait",
                    "self._queue.per_time[0] = 0.01 * self.number / wait",
                    "the calendar's buckets are a hundred times too wide",
                ),
            ),
        ),
    ),
)
