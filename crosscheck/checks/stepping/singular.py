"""Two bodies that meet in one point, where no force is finite: the run diverges there, says so, and ends."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.meetings import DT, MEETING, MEETINGS, WEAK, Meeting, judged_meeting
from crosscheck.checks.stepping.faults import gravity_fault
from crosscheck.engines.capabilities import Needs, words
from crosscheck.scene import Gravity, Method, Scene
from crosscheck.verdict import Judged, worst


def _scene(meeting: Meeting) -> Scene:
    return meeting.scene(gravity=Gravity(G=WEAK))


def _judge(laboratory: Laboratory, meeting: Meeting) -> Judged:
    scene = _scene(meeting)
    nearest = 2 * float(np.abs(scene.initial_state().velocities).max()) * DT
    pull = meeting.number * WEAK / nearest**2 * scene.duration**2
    method = Method(scheme="velocity_verlet", dt=DT)
    judgements, _ = judged_meeting(laboratory, scene, method, pull, MEETING - 1)
    return worst(judgements, f"two of {meeting.number} meet after {MEETING} steps")


CHECKS = (
    Check(
        name="stepping/singular",
        title="Two bodies meet in one point: the run says that it diverged, and ends there",
        equation="r(t) = r_0 + v t until |r_1 - r_2| = 0, where the force is 0/0",
        criterion="the flag is set; the path before is exact; nothing is recorded from there on, and no step taken "
        "where steps are counted exactly",
        citation="Aarseth, Gravitational N-Body Simulations (2003), ch. 1: the singularity of unsoftened gravity",
        judge=_judge,
        variants=tuple(
            Variant(name, meeting, needs=Needs("gravity", words=words(_scene(meeting))))
            for name, meeting in MEETINGS.items()
        ),
        needs=Needs("gravity", observables=frozenset({"positions"}), schemes=("velocity_verlet",)),
        interpreted=True,
        faults=(
            (
                "last-of-many",
                gravity_fault(
                    "divergence-not-seen",
                    "outcome[0] = GOOD if kernels.all_finite(a) else DIVERGED",
                    "outcome[0] = GOOD if kernels.all_finite(r) else DIVERGED",
                    "a run whose forces are not finite goes on to its end",
                ),
            ),
        ),
    ),
)
