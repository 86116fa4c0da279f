"""Problems of three bodies that the checks of this group share: scenes, and the best final state of an engine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory, Variant, variants_of
from crosscheck.checks.stepping.orbits import SEQUENCE, SIGMAS
from crosscheck.convergence import extrapolate
from crosscheck.engines.protocol import Claims
from crosscheck.references.three_body import ThreeBodies
from crosscheck.scene import Floats, Gravity, Method, Scene, explicit

WHY_ROUNDING = "10 standard deviations of independent roundings of the state in every step, carried to the end"
CITATION = "Chenciner & Montgomery, Ann. Math. 152, 881 (2000)"
EQUATION = "r_i'' = -sum_j m_j (r_i - r_j)/|r_i - r_j|^3"


def three_body_scene(name: str, problem: ThreeBodies) -> Scene:
    """From the initial state to `problem.time`; nothing is recorded on the way."""
    return Scene(
        name=name,
        dimension=2,
        duration=problem.time,
        masses=problem.masses,
        gravity=Gravity(),
        initial=explicit(problem.positions, problem.velocities),
    )


def furthest(positions: Floats, others: Floats) -> float:
    """Largest distance of a body from its place; infinite where one is not finite."""
    distance = float(np.linalg.norm(positions - others, axis=-1).max())
    return distance if np.isfinite(distance) else np.inf


class Final(NamedTuple):
    """Final positions and velocities, (N, d), what may be wrong with them, and how they came about."""

    positions: Floats
    velocities: Floats
    uncertainty: float
    note: str


def best_schemes(schemes: Mapping[str, Claims]) -> tuple[Variant, ...]:
    """Schemes that choose their own steps, and velocity Verlet, which is extrapolated to no step."""
    return variants_of(
        {
            name: name
            for name, claims in schemes.items()
            if claims.kind == "stepping" and (claims.order is None or name == "velocity_verlet")
        }
    )


def best(laboratory: Laboratory, scheme: str, scene: Scene, problem: ThreeBodies, coarsest: int) -> Final:
    """The final state, by a scheme that chooses its own steps, or extrapolated from `coarsest` and more steps."""
    if laboratory.claims[scheme].order is not None:
        return _extrapolated(laboratory, scheme, scene, problem, coarsest)
    run = laboratory.run(scene, Method(scheme=scheme, dt=problem.time / 10_000))
    rounding = SIGMAS * problem.rounding_error(run.cost.steps, even=False)
    return Final(run["final_positions"], run["final_velocities"], rounding, f"{run.cost.steps} steps")


def _extrapolated(laboratory: Laboratory, scheme: str, scene: Scene, problem: ThreeBodies, coarsest: int) -> Final:
    numbers = coarsest * SEQUENCE
    runs = [laboratory.run(scene, Method(scheme=scheme, dt=problem.time / n)) for n in numbers]
    limit = extrapolate(1 / numbers, [np.array([run["final_positions"], run["final_velocities"]]) for run in runs])
    each = np.array([problem.rounding_error(n) for n in numbers])
    rounding = SIGMAS * float(np.sqrt(((limit.weights * each) ** 2).sum()))
    note = f"{coarsest} to {coarsest * SEQUENCE[-1]} steps; extrapolation {limit.error:.1g}, rounding {rounding:.1g}"
    return Final(limit.value[0], limit.value[1], limit.error + rounding, note)
