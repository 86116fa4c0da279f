"""Precession of the apsides of a Kepler orbit under leap-frog steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.faults import gravity_fault, scheme_fault
from crosscheck.checks.stepping.orbits import (
    MODIFIED,
    MU,
    PERIOD,
    SAMPLED_ORBIT,
    Orbit,
    kepler_scene,
    step_numbers,
    tier_of,
)
from crosscheck.engines.protocol import Claims
from crosscheck.figure import Figure, Series
from crosscheck.references import kepler
from crosscheck.scene import Method
from crosscheck.verdict import Judged, within

#: Schemes whose positions are those of leap-frog, at the same or at other times.
TURNING = ("symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "beeman", "beeman_pc", "gear2")
#: Step of the coarser run, times the angular speed at pericentre.
TURNING_STEP = 0.1


def _variants(schemes: Mapping[str, Claims]) -> Iterator[Variant]:
    for orbit in (Orbit(e, name) for e in (0.5, 0.9) for name in TURNING if name in schemes):
        yield Variant(orbit.name, orbit, tier_of(orbit.scheme))


def _judge(laboratory: Laboratory, orbit: Orbit) -> Judged:
    """Angle of the eccentricity vector per radian of mean anomaly, from apocentre to apocentre over 10 periods."""
    e, scheme = orbit
    numbers = step_numbers(e, TURNING_STEP, 2)
    rates, theory = [], [kepler.precession(e, PERIOD / n) for n in numbers]
    for n in numbers:
        run = laboratory.run(kepler_scene(e, 10, 1), Method(scheme=scheme, dt=PERIOD / n))
        vector = kepler.eccentricity_vector(kepler.relative(run["positions"]), kepler.relative(run["velocities"]), MU)
        angle = np.unwrap(np.arctan2(vector[:, 1], vector[:, 0]))
        angle -= angle[0]
        rates.append(float(np.polyfit(run["time"], angle, 1)[0]))
    coarse, fine = np.array(rates) / np.array(theory)
    periods = run["time"] / PERIOD
    series = (
        Series(scheme, periods.tolist(), angle.tolist()),
        Series(
            f"theory, {numbers[1]:.0f} steps a period",
            periods.tolist(),
            (theory[1] * run["time"]).tolist(),
            theory=True,
        ),
    )
    return within(
        "order",
        "rate of precession/theory, extrapolated",
        (4 * fine - coarse) / 3,
        1.0,
        (PERIOD * kepler.fastest(e) / numbers[0]) ** 3,
        "terms of third and higher order in the step times the angular speed at pericentre, which extrapolation leaves",
        note=f"{coarse:.6f} and {fine:.6f} at {numbers[0]:.0f} and {numbers[1]:.0f} steps a period",
        figures=(Figure(f"precession, e = {e:g}", "periods", "angle of the apsides/rad", series=series),),
    )


CHECKS = (
    Check(
        name="stepping/kepler-precession",
        title="Precession of the apsides under leap-frog steps, against the modified Hamiltonian's",
        equation="d(varpi)/d(n t) = -(n dt)^2 (4 + e^2)/(16 (1 - e^2)^3), from <H_2> by Lagrange's planetary equation",
        criterion="rate extrapolated from two steps = theory +- (omega_p dt)^3; omega_p: angular speed at pericentre",
        citation=f"{MODIFIED}; Murray & Dermott, Solar System Dynamics (1999), chapter 6",
        judge=_judge,
        variants=_variants,
        faults=(
            (
                "e0.5/velocity_verlet",
                gravity_fault(
                    "gravity-exponent",
                    "inverse_cube = G / (square * sqrt(square))",
                    "inverse_cube = G / (square * sqrt(square)) ** 1.000001",
                    "the exponent of the law is off by 3e-6: the orbit turns by itself",
                ),
            ),
            (
                "e0.5/beeman_pc",
                scheme_fault(
                    "beeman-pc-coefficients",
                    "r = r + dt * v + dt**2 / 6.0 * (4.0 * a - a_before)\n        v_predicted",
                    "r = r + dt * v + dt**2 / 6.0 * (3.96 * a - 0.96 * a_before)\n        v_predicted",
                    "the position's coefficients are 3.96 and 0.96 for 4 and 1: still of order 2, but not Verlet's",
                ),
            ),
        ),
        needs=SAMPLED_ORBIT,
    ),
)
