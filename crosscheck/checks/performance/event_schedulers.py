"""Speed of the event-driven schedulers beside each other: the same gas, alternated, CPU seconds of the events alone."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.cost import LINEAR_SCAN
from crosscheck.checks.events.gases import spheres
from crosscheck.engines.capabilities import Needs
from crosscheck.scene import Method, Output, explicit
from crosscheck.verdict import Judged, bounded

TURNS = 7
_SCHEDULERS = {"tree": "event_driven", "lists": "event_driven_lists", "calendar": "event_driven_calendar"}


def _judge(laboratory: Laboratory, number: int) -> Judged:
    """CPU time per collision of the documented scheduler over that of the fastest one; number: of spheres."""
    melt = spheres(number, 0.5, laboratory.seed() % 2**31, duration=4.0)
    start = laboratory.run(melt, EVENT_DRIVEN)
    scene = melt.changed(
        initial=explicit(start["final_positions"], start["final_velocities"]),
        duration=1e6,
        output=Output(collisions=(20 * number,), observables=("collisions",)),
    )
    taken: dict[str, list[float]] = {name: [] for name in _SCHEDULERS}
    for turn in range(TURNS + 1):
        for name, scheme in _SCHEDULERS.items():
            cost = laboratory.run(scene, Method(scheme=scheme)).cost
            if turn:  # the first turn warms caches
                taken[name].append(cost.cpu / (20 * number))
    best = np.minimum.reduce(list(taken.values()))
    ratios = np.array(taken["lists"]) / best
    rates = ", ".join(f"{name} {1e-6 / float(np.median(times)):.3g}" for name, times in taken.items())
    return bounded(
        "CPU time of the documented lists and tree over the fastest scheduler's",
        float(np.median(ratios)),
        1.5,
        f"the goal; median of {TURNS} alternated turns, of {ratios.min():.2f} ... {ratios.max():.2f}",
        note=f"million collisions per CPU second: {rates}",
    )


CHECKS = (
    Check(
        name="performance/event-schedulers",
        title="Elastic spheres at n = 0.5: the documented lists and tree beside the other schedulers",
        equation="CPU seconds/collisions",
        criterion=f"at most 1.5 times the fastest, median of {TURNS} alternated turns, one thread, compilation apart",
        citation="Marin & Cordero, Comput. Phys. Commun. 92, 214 (1995); Paul, J. Comput. Phys. 221, 615 (2007)",
        judge=_judge,
        variants=full(N10976=10976),
        faults=(("N10976", LINEAR_SCAN),),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({"dimension=3", "box.boundaries=periodic", "output.collisions"}),
            observables=frozenset({"collisions"}),
            schemes=tuple(_SCHEDULERS.values()),
        ),
        timing=True,
    ),
)
