"""Two Lennard-Jones particles that meet in one point, where no force is finite: the run diverges, says so, and ends."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.meetings import DT, MEETING, MEETINGS, STEPS, WEAK, Meeting, judged_meeting
from crosscheck.engines.capabilities import Needs, words
from crosscheck.scene import LennardJones, Method, Output, Scene
from crosscheck.verdict import Judged, worst


def _scene(meeting: Meeting) -> Scene:
    return Scene(
        name="meeting",
        dimension=meeting.dimension,  # type: ignore[arg-type]
        duration=STEPS * DT,
        lennard_jones=LennardJones(epsilon=WEAK, cutoff=2.5),
        initial=meeting.start,
        output=Output(interval=DT, trajectory=True),
    )


def _judge(laboratory: Laboratory, meeting: Meeting) -> Judged:
    scene = _scene(meeting)
    # one coordinate of the distance, a step before the meeting
    nearest = 2 * float(abs(scene.initial_state().velocities).max()) * DT
    pull = 48 * WEAK / nearest**13 * scene.duration**2
    method = Method(scheme="velocity_verlet", dt=DT)
    judgements, _ = judged_meeting(laboratory, scene, method, pull, MEETING)
    return worst(judgements, f"two of {meeting.number} meet after {MEETING} steps")


CHECKS = (
    Check(
        name="stepping/singular-pair",
        title="Two Lennard-Jones particles meet in one point: the run says that it diverged, and ends there",
        equation="r(t) = r_0 + v t until |r_1 - r_2| = 0, where phi is not finite",
        criterion="the flag is set; the path before is exact; nothing is recorded from there on",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 1.3: the potential",
        judge=_judge,
        variants=tuple(
            Variant(name, meeting, needs=Needs("lennard_jones", words=words(_scene(meeting))))
            for name, meeting in MEETINGS.items()
        ),
        needs=Needs("lennard_jones", observables=frozenset({"positions"}), schemes=("velocity_verlet",)),
        interpreted=True,
        faults=(),
    ),
)
