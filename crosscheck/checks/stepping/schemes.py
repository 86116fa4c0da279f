"""What each scheme claims besides its order: stability limit, symplectic or not, reversible or not, energy drift."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Laboratory, legacy_check, legacy_schemes_with
from crosscheck.checks.stepping.oscillator import has_matrix
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON, oscillator
from crosscheck.scene import Explicit, Floats, Gravity, Kepler, Method, Output, Scene, Spring, explicit
from crosscheck.verdict import Judged, bounded, within

_SCHEMES_FILE = "stepping/schemes.py"


# -- stability ----------------------------------------------------------------------------------------

#: Steps of a stability run, and the growth per step that counts as unstable where no step is stable for ever.
STEPS, PRACTICAL = 10_000, 1.01


def _unit_oscillator(duration: float, interval: float | None = None) -> Scene:
    """omega0 = 1 from a general phase."""
    return Scene(
        name="oscillator-unit",
        dimension=1,
        duration=duration,
        spring=Spring(k=1.0),
        initial=Explicit(positions=((1.0,),), velocities=((0.7,),)),
        output=Output() if interval is None else Output(interval=interval, trajectory=True),
    )


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
        run = laboratory.run(_unit_oscillator(STEPS * middle, half * middle), Method(scheme=scheme, dt=middle))
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


# -- symplectic and reversible ------------------------------------------------------------------------

#: Steps of the map whose Jacobian is taken, and its time step: far from convergence, where a broken structure shows.
MAP_STEPS, MAP_DT = 20, 0.1
#: Step of the differences: truncation and rounding are of one size here.
DIFFERENCE = 1e-4


def _orbit(positions: Floats, velocities: Floats, steps: int) -> Scene:
    return Scene(
        name="orbit-map",
        dimension=2,
        duration=steps * MAP_DT,
        gravity=Gravity(),
        initial=explicit(positions, velocities),
        # the end alone is looked at; with a trajectory, the compiled loop is that of the other orbit checks
        output=Output(interval=steps * MAP_DT, trajectory=True),
    )


def _start() -> tuple[Floats, Floats]:
    initial = Kepler(kind="kepler", eccentricity=0.5)
    state = Scene(name="orbit", dimension=2, duration=0.0, gravity=Gravity(), initial=initial).initial_state()
    # turned by a general angle, so that no component vanishes
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    return state.positions @ turn.T, state.velocities @ turn.T


def _mapped(laboratory: Laboratory, scheme: str, state: Floats) -> Floats:
    r, v = state[:4].reshape(2, 2), state[4:].reshape(2, 2)
    run = laboratory.run(_orbit(r, v, MAP_STEPS), Method(scheme=scheme, dt=MAP_DT))
    return np.concatenate([run["final_positions"].ravel(), run["final_velocities"].ravel()])


def _judge_symplectic(laboratory: Laboratory, scheme: str) -> Judged:
    """|| J^T Omega J - Omega || of the map from the first to the last (r, v), J by fourth-order differences."""
    state = np.concatenate([part.ravel() for part in _start()])
    jacobians = [np.empty((8, 8)), np.empty((8, 8))]
    for k in range(8):
        unit = np.zeros(8)
        unit[k] = DIFFERENCE
        end = {factor: _mapped(laboratory, scheme, state + factor * unit) for factor in (-4, -2, -1, 1, 2, 4)}
        for jacobian, m in zip(jacobians, (1, 2), strict=True):
            difference = 8 * (end[m] - end[-m]) - (end[2 * m] - end[-2 * m])
            jacobian[:, k] = difference / (12 * m * DIFFERENCE)
    fine, coarse = jacobians
    omega = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.eye(4), np.zeros((4, 4))]])
    defect = float(np.abs(fine.T @ omega @ fine - omega).max())
    uncertain = 2 * 8 * float(np.abs(fine).max() * np.abs(fine - coarse).max())
    quantity, why = (
        "defect of J^T Omega J = Omega",
        "2 x 8 |J| |dJ|, dJ the change of J when its differences are doubled",
    )
    if laboratory.claims[scheme].symplectic:
        return bounded(quantity, defect, uncertain, why)
    return bounded(quantity, defect, 100 * uncertain, f"100 times {why}", expected_failure=True)


def _judge_reversible(laboratory: Laboratory, scheme: str) -> Judged:
    """Forward, velocities turned, forward again with the scheme's own start: how far from the initial state."""
    r, v = _start()
    there = laboratory.run(_orbit(r, v, MAP_STEPS), Method(scheme=scheme, dt=MAP_DT))
    back = laboratory.run(
        _orbit(there["final_positions"], -there["final_velocities"], MAP_STEPS), Method(scheme=scheme, dt=MAP_DT)
    )
    error = float(max(abs(back["final_positions"] - r).max(), abs(back["final_velocities"] + v).max()))
    # rounding grows with the sensitivity of the orbit, some 10 per passage of the pericentre
    limit = 1e3 * EPSILON * MAP_STEPS
    why = f"a few roundings in each of 2 x {MAP_STEPS} steps, times the orbit's sensitivity of about 100"
    if laboratory.claims[scheme].reversible:
        return bounded("distance from the start after going there and back", error, limit, why)
    quantity = "distance from the start after going there and back"
    return bounded(quantity, error, 100 * limit, f"100 times: {why}", expected_failure=True)


# -- energy drift -------------------------------------------------------------------------------------

PERIODS = 100_000
DRIFT_H = 2 * np.pi / 50


