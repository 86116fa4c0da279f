"""The recorded states of three bodies against an integrator of another kind, and their invariants."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from crosscheck.references import EPSILON
from crosscheck.references.three_body import (
    FIGURE_EIGHT,
    GREATEST_GRADIENT,
    PYTHAGOREAN,
    RETURN_ERROR,
    ThreeBodies,
    angular_momentum,
    energy,
)


def _right_side(masses: np.ndarray, y: np.ndarray) -> np.ndarray:
    r = y[:6].reshape(3, 2)
    apart = r[None] - r[:, None]
    square = (apart**2).sum(-1) + np.eye(3)
    return np.concatenate([y[6:], (masses[None, :, None] * apart / square[..., None] ** 1.5).sum(1).ravel()])


@pytest.mark.parametrize(("problem", "tolerance"), [(FIGURE_EIGHT, 1e-10), (PYTHAGOREAN, 1e-8)])
def test_recorded_states(problem: ThreeBodies, tolerance: float) -> None:
    masses = np.array(problem.masses)
    start = np.concatenate([problem.positions.ravel(), problem.velocities.ravel()])
    run = solve_ivp(lambda t, y: _right_side(masses, y), (0, problem.time), start, "DOP853", rtol=1e-13, atol=1e-14)
    assert run.y[:6, -1] == pytest.approx(problem.final_positions.ravel(), abs=tolerance)
    assert run.y[6:, -1] == pytest.approx(problem.final_velocities.ravel(), abs=10 * tolerance)


@pytest.mark.parametrize("problem", [FIGURE_EIGHT, PYTHAGOREAN])
def test_invariants(problem: ThreeBodies) -> None:
    masses = np.array(problem.masses)
    states = [(problem.positions, problem.velocities), (problem.final_positions, problem.final_velocities)]
    for r, v in states:
        assert float(energy(masses, r, v)) == pytest.approx(problem.energy, rel=1e-14)
        assert float(angular_momentum(masses, r, v)) == pytest.approx(0.0, abs=2e-14)
    assert (masses[:, None] * problem.final_velocities).sum(0) == pytest.approx(0.0, abs=1e-14)


def test_return_error() -> None:
    distance = np.linalg.norm(FIGURE_EIGHT.final_positions - FIGURE_EIGHT.positions, axis=-1).max()
    assert distance == pytest.approx(RETURN_ERROR, abs=2e-16)


def test_sensitivity_of_the_figure_eight() -> None:
    """Relative errors of the state, carried to the end by the variational equations."""
    problem = FIGURE_EIGHT
    masses = np.array(problem.masses)

    def jacobian(y: np.ndarray) -> np.ndarray:
        out = np.zeros((12, 12))
        out[:6, 6:] = np.eye(6)
        r = y[:6].reshape(3, 2)
        for i in range(3):
            for j in range(3):
                if i != j:
                    d = r[j] - r[i]
                    q = np.linalg.norm(d)
                    block = masses[j] * (np.eye(2) / q**3 - 3 * np.outer(d, d) / q**5)
                    out[6 + 2 * i : 8 + 2 * i, 2 * j : 2 * j + 2] += block
                    out[6 + 2 * i : 8 + 2 * i, 2 * i : 2 * i + 2] -= block
        return out

    def right_side(t: float, z: np.ndarray) -> np.ndarray:
        return np.concatenate([_right_side(masses, z[:12]), (jacobian(z[:12]) @ z[12:].reshape(12, 12)).ravel()])

    start = np.concatenate([problem.positions.ravel(), problem.velocities.ravel(), np.eye(12).ravel()])
    times = np.linspace(0, problem.time, 200)
    run = solve_ivp(right_side, (0, problem.time), start, "DOP853", times, rtol=1e-8, atol=1e-10)
    end = run.y[12:, -1].reshape(12, 12)
    carried = [
        np.linalg.norm((end @ np.linalg.inv(run.y[12:, k].reshape(12, 12))) * run.y[:12, k]) for k in range(times.size)
    ]
    assert np.sqrt(np.mean(np.square(carried))) == pytest.approx(problem.sensitivity, rel=0.02)
    assert max(carried) == pytest.approx(problem.greatest, rel=0.02)


@pytest.mark.parametrize("conserved", [energy, angular_momentum])
def test_gradients_of_what_is_conserved(conserved) -> None:  # type: ignore[no-untyped-def]
    masses, state = np.array(FIGURE_EIGHT.masses), np.array([FIGURE_EIGHT.positions, FIGURE_EIGHT.velocities])
    gradient = np.zeros(12)
    for k in range(12):
        step = np.zeros(12)
        step[k] = 1e-6
        after, before = (conserved(masses, *(state + sign * step.reshape(2, 3, 2))) for sign in (1, -1))
        gradient[k] = (after - before) / 2e-6
    assert np.linalg.norm(gradient) == pytest.approx(2.35 if conserved is energy else 2.11, abs=0.01)
    assert np.linalg.norm(gradient) < GREATEST_GRADIENT


@pytest.mark.parametrize(("even", "size"), [(True, 30.3), (False, 46.1)])
def test_rounding_error_is_the_spread_of_a_sum_of_roundings(even: bool, size: float) -> None:
    """Roundings are uniform over one unit: a sum of them, carried with one gain, by drawing them."""
    steps = 400
    draws = np.random.default_rng(3).uniform(-0.5, 0.5, (4000, steps)).sum(axis=1) * EPSILON * size
    assert FIGURE_EIGHT.rounding_error(steps, even) == pytest.approx(draws.std(), rel=0.05)
