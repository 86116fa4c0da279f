"""Gear's schemes on a Kepler orbit, started with higher derivatives of zero, since gravity gives none: the error."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.orbits import (
    AXIS,
    MU,
    PERIOD,
    SAMPLED_ORBIT,
    SAMPLES,
    kepler_scene,
    rounding_floor,
)
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.engines.protocol import Claims
from crosscheck.figure import Figure, Series
from crosscheck.references import kepler
from crosscheck.scene import Floats, Method
from crosscheck.verdict import Judged, order

#: Schemes, by the order that an exact start would give them.
GEAR = ("gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity")


def _variants(schemes: Mapping[str, Claims]) -> tuple[Variant, ...]:
    tier = tier_beside_audits("gear5")
    return tuple(Variant(name, name, tier(name)) for name in GEAR if name in schemes)


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    """The error that is left once the orbit is that of the changed starting velocity has the claimed order."""
    claimed = laboratory.claims[scheme].order
    assert claimed is not None
    e, nominal = 0.5, claimed[0]
    numbers = (512 if nominal > 5 else 1024) * np.array([1, 2, 4])
    rest, plain = [], []
    for n in numbers:
        run = laboratory.run(kepler_scene(e, 1, SAMPLES), Method(scheme=scheme, dt=PERIOD / n))
        r = kepler.relative(run["positions"])
        expected, _ = kepler.zero_start_orbit(run["time"], e, AXIS, MU, PERIOD / n)
        true, _ = kepler.relative_orbit(run["time"], e, AXIS, MU)
        rest.append(_furthest(r, expected))
        plain.append(_furthest(r, true))
    slope = fitted_order(1 / numbers, rest, rounding_floor(scheme, e, 1, numbers[-1]))
    series = (
        Series(f"{scheme}, zero start", (PERIOD / numbers).tolist(), plain),
        Series(f"{scheme}, start accounted for", (PERIOD / numbers).tolist(), rest),
    )
    return order(
        "order of the position error, start accounted for",
        slope.value,
        nominal,
        ORDER_TOLERANCE,
        WHY_ORDER,
        uncertainty=slope.error,
        note=f"position error/a at {numbers[-1]} steps a period: {plain[-1]:.3g}, start accounted for {rest[-1]:.3g}",
        figures=(Figure("cost of the zero start, e = 0.5", "n dt", "largest position error/a", "log", "log", series),),
    )


def _furthest(r: Floats, exact: Floats) -> float:
    return float(np.linalg.norm(r - exact, axis=-1).max() / AXIS)


CHECKS = (
    Check(
        name="stepping/kepler-start",
        title="Gear's zero start on a Kepler orbit: a starting velocity off by dt^2 r'''/12, full order beside that",
        equation="v(0) -> v(0) - dt^2 r'''(0)/12, r''' = -mu v/r^3 at apocentre",
        criterion=f"fitted order of what is left = that claimed for an exact start +- {ORDER_TOLERANCE}: {WHY_ORDER}",
        citation="Gear, Numerical Initial Value Problems in ODEs (1971); derivation in docs/kepler.md",
        judge=_judge,
        variants=_variants,
        faults=(
            (
                "gear5",
                scheme_fault(
                    "gear5-third",
                    "_GEAR5 = (3 / 20, 251 / 360, 1.0, 11 / 18",
                    "_GEAR5 = (3 / 20, 251 / 360, 1.0, 11.011 / 18",
                    "alpha_3 is off by 1e-3",
                ),
            ),
        ),
        needs=SAMPLED_ORBIT,
    ),
)
