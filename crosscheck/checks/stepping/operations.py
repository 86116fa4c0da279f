"""Operations of time steps: evaluations of the force, distances of pairs, lists of neighbours."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Literal, NamedTuple

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

_NUMBER, _STEPS = 64, 50
#: Of `refimpl`: particles that share a list of neighbours, and how far it reaches beyond the cutoff.
_TILE, _CLOSE_SKIN = 8, 0.2


class _Fluid(NamedTuple):
    """dimension, density, cutoff of a fluid; temperature: of its start; known: counts of `refimpl`.

    open_: the last axis has no period. number: of particles.
    """

    dimension: Literal[2, 3]
    density: float
    cutoff: float
    temperature: float
    known: dict[str, float]
    open_: bool = False
    number: int = _NUMBER


# lists reach 0.8 beyond the cutoff
_DISKS = _Fluid(2, 0.7, 2.5, 1.5, {"pair_tests": 132544, "list_builds": 2, "list_prunings": 8, "list_tests": 29120})
_LAYER = _Fluid(
    2, 0.7, 1.6, 1.5, {"pair_tests": 66736, "list_builds": 2, "list_prunings": 8, "list_tests": 15736}, True
)
# a side of little more than the cutoff: lists reach as far as elsewhere, to further images
_SHORT = _Fluid(2, 0.7, 4.7, 1.5, {"list_builds": 2, "list_tests": 16328}, number=16)
# wide columns of cells: how finely they are cut says how much is looked at beyond the reach of a list
_DILUTE = _Fluid(2, 0.03, 1.12, 10.0, {"list_builds": 8, "list_tests": 35624}, number=225)
_SPHERES = _Fluid(3, 0.5, 1.6, 6.0, {"pair_tests": 147848, "list_builds": 5, "list_prunings": 16, "list_tests": 138400})


def _scene(fluid: _Fluid, steps: int) -> Scene:
    """A Lennard-Jones fluid from the same start whatever the seed: counts are known of it."""
    structure: Literal["square", "sc"] = "square" if fluid.dimension == 2 else "sc"
    return Scene(
        name=f"fluid-of-{fluid.number}",
        dimension=fluid.dimension,
        duration=steps * STEP.step,
        lennard_jones=LennardJones(cutoff=fluid.cutoff),
        box=Box(density=fluid.density, boundaries=("periodic", "open") if fluid.open_ else None),
        initial=Lattice(
            kind="lattice", structure=structure, number=fluid.number, temperature=fluid.temperature, seed=3
        ),
    )


def _around(dimension: int, side: float, reach: float) -> float:
    """Area within reach of a square, or volume within reach of a cube (Steiner's formula)."""
    if dimension == 2:
        return side**2 + 4 * side * reach + math.pi * reach**2
    return side**3 + 6 * side**2 * reach + 3 * math.pi * side * reach**2 + 4 / 3 * math.pi * reach**3


def _judge_schemes(laboratory: Laboratory) -> Judged:
    judged = []
    for name, claims in laboratory.claims.items():
        if claims.kind != "stepping":
            continue
        cost = laboratory.run(_scene(_DISKS._replace(density=0.1, number=4), 6), Method(scheme=name, dt=STEP.dt)).cost
        start, each = evaluations_of(name)
        if laboratory.engine == "refimpl":
            judged.append(exactly(f"{name}: evaluations in 6 steps", cost.evaluations, start + 6 * each))
            judged.append(exactly(f"{name}: pair tests beyond whole tiles", counted(cost, "pair_tests") % _TILE, 0))
        else:
            why = "no scheme of fixed steps needs more than the four of Runge and Kutta, and some at the start"
            judged.append(at_most(f"{name}: evaluations over 4 a step and 8", cost.evaluations / 32, 1.0, why))
    return worst(judged, "6 steps of 4 disks")


def _judge_fluid(laboratory: Laboratory, fluid: _Fluid) -> Judged:
    cost = laboratory.run(_scene(fluid, _STEPS), STEP).cost
    tests = counted(cost, "pair_tests") / (fluid.number * cost.evaluations)
    builds, box = counted(cost, "list_builds"), (fluid.number / fluid.density) ** (1 / fluid.dimension)
    judged = [
        exactly("evaluations of the force", cost.evaluations, _STEPS + 1),
        at_most("lists made, over steps", builds / _STEPS, 0.2, "a list is good for several steps"),
        at_most(
            "distances each time a list is made or pruned, over those of all pairs",
            counted(cost, "list_tests") / ((builds + (cost.list_prunings or 0)) * fluid.number**2),
            2.0 * (1 + 2 * (fluid.cutoff + 1.0) / box) ** fluid.dimension,
            "the box and its images within the cutoff and a skin as large as sigma, at most, from both sides",
        ),
    ]
    if laboratory.engine == "refimpl":
        side = (_TILE / fluid.density) ** (1 / fluid.dimension)
        around = _around(fluid.dimension, side, fluid.cutoff + _CLOSE_SKIN)
        judged.append(
            at_most(
                "distances of a particle, over density x what is within reach of a square or a cube of eight",
                tests / (fluid.density * around),
                1.0,
                "eight particles share a list of all that is in reach of one of them; scattered, they reach less far",
            )
        )
    return worst([*judged, *as_known(laboratory, cost, fluid.known)], f"{_STEPS} steps of {fluid.number} particles")


def _judge(laboratory: Laboratory, judge: Callable[[Laboratory], Judged]) -> Judged:
    return judge(laboratory)


def _needs(dimension: int, *words: str) -> Needs:
    return Needs("lennard_jones", words=frozenset({f"dimension={dimension}", *words}))


CHECKS = (
    Check(
        name="stepping/operations",
        title="Operations of time steps of a Lennard-Jones fluid",
        equation=EQUATION,
        criterion=CRITERION,
        citation=f"{LISTS}; Pall & Hess, Comput. Phys. Commun. 184, 2641 (2013)",
        judge=_judge,
        variants=(
            Variant("schemes", _judge_schemes, needs=_needs(2)),
            Variant("fluid", partial(_judge_fluid, fluid=_DISKS), needs=_needs(2)),
            Variant("dilute", partial(_judge_fluid, fluid=_DILUTE), needs=_needs(2)),
            Variant("short-box", partial(_judge_fluid, fluid=_SHORT), needs=_needs(2)),
            Variant("layer", partial(_judge_fluid, fluid=_LAYER), needs=_needs(2, "box.boundaries=open")),
            Variant("fluid-in-space", partial(_judge_fluid, fluid=_SPHERES), needs=_needs(3)),
        ),
        needs=counting(Needs("lennard_jones", words=frozenset({"box.boundaries=periodic"}), schemes=(STEP.scheme,))),
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
