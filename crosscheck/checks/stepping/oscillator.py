"""The harmonic oscillator: order of every scheme in four regimes, and each step against its exact matrix."""

from __future__ import annotations

from functools import partial
from typing import cast

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.springs import DAMPED, MASS, OMEGA0, SPRING, STIFFNESS
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.engines.protocol import Claims, Run, sample_times
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON, oscillator
from crosscheck.scene import Explicit, Floats, Method, Output, Scene, Spring
from crosscheck.verdict import Judged, controls, order, round_off, worst

CRITICAL = 2 * (STIFFNESS * MASS) ** 0.5
#: regime -> (gamma, duration, r0, v0). A general phase at the start: from rest, some orders look better than they are.
#: Undamped, a short run: Gear's velocity error has a secular term of one order more that takes over in long ones.
REGIMES: dict[str, tuple[float | None, float, float, float]] = {
    "undamped": (None, 0.25, 1.0, 0.7 * OMEGA0),
    "damped": (100.0, 5.0, 1.0, -100.0 / (2 * MASS)),
    "critical": (CRITICAL, 1.0, 1.0, 0.7 * OMEGA0),
    "over-damped": (2 * CRITICAL, 1.0, 1.0, 0.7 * OMEGA0),
}
SAMPLES = 10
#: Schemes that show the orders in the quick tier: one of each family over the four regimes.
_QUICK = {
    "undamped": ("velocity_verlet", "gear5"),
    "damped": ("velocity_verlet", "beeman_pc", "gear5_velocity"),
    "critical": ("velocity_verlet", "beeman_pc"),
    "over-damped": ("velocity_verlet", "gear5"),
}


def _oscillator_scene(regime: str, samples: int = SAMPLES) -> Scene:
    """One oscillator on a line, `samples` samples after the start."""
    gamma, duration, r0, v0 = REGIMES[regime]
    return Scene(
        name=f"oscillator-{regime}",
        dimension=1,
        duration=duration,
        masses=MASS,
        spring=Spring(k=STIFFNESS, gamma=gamma),
        initial=Explicit(positions=((r0,),), velocities=((v0,),)),
        output=Output(interval=duration / samples, trajectory=True),
    )


def _errors_against_closed_form(run: Run, regime: str) -> tuple[float, float]:
    """Largest errors of r, in units of r0, and of v, in units of omega0 r0; infinite after a divergence."""
    gamma, _, r0, v0 = REGIMES[regime]
    r, v = oscillator.solution(run["time"], r0, v0, OMEGA0, (gamma or 0.0) / (2 * MASS))
    if run.diverged:
        return np.inf, np.inf
    return float(abs(run["positions"][:, 0, 0] - r).max()), float(abs(run["velocities"][:, 0, 0] - v).max() / OMEGA0)


def _time_steps(regime: str, nominal: int) -> Floats:
    """Five steps, halved each time, that divide the sampling interval; small enough for the nominal order to show.

    First-order errors grow like omega^2 dt t, so these schemes need far smaller steps to be asymptotic.
    """
    gamma, duration, _, _ = REGIMES[regime]
    fastest = oscillator.fastest_rate(OMEGA0, (gamma or 0.0) / (2 * MASS))
    largest = {1: 0.01, 2: 0.05}.get(nominal, 0.2 if regime in ("undamped", "damped") else 0.1) / fastest
    coarsest = int(np.ceil(duration / SAMPLES / largest))
    return duration / SAMPLES / (coarsest * 2.0 ** np.arange(5))


def _judge_order(laboratory: Laboratory, scheme: str, regime: str) -> Judged:
    claims = laboratory.claims[scheme]
    nominal = claims.order if regime == "undamped" else claims.order_damped
    assert nominal is not None
    scene = _oscillator_scene(regime)
    steps = _time_steps(regime, min(nominal))
    runs = [laboratory.run(scene, Method(scheme=scheme, dt=float(dt)), may_end_early=True) for dt in steps]
    errors = np.array([_errors_against_closed_form(run, regime) for run in runs])
    judgements = []
    for column, name in enumerate(("position", "velocity")):
        # rounding: each of n steps adds about eps, and Verlet's second difference adds them up twice
        floor = 10 * EPSILON * scene.duration / steps.min()
        slope = fitted_order(steps, errors[:, column], floor)
        curve = Series(f"{scheme}", (OMEGA0 * steps).tolist(), errors[:, column].tolist())
        figure = Figure(f"error of the {name}, {regime}", "omega0 dt", f"largest {name} error", "log", "log", (curve,))
        judgements.append(
            order(
                f"order of the {name} error",
                slope.value,
                nominal[column],
                ORDER_TOLERANCE,
                WHY_ORDER,
                uncertainty=slope.error,
                figures=(figure,),
            )
        )
    return worst(judgements, f"error at omega0 dt = {OMEGA0 * steps[0]:.2g}: {errors[0, 0]:.2g} r0")


