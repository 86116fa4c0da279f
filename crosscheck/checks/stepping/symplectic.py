"""Symplectic and reversible or not: the map of 20 steps of an eccentric orbit, start included."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.springs import LITERATURE
from crosscheck.engines.capabilities import Needs
from crosscheck.references import EPSILON
from crosscheck.scene import Floats, Gravity, Kepler, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, bounded, worst

#: Steps of the map whose Jacobian is taken, and its time step: far from convergence, where a broken structure shows.
MAP_STEPS, MAP_DT = 20, 0.1
#: Step of the differences: truncation and rounding are of one size here.
DIFFERENCE = 1e-4
_NEEDS = Needs("gravity", words=frozenset({"dimension=2"}), observables=frozenset({"positions", "velocities"}))


def _orbit(positions: Floats, velocities: Floats, steps: int) -> Scene:
    return Scene(
        name="orbit-map",
        dimension=2,
        duration=steps * MAP_DT,
        gravity=Gravity(),
        initial=explicit(positions, velocities),
        # only the end is used; with a trajectory, the compiled loop is that of the other orbit checks
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
    quantity = "defect of J^T Omega J = Omega"
    why = "2 x 8 |J| |dJ|, dJ the change of J when its differences are doubled"
    if laboratory.claims[scheme].symplectic:
        # noise of the engine would widen its own bound
        resolved = "a ten-thousandth of the smallest defect of the schemes that are not symplectic, 0.03 of gear5"
        return worst(
            [
                bounded(quantity, defect, uncertain, why),
                bounded("uncertainty of that defect", uncertain, 3e-6, resolved, control=True),
            ]
        )
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
    quantity = "distance from the start after going there and back"
    if laboratory.claims[scheme].reversible:
        return bounded(quantity, error, limit, why)
    return bounded(quantity, error, 100 * limit, f"100 times: {why}", expected_failure=True)


CHECKS = (
    Check(
        name="stepping/symplectic",
        title="Symplectic or not: Jacobian of 20 steps of an eccentric orbit, start included",
        equation="J^T Omega J = Omega",
        criterion="defect <= 16 |J| |dJ| if claimed, dJ the error of the differences; found > 100 times that if denied",
        citation=LITERATURE,
        judge=_judge_symplectic,
        variants=schemes_with(
            lambda name, claims: claims.order is not None and claims.symplectic is not None,
            tier_beside_audits("velocity_verlet", "symplectic_euler", "beeman", "gear2", "gear4"),
        ),
        faults=(
            (
                "velocity_verlet",
                scheme_fault(
                    "velocity-verlet-old-acceleration",
                    "return r, add_to(v_half, 0.5 * dt, a), (a,)",
                    "return r, add_to(v_half, 0.5 * dt, memory[0]), (a,)",
                    "the second half kick takes the old acceleration",
                ),
            ),
            (
                "symplectic_euler",
                scheme_fault(
                    "symplectic-euler-old-velocity",
                    "v = v + dt * accelerate(force, r, v)\n        return r + dt * v, v, memory",
                    "return r + dt * v, v + dt * accelerate(force, r, v), memory",
                    "the position moves with the old velocity: explicit Euler",
                ),
            ),
        ),
        needs=_NEEDS,
        interpreted=True,
    ),
    Check(
        name="stepping/reversible",
        title="Reversible or not: 20 steps of an eccentric orbit there and, velocities turned, back",
        equation="R Phi R Phi = 1, R (r, v) = (r, -v)",
        criterion="distance from the start <= 1e3 eps x 20 if claimed, found > 100 times that if denied",
        citation=LITERATURE,
        judge=_judge_reversible,
        variants=schemes_with(lambda name, claims: claims.order is not None and claims.reversible is not None),
        faults=(
            (
                "verlet",
                scheme_fault(
                    "verlet-start",
                    "r_before = r - dt * v + 0.5 * dt**2 * a",
                    "r_before = r - dt * v",
                    "the step backwards leaves out the acceleration",
                ),
            ),
        ),
        needs=_NEEDS,
        interpreted=True,
    ),
)