def _judge_drift(laboratory: Laboratory, scheme: str) -> Judged:
    """Growth of the energy per radian at 50 steps a period, against twice the eigenvalues' growth of the amplitude."""
    rate = 2 * oscillator.growth_rate(scheme, float(DRIFT_H)) / DRIFT_H
    rate = float(rate) if abs(rate) > 4 * EPSILON / DRIFT_H else 0.0
    # as long as 1e5 periods, but no longer than the energy takes to change by a factor e^200
    steps = 50 * (PERIODS if rate == 0.0 else min(PERIODS, int(200 / abs(rate) / (2 * np.pi))))
    chunk = steps // 50
    scene = _unit_oscillator(steps * DRIFT_H, chunk * DRIFT_H)
    run = laboratory.run(scene, Method(scheme=scheme, dt=float(DRIFT_H)))
    energy = _energies(run["positions"][:, 0, 0], run["velocities"][:, 0, 0])
    slope, scatter = _slope(run["time"][1:], np.log(energy[1:]))
    # the phase at which the energy is looked at creeps round: over the run, that moves it by its swing in a period
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


def _fault(name: str, old: str, new: str, breaks: str) -> Fault:
    return Fault(name, "stepping/schemes.py", old, new, breaks)


_LITERATURE = (
    "Allen & Tildesley, Computer Simulation of Liquids (1987), chapter 3 and appendix E; "
    "Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), chapters I, V and VI"
)

CHECKS = (
    legacy_check(
        name="stepping/stability-limit",
        title="Largest stable step on the undamped oscillator, by bisection, against the step matrix's eigenvalues",
        equation="largest |eigenvalue of M(omega0 dt)| = 1; where that holds for no step, = 1.01",
        criterion=f"twice the distance from the limit at which {STEPS} steps show it",
        citation=_LITERATURE,
        judge=_judge_limit,
        variants=legacy_schemes_with(has_matrix),
        faults=(
            (
                "euler_pc",
                _fault(
                    "euler-pc-first-order-prediction",
                    "v_new = v + dt * accelerate(force, r + dt * v, v + dt * a)",
                    "v_new = v + dt * accelerate(force, r + 0.5 * dt * v, v + dt * a)",
                    "the prediction goes half a step only",
                ),
            ),
            (
                "gear4",
                _fault(
                    "gear4-table",
                    "_GEAR4, _GEAR4_VELOCITY = (19 / 120,",
                    "_GEAR4, _GEAR4_VELOCITY = (19 / 90,",
                    "the corrector for f(r) takes its first coefficient from the table for f(r, v)",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
    ),
    legacy_check(
        name="stepping/symplectic",
        title="Symplectic or not: Jacobian of 20 steps of an eccentric orbit, start included",
        equation="J^T Omega J = Omega",
        criterion="defect <= 16 |J| |dJ| if claimed, dJ the error of the differences; found > 100 times that if denied",
        citation=_LITERATURE,
        judge=_judge_symplectic,
        variants=legacy_schemes_with(lambda name, claims: claims.order is not None and claims.symplectic is not None),
        faults=(
            (
                "velocity_verlet",
                _fault(
                    "velocity-verlet-old-acceleration",
                    "return r, v_half + 0.5 * dt * a, (a,)",
                    "return r, v_half + 0.5 * dt * memory[0], (a,)",
                    "the second half kick takes the old acceleration",
                ),
            ),
            (
                "symplectic_euler",
                _fault(
                    "symplectic-euler-old-velocity",
                    "v = v + dt * accelerate(force, r, v)\n        return r + dt * v, v, memory",
                    "return r + dt * v, v + dt * accelerate(force, r, v), memory",
                    "the position moves with the old velocity: explicit Euler",
                ),
            ),
        ),
        engines=("refimpl", "lammps", "rebound"),
    ),
    legacy_check(
        name="stepping/reversible",
        title="Reversible or not: 20 steps of an eccentric orbit there and, velocities turned, back",
        equation="R Phi R Phi = 1, R (r, v) = (r, -v)",
        criterion="distance from the start <= 1e3 eps x 20 if claimed, found > 100 times that if denied",
        citation=_LITERATURE,
        judge=_judge_reversible,
        variants=legacy_schemes_with(lambda name, claims: claims.order is not None and claims.reversible is not None),
        faults=(
            (
                "verlet",
                _fault(
                    "verlet-start",
                    "r_before = r - dt * v + 0.5 * dt**2 * a",
                    "r_before = r - dt * v",
                    "the step backwards leaves out the acceleration",
                ),
            ),
        ),
        engines=("refimpl", "lammps", "rebound"),
    ),
    legacy_check(
        name="stepping/energy-drift",
        title="Growth of the energy over 1e5 periods, 50 steps each: none for symplectic schemes, theory's for others",
        equation="d ln E/d(omega0 t) = 2 ln(largest |eigenvalue|)/(omega0 dt)",
        criterion="four standard errors of the slope + swing of ln E within a period/duration + four roundings a step",
        citation=_LITERATURE,
        judge=_judge_drift,
        variants=legacy_schemes_with(has_matrix),
        faults=(
            (
                "velocity_verlet",
                _fault(
                    "velocity-verlet-drift",
                    "v_half = v + 0.5 * dt * memory[0]",
                    "v_half = (1.0 - 1e-7) * v + 0.5 * dt * memory[0]",
                    "the velocity loses 1e-7 of itself every step",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
        tier="full",
    ),
)