def _judge_exact(laboratory: Laboratory, scheme: str) -> Judged:
    """200 steps of a damped oscillator at omega0 dt = 0.2 against the power of the scheme's matrix."""
    steps, dt, beta = 200, 0.2 / OMEGA0, 0.1 * OMEGA0
    r0, v0 = 1.0, 0.7 * OMEGA0
    scene = Scene(
        name="oscillator-exact",
        dimension=1,
        duration=steps * dt,
        masses=MASS,
        spring=Spring(k=STIFFNESS, gamma=2 * beta * MASS),
        initial=Explicit(positions=((r0,),), velocities=((v0,),)),
        output=Output(interval=dt, trajectory=True),
    )
    run = laboratory.run(scene, Method(scheme=scheme, dt=dt))
    r, v = oscillator.numerical_solution(scheme, steps, dt, r0, v0, OMEGA0, beta)
    error = max(abs(run["positions"][:, 0, 0] - r).max(), abs(run["velocities"][:, 0, 0] - v).max() / OMEGA0)
    exact = round_off(
        "largest difference from the exact numerical solution",
        float(error),
        4 * EPSILON * steps,
        "four roundings a step, added up over 200 steps",
    )
    claims = laboratory.claims[scheme]
    claimed = {"undamped": claims.order, "damped": claims.order_damped}
    matrices = cast(Laboratory, _Matrices(laboratory.claims))
    orders = [_judge_order(matrices, scheme, regime) for regime, orders in claimed.items() if orders is not None]
    return worst([exact, *map(controls, orders)], figures=())


class _Matrices:
    """A laboratory whose engine is the exact numerical solution: to judge claims without a run. claims: by scheme."""

    def __init__(self, claims: dict[str, Claims]) -> None:
        self.claims = claims

    def run(self, scene: Scene, method: Method, *, may_end_early: bool) -> Run:
        state, spring, dt = scene.initial_state(), scene.spring, method.step
        assert spring is not None
        every, steps = scene.every(dt) or 1, scene.steps(dt)
        start = float(state.positions[0, 0]), float(state.velocities[0, 0])
        beta = (spring.gamma or 0.0) / (2 * MASS)
        r, v = oscillator.numerical_solution(method.scheme, steps, dt, *start, OMEGA0, beta)
        shape = (-1, 1, 1)
        sampled = {"positions": r[::every].reshape(shape), "velocities": v[::every].reshape(shape)}
        return Run({"time": sample_times(scene, method), **sampled}, diverged=not bool(np.isfinite(r).all()))


def _coefficient(name: str, scheme: str, old: str, new: str) -> tuple[str, Fault]:
    return scheme, scheme_fault(name, old, new, f"one coefficient of {scheme} is off by 1e-3")


COEFFICIENTS = (
    _coefficient(
        "euler-coefficient",
        "euler",
        "return r + dt * v + 0.5 * dt**2 * a, v + dt * a, memory",
        "return r + dt * v + 0.5005 * dt**2 * a, v + dt * a, memory",
    ),
    _coefficient(
        "modified-euler-coefficient",
        "modified_euler",
        "return r + dt * v + 0.5 * dt**2 * a, v, memory",
        "return r + dt * v + 0.5005 * dt**2 * a, v, memory",
    ),
    _coefficient(
        "symplectic-euler-coefficient",
        "symplectic_euler",
        "v = v + dt * accelerate(force, r, v)\n",
        "v = v + 1.001 * dt * accelerate(force, r, v)\n",
    ),
    _coefficient(
        "verlet-coefficient",
        "verlet",
        "r_ahead = 2.0 * r_now - r + dt**2 * a",
        "r_ahead = 2.0 * r_now - r + 1.001 * dt**2 * a",
    ),
    _coefficient("leapfrog-coefficient", "leapfrog", "0.5 * (v_behind + v_ahead)", "0.5005 * (v_behind + v_ahead)"),
    _coefficient(
        "velocity-verlet-coefficient",
        "velocity_verlet",
        "v_half, r = kick_drift(r, v, memory[0], dt)",
        "v_half, r = kick_drift(r, v, 1.001 * memory[0], dt)",
    ),
    _coefficient(
        "beeman-coefficient",
        "beeman",
        "a_new = accelerate(force, r, v)\n        return r, v + dt / 6.0 * (2.0 * a_new + 5.0 * a - a_before)",
        "a_new = accelerate(force, r, v)\n        return r, v + dt / 6.0 * (2.002 * a_new + 5.0 * a - a_before)",
    ),
    _coefficient(
        "beeman-pc-coefficient",
        "beeman_pc",
        "v_predicted = v + 0.5 * dt * (3.0 * a - a_before)",
        "v_predicted = v + 0.5005 * dt * (3.0 * a - a_before)",
    ),
    _coefficient(
        "euler-pc-coefficient",
        "euler_pc",
        "accelerate(force, r + dt * v, v + dt * a)",
        "accelerate(force, r + 1.001 * dt * v, v + dt * a)",
    ),
    _coefficient("gear2-coefficient", "gear2", "(0.0, 1.0, 1.0)", "(0.0, 1.001, 1.0)"),
    _coefficient("gear3-coefficient", "gear3", "(1 / 6, 5 / 6, 1.0, 1 / 3)", "(1 / 6, 5 / 6, 1.0, 1.001 / 3)"),
    _coefficient("gear4-coefficient", "gear4", "_GEAR4_VELOCITY = (19 / 120,", "_GEAR4_VELOCITY = (19.019 / 120,"),
    _coefficient("gear4-velocity-coefficient", "gear4_velocity", "(19 / 90, 3 / 4", "(19 / 90, 3.003 / 4"),
    _coefficient("gear5-coefficient", "gear5", "_GEAR5 = (3 / 20, 251", "_GEAR5 = (3 / 20, 251.251"),
    _coefficient(
        "gear5-velocity-coefficient",
        "gear5_velocity",
        "_GEAR5_VELOCITY = (3 / 16, 251 / 360, 1.0, 11 / 18, 1 / 6, 1 / 60)",
        "_GEAR5_VELOCITY = (3 / 16, 251 / 360, 1.0, 11 / 18, 1 / 6, 1.001 / 60)",
    ),
)

