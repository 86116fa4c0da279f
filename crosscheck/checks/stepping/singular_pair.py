"""Lennard-Jones particles where no force is finite, two in a point or one beyond a wall: a run says so, and ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.meetings import DT, MEETING, MEETINGS, STEPS, WEAK, Meeting, judged_meeting
from crosscheck.engines.capabilities import Needs, words
from crosscheck.faults import Fault
from crosscheck.scene import AXES, Box, LennardJones, Method, Output, Scene, explicit
from crosscheck.scene.parts import Wall
from crosscheck.verdict import Judged, worst

_METHOD = Method(scheme="velocity_verlet", dt=DT)


def _scene(meeting: Meeting) -> Scene:
    return meeting.scene(lennard_jones=LennardJones(epsilon=WEAK, cutoff=2.5))


def _judge(laboratory: Laboratory, meeting: Meeting) -> Judged:
    scene = _scene(meeting)
    # one coordinate of the distance, a step before the meeting
    nearest = 2 * float(abs(scene.initial_state().velocities).max()) * DT
    pull = 48 * WEAK / nearest**13 * scene.duration**2
    judgements, _ = judged_meeting(laboratory, scene, _METHOD, pull, MEETING)
    return worst(judgements, f"two of {meeting.number} meet after {MEETING} steps")


#: Side of the box, distance from the wall at the start, and path in a step: the wall is passed between two steps.
_SIDE, _START, _PATH, _LEAP = 8.0, 0.40625, 0.0625, 7


class _Face(NamedTuple):
    """A face of the box: its axis, and whether it is the upper one."""

    axis: int
    upper: bool


def _leap(face: _Face) -> Scene:
    """Three particles that are far from each other: one leaps through the face, the others fly along it."""
    x = np.array([[4.0, 4.0, 4.0], [1.5, 1.5, 1.5], [6.5, 6.5, 6.5]])
    v = np.zeros_like(x)
    x[0, face.axis] = _SIDE - _START if face.upper else _START
    v[0, face.axis] = (1 if face.upper else -1) * _PATH / DT
    v[1, (face.axis + 1) % 3] = v[2, (face.axis + 2) % 3] = 0.25
    return Scene(
        name="leap",
        dimension=3,
        duration=STEPS / 2 * DT,
        lennard_jones=LennardJones(epsilon=WEAK, cutoff=1.5),
        box=Box(lengths=(_SIDE,) * 3, boundaries=("wall",) * 3, wall=Wall(epsilon=WEAK, cutoff=2.5)),
        initial=explicit(x, v),
        output=Output(interval=DT, trajectory=True),
    )


def _judge_leap(laboratory: Laboratory, face: _Face) -> Judged:
    scene = _leap(face)
    pull = 48 * WEAK / (_PATH / 2) ** 13 * scene.duration**2
    judgements, _ = judged_meeting(laboratory, scene, _METHOD, pull, _LEAP - 1, _LEAP)
    return worst(judgements, f"{AXES[face.axis]}{'-+'[face.upper]}: beyond it after {_LEAP} steps")


_FACES = {f"{AXES[axis]}{'-+'[upper]}": _Face(axis, upper) for axis in range(3) for upper in (False, True)}

CHECKS = (
    Check(
        name="stepping/through-a-wall",
        title="A Lennard-Jones particle leaps through a wall in one step: the run says so, and ends there",
        equation="r(t) = r_0 + v t until a coordinate is beyond the face, where the wall's force has no meaning",
        criterion="the flag is set; the path before is exact; nothing is recorded from there on",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 1.5",
        judge=_judge_leap,
        variants=tuple(Variant(name, face) for name, face in _FACES.items()),
        needs=Needs(
            "lennard_jones",
            words=words(_leap(_Face(0, False))),
            observables=frozenset({"positions"}),
            schemes=("velocity_verlet",),
        ),
        interpreted=True,
        faults=(
            (
                "y+",
                Fault(
                    "lower-faces-alone",
                    "stepping/kernels/lennard_jones.py",
                    "inside &= 0 < x < lengths[k]",
                    "inside &= 0 < x",
                    "a particle beyond the upper face of an axis is not looked for",
                ),
            ),
        ),
    ),
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
        faults=(
            (
                "last-of-many",
                Fault(
                    "no-force-in-one-place",
                    "stepping/kernels/lennard_jones.py",
                    "    q = splat(1.0) / r2\n    q2 = q * q\n",
                    "    q = splat(1.0) / (r2 + splat(1e-6))\n    q2 = q * q\n",
                    "particles in one place do not push each other, and pass through each other",
                ),
            ),
        ),
    ),
)
