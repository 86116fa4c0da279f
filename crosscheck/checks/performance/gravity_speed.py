"""Speed of gravity between all pairs beside REBOUND."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.performance.speeds import CITATION, EQUATION, beside, criterion
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Gravity, Method, Scene, explicit
from crosscheck.verdict import Judged

PEER, GOAL = "rebound", 4.0
LEAP_FROG = Method(scheme="leapfrog", dt=1e-4)


def _judge(laboratory: Laboratory, number: int) -> Judged:
    """A softened cloud at rest, leap-frog on both sides: one evaluation of all pairs a step; number: of particles."""
    positions = np.random.default_rng(laboratory.seed()).normal(size=(number, 3))
    scene = Scene(
        name=f"cloud-{number}",
        dimension=3,
        duration=max(40, 40_000_000 // number**2) * LEAP_FROG.step,
        masses=1.0 / number,
        gravity=Gravity(softening=0.01),
        initial=explicit(positions, np.zeros_like(positions)),
    )
    return beside(laboratory, scene, LEAP_FROG, PEER, GOAL)


CHECKS = (
    Check(
        name="performance/gravity-speed",
        title="Gravity between all pairs: speed beside REBOUND's basic gravity",
        equation=EQUATION,
        criterion=criterion("at least 4 times REBOUND"),
        citation=CITATION,
        judge=_judge,
        variants=full(N1024=1024, N4096=4096),
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