_LANDAU = "Landau & Lifshitz, Mechanics, sections 21 and 25; Allen & Tildesley, Computer Simulation of Liquids (1987)"
_EQUATIONS = {
    "undamped": "m r'' = -k r;  r = r0 cos(omega0 t) + (v0/omega0) sin(omega0 t)",
    "damped": "m r'' = -k r - gamma r';  r = A exp(-gamma t/2m) cos(sqrt(k/m - gamma^2/4m^2) t)",
    "critical": "m r'' = -k r - gamma r', gamma = 2 sqrt(k m);  r = (r0 + (v0 + omega0 r0) t) exp(-omega0 t)",
    "over-damped": "m r'' = -k r - gamma r', gamma = 4 sqrt(k m);  two decaying exponentials",
}
_FAULTS = {
    "undamped": (
        "velocity_verlet",
        scheme_fault(
            "velocity-verlet-misprint",
            "        v_half, r = kick_drift(r, v, memory[0], dt)\n",
            "        v_half, r = kick_drift(r, v, memory[0], dt)\n        r = r + 0.5 * dt * dt * memory[0]\n",
            "dt^2 f/m for dt^2 f/2m in the position: a printed form of velocity Verlet; order 1",
        ),
    ),
    "damped": (
        "gear5_velocity",
        Fault(
            "spring-damping-sign",
            "stepping/forces/spring.py",
            "return -(k / mass) * r - (gamma / mass) * v",
            "return -(k / mass) * r + (gamma / mass) * v",
            "the damping drives the oscillator",
        ),
    ),
    "critical": (
        "beeman_pc",
        scheme_fault(
            "beeman-lagged",
            "a_new = accelerate(force, r, v_predicted)",
            "a_new = accelerate(force, r, v)",
            "the predictor-corrector uses the old velocity: order 1",
        ),
    ),
    "over-damped": (
        "gear5",
        Fault(
            "gear-derivatives",
            "stepping/forces/spring.py",
            "below, last = last, _spring_acceleration(below, last, k, mass, gamma)",
            "below, last = last, _spring_acceleration(last, below, k, mass, gamma)",
            "the analytic start takes r_3 ... from swapped derivatives: order 2",
        ),
    ),
}


def _regime_check(regime: str) -> Check:
    return Check(
        name=f"stepping/oscillator-{regime}",
        title=f"Order of convergence of every scheme on the {regime} harmonic oscillator, against the closed form",
        equation=_EQUATIONS[regime],
        criterion=f"fitted order of the largest error of r and of v = claimed order +- {ORDER_TOLERANCE}: {WHY_ORDER}",
        citation=_LANDAU,
        judge=partial(_judge_order, regime=regime),
        variants=schemes_with(
            lambda name, claims: (claims.order if regime == "undamped" else claims.order_damped) is not None,
            tier_beside_audits(*_QUICK[regime]),
        ),
        faults=(_FAULTS[regime],),
        needs=SPRING if regime == "undamped" else DAMPED,
    )


CHECKS = (
    *map(_regime_check, REGIMES),
    Check(
        name="stepping/oscillator-exact",
        title="200 steps of the damped oscillator against the scheme's exact numerical solution, a power of its matrix",
        equation="(r, v dt)_n = R M^n S (r0, v0 dt); a dt^2 = -(omega0 dt)^2 r - (gamma dt/m) v dt",
        criterion="largest difference <= 800 eps: four roundings a step; its orders are those claimed",
        citation="Gear, Numerical Initial Value Problems in ODEs (1971); Nordsieck, Math. Comp. 16, 22 (1962)",
        judge=_judge_exact,
        variants=schemes_with(lambda name, claims: oscillator.has_matrix(name)),
        faults=COEFFICIENTS,
        needs=DAMPED,
        interpreted=True,
    ),
)
