"""Autocorrelations by integrals and by the linear equations of motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm

from crosscheck.references import brownian


def test_brownian_autocorrelation_integrates_to_the_diffusion_coefficient() -> None:
    gamma, temperature, mass = 0.3, 1.7, 25.0
    integral, _ = quad(lambda t: brownian.brownian_autocorrelation(t, gamma, temperature, mass), 0, np.inf)
    assert integral == pytest.approx(temperature / (mass * gamma), rel=1e-9)
    assert brownian.brownian_autocorrelation(0.0, gamma, temperature, mass) == pytest.approx(temperature / mass)


CASES = [(0.05, 894, 6, 3.0, 50.0, 2), (0.02, 1323, 8, 3.0, 50.0, 3)]


@pytest.mark.parametrize("case", CASES)
def test_autocorrelation_of_tracers_starts_with_the_exact_slope(
    case: tuple[float, int, int, float, float, int],
) -> None:
    """-dC/dt(0) = (gamma + gamma_tt (k - 1)/k) T/M whatever the bath's size: momentum is conserved."""
    known = brownian.tracers_in_bath(*case)
    start, soon = known.autocorrelation(np.array([0.0, 1e-6]))
    assert start == pytest.approx(known.variance)
    exact = (known.gamma + known.between * (known.number - 1) / known.number) / known.mass
    # relative modes decay with both rates, the common one with the bath's
    assert (start - soon) / 1e-6 == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("case", CASES)
def test_autocorrelation_of_tracers_by_their_equations_of_motion(
    case: tuple[float, int, int, float, float, int],
) -> None:
    """Every tracer is drawn to the bath's velocity and to that of all tracers; the bath takes up the momentum."""
    known = brownian.tracers_in_bath(*case)
    k, light = known.number, known.number * known.mass * (1 - known.share) / known.share
    matrix = np.zeros((k + 1, k + 1))  # velocities of the tracers, and of the bath
    matrix[:k, :k] = known.between / k - (known.gamma + known.between) * np.eye(k)
    matrix[:k, k] = known.gamma
    matrix[k] = -(known.mass * matrix[:k]).sum(axis=0) / light
    # covariances at total momentum zero, of the tracers and of the bath's mean velocity
    masses = np.array([known.mass] * k + [light])
    start = np.diag(1 / masses) - 1 / masses.sum()
    for time in (0.1, 2.0, 30.0):
        expected = (expm(time * matrix) @ start)[0, 0]
        assert known.autocorrelation(np.array([time]))[0] == pytest.approx(expected, rel=1e-10)


def test_one_tracer_in_an_endless_bath_is_that_of_ornstein_and_uhlenbeck() -> None:
    known = brownian.tracers_in_bath(1e-3, 10**9, 1, 3.0, 50.0, 3)
    time = np.array([0.0, 1.0, 20.0])
    expected = brownian.brownian_autocorrelation(time, known.gamma, 1.0, 50.0)
    assert known.autocorrelation(time) == pytest.approx(expected, rel=1e-6)


def test_returned_share_by_its_three_factors() -> None:
    """Collisions since the encounter, averaged over it (t/2), a third of them back, with half the momentum."""
    rate, time = 0.3, 2.0
    since, _ = quad(lambda t: rate * (time - t) / time, 0, time)
    assert brownian.returned_share(rate, time) == pytest.approx(since / 3 / 2, rel=1e-12)
