"""Order of convergence of every scheme on Kepler orbits, from a circle to e = 0.99."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.faults import gravity_fault, scheme_fault
from crosscheck.checks.stepping.orbits import (
    ECCENTRICITIES,
    EQUATION,
    LONG_ORBIT,
    ORBITS,
    PERIOD,
    SAMPLED_ORBIT,
    SAMPLES,
    SIGMAS,
    WHY_BIASED,
    Orbit,
    kepler_scene,
    nominal_order,
    position_error,
    rounding_floor,
    step_numbers,
    tier_of,
)
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.engines.protocol import Claims
from crosscheck.figure import Figure, Series
from crosscheck.references import kepler
from crosscheck.scene import Method
from crosscheck.verdict import Judged, order, round_off

#: Steps of the coarsest run, times the angular speed at pericentre: there, errors are asymptotic. By the order.
COARSEST = {1: 0.025, 2: 0.1}


def _variants(schemes: Mapping[str, Claims]) -> Iterator[Variant]:
    for e in ECCENTRICITIES:
        for name, claims in schemes.items():
            if claims.order is None or (e == 0.99 and claims.order[0] == 1):
                continue
            # the start's dt^2 shows only far below the corrector's own error where the orbit is eccentric
            if name.startswith("gear") and name != "gear2" and e > 0.5:
                continue
            orbit = Orbit(e, name)
            # hundreds of thousands of steps: one scheme will do in the quick tier
            tier = "full" if e == 0.99 and name != "velocity_verlet" else tier_of(name)
            yield Variant(orbit.name, orbit, tier, LONG_ORBIT if e == 0.99 else None)


def _judge(laboratory: Laboratory, orbit: Orbit) -> Judged:
    e, scheme = orbit
    nominal = nominal_order(scheme, laboratory.claims[scheme])
    numbers = step_numbers(e, COARSEST.get(nominal, 0.2), 3 if e == 0.99 else 4)
    scene = kepler_scene(e, 1, SAMPLES)
    runs = [laboratory.run(scene, Method(scheme=scheme, dt=PERIOD / n), may_end_early=True) for n in numbers]
    errors = np.array([position_error(run, e) for run in runs])
    x = kepler.fastest(e) * PERIOD / numbers
    figure = Figure(
        f"position error over a period, e = {e:g}",
        "dt times angular speed at pericentre",
        "largest position error/a",
        "log",
        "log",
        (Series(scheme, x.tolist(), errors.tolist()),),
    )
    floor = rounding_floor(scheme, e, 1, numbers[-1])
    biased = floor * np.sqrt(numbers[-1])
    if (errors <= biased).all():
        exact = f"exact for two bodies; {SIGMAS * errors[-1] / floor:.1f} standard deviations of independent roundings"
        return round_off("largest position error/a", errors.max(), biased, WHY_BIASED, note=exact, figures=(figure,))
    slope = fitted_order(x, errors, floor)
    return order(
        "order of the position error",
        slope.value,
        nominal,
        ORDER_TOLERANCE,
        WHY_ORDER,
        uncertainty=slope.error,
        note=f"error at {numbers[0]:.0f} steps a period: {errors[0]:.2g} a",
        figures=(figure,),
    )


CHECKS = (
    Check(
        name="stepping/kepler-order",
        title="Order of convergence on Kepler orbits, e = 0 to 0.99, against the closed form",
        equation=EQUATION,
        criterion=f"fitted order of the largest position error over a period = claimed +- {ORDER_TOLERANCE}: "
        f"{WHY_ORDER}; 2 for Gear's schemes, whose higher derivatives start at zero",
        citation=ORBITS,
        judge=_judge,
        variants=_variants,
        faults=(
            (
                "e0.5/leapfrog",
                scheme_fault(
                    "leapfrog-start",
                    "return (v + 0.5 * dt * accelerate(force, r, v),)",
                    "return (v,)",
                    "the half-step velocity starts without its half kick: order 1",
                ),
            ),
            (
                "e0/velocity_verlet",
                gravity_fault(
                    "gravity-own-mass",
                    "from_j = inverse_cube * mass[j]",
                    "from_j = inverse_cube * mass[i]",
                    "a body is pulled by its own mass, not by the other's",
                ),
            ),
            (
                "e0.5/beeman_pc",
                scheme_fault(
                    "beeman-start",
                    "return a, accelerate(force, r - dt * v + 0.5 * dt**2 * a, v - dt * a)",
                    "return a, 0.0 * a",
                    "a(-dt) starts as zero: order 1",
                ),
            ),
        ),
        needs=SAMPLED_ORBIT,
    ),
)
