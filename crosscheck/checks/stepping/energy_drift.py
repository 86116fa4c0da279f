"""Growth of the oscillator's energy over very long runs, against the eigenvalues of the step."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.springs import LITERATURE, SPRING, unit_oscillator
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON, oscillator
from crosscheck.scene import Floats, Method
from crosscheck.verdict import Judged, within

PERIODS = 100_000
DRIFT_H = 2 * np.pi / 50


def _judge_drift(laboratory: Laboratory, scheme: str) -> Judged:
    """Growth of the energy per radian at 50 steps a period, against twice the eigenvalues' growth of the amplitude."""
    rate = oscillator.energy_growth(scheme, DRIFT_H)
    # as long as 1e5 periods, but no longer than the energy takes to change by a factor e^200
    steps = 50 * (PERIODS if rate == 0.0 else min(PERIODS, int(200 / abs(rate) / (2 * np.pi))))
    chunk = steps // 50
    scene = unit_oscillator(steps * DRIFT_H, chunk * DRIFT_H)
    run = laboratory.run(scene, Method(scheme=scheme, dt=float(DRIFT_H)))
    energy = _energies(run["positions"][:, 0, 0], run["velocities"][:, 0, 0])
    slope, scatter = _slope(run["time"][1:], np.log(energy[1:]))
    # the phase of the samples drifts: over the run, that changes the energy by its oscillation within a period
    swing = np.log(_energies(*oscillator.numerical_solution(scheme, 50, float(DRIFT_H), 1.0, 0.7, 1.0, 0.0)))
    tolerance = 4 * scatter + float(np.ptp(swing)) / (steps * DRIFT_H) + 4 * EPSILON / DRIFT_H
    curve = Series(scheme, run["time"].tolist(), (energy / energy[0] - 1).tolist())
    return within(
        "order",
        "growth of ln(energy) per radian",
        slope,
        rate,
        tolerance,
        "four standard errors of the slope, the energy's swing in a period over the duration, four roundings a step",
        uncertainty=scatter,
        note=f"{steps // 50} periods",
        figures=(Figure("energy of the oscillator", "omega0 t", "E/E0 - 1", "linear", "linear", (curve,)),),
    )


def _energies(r: Floats, v: Floats) -> Floats:
    return 0.5 * (r**2 + v**2)


def _slope(x: Floats, y: Floats) -> tuple[float, float]:
    design = np.vstack([x - x.mean(), np.ones_like(x)]).T
    coefficients, *_ = np.linalg.lstsq(design, y, rcond=None)
    residual = y - design @ coefficients
    error = np.sqrt(residual @ residual / (len(x) - 2) / ((x - x.mean()) ** 2).sum())
    return float(coefficients[0]), float(error)


CHECKS = (
    Check(
        name="stepping/energy-drift",
        title="Growth of the energy over 1e5 periods, 50 steps each: none for symplectic schemes, theory's for others",
        equation="d ln E/d(omega0 t) = 2 ln(largest |eigenvalue|)/(omega0 dt)",
        criterion="four standard errors of the slope + oscillation of ln E/duration + four roundings a step",
        citation=LITERATURE,
        judge=_judge_drift,
        variants=schemes_with(lambda name, claims: oscillator.has_matrix(name), lambda name: "full"),
        faults=(
            (
                "velocity_verlet",
                scheme_fault(
                    "velocity-verlet-drift",
                    "v_half, r = kick_drift(r, v, memory[0], dt)",
                    "v_half, r = kick_drift(r, (1.0 - 1e-7) * v, memory[0], dt)",
                    "the velocity loses 1e-7 of itself every step",
                ),
            ),
        ),
        needs=SPRING,
    ),
)
