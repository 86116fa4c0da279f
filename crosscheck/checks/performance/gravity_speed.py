"""Speed of gravity between all pairs beside REBOUND, of many bodies and of a few."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.performance.speeds import CITATION, EQUATION, beside, by_two_threads, criterion
from crosscheck.checks.performance.stepping_races import cloud
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Method, Scene
from crosscheck.verdict import Judged

PEER = "rebound"
#: Times as fast as the peer, from so many bodies on.
GOALS = {2: 3.0, 1024: 9.0}
#: Speed of two threads over that of one.
TWO_THREADS = 1.8
ASKED = 0.9  # of a goal
LEAP_FROG = Method(scheme="leapfrog", dt=1e-4)


def _cloud(laboratory: Laboratory, number: int) -> Scene:
    """A softened cloud at rest; number: of particles.

    Of many bodies a run has 40 steps at least, so that the evaluation with which one side starts is a fortieth; of few,
    a million, as in the runs for which their speed matters.
    """
    steps = 1_000_000 if number <= 16 else max(40, 40_000_000 // number**2)
    return cloud(number, laboratory.seed()).changed(duration=steps * LEAP_FROG.step)


def _judge(laboratory: Laboratory, number: int) -> Judged:
    """Leap-frog on both sides: one evaluation of all pairs a step; number: of particles."""
    goal = GOALS[max(least for least in GOALS if least <= number)]
    return beside(laboratory, _cloud(laboratory, number), LEAP_FROG, PEER, ASKED * goal)


def _judge_threads(laboratory: Laboratory, number: int) -> Judged:
    """One thread beside two; number: of particles."""
    scene = _cloud(laboratory, number)
    return by_two_threads(laboratory, scene, LEAP_FROG, ASKED * TWO_THREADS, f"{number} bodies, leap-frog")


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
    Check(
        name="performance/gravity-threads",
        title="Gravity between all pairs: two threads beside one",
        equation="elapsed seconds of one thread/elapsed seconds of two",
        criterion="at least 0.9 of the goal, 1.8; inconclusive where two cores are not free",
        citation="Amdahl, AFIPS Conf. Proc. 30, 483 (1967)",
        judge=_judge_threads,
        variants=full(N1024=1024, N4096=4096),
        faults=(
            (
                "N4096",
                Fault(
                    "one-piece",
                    "stepping/kernels/gravity.py",
                    "_LEAST, _MOST = 256, 32",
                    "_LEAST, _MOST = 256, 1",
                    "the pairs are one piece of work, which nobody can share",
                ),
            ),
        ),
        needs=Needs(
            "gravity",
            words=frozenset({"dimension=3", "gravity.softening", "method.threads"}),
            schemes=(LEAP_FROG.scheme,),
            promises=("speed",),
        ),
        timing=True,
    ),
)
