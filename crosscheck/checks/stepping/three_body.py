"""Three bodies: the figure-eight orbit and the Pythagorean problem, against states known to 20 digits."""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.checks.base import Check, Laboratory, legacy_check
from crosscheck.checks.stepping.kepler import RARE, SEQUENCE, SIGMAS, nominal_order
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, Limit, extrapolate
from crosscheck.engines.protocol import Claims
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import three_body
from crosscheck.references.three_body import FIGURE_EIGHT, PYTHAGOREAN, RETURN_ERROR, ThreeBodies
from crosscheck.scene import Floats, Gravity, Method, Scene, explicit
from crosscheck.statistics import fitted_order
from crosscheck.verdict import Judged, order, round_off, within, worst

WHY_ROUNDING = "10 standard deviations of independent roundings of the state in every step, carried to the end"


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


EIGHT = three_body_scene("figure-eight", FIGURE_EIGHT)
TRIANGLE = three_body_scene("pythagorean", PYTHAGOREAN)


def _furthest(positions: Floats, others: Floats) -> float:
    """Largest distance of a body from its place; infinite where one is not finite."""
    distance = float(np.linalg.norm(positions - others, axis=-1).max())
    return distance if np.isfinite(distance) else np.inf


def _extrapolated(laboratory: Laboratory, scene: Scene, problem: ThreeBodies, coarsest: int) -> tuple[Limit, float]:
    """Final positions and velocities of velocity Verlet at no step, shape (2, N, d), and what rounding adds to them."""
    numbers = coarsest * SEQUENCE
    runs = [laboratory.run(scene, Method(scheme="velocity_verlet", dt=problem.time / n)) for n in numbers]
    limit = extrapolate(1 / numbers, [np.array([run["final_positions"], run["final_velocities"]]) for run in runs])
    each = np.array([problem.rounding_error(n) for n in numbers])
    return limit, SIGMAS * float(np.sqrt(((limit.weights * each) ** 2).sum()))


def _best(
    laboratory: Laboratory, scheme: str, scene: Scene, problem: ThreeBodies, coarsest: int
) -> tuple[Floats, Floats, float, str]:
    """Final positions and velocities, their uncertainty, and a note: adaptive, or extrapolated to no step."""
    if laboratory.engine == "refimpl":
        limit, rounding = _extrapolated(laboratory, scene, problem, coarsest)
        note = (
            f"{coarsest} to {coarsest * SEQUENCE[-1]} steps; extrapolation {limit.error:.1g}, rounding {rounding:.1g}"
        )
        return limit.value[0], limit.value[1], limit.error + rounding, note
    run = laboratory.run(scene, Method(scheme=scheme, dt=problem.time / 10_000))
    rounding = SIGMAS * problem.rounding_error(run.cost.steps, even=False)
    return run["final_positions"], run["final_velocities"], rounding, f"{run.cost.steps} steps"


def _best_schemes(engine: str, schemes: dict[str, Claims]) -> tuple[str, ...]:
    """velocity Verlet, extrapolated, of `refimpl`; the adaptive schemes of others."""
    if engine == "refimpl":
        return ("velocity_verlet",)
    return tuple(name for name, claims in schemes.items() if claims.kind == "stepping" and claims.order is None)


# -- the figure eight --------------------------------------------------------------------------------------------------


def _judge_order(laboratory: Laboratory, scheme: str) -> Judged:
    nominal = nominal_order(scheme, laboratory.claims[scheme])
    numbers = (2048 if nominal == 1 else 512) * 2.0 ** np.arange(4)
    errors = []
    for n in numbers:
        run = laboratory.run(EIGHT, Method(scheme=scheme, dt=FIGURE_EIGHT.time / n))
        errors.append(_furthest(run["final_positions"], FIGURE_EIGHT.final_positions))
    lever = numbers[-1] / FIGURE_EIGHT.time if scheme == "verlet" else 1.0
    slope = fitted_order(1 / numbers, errors, SIGMAS * lever * FIGURE_EIGHT.rounding_error(numbers[-1]))
    curve = Series(scheme, (FIGURE_EIGHT.time / numbers).tolist(), errors)
    return order(
        "order of the position error after one period",
        slope.value,
        nominal,
        ORDER_TOLERANCE,
        WHY_ORDER,
        uncertainty=slope.error,
        note=f"error at {numbers[0]:.0f} steps a period: {errors[0]:.2g}",
        figures=(Figure("figure eight after one period", "dt", "largest position error", "log", "log", (curve,)),),
    )


def _order_variants(full: bool) -> Any:
    """WHFast is for planets about one star: three equal bodies are no perturbed Kepler orbits."""
    return lambda engine, schemes: tuple(
        name
        for name, claims in schemes.items()
        if claims.order is not None and name != "whfast" and (name in RARE) == full
    )


