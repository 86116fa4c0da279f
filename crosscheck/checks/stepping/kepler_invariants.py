"""Energy, modified energy and angular momentum of symplectic schemes on a Kepler orbit."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.faults import gravity_fault, scheme_fault
from crosscheck.checks.stepping.orbits import (
    AXIS,
    DRIFT,
    MODIFIED,
    MU,
    PERIOD,
    SAMPLED_ORBIT,
    SAMPLES,
    SIGMAS,
    WHY_BIASED,
    WHY_DRIFT,
    departure,
    energies,
    kepler_scene,
    step_numbers,
)
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON, kepler
from crosscheck.references.oscillator import rounding_lever
from crosscheck.scene import Floats, Method
from crosscheck.verdict import Judged, Judgement, bounded, order, round_off, within, worst

ECCENTRICITY, PERIODS = 0.5, 20
#: The modified Hamiltonians of (engine, scheme): the same name may stand for different maps.
SHADOWS = {
    **{("refimpl", scheme): kepler.KICK_DRIFT_KICK for scheme in ("verlet", "leapfrog", "velocity_verlet", "gear2")},
    ("refimpl", "symplectic_euler"): kepler.KICK_DRIFT,
    ("lammps", "velocity_verlet"): kepler.KICK_DRIFT_KICK,
    ("rebound", "leapfrog"): kepler.DRIFT_KICK_DRIFT,
}
_MOMENTUM = "departure of L from that of the orbit, in standard deviations of rounding"
_START = "energy and angular momentum of the start, relative to those of the orbit"
_WHY_START = "roundings of the state and of a dozen operations"


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    """20 periods at e = 0.5: energy, modified energy, angular momentum."""
    shadow = SHADOWS.get((laboratory.engine, scheme))
    numbers = step_numbers(ECCENTRICITY, 0.1, 3)
    of_energy, of_modified, of_momentum, of_start = [], [], [], []
    exact = kepler.angular_momentum(*kepler.relative_orbit(0.0, ECCENTRICITY, AXIS, MU))
    for n in numbers:
        run = laboratory.run(kepler_scene(ECCENTRICITY, PERIODS, SAMPLES), Method(scheme=scheme, dt=PERIOD / n))
        r, v = kepler.relative(run["positions"]), kepler.relative(run["velocities"])
        energy = energies(run)
        of_energy.append(departure(energy))
        if shadow is not None:
            correction = shadow.correction(r, v, MU) * (2 * AXIS / MU)
            of_modified.append(departure(energy + (PERIOD / n) ** shadow.power * correction))
        momentum = kepler.angular_momentum(r, v)
        walk = kepler.momentum_rounding(ECCENTRICITY, PERIODS, n) * rounding_lever(scheme, n / PERIOD)
        of_momentum.append(float(abs(momentum / exact - 1).max()) / walk)
        of_start.append(max(abs(energy[0] + 1), abs(momentum[0] / exact - 1)))
    rounding = SIGMAS * kepler.energy_rounding(ECCENTRICITY, PERIODS, numbers[-1])
    rounding *= rounding_lever(scheme, numbers[-1] / PERIOD)
    biased = np.sqrt(numbers[-1] * PERIODS)
    if max(of_energy) <= rounding * biased:
        judgements = [
            round_off(_START, max(of_start), 16 * EPSILON, _WHY_START),
            round_off("departure of E/E0", max(of_energy), rounding * biased, WHY_BIASED),
            round_off(_MOMENTUM, max(of_momentum), SIGMAS * biased, WHY_BIASED),
        ]
        return worst(judgements, "exact for two bodies")
    why = "a random walk by the rounding of r and v; the kicks are central"
    claimed = laboratory.claims[scheme].order
    assert claimed is not None
    judgements = [
        round_off(_START, max(of_start), 16 * EPSILON, _WHY_START),
        round_off(_MOMENTUM, max(of_momentum), SIGMAS, why),
        _order_of("energy error", numbers, of_energy, min(claimed), rounding),
        bounded(
            "largest energy error, 20 periods to the first",
            of_energy[-1] / departure(energy[: SAMPLES + 1]),
            DRIFT,
            WHY_DRIFT,
            control=True,
        ),
    ]
    series = [Series(f"{scheme}, E", (PERIOD / numbers).tolist(), of_energy)]
    if shadow is not None:
        judgements.append(
            _order_of("modified energy's error", numbers, of_modified, shadow.power + shadow.gain, rounding)
        )
        judgements.append(_size_of(shadow, numbers[-1], of_energy[-1], of_modified[-1]))
        series.append(Series(f"{scheme}, modified E", (PERIOD / numbers).tolist(), of_modified))
    figure = Figure("energy over 20 periods, e = 0.5", "n dt", "largest |E - E0|/|E0|", "log", "log", tuple(series))
    return worst(judgements, f"energy error at {numbers[0]:.0f} steps a period: {of_energy[0]:.2g}", (figure,))


def _order_of(what: str, numbers: Floats, errors: list[float], expected: int, rounding: float) -> Judgement:
    slope = fitted_order(1 / numbers, errors, rounding)
    return order(f"order of the {what}", slope.value, expected, ORDER_TOLERANCE, WHY_ORDER, uncertainty=slope.error)


def _size_of(shadow: kepler.Shadow, n: float, of_energy: float, of_modified: float) -> Judgement:
    """The energy error itself, at n steps a period: that of the modified energy along the exact orbit."""
    r, v = kepler.relative_orbit(np.arange(SAMPLES + 1) * PERIOD / SAMPLES, ECCENTRICITY, AXIS, MU)
    expected = (PERIOD / n) ** shadow.power * departure(shadow.correction(r, v, MU) * (2 * AXIS / MU))
    # over the run the orbits of all these maps turn by order dt^2 a radian, and samples fall elsewhere on them
    turned = expected * (PERIOD * PERIODS) * (PERIOD * kepler.fastest(ECCENTRICITY) / n) ** 2
    return within(
        "order",
        f"largest energy error at {n:.0f} steps a period",
        of_energy,
        expected,
        of_modified + turned,
        "that of the modified energy, and what the error of the phase after the run changes in the samples",
    )


CHECKS = (
    Check(
        name="stepping/kepler-invariants",
        title="Energy, modified energy and angular momentum of symplectic schemes over 20 periods of a Kepler orbit",
        equation="velocity Verlet: E + dt^2 (v.U''.v/12 - |grad U|^2/24); symplectic Euler: E - dt v.grad U/2",
        criterion="L to rounding; order of the energy error as claimed, of the modified energy's 4 (symplectic Euler: "
        f"2); no drift: error over 20 periods <= {DRIFT:g} times that of the first",
        citation=MODIFIED,
        judge=_judge,
        variants=schemes_with(lambda name, claims: claims.order is not None and bool(claims.symplectic)),
        faults=(
            (
                "velocity_verlet",
                scheme_fault(
                    "velocity-verlet-half-kick",
                    "return r, add_to(v_half, 0.5 * dt, a), (a,)",
                    "return r, add_to(v_half, 0.5 * dt, memory[0]), (a,)",
                    "the second half kick takes the old acceleration",
                ),
            ),
            (
                "symplectic_euler",
                gravity_fault(
                    "gravity-not-central",
                    "a[p + 1] += from_j * dy",
                    "a[p + 1] += 1.0000000001 * from_j * dy",
                    "one component of the force on the later body of a pair is off by 1e-10: not central",
                ),
            ),
        ),
        needs=SAMPLED_ORBIT,
    ),
)
