"""The figure-eight orbit of three equal bodies: order of every scheme, and the return to the start after a period."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.checks.stepping.faults import gravity_fault, scheme_fault
from crosscheck.checks.stepping.orbits import SIGMAS, nominal_order
from crosscheck.checks.stepping.three_bodies import (
    CITATION,
    EQUATION,
    WHY_ROUNDING,
    best,
    best_schemes,
    furthest,
    three_body_scene,
)
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references import three_body
from crosscheck.references.oscillator import rounding_lever
from crosscheck.references.three_body import FIGURE_EIGHT, GREATEST_GRADIENT, RETURN_ERROR
from crosscheck.scene import Method
from crosscheck.verdict import Judged, order, round_off, within, worst

EIGHT = three_body_scene("figure-eight", FIGURE_EIGHT)
_tier = tier_beside_audits("velocity_verlet", "gear5")
_NEEDS = Needs("gravity", words=frozenset({"dimension=2"}))


def _judge_order(laboratory: Laboratory, scheme: str) -> Judged:
    nominal = nominal_order(scheme, laboratory.claims[scheme])
    numbers = (2048 if nominal == 1 else 512) * 2.0 ** np.arange(4)
    errors = []
    for n in numbers:
        run = laboratory.run(EIGHT, Method(scheme=scheme, dt=FIGURE_EIGHT.time / n))
        errors.append(furthest(run["final_positions"], FIGURE_EIGHT.final_positions))
    lever = rounding_lever(scheme, numbers[-1] / FIGURE_EIGHT.time)
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


def _judge_return(laboratory: Laboratory, scheme: str) -> Judged:
    r, v, uncertainty, note = best(laboratory, scheme, EIGHT, FIGURE_EIGHT, 128)
    masses = np.array(FIGURE_EIGHT.masses)
    return worst(
        [
            round_off(
                "distance from the known state after one period",
                furthest(r, FIGURE_EIGHT.final_positions),
                uncertainty,
                WHY_ROUNDING,
            ),
            within(
                "round_off",
                "distance from the start after one period",
                furthest(r, FIGURE_EIGHT.positions),
                RETURN_ERROR,
                uncertainty,
                f"what the eight digits of the initial state leave; {WHY_ROUNDING}",
            ),
            round_off(
                "change of the energy",
                abs(float(three_body.energy(masses, r, v)) - FIGURE_EIGHT.energy),
                GREATEST_GRADIENT * uncertainty,
                "the uncertainty of the state, times the energy's gradient",
            ),
            round_off(
                "angular momentum",
                abs(float(three_body.angular_momentum(masses, r, v))),
                GREATEST_GRADIENT * uncertainty,
                "the uncertainty of the state, times the gradient",
            ),
        ],
        note,
    )


CHECKS = (
    Check(
        name="stepping/figure-eight-order",
        title="Order of convergence on the figure-eight orbit of three bodies",
        equation=EQUATION,
        criterion=f"fitted order of the position error after a period = claimed +- {ORDER_TOLERANCE}: {WHY_ORDER}; "
        "2 for Gear's schemes, whose higher derivatives start at zero",
        citation=CITATION,
        judge=_judge_order,
        # WHFast is for planets about one star: three equal bodies are no perturbed Kepler orbits
        variants=schemes_with(lambda name, claims: claims.order is not None and name != "whfast", _tier),
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
            (
                "beeman_pc",
                scheme_fault(
                    "beeman-pc-velocity",
                    "return r, v + dt / 6.0 * (2.0 * a_new + 5.0 * a - a_before), (a_new, a)\n\n\nclass EulerPredictor",
                    "return r, v + dt / 6.0 * (2.0 * a_new + 4.0 * a), (a_new, a)\n\n\nclass EulerPredictor",
                    "the velocity leaves out the acceleration of the step before: order 1",
                ),
            ),
        ),
        needs=_NEEDS,
    ),
    Check(
        name="stepping/figure-eight",
        title="Figure-eight orbit of three bodies: back at the start after a period, energy and angular momentum kept",
        equation=f"{EQUATION}; E = -1.2871419918, L = 0, period 6.32591398",
        criterion="from the state known to 20 digits: rounding; from the start 4.1e-8, as its digits give",
        citation=f"{CITATION}; Rein & Spiegel, MNRAS 446, 1424 (2015)",
        judge=_judge_return,
        variants=best_schemes,
        faults=(
            (
                "velocity_verlet",
                gravity_fault(
                    "gravity-not-inverse-square",
                    "inverse_cube = G / (square * sqrt(square))",
                    "inverse_cube = G / (square * sqrt(square) + 1e-10)",
                    "a softening of 1e-10 in the cube of the distance",
                ),
            ),
        ),
        needs=_NEEDS,
    ),
)
