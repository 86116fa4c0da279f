"""A few bodies, softened or of Lennard-Jones, by final states alone: whatever the scheme, against a tight solution."""

from __future__ import annotations

from functools import cache, partial
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.checks.stepping.faults import gravity_fault, pair_fault
from crosscheck.checks.stepping.orbits import nominal_order
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.engines.capabilities import Needs
from crosscheck.references.smooth_forces import orbit
from crosscheck.scene import Box, Floats, Gravity, LennardJones, Method, Scene, explicit
from crosscheck.verdict import Judged, order, round_off


class _Problem(NamedTuple):
    """A scene, and the steps of the coarsest of its runs; first: of a scheme of order 1."""

    scene: Scene
    steps: int
    first: int


#: Error of the tight solution: its tolerance, 1e-13 a step, over some hundred steps, carried along.
_TIGHT = 1e-10


def _planets() -> _Problem:
    r = np.array([[3.0, -1.0, 2.1], [5.0, -0.7, 1.9], [2.0, -4.0, 2.4]])
    v = np.array([[0.0, -0.2, 0.0], [0.1, 1.1, 0.3], [0.7, -0.2, -0.1]])
    scene = Scene(
        name="three-softened-bodies",
        dimension=3,
        duration=1.6,
        masses=(2.5, 0.7, 0.3),
        gravity=Gravity(G=1.3, softening=0.6),
        initial=explicit(r, v),
    )
    return _Problem(scene, 32, 128)


def _trimer() -> _Problem:
    r = np.array([[9.0, 9.0], [10.25, 9.1], [9.4, 10.3]])
    v = np.array([[0.3, 0.1], [-0.4, 0.2], [0.2, -0.5]])
    scene = Scene(
        name="three-lennard-jones-particles",
        dimension=2,
        duration=0.32,
        lennard_jones=LennardJones(cutoff=8.0),
        box=Box(lengths=(20.0, 20.0), boundaries=("open", "open")),
        initial=explicit(r, v),
    )
    return _Problem(scene, 32, 64)


@cache
def _solution(make: object) -> tuple[Floats, Floats]:
    scene = {"planets": _planets, "trimer": _trimer}[str(make)]().scene
    return orbit(scene, scene.duration)


def _judge(laboratory: Laboratory, scheme: str, of: str) -> Judged:
    """of: which of the problems."""
    scene, steps, first = {"planets": _planets, "trimer": _trimer}[of]()
    exact = _solution(of)
    claims = laboratory.claims[scheme]
    coarsest = first if claims.order is not None and claims.order[0] == 1 else steps
    # what Gear's schemes lose by their start shows only at small steps
    numbers = coarsest * (4 if scheme.startswith("gear") else 1) * np.array([1, 2, 4])
    errors = []
    for n in numbers.tolist():
        run = laboratory.run(scene, Method(scheme=scheme, dt=scene.duration / n))
        apart = run["final_positions"] - exact[0], run["final_velocities"] - exact[1]
        errors.append(float(max(abs(apart[0]).max(), abs(apart[1]).max())))
    if claims.order is None or max(errors) <= _TIGHT:
        why = "tolerance of the tight solution, 1e-13 a step, over hundreds of steps"
        return round_off("largest error of the final state", max(errors), _TIGHT, why)
    # higher derivatives that Gear's schemes start from are zero here
    nominal = min(nominal_order(scheme, claims), *claims.order)
    slope = fitted_order(1 / numbers, errors, _TIGHT)
    return order(
        "order of the error of the final state",
        slope.value,
        nominal,
        ORDER_TOLERANCE,
        WHY_ORDER,
        uncertainty=slope.error,
        note=f"errors {errors[0]:.2g} to {errors[-1]:.2g}",
    )


_CITATION = "Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), section II.5"
_CRITERION = f"fitted order of the error of final positions and velocities = claimed +- {ORDER_TOLERANCE}: {WHY_ORDER}"

CHECKS = (
    Check(
        name="stepping/few-bodies",
        title="Three softened bodies of unlike masses: their final state, against a tight solution",
        equation="m_i r_i'' = -sum_j G m_i m_j (r_i - r_j)/(r_ij^2 + s^2)^(3/2)",
        criterion=f"{_CRITERION}; of schemes that choose their steps: error <= {_TIGHT:g}",
        citation=f"{_CITATION}; Aarseth, MNRAS 126, 223 (1963)",
        judge=partial(_judge, of="planets"),
        # WHFast is for planets about one star, without softening
        variants=schemes_with(lambda name, claims: name != "whfast", tier_beside_audits("velocity_verlet")),
        faults=(
            (
                "velocity_verlet",
                gravity_fault(
                    "softening-slightly-short",
                    "square += softening * softening",
                    "square += 0.999 * softening * softening",
                    "the square of the softening is off by 1e-3",
                ),
            ),
        ),
        needs=Needs("gravity", words=frozenset({"dimension=3", "masses[]", "gravity.G", "gravity.softening"})),
        interpreted=True,
    ),
    Check(
        name="stepping/few-particles",
        title="Three Lennard-Jones particles in open space: their final state, against a tight solution",
        equation="m r_i'' = -sum_j phi'(r_ij) r_ij/|r_ij|, phi = 4 ((1/r)^12 - (1/r)^6)",
        criterion=_CRITERION,
        citation=_CITATION,
        judge=partial(_judge, of="trimer"),
        variants=schemes_with(tier=tier_beside_audits("velocity_verlet")),
        faults=(
            (
                "velocity_verlet",
                pair_fault(
                    "repulsion-factor",
                    "repulsion = attraction * splat(2.0 * sigma**6)",
                    "repulsion = attraction * splat(2.001 * sigma**6)",
                    "the repulsion is off by 5e-4",
                ),
            ),
        ),
        needs=Needs("lennard_jones", words=frozenset({"dimension=2", "box.boundaries=open"})),
        interpreted=True,
    ),
)
