"""Operations of event-driven algorithms, per event: predictions, comparisons, events that were not valid any more."""

from __future__ import annotations

import math
from typing import NamedTuple

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.checks.events.cost import LINEAR_SCAN
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.checks.operations import CRITERION, EQUATION, alike, as_known, at_most, counted, counting, exactly
from crosscheck.engines.protocol import Kind, Run
from crosscheck.faults import Fault
from crosscheck.scene import Method, Observable, Output, Scene
from crosscheck.scene.observables import OPERATIONS
from crosscheck.verdict import Judged, Judgement, bounded, worst

_DISKS = 64
#: A share of the predictions that the volume which the particle itself takes may save, and its neighbours' order.
_CORRELATED = 0.1
_OBSERVABLES: tuple[Observable, ...] = ("collisions", "events", "operation_counts")


class _Queue(NamedTuple):
    """How the next event is found.

    method: of the run. levels: of comparisons of an update, over log2 N; None: no tree. known: counts of the scene.
    moves: along lists of events, in the scene.
    """

    method: Method | Kind
    levels: float | None
    known: dict[str, float]
    moves: int = 0


def _scene() -> Scene:
    """Disks at the density 1/2, from the same start whatever the seed: counts are known of it."""
    output = Output(interval=1.0, observables=_OBSERVABLES)
    return spheres(_DISKS, 0.5, 3, dimension=2, duration=4.0, output=output)


def _judge(laboratory: Laboratory, queue: _Queue) -> Judged:
    run = laboratory.run(_scene(), queue.method)
    cost, collisions = run.cost, float(run["collisions"][-1])
    stale, crossings, events = counted(cost, "stale_events"), counted(cost, "cell_crossings"), float(cost.events)
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
        updates = events + collisions
        judged.append(
            at_most(
                f"comparisons over {queue.levels:g} ln N/ln 2 of an update",
                comparisons / (updates * queue.levels * math.log2(_DISKS)),
                1.0,
                "a complete binary tree: an update climbs it once, and a collision updates two particles",
            )
        )
    if laboratory.engine == "refimpl":
        judged.append(exactly("first events of particles", events - collisions - crossings - stale, _DISKS))
        judged.append(_neighbourhoods(queue, predictions, collisions, stale, crossings))
        judged.append(_moves(queue, run))
    return worst([*judged, *as_known(laboratory, cost, queue.known)], f"{collisions:.0f} collisions of {_DISKS} disks")


def _neighbourhoods(queue: _Queue, predictions: float, collisions: float, stale: float, crossings: float) -> Judgement:
    """Of cells with one particle in the mean, 9 are searched, or 3 after a crossing."""
    others = (_DISKS - 1) / _DISKS
    # a store of all events of a particle needs none after an event that was stale
    anew = _DISKS + 2 * collisions + (0.0 if queue.method == _LISTS else stale)
    expected = anew * (1 + 9 * others) + crossings * 3 * others
    return bounded(
        "predictions over those of the cells around: share by which it differs from 1",
        abs(predictions / expected - 1),
        _CORRELATED,
        "on the average over many places, a cell holds N/cells others; a disk's own place holds fewer",
    )


def _moves(queue: _Queue, run: Run) -> Judgement:
    """Steps along lists of events, and nodes of them that are put away; none without such lists."""
    moves = float(run["operation_counts"][-1, OPERATIONS.index("list_moves")])
    if queue.moves == 0:
        return exactly("steps along lists of events", moves, 0)
    return alike("list moves", moves, queue.moves)


_LISTS = Method(scheme="event_driven_lists")
_CALENDAR = Method(scheme="event_driven_calendar")


def _variant(name: str, queue: _Queue) -> Variant:
    needs = None
    if isinstance(queue.method, Method):
        needs = event_driven(schemes=(queue.method.scheme,))
    return Variant(name, queue, "quick", needs)


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
        ),
        needs=counting(event_driven(observables=" ".join(_OBSERVABLES))),
        interpreted=True,
        faults=(
            ("tree", LINEAR_SCAN),
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
