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
    """The scene `name`, from the initial state of `problem` to its final time; nothing is recorded in between."""
    return Scene(
        name=name,
        dimension=2,
        duration=problem.time,
        masses=problem.masses,
        gravity=Gravity(),
        initial=explicit(problem.positions, problem.velocities),
    )


def furthest(positions: Floats, others: Floats) -> float:
    """Largest distance of a body in `positions` from that in `others`, both (N, d); infinite if one is not finite."""
    distance = float(np.linalg.norm(positions - others, axis=-1).max())
    return distance if np.isfinite(distance) else np.inf


class Final(NamedTuple):
    """A final state.

    positions, velocities: (N, d). uncertainty: of a position (length). note: how the state was found, in words.
    """

    positions: Floats
    velocities: Floats
    uncertainty: float
    note: str


def best_schemes(schemes: Mapping[str, Claims]) -> tuple[Variant, ...]:
    """Variants for the schemes that choose their own steps, and for velocity Verlet, which is extrapolated to dt = 0.

    schemes: the claims of an engine, by scheme.
    """
    return variants_of(
        {
            name: name
            for name, claims in schemes.items()
            if claims.kind == "stepping" and (claims.order is None or name == "velocity_verlet")
        }
    )


def best(laboratory: Laboratory, scheme: str, scene: Scene, problem: ThreeBodies, coarsest: int) -> Final:
    """The final state by `scheme`: at the steps that it chooses, or extrapolated from `coarsest` and more steps.

    laboratory: runs it. scene: of the problem. problem: gives the duration, and the rounding error.
    """
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
