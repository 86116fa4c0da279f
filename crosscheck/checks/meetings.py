"""Two particles that meet in one point, or one that leaps through a wall: a run diverges there, says so, and ends."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.engines.protocol import Run
from crosscheck.engines.registry import engine_class
from crosscheck.scene import Explicit, Floats, Method, Output, Scene, explicit
from crosscheck.scene.parts import Interaction
from crosscheck.verdict import Judgement, bounded, round_off, within

#: Time step, the step after which two meet, and steps of a run. All numbers are short in base two: paths have no
#: rounding.
DT, MEETING, STEPS = 0.125, 6, 40
#: So weak that nothing turns aside, and that only a division by 0 is seen.
WEAK = 1e-90


class Meeting(NamedTuple):
    """Two particles that meet.

    pair: their numbers. number: of all particles. dimension: of space, 2 or 3.
    """

    pair: tuple[int, int]
    number: int
    dimension: Literal[2, 3]

    @property
    def start(self) -> Explicit:
        """Particles at rest on a line, 8 apart, but for two that are a few steps from one point."""
        d = self.dimension
        x, v = np.zeros((self.number, d)), np.zeros((self.number, d))
        x[:, 0] = 8.0 * np.arange(self.number)
        towards = np.array([0.5, -0.25, 1.0])[:d]
        for one, sign in zip(self.pair, (1, -1), strict=True):
            v[one] = sign * towards
            x[one] = 4.0 - v[one] * MEETING * DT
        return explicit(x, v)

    def scene(self, observables: tuple[str, ...] = (), **interaction: Interaction) -> Scene:
        """The scene, recorded at each step.

        observables: beside the trajectory. interaction: the table of the scene that says how particles act on each
        other, by its name.
        """
        return Scene(
            name="meeting",
            dimension=self.dimension,
            duration=STEPS * DT,
            initial=self.start,
            output=Output(interval=DT, trajectory=True, observables=observables),
            **interaction,  # type: ignore[arg-type]
        )


#: The first two of few, the first two of many, and two that are neither first nor last of their lists.
MEETINGS = {
    "first-of-few": Meeting((0, 1), 5, 2),
    "first-of-many": Meeting((0, 1), 79, 2),
    "last-of-many": Meeting((77, 78), 79, 3),
}


def _free(scene: Scene, time: Floats) -> Floats:
    """Positions without forces, (times, N, d)."""
    start = scene.initial_state()
    path: Floats = start.positions + time[:, None, None] * start.velocities
    return path


def judged_meeting(
    laboratory: Laboratory, scene: Scene, method: Method, pull: float, last: int, meeting: int = MEETING
) -> tuple[list[Judgement], Run]:
    """Whether the run says that it diverged, the path before, and what is recorded afterwards; and the run.

    laboratory: runs it. scene: recorded at each step of `DT`. method: how. pull: bound on how far forces move a
    particle before the meeting, length. last: steps that are taken by an engine that counts them exactly. meeting: the
    step after which no force is finite.
    """
    run = laboratory.run(scene, method, may_end_early=True)
    x = run["positions"]
    before = np.abs(x[:meeting] - _free(scene, run["time"])[:meeting]).max()
    after = int(np.isfinite(x[meeting:]).any(axis=(1, 2)).sum())
    judgements = [
        bounded("runs that do not say that they diverged", float(not run.diverged), 0.0, "no force is finite there"),
        round_off(
            "distance from the free path before",
            float(before),
            pull,
            "no rounding, of numbers short in base two; what the weak force does until the step before",
        ),
        bounded("samples with numbers from the meeting on", float(after), 0.0, "no velocity is known"),
    ]
    if "operations" in getattr(engine_class(laboratory.engine), "promises", ()):
        why = "the run ends where forces, or the velocities that they give, are not finite"
        judgements.append(within("round_off", "steps taken", float(run.cost.steps), float(last), 0.5, why))
    return judgements, run
