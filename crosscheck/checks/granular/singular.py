"""Two soft grains that meet in one point, where the normal is 0/0: the run diverges there, says so, and ends."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.checks.meetings import DT, MEETING, MEETINGS, WEAK, Meeting, judged_meeting
from crosscheck.engines.capabilities import Needs, words
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Contact, HardSpheres, Method, Scene
from crosscheck.verdict import Judged, bounded, round_off, worst

#: The two overlap at the step before the meeting in space, and at the three before it in the plane.
_DIAMETER = 0.5
_METHOD = Method(scheme="velocity_verlet", dt=DT, contact=Contact(stiffness=WEAK))


def _scene(meeting: Meeting) -> Scene:
    return meeting.scene(("contact_time",), hard_spheres=HardSpheres(diameter=_DIAMETER))


def _judge(laboratory: Laboratory, meeting: Meeting) -> Judged:
    scene = _scene(meeting)
    pull = WEAK * _DIAMETER * scene.duration**2
    judgements, run = judged_meeting(laboratory, scene, _METHOD, pull, MEETING)
    speed = 2 * float(np.linalg.norm(scene.initial_state().velocities, axis=1).max())
    touching = (np.abs(np.arange(MEETING) - MEETING) * DT * speed < _DIAMETER).astype(float)
    expected = np.concatenate([[0.0], np.cumsum(touching[1:] + touching[:-1]) * DT / 2])
    times = run["contact_time"]
    judgements += [
        round_off(
            "contact times before, off by",
            float(np.abs(times[:MEETING] - expected).max()),
            MEETING * EPSILON * MEETING * DT,
            "half a step for each side of a sample at which two overlap; roundings of a sum of as many times",
        ),
        bounded(
            "contact times with numbers from the meeting on",
            float(np.isfinite(times[MEETING:]).sum()),
            0.0,
            "what is not known has no sum",
        ),
    ]
    return worst(judgements, f"two of {meeting.number} meet after {MEETING} steps")


CHECKS = (
    Check(
        name="granular/singular",
        title="Two soft grains meet in one point: the run says that it diverged, and ends there",
        equation="F = k (2 R - |r_12|) n, n = r_12/|r_12|, which is 0/0 where they meet",
        criterion="the flag is set; path and contact times before are exact; nothing is recorded from there on",
        citation="Cundall and Strack, Geotechnique 29, 47 (1979): the linear contact",
        judge=_judge,
        variants=tuple(
            Variant(name, meeting, needs=Needs("hard_spheres", words=words(_scene(meeting), _METHOD)))
            for name, meeting in MEETINGS.items()
        ),
        needs=soft_needs(observables="positions contact_time"),
        interpreted=True,
        faults=(
            (
                "last-of-many",
                Fault(
                    "no-push-in-one-place",
                    CONTACTS,
                    "n = _times(1.0 / distance, apart)",
                    "n = _times(1.0 / max(distance, 1e-300), apart)",
                    "grains in one place push each other nowhere, and pass through each other",
                ),
            ),
        ),
    ),
)
