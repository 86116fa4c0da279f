"""Kepler orbits in the limit of rounding: against the closed form, and engine against engine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.faults import gravity_fault, scheme_fault
from crosscheck.checks.stepping.orbits import (
    AXIS,
    ECCENTRICITIES,
    EQUATION,
    LONG_ORBIT,
    ORBIT,
    ORBITS,
    PERIOD,
    SIGMAS,
    WHY_ROUNDING,
    Orbit,
    extrapolated,
    kepler_scene,
)
from crosscheck.engines.protocol import Claims
from crosscheck.references import kepler
from crosscheck.scene import Method
from crosscheck.verdict import Judged, round_off


def _variants(schemes: Mapping[str, Claims]) -> Iterator[Variant]:
    """Schemes that choose their own steps, and velocity Verlet, extrapolated; e = 0.99 costs the latter too much."""
    for e in ECCENTRICITIES:
        for name, claims in schemes.items():
            if claims.kind == "stepping" and (claims.order is None or (name == "velocity_verlet" and e < 0.99)):
                yield Variant(Orbit(e, name).name, Orbit(e, name))


def _judge(laboratory: Laboratory, orbit: Orbit) -> Judged:
    e, scheme = orbit
    exact, _ = kepler.relative_orbit(0.0, e)
    if laboratory.claims[scheme].order is not None:
        limit, rounding, numbers = extrapolated(laboratory, e, 3)
        return round_off(
            "position error/a after 3 periods, extrapolated to no step",
            float(np.linalg.norm(limit.value - exact)),
            limit.error + rounding,
            f"the extrapolation's own error, and {WHY_ROUNDING}, added with the weights of the extrapolation",
            note=f"{numbers[0]:.0f} to {numbers[-1]:.0f} steps a period; extrapolation {limit.error:.1g}, "
            f"rounding {rounding:.1g}",
        )
    run = laboratory.run(kepler_scene(e, 10), Method(scheme=scheme, dt=PERIOD / 1000))
    return round_off(
        "position error/a after 10 periods",
        float(np.linalg.norm(kepler.relative(run["final_positions"]) / AXIS - exact)),
        SIGMAS * kepler.rounding_error(e, 10, run.cost.steps),
        WHY_ROUNDING,
        note=f"{run.cost.steps / 10:.0f} steps a period",
    )


def _judge_against_rebound(laboratory: Laboratory, e: float) -> Judged:
    """Velocity Verlet extrapolated to no step against IAS15, each with its own uncertainty."""
    limit, rounding, _ = extrapolated(laboratory, e, 1)
    reference = laboratory.run(kepler_scene(e, 1), Method(scheme="ias15", dt=PERIOD / 1000), engine="rebound")
    theirs = SIGMAS * kepler.rounding_error(e, 1, reference.cost.steps)
    return round_off(
        "distance/a of the two final positions",
        float(np.linalg.norm(limit.value - kepler.relative(reference["final_positions"]) / AXIS)),
        limit.error + rounding + theirs,
        f"the extrapolation's own error, and of either code {WHY_ROUNDING}",
        note=f"extrapolation {limit.error:.1g}, its rounding {rounding:.1g}, IAS15's {theirs:.1g}",
    )


CHECKS = (
    Check(
        name="stepping/kepler-round-off",
        title="Kepler orbits in the limit of rounding: adaptive schemes, and velocity Verlet extrapolated to no step",
        equation=EQUATION,
        criterion=WHY_ROUNDING,
        citation=f"Brouwer, Astron. J. 46, 149 (1937); Rein & Spiegel, MNRAS 446, 1424 (2015); {ORBITS}",
        judge=_judge,
        variants=_variants,
        faults=(
            (
                "e0.5/velocity_verlet",
                scheme_fault(
                    "velocity-verlet-slightly",
                    "v_half, r = kick_drift(r, v, memory[0], dt)",
                    "v_half, r = kick_drift(r, v, 1.0000000001 * memory[0], dt)",
                    "the first half kick is too strong by 1e-10",
                ),
            ),
        ),
        needs=ORBIT,
    ),
    Check(
        name="stepping/kepler-against-rebound",
        title="Velocity Verlet extrapolated to no step against REBOUND's IAS15, after one period",
        equation="r'' = -mu r/|r|^3",
        criterion="distance <= the extrapolation's own error + 10 standard deviations of the rounding of either",
        citation="Rein & Spiegel, MNRAS 446, 1424 (2015); Hairer, Norsett & Wanner, Solving ODEs I (1993), II.9",
        judge=_judge_against_rebound,
        variants=tuple(Variant(f"e{e:g}", e, needs=LONG_ORBIT if e == 0.99 else None) for e in ECCENTRICITIES[1:]),
        faults=(
            (
                "e0.5",
                gravity_fault(
                    "gravity-weaker",
                    "inverse_cube = G / (square * sqrt(square))",
                    "inverse_cube = 0.9999999999 * G / (square * sqrt(square))",
                    "the attraction is too weak by 1e-10",
                ),
            ),
        ),
        needs=replace(ORBIT, schemes=("velocity_verlet",)),
        reference="rebound",
    ),
)
