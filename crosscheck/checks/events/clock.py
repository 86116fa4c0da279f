"""Thousands of impacts one after the other: the clock of a long run is as good as that of a short one."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import event_driven
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Box, Floats, HardSpheres, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, Judgement, round_off, worst

#: Disks of diameter 1 in lanes of their own, between walls that far apart.
_SIDES = (2.3, 6.0)
#: Schemes of `refimpl` whose clock is a sum of two numbers; impacts of the fastest disk: it shows in long runs alone.
_EXACT_CLOCKS, _MANY, _SOME = ("event_driven_naive",), 3000, 600
_STARTS = np.array([[0.6, 1.0], [1.7, 3.0], [1.1, 5.0]])
_SPEEDS = np.array([0.7, -0.9, 0.31])


def _scene(impacts: int) -> Scene:
    duration = impacts * (_SIDES[0] - 1.0) / float(np.abs(_SPEEDS).max())
    return Scene(
        name="lanes",
        dimension=2,
        duration=duration,
        hard_spheres=HardSpheres(),
        box=Box(lengths=_SIDES, boundaries=("hard", "periodic")),
        initial=explicit(_STARTS, np.stack([_SPEEDS, np.zeros(3)], axis=1)),
        output=Output(interval=duration / 16, trajectory=True),
    )


def _unfolded(t: Floats) -> Floats:
    """Places in a row of mirror images of the box, less the radius: without impacts, (times, disks)."""
    path: Floats = _STARTS[:, 0] - 0.5 + t[:, None] * _SPEEDS
    return path


def _judge(laboratory: Laboratory, _: str) -> Judged:
    gap = _SIDES[0] - 1.0
    judged: list[Judgement] = []
    for name, claims in laboratory.claims.items():
        method, impacts = Method(scheme=name), _MANY if name in _EXACT_CLOCKS else _SOME
        scene = _scene(impacts)
        if claims.kind != EVENT_DRIVEN or laboratory.refusal(scene, method) is not None:
            continue
        run = laboratory.run(scene, method)
        expected = 0.5 + gap - np.abs(np.mod(_unfolded(run["time"]), 2 * gap) - gap)
        clock = 0.0 if name in _EXACT_CLOCKS else 0.5 * scene.duration
        judged.append(
            round_off(
                f"{name}: error of a place",
                float(np.abs(run["positions"][:, :, 0] - expected).max()),
                impacts * EPSILON * (8 * _SIDES[0] + clock),
                "at each impact, roundings of the place, of the flight's time, of its product with the speed, and of "
                "a clock that is one number",
            )
        )
    return worst(judged, f"{_SOME} impacts of the fastest disk, or {_MANY}")


CHECKS = (
    Check(
        name="events/clock",
        title="Disks that go to and fro between walls thousands of times",
        equation="x(t): x_0 + v t folded at the walls",
        criterion="at each impact, eight roundings of a place, and one of the time where the clock is one number",
        citation="Knuth, The Art of Computer Programming, vol. 2 (1997), 4.2.2",
        judge=_judge,
        variants=variants_of({"lanes": "all"}),
        needs=event_driven("dimension=2 box.boundaries=hard box.boundaries=periodic", "positions"),
        interpreted=True,
        faults=(
            (
                "lanes",
                Fault(
                    "clock-without-its-rest",
                    "events/state.py",
                    "    more += low\n",
                    "",
                    "what the clock of the naive algorithm lacks by rounding is not added to its next step",
                ),
            ),
        ),
    ),
)
