"""Error against run time of three bodies: the figure-eight orbit, and the Pythagorean problem with its near collisions.

Literature: A. Chenciner and R. Montgomery, Ann. Math. 152, 881 (2000); V. Szebehely and C. F. Peters, Astron. J. 72,
876 (1967).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from crosscheck.checks.performance.work_precision_judging import Problem, check
from crosscheck.checks.stepping.faults import gravity_fault
from crosscheck.checks.stepping.orbits import SIGMAS, nominal_order
from crosscheck.checks.stepping.three_bodies import CITATION, EQUATION, furthest, three_body_scene
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.references.oscillator import rounding_lever
from crosscheck.references.three_body import FIGURE_EIGHT, PYTHAGOREAN, ThreeBodies
from crosscheck.scene import Floats

_NEEDS = Needs("gravity", words=frozenset({"dimension=2"}))
_WHY_AT_LEAST = (
    "from rest and far apart, the terms of lowest order (of Gear's zero start, of symplectic Euler's shift of the "
    "phase) are so small that those of the near collisions outweigh them at all steps above rounding"
)


def _error(run: Run, problem: ThreeBodies) -> float:
    if run.diverged or run.stopped:
        return np.inf
    return furthest(run["final_positions"], problem.final_positions)


def _floor(scheme: str, steps: float, problem: ThreeBodies, even: bool) -> float:
    lever = rounding_lever(scheme, max(steps, 1) / problem.time)
    return SIGMAS * lever * problem.rounding_error(max(steps, 1), even=even)


def _numbers(claims: Claims, coarsest: int, runs: int) -> Floats:
    nominal = claims.order[0] if claims.order else 2
    finer = 16 if nominal == 1 and not claims.symplectic else 4 if nominal == 1 else 1
    return np.asarray(finer * coarsest * 2.0 ** np.arange(runs))


def _accept(scheme: str, claims: Claims, first: bool) -> bool:
    """WHFast is for planets about one star. first: whether schemes of first order, not symplectic, are of use."""
    explicit = claims.order is not None and claims.order[0] == 1 and not claims.symplectic
    return scheme != "whfast" and (first or not explicit)


def _problem(name: str, title: str, problem: ThreeBodies, coarsest: int, runs: int, first: bool) -> Problem:
    return Problem(
        name=name,
        title=title,
        equation=EQUATION,
        citation=f"{CITATION}; Szebehely & Peters, Astron. J. 72, 876 (1967)",
        unit="length",
        scene=three_body_scene(f"work-precision-{name}", problem),
        error=partial(_error, problem=problem),
        order=nominal_order,
        numbers=partial(_numbers, coarsest=coarsest, runs=runs),
        floor=partial(_floor, problem=problem, even=first),
        needs=_NEEDS,
        faults=(
            (
                "velocity_verlet",
                gravity_fault(
                    "gravity-third-body",
                    "        for j in range(i):\n            q = d * j\n            dx = r[q] - r[p]",
                    "        for j in range(min(i, 1)):\n            q = d * j\n            dx = r[q] - r[p]",
                    "pairs without the first body do not attract each other",
                ),
            ),
        ),
        accept=partial(_accept, first=first),
        at_least="" if first else _WHY_AT_LEAST,
    )


PROBLEMS = (
    _problem("figure-eight", "the figure-eight orbit of three bodies, one period", FIGURE_EIGHT, 32, 11, True),
    _problem(
        "pythagorean",
        "the Pythagorean problem of three bodies, to t = 10, with close encounters",
        PYTHAGOREAN,
        2**13,
        9,
        False,
    ),
)
CHECKS = tuple(map(check, PROBLEMS))
