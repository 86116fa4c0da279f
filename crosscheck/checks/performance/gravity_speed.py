"""Speed of gravity between all pairs beside REBOUND, of many bodies and of a few."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.performance.speeds import CITATION, EQUATION, beside, criterion
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Gravity, Method, Scene, explicit
from crosscheck.verdict import Judged

PEER = "rebound"
#: Times as fast as the peer, from so many bodies on.
GOALS = {2: 3.0, 1024: 9.0}
ASKED = 0.9  # of a goal
LEAP_FROG = Method(scheme="leapfrog", dt=1e-4)


def _judge(laboratory: Laboratory, number: int) -> Judged:
    """A softened cloud at rest, leap-frog on both sides: one evaluation of all pairs a step; number: of particles.

    Of many bodies a run has 40 steps at least, so that the evaluation with which one side starts is a fortieth; of few,
    a million, as in the runs for which their speed matters.
    """
    positions = np.random.default_rng(laboratory.seed()).normal(size=(number, 3))
    scene = Scene(
        name=f"cloud-{number}",
        dimension=3,
        duration=(1_000_000 if number <= 16 else max(40, 40_000_000 // number**2)) * LEAP_FROG.step,
        masses=1.0 / number,
        gravity=Gravity(softening=0.01),
        initial=explicit(positions, np.zeros_like(positions)),
    )
    goal = GOALS[max(least for least in GOALS if least <= number)]
    return beside(laboratory, scene, LEAP_FROG, PEER, ASKED * goal)


CHECKS = (
    Check(
        name="performance/gravity-speed",
        title="Gravity between all pairs: speed beside REBOUND's basic gravity",
        equation=EQUATION,
        criterion=criterion("at least 0.9 of the goal: 9 times REBOUND for many bodies, 3 times for a few"),
        citation=CITATION,
        judge=_judge,
        variants=full(N2=2, N3=3, N8=8, N16=16, N1024=1024, N4096=4096),
        faults=(
            (
                "N1024",
                Fault(
                    "plain-gravity",
                    "stepping/forces/gravity.py",
                    "if mass.size <= FEW_BODIES:",
                    "if mass.size <= 1_000_000:",
                    "the plain loop is taken for any number of bodies",
                ),
            ),
            (
                "N2",
                Fault(
                    "arrays-for-few",
                    "stepping/integrate.py",
                    "MANY_STEPS = 1_000_000",
                    "MANY_STEPS = 100_000_000",
                    "a long run of few bodies allocates arrays in every step",
                ),
            ),
        ),
        needs=Needs(
            "gravity",
            words=frozenset({"dimension=3", "gravity.softening"}),
            schemes=(LEAP_FROG.scheme,),
            promises=("speed",),
        ),
        reference=PEER,
        timing=True,
    ),
)
