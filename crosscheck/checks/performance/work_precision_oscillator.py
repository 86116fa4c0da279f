"""Error against run time of the harmonic oscillator: undamped, damped, critical, over-damped and stiff.

Literature: L. D. Landau and E. M. Lifshitz, Mechanics, sections 21 and 25; E. Hairer and G. Wanner, Solving Ordinary
Differential Equations II, 2nd ed. (1996), section IV.2, on stiffness.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from crosscheck.checks.performance.work_precision_judging import Problem, check
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.orbits import SIGMAS
from crosscheck.checks.stepping.oscillator import CRITICAL
from crosscheck.checks.stepping.springs import DAMPED, MASS, OMEGA0, SPRING, STIFFNESS
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.references import oscillator
from crosscheck.scene import Explicit, Floats, Output, Scene, Spring

PERIODS = 10
#: Samples a period: at whole and half periods, the errors of some schemes vanish.
SAMPLES = 5
_R0, _V0 = 1.0, 0.7 * OMEGA0
_AMPLITUDE = float(np.hypot(_R0, _V0 / OMEGA0))
_PERIOD = 2 * np.pi / OMEGA0
_LITERATURE = "Landau & Lifshitz, Mechanics, sections 21 and 25; Hairer & Wanner, Solving ODEs II (1996), section IV.2"
#: Damping gamma of each regime, and periods 2 pi/omega0 of its run.
_REGIMES = {"damped": (0.1 * CRITICAL, 3), "critical": (CRITICAL, 1), "over-damped": (2 * CRITICAL, 1)}
#: Of the stiff oscillator: gamma/m over the rate k/gamma at which it creeps back.
STIFF = 1e4


def _scene(name: str, gamma: float | None, duration: float, interval: float, v0: float = _V0) -> Scene:
    return Scene(
        name=f"work-precision-{name}",
        dimension=1,
        duration=duration,
        masses=MASS,
        spring=Spring(k=STIFFNESS, gamma=gamma),
        initial=Explicit(positions=((_R0,),), velocities=((v0,),)),
        output=Output(interval=interval, trajectory=True),
    )


def _error(run: Run, gamma: float, v0: float = _V0, unit: float = _AMPLITUDE) -> float:
    """Largest |r - exact| over the samples, in units of `unit`; infinite after a divergence."""
    if run.diverged or run.stopped:
        return np.inf
    exact, _ = oscillator.solution(run["time"], _R0, v0, OMEGA0, gamma / (2 * MASS))
    return float(abs(run["positions"][:, 0, 0] - exact).max() / unit)


def _floor(scheme: str, steps: float, radians: float) -> float:
    lever = oscillator.rounding_lever(scheme, steps / radians)
    return SIGMAS * lever * oscillator.rounding_error(steps)


def _ladder(claims: Claims, samples: int, coarsest: dict[str, int], runs: int, nominal: int) -> Floats:
    """Steps of a whole run, doubled each time. samples: of the run. coarsest: steps a sample, by order."""
    kind = {1: "first" if claims.symplectic else "explicit", 2: "second"}.get(nominal, "higher")
    return np.asarray(coarsest[kind] * samples * 2.0 ** np.arange(runs))


def _undamped(claims: Claims) -> Floats:
    nominal = claims.order[0] if claims.order else 2
    coarsest = {"first": 64, "explicit": 128, "second": 4, "higher": 4}
    return _ladder(claims, SAMPLES * PERIODS, coarsest, 8 if nominal == 2 else 7, nominal)


def _with_friction(claims: Claims, regime: str) -> Floats:
    nominal = min(claims.order_damped) if claims.order_damped else 2
    coarsest = {"first": 16, "explicit": 16, "second": 4, "higher": 4}
    # Gear's higher ones are exact to rounding after few doublings
    return _ladder(claims, SAMPLES * _REGIMES[regime][1], coarsest, 7 if nominal > 2 else 9, nominal)


EVALUATIONS = Fault(
    "evaluations-of-the-start",
    "stepping/integrate.py",
    "starts * table.start_evaluations + done * table.evaluations",
    "done * table.evaluations",
    "the evaluations of the start are not counted",
)

OSCILLATOR = Problem(
    name="oscillator",
    title=f"the undamped oscillator, {PERIODS} periods",
    equation="m r'' = -k r",
    citation="Allen & Tildesley, Computer Simulation of Liquids (1987), chapter 3; Hairer, Norsett & Wanner (1993)",
    unit="amplitude",
    scene=_scene("oscillator", None, PERIODS * _PERIOD, _PERIOD / SAMPLES),
    error=partial(_error, gamma=0.0),
    order=lambda scheme, claims: claims.order[0] if claims.order else 0,
    numbers=_undamped,
    floor=partial(_floor, radians=2 * np.pi * PERIODS),
    needs=SPRING,
    faults=(
        ("velocity_verlet", EVALUATIONS),
        (
            "gear5",
            Fault(
                "gear5-second",
                "stepping/schemes.py",
                "_GEAR5 = (3 / 20, 251 / 360, 1.0",
                "_GEAR5 = (3 / 20, 251.251 / 360, 1.0",
                "one coefficient is off by 1e-3: the error falls too slowly",
            ),
        ),
    ),
    quick=("leapfrog", "velocity_verlet", "gear5", "DOP853"),
)


def _damped_problem(regime: str, faults: tuple[tuple[str, Fault], ...]) -> Problem:
    gamma, periods = _REGIMES[regime]
    return Problem(
        name=f"oscillator-{regime}",
        title=f"the {regime} oscillator, {periods} period{'s' if periods > 1 else ''} 2 pi/omega0",
        equation=f"m r'' = -k r - gamma r', gamma = {gamma / CRITICAL:g} times 2 sqrt(k m)",
        citation=_LITERATURE,
        unit="amplitude",
        scene=_scene(f"oscillator-{regime}", gamma, periods * _PERIOD, _PERIOD / SAMPLES),
        error=partial(_error, gamma=gamma),
        order=lambda scheme, claims: claims.order_damped[0] if claims.order_damped else 0,
        numbers=partial(_with_friction, regime=regime),
        floor=partial(_floor, radians=2 * np.pi * periods),
        needs=DAMPED,
        faults=faults,
        accept=_takes_friction,
        same_steps=False,
    )


def _takes_friction(scheme: str, claims: Claims) -> bool:
    return claims.takes_tolerance or claims.order_damped is not None


# -- stiff -------------------------------------------------------------------------------------------------------------

_STIFF_GAMMA = (STIFF * STIFFNESS * MASS) ** 0.5
_WHY_AT_LEAST = (
    "it starts, but for a share of 1e-4, as it creeps: the terms of lowest order, which act on the rest, are so small "
    "that those of the creep may outweigh them at all steps above rounding"
)
#: The time in which it creeps back by a factor e.
_CREEP = _STIFF_GAMMA / STIFFNESS


def _stiff_numbers(claims: Claims) -> Floats:
    """1, 4, 16 ... 2^12, 2^13, 2^14 ... steps of the whole run: gamma dt/m from 1e4 to 1e-2."""
    return np.concatenate((4.0 ** np.arange(6), 2.0 ** np.arange(12, 21)))


STIFF_OSCILLATOR = Problem(
    name="oscillator-stiff",
    title="a stiff oscillator: gamma/m is 10^4 times the rate k/gamma at which it creeps back",
    equation="m r'' = -k r - gamma r', gamma^2 = 10^4 k m, r' = -(k/gamma) r at the start, to t = gamma/k",
    citation=_LITERATURE,
    unit="r0",
    scene=_scene("oscillator-stiff", _STIFF_GAMMA, _CREEP, _CREEP, -_R0 / _CREEP),
    error=partial(_error, gamma=_STIFF_GAMMA, v0=-_R0 / _CREEP, unit=_R0),
    order=lambda scheme, claims: claims.order_damped[0] if claims.order_damped else 0,
    numbers=_stiff_numbers,
    # each of n roundings of r lasts; those of v decay within a step or few
    floor=lambda scheme, steps: _floor(scheme, steps, 1.0),
    needs=DAMPED,
    faults=(
        (
            "velocity_verlet",
            Fault(
                "friction-slightly-short",
                "stepping/forces/spring.py",
                "return -(k / mass) * r - (gamma / mass) * v",
                "return -(k / mass) * r - (0.999 * gamma / mass) * v",
                "the friction is off by 1e-3: it creeps too fast",
            ),
        ),
    ),
    accept=_takes_friction,
    same_steps=False,
    at_least=_WHY_AT_LEAST,
)

PROBLEMS = (
    OSCILLATOR,
    _damped_problem(
        "damped",
        (
            (
                "velocity_verlet",
                Fault(
                    "friction-slightly-short",
                    "stepping/forces/spring.py",
                    "return -(k / mass) * r - (gamma / mass) * v",
                    "return -(k / mass) * r - (0.999 * gamma / mass) * v",
                    "the friction is off by 1e-3: it creeps too fast",
                ),
            ),
        ),
    ),
    _damped_problem(
        "critical",
        (
            (
                "beeman_pc",
                scheme_fault(
                    "beeman-lagged",
                    "a_new = accelerate(force, r, v_predicted)",
                    "a_new = accelerate(force, r, v)",
                    "the predictor-corrector uses the old velocity: order 1",
                ),
            ),
        ),
    ),
    _damped_problem(
        "over-damped",
        (
            (
                "gear5_velocity",
                Fault(
                    "gear-derivatives",
                    "stepping/forces/spring.py",
                    "below, last = last, _spring_acceleration(below, last, k, mass, gamma)",
                    "below, last = last, _spring_acceleration(last, below, k, mass, gamma)",
                    "the analytic start takes r_3 ... from swapped derivatives: order 2",
                ),
            ),
        ),
    ),
    STIFF_OSCILLATOR,
)
CHECKS = tuple(map(check, PROBLEMS))
