"""The schedulers of refimpl, queues of events of three kinds, against each other."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.faults import Fault
from crosscheck.scene import HardSpheres, Method, Output
from crosscheck.verdict import Judged, bounded, worst

#: Schemes by the name of their queue; the first is what the others are compared with.
SCHEDULERS = {"tree": "event_driven", "lists": "event_driven_lists", "calendar queue": "event_driven_calendar"}


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


CHECKS = (
    Check(
        name="events/schedulers",
        title="The tree, the documented lists and the calendar queue give the same events",
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