def _judge_return(laboratory: Laboratory, scheme: str) -> Judged:
    r, v, uncertainty, note = _best(laboratory, scheme, EIGHT, FIGURE_EIGHT, 128)
    masses = np.array(FIGURE_EIGHT.masses)
    # of the energy, and of the angular momentum, with respect to the state: 2.35 and 2.11 at the start
    gradient = 2.4
    return worst(
        [
            round_off(
                "distance from the known state after one period",
                _furthest(r, FIGURE_EIGHT.final_positions),
                uncertainty,
                WHY_ROUNDING,
            ),
            within(
                "round_off",
                "distance from the start after one period",
                _furthest(r, FIGURE_EIGHT.positions),
                RETURN_ERROR,
                uncertainty,
                f"what the eight digits of the initial state leave; {WHY_ROUNDING}",
            ),
            round_off(
                "change of the energy",
                abs(float(three_body.energy(masses, r, v)) - FIGURE_EIGHT.energy),
                gradient * uncertainty,
                "the uncertainty of the state, times the energy's gradient",
            ),
            round_off(
                "angular momentum",
                abs(float(three_body.angular_momentum(masses, r, v))),
                gradient * uncertainty,
                "the uncertainty of the state, times the gradient",
            ),
        ],
        note,
    )


# -- the Pythagorean problem -------------------------------------------------------------------------------------------


def _judge_pythagorean(laboratory: Laboratory, scheme: str) -> Judged:
    r, _, uncertainty, note = _best(laboratory, scheme, TRIANGLE, PYTHAGOREAN, 120_000)
    return round_off(
        "largest position error at t = 10",
        _furthest(r, PYTHAGOREAN.final_positions),
        uncertainty,
        WHY_ROUNDING + "; where steps are uneven, from where it matters most",
        note=note,
    )


# -- the checks --------------------------------------------------------------------------------------------------------

_LITERATURE = "Chenciner & Montgomery, Ann. Math. 152, 881 (2000)"
_EQUATION = "r_i'' = -sum_j m_j (r_i - r_j)/|r_i - r_j|^3"
_REST = ": the schemes left out of the quick tier"


def _fault(file: str, name: str, old: str, new: str, breaks: str) -> Fault:
    return Fault(name, f"stepping/{file}.py", old, new, breaks)


def _order_check(full: bool) -> Check:
    return legacy_check(
        name="stepping/figure-eight-order" + "-full" * full,
        title="Order of convergence on the figure-eight orbit of three bodies" + _REST * full,
        equation=_EQUATION,
        criterion=f"fitted order of the position error after a period = claimed +- {ORDER_TOLERANCE}: {WHY_ORDER}; "
        "2 for Gear's schemes, whose higher derivatives start at zero",
        citation=_LITERATURE,
        judge=_judge_order,
        variants=_order_variants(full),
        faults=(
            (
                "beeman_pc",
                _fault(
                    "schemes",
                    "beeman-pc-velocity",
                    "return r, v + dt / 6.0 * (2.0 * a_new + 5.0 * a - a_before), (a_new, a)\n\n\nclass EulerPredictor",
                    "return r, v + dt / 6.0 * (2.0 * a_new + 4.0 * a), (a_new, a)\n\n\nclass EulerPredictor",
                    "the velocity leaves out the acceleration of the step before: order 1",
                ),
            ),
        )
        if full
        else (
            (
                "velocity_verlet",
                _fault(
                    "forces/gravity",
                    "gravity-third-body",
                    "        for j in range(i):\n            q = d * j\n            dx = r[q] - r[p]",
                    "        for j in range(min(i, 1)):\n            q = d * j\n            dx = r[q] - r[p]",
                    "pairs without the first body do not attract each other",
                ),
            ),
        ),
        engines=("refimpl", "lammps", "rebound"),
        tier="full" if full else "quick",
    )


CHECKS = (
    *map(_order_check, (False, True)),
    legacy_check(
        name="stepping/figure-eight",
        title="Figure-eight orbit of three bodies: back at the start after a period, energy and angular momentum kept",
        equation=f"{_EQUATION}; E = -1.2871419918, L = 0, period 6.32591398",
        criterion="from the state known to 20 digits: rounding; from the start 4.1e-8, as its digits give",
        citation=f"{_LITERATURE}; Rein & Spiegel, MNRAS 446, 1424 (2015)",
        judge=_judge_return,
        variants=_best_schemes,
        faults=(
            (
                "velocity_verlet",
                _fault(
                    "forces/gravity",
                    "gravity-not-inverse-square",
                    "inverse_cube = G / (square * sqrt(square))",
                    "inverse_cube = G / (square * sqrt(square) + 1e-10)",
                    "a softening of 1e-10 in the cube of the distance",
                ),
            ),
        ),
        engines=("refimpl", "rebound"),
    ),
    legacy_check(
        name="stepping/pythagorean",
        title="Pythagorean problem of three bodies: positions at t = 10, after close encounters",
        equation=f"{_EQUATION}; m = 3, 4, 5 at (1, 3), (-2, -1), (1, -1), at rest",
        criterion="distance from the state known to 20 digits within rounding, carried through the encounters",
        citation="Burrau, Astron. Nachr. 195, 113 (1913); Szebehely & Peters, Astron. J. 72, 876 (1967)",
        judge=_judge_pythagorean,
        variants=_best_schemes,
        faults=(
            (
                "velocity_verlet",
                _fault(
                    "forces/gravity",
                    "gravity-mass-of-third",
                    "from_i = inverse_cube * mass[i]",
                    "from_i = inverse_cube * mass[i] * 1.00000001",
                    "later bodies attract earlier ones too strongly by 1e-8",
                ),
            ),
        ),
        engines=("refimpl", "rebound"),
        tier="full",
    ),
)
