"""The largest stable step of each scheme on the undamped oscillator."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.springs import LITERATURE, SPRING, unit_oscillator
from crosscheck.engines.protocol import Run
from crosscheck.figure import Figure, Series
from crosscheck.references import oscillator
from crosscheck.scene import Floats, Method
from crosscheck.verdict import Judged, within

#: Steps of a stability run, and the growth per step that counts as unstable where no step is stable for ever.
STEPS, PRACTICAL = 10_000, 1.01


def _log_amplitudes(run: Run) -> Floats:
    """ln sqrt(r^2 + v^2) at each sample; infinite where it is not finite."""
    amplitudes = np.hypot(run["positions"][:, 0, 0], run["velocities"][:, 0, 0])
    with np.errstate(divide="ignore"):  # a damped amplitude may underflow to zero
        return np.log(np.where(np.isfinite(amplitudes), amplitudes, np.inf))


def _judge_limit(laboratory: Laboratory, scheme: str) -> Judged:
    """Bisects on whether STEPS steps raise the amplitude.

    Where a strict limit exists: by more than 1e6, for Verlet's amplitude oscillates by 1/sqrt(2 - omega0 dt) just below
    its limit. Elsewhere: by 1 % a step in the second half, when the growing mode has taken over; the phase of the
    oscillation blurs that by less than a factor 10.
    """
    strict = oscillator.strict_limit(scheme)
    half = STEPS // 2
    if strict is not None:
        expected, visible = strict, oscillator.practical_limit(scheme, 1e6 ** (1 / STEPS))
    else:
        expected = oscillator.practical_limit(scheme, PRACTICAL)
        visible = oscillator.practical_limit(scheme, PRACTICAL * 10 ** (1 / half))
    low, high = 0.9 * expected, 1.1 * expected
    resolution = abs(visible - expected)
    while high - low > 0.05 * resolution:
        middle = 0.5 * (low + high)
        run = laboratory.run(
            unit_oscillator(STEPS * middle, half * middle), Method(scheme=scheme, dt=middle), may_end_early=True
        )
        _, at_half, at_end = _log_amplitudes(run)
        limit = np.log(1e6) if strict is not None else at_half + half * np.log(PRACTICAL)
        if at_end > limit or not np.isfinite(at_half):
            high = middle
        else:
            low = middle
    kind = "no growth for ever" if strict is not None else "growth of 1 % a step (no step is stable for ever)"
    curve = [(h, oscillator.growth_per_step(scheme, h)) for h in np.linspace(0.02, 2.2, 40)]
    shown = [(float(h), g) for h, g in curve if g < 1.2]
    series = (
        Series(scheme, [h for h, _ in shown], [g for _, g in shown], theory=True),
        Series(scheme, [0.5 * (low + high)], [1.0 if strict is not None else PRACTICAL]),
    )
    return within(
        "order",
        f"largest omega dt with {kind}",
        0.5 * (low + high),
        expected,
        2 * resolution,
        f"twice the distance from the limit at which {STEPS} steps show it, from the eigenvalues",
        uncertainty=0.5 * (high - low),
        figures=(Figure("growth per step and measured limit", "omega0 dt", "growth of the amplitude", series=series),),
    )


CHECKS = (
    Check(
        name="stepping/stability-limit",
        title="Largest stable step on the undamped oscillator, by bisection, against the step matrix's eigenvalues",
        equation="largest |eigenvalue of M(omega0 dt)| = 1; where that holds for no step, = 1.01",
        criterion=f"twice the distance from the limit at which {STEPS} steps show it",
        citation=LITERATURE,
        judge=_judge_limit,
        variants=schemes_with(
            lambda name, claims: oscillator.has_matrix(name), tier_beside_audits("velocity_verlet", "gear5_velocity")
        ),
        faults=(
            (
                "euler_pc",
                scheme_fault(
                    "euler-pc-first-order-prediction",
                    "v_new = v + dt * accelerate(force, r + dt * v, v + dt * a)",
                    "v_new = v + dt * accelerate(force, r + 0.5 * dt * v, v + dt * a)",
                    "the prediction goes half a step only",
                ),
            ),
            (
                "gear4",
                scheme_fault(
                    "gear4-table",
                    "_GEAR4, _GEAR4_VELOCITY = (19 / 120,",
                    "_GEAR4, _GEAR4_VELOCITY = (19 / 90,",
                    "the corrector for f(r) takes its first coefficient from the table for f(r, v)",
                ),
            ),
        ),
        needs=SPRING,
    ),
)
