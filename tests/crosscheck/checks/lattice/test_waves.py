"""Fits of decays and waves, on signals whose answer is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.lattice.waves import (
    Signals,
    amplitude_at_start,
    decay_rate,
    standing_wave,
    wavenumber,
)
from crosscheck.references.lattice_models import MODELS, VELOCITIES

#: Runs of noise, whose mean is compared with its standard error; 5.5 of them by chance once in 3e7.
MEMBERS, LIMIT = 64, 5.5


def assert_unbiased(found: list[float], expected: float, smallest: float) -> None:
    """The mean is right within its standard error, which is below `smallest`."""
    error = float(np.std(found, ddof=1)) / len(found) ** 0.5
    assert error < smallest
    assert abs(np.mean(found) - expected) < LIMIT * error


# -- decays and waves --------------------------------------------------------------------------------------------------


@given(
    amplitude=st.floats(0.1, 10) | st.floats(-10, -0.1),
    alpha=st.floats(1e-3, 0.02),
    guess=st.floats(0.7, 1.5),
)
def test_rate_of_a_pure_decay(amplitude: float, alpha: float, guess: float) -> None:
    times = np.arange(0.0, 151.0, 5.0)
    signal = amplitude * np.exp(-alpha * times) + 3j  # what is out of phase does not count
    signal[0] *= 1.3  # still relaxing
    assert decay_rate(times, signal, guess * alpha) == pytest.approx(alpha, rel=1e-5)


def test_rate_of_a_decay_with_noise() -> None:
    rng, times, alpha = np.random.default_rng(1), np.arange(0.0, 301.0, 5.0), 5e-3
    clean = 0.1 * np.exp(-alpha * times)
    found = [decay_rate(times, clean + rng.normal(0, 2e-3, times.size), 1.2 * alpha) for _ in range(MEMBERS)]
    assert_unbiased(found, alpha, 0.01 * alpha)


@pytest.mark.filterwarnings("ignore:Covariance")  # none is left to estimate where the fit is perfect
@given(
    amplitude=st.floats(0.1, 10) | st.floats(-10, -0.1),
    alpha=st.floats(1e-5, 2e-3),
    omega=st.floats(0.01, 0.05),
    phi=st.floats(-0.5, 0.5),
    off=st.floats(0.97, 1.03),
)
def test_damping_and_frequency_of_a_pure_wave(
    amplitude: float, alpha: float, omega: float, phi: float, off: float
) -> None:
    times = np.arange(0.0, 1001.0, 4.0)
    signal = amplitude * np.exp(-alpha * times) * np.cos(omega * times + phi) + 3j
    found = standing_wave(times, signal, alpha * off + 1e-5, omega * off)
    assert found == pytest.approx((alpha, omega), rel=1e-5, abs=1e-8)


def test_damping_and_frequency_of_a_wave_with_noise() -> None:
    rng, times, alpha, omega = np.random.default_rng(2), np.arange(0.0, 2001.0, 8.0), 1e-3, 0.02
    clean = 0.1 * np.exp(-alpha * times) * np.cos(omega * times)
    found = [
        standing_wave(times, clean + rng.normal(0, 5e-3, times.size), 1.2 * alpha, 1.01 * omega) for _ in range(MEMBERS)
    ]
    assert_unbiased([damping for damping, _ in found], alpha, 0.01 * alpha)
    assert_unbiased([frequency for _, frequency in found], omega, 1e-3 * omega)


@pytest.mark.parametrize("name", MODELS)
def test_wavenumber_of_rows(name: str) -> None:
    k = wavenumber(name, 4000)
    assert 4000 * VELOCITIES[name].row_height * k == pytest.approx(2 * math.pi, rel=1e-15)


def test_the_amplitude_at_the_start_is_judged() -> None:
    values = np.random.default_rng(4).normal(0.3, 0.003, (16, 3)) + 1j
    right, wrong = (amplitude_at_start(Signals(np.arange(3.0), values), asked, "wave") for asked in (0.3, 0.29))
    assert (right.outcome, wrong.outcome) == ("pass", "fail")
