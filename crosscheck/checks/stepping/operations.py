"""Operations of time steps: evaluations of the force, distances of pairs, lists of neighbours."""

from __future__ import annotations

import math
from collections.abc import Callable

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.operations import (
    CRITERION,
    EQUATION,
    as_known,
    at_most,
    counted,
    counting,
    evaluations_of,
    exactly,
)
from crosscheck.checks.stepping.fluids import LISTS, STEP
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Box, Lattice, LennardJones, Method, Scene
from crosscheck.verdict import Judged, worst

_CUTOFF, _DENSITY, _NUMBER, _STEPS = 2.5, 0.7, 64, 50
#: Of `refimpl`: particles that share a list of neighbours, and how far it reaches beyond the cutoff.
_TILE, _CLOSE_SKIN = 8, 0.2
#: Counts of the fluid. Lists reach 0.8 beyond the cutoff.
_KNOWN = {"pair_tests": 132544, "list_builds": 2, "list_prunings": 8, "list_tests": 29120}


def _fluid(number: int, density: float, steps: int) -> Scene:
    """Lennard-Jones disks from the same start whatever the seed: counts are known of it."""
    return Scene(
        name=f"disks-{number}",
        dimension=2,
        duration=steps * STEP.step,
        lennard_jones=LennardJones(cutoff=_CUTOFF),
        box=Box(density=density),
        initial=Lattice(kind="lattice", structure="square", number=number, temperature=1.5, seed=3),
    )


def _judge_schemes(laboratory: Laboratory) -> Judged:
    judged = []
    for name, claims in laboratory.claims.items():
        if claims.kind != "stepping":
            continue
        cost = laboratory.run(_fluid(4, 0.1, 6), Method(scheme=name, dt=STEP.dt)).cost
        start, each = evaluations_of(name)
        if laboratory.engine == "refimpl":
            judged.append(exactly(f"{name}: evaluations in 6 steps", cost.evaluations, start + 6 * each))
        else:
            why = "no scheme of fixed steps needs more than the four of Runge and Kutta, and some at the start"
            judged.append(at_most(f"{name}: evaluations over 4 a step and 8", cost.evaluations / 32, 1.0, why))
    return worst(judged, "6 steps of 4 disks")


def _judge_fluid(laboratory: Laboratory) -> Judged:
    cost = laboratory.run(_fluid(_NUMBER, _DENSITY, _STEPS), STEP).cost
    tests = counted(cost, "pair_tests") / (_NUMBER * cost.evaluations)
    builds = counted(cost, "list_builds")
    judged = [
        exactly("evaluations of the force", cost.evaluations, _STEPS + 1),
        at_most("lists made, over steps", builds / _STEPS, 0.2, "a list is good for several steps"),
        at_most(
            "distances for a list, over those of all pairs",
            counted(cost, "list_tests") / (builds * _NUMBER**2),
            6.0,
            "the box and its images within the cutoff and a skin as large as sigma, at most, from both sides",
        ),
    ]
    if laboratory.engine == "refimpl":
        side = math.sqrt(_TILE / _DENSITY)
        reach = _CUTOFF + _CLOSE_SKIN
        around = side * side + 4 * side * reach + math.pi * reach * reach
        judged.append(
            at_most(
                "distances of a particle, over density x area within reach of a square of eight",
                tests / (_DENSITY * around),
                1.0,
                "eight particles share a list of all that is in reach of one of them; scattered, they reach less far",
            )
        )
    return worst([*judged, *as_known(laboratory, cost, _KNOWN)], f"{_STEPS} steps of {_NUMBER} disks")


def _judge(laboratory: Laboratory, judge: Callable[[Laboratory], Judged]) -> Judged:
    return judge(laboratory)


CHECKS = (
    Check(
        name="stepping/operations",
        title="Operations of time steps of a Lennard-Jones fluid",
        equation=EQUATION,
        criterion=CRITERION,
        citation=f"{LISTS}; Pall & Hess, Comput. Phys. Commun. 184, 2641 (2013)",
        judge=_judge,
        variants=(Variant("schemes", _judge_schemes), Variant("fluid", _judge_fluid)),
        needs=counting(
            Needs("lennard_jones", words=frozenset({"dimension=2", "box.boundaries=periodic"}), schemes=(STEP.scheme,))
        ),
        interpreted=True,
        faults=(
            (
                "fluid",
                Fault(
                    "list-each-step",
                    "stepping/kernels/neighbours.py",
                    "        if still_close:\n            return GOOD\n        if _moved_less(neighbours, 0.5",
                    "        if _moved_less(neighbours, -0.5",
                    "the lists are made anew at each step",
                ),
            ),
        ),
    ),
)
