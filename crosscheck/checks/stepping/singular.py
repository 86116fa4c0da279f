"""Two bodies that meet in one point, where no force is finite: the run diverges there, says so, and ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.faults import gravity_fault
from crosscheck.engines.capabilities import Needs, words
from crosscheck.engines.registry import engine_class
from crosscheck.scene import Floats, Gravity, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, bounded, round_off, within, worst

#: Time step, the step after which two meet, and steps of a run. All numbers are short in base two: paths have no
#: rounding.
_DT, _MEETING, _STEPS = 0.125, 6, 40
#: So weak that nothing turns aside, and that only a division by 0 is seen.
_WEAK = 1e-90


class _Meeting(NamedTuple):
    """The two that meet, of so many, in so many dimensions."""

    pair: tuple[int, int]
    number: int
    dimension: int


def _scene(meeting: _Meeting) -> Scene:
    """Bodies at rest on a line, far from each other, but for two that are a few steps from one point."""
    d = meeting.dimension
    x, v = np.zeros((meeting.number, d)), np.zeros((meeting.number, d))
    x[:, 0] = 8.0 * np.arange(meeting.number)
    towards = np.array([0.5, -0.25, 1.0])[:d]
    for one, sign in zip(meeting.pair, (1, -1), strict=True):
        v[one] = sign * towards
        x[one] = 4.0 - v[one] * _MEETING * _DT
    return Scene(
        name="meeting",
        dimension=d,  # type: ignore[arg-type]
        duration=_STEPS * _DT,
        gravity=Gravity(G=_WEAK),
        initial=explicit(x, v),
        output=Output(interval=_DT, trajectory=True),
    )


def _free(scene: Scene, time: Floats) -> Floats:
    """Positions without forces, (times, N, d)."""
    start = scene.initial_state()
    path: Floats = start.positions + time[:, None, None] * start.velocities
    return path


def _pull(meeting: _Meeting, scene: Scene) -> float:
    """Bound on how far forces move a body before the two meet."""
    nearest = 2 * float(np.abs(scene.initial_state().velocities).max()) * _DT
    return meeting.number * _WEAK / nearest**2 * scene.duration**2


def _judge(laboratory: Laboratory, meeting: _Meeting) -> Judged:
    scene = _scene(meeting)
    run = laboratory.run(scene, Method(scheme="velocity_verlet", dt=_DT), may_end_early=True)
    x = run["positions"]
    before = np.abs(x[:_MEETING] - _free(scene, run["time"])[:_MEETING]).max()
    after = int(np.isfinite(x[_MEETING:]).any(axis=(1, 2)).sum())
    judgements = [
        bounded("runs that do not say that they diverged", float(not run.diverged), 0.0, "no force is finite there"),
        round_off(
            "distance from the free path before",
            float(before),
            _pull(meeting, scene),
            "no rounding, of numbers short in base two; what the weak force does until the step before",
        ),
        bounded("samples with numbers from the meeting on", float(after), 0.0, "no velocity is known"),
    ]
    if "operations" in getattr(engine_class(laboratory.engine), "promises", ()):
        steps, last = float(run.cost.steps), _MEETING - 1.0
        judgements.append(within("round_off", "steps taken", steps, last, 0.5, "the next one ends without velocities"))
    return worst(judgements, f"two of {meeting.number} meet after {_MEETING} steps")


def _variant(name: str, meeting: _Meeting) -> Variant:
    scene = _scene(meeting)
    return Variant(name, meeting, "quick", Needs("gravity", words=words(scene)))


CHECKS = (
    Check(
        name="stepping/singular",
        title="Two bodies meet in one point: the run says that it diverged, and ends there",
        equation="r(t) = r_0 + v t until |r_1 - r_2| = 0, where the force is 0/0",
        criterion="the flag is set; the path before is exact; nothing is recorded from there on, and no step taken "
        "where steps are counted exactly",
        citation="Aarseth, Gravitational N-Body Simulations (2003), ch. 1: the singularity of unsoftened gravity",
        judge=_judge,
        variants=(
            _variant("first-of-few", _Meeting((0, 1), 5, 2)),
            _variant("first-of-many", _Meeting((0, 1), 79, 2)),
            _variant("last-of-many", _Meeting((77, 78), 79, 3)),
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
