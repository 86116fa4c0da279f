"""What the checks of lattice gases work out themselves, on signals and occupations whose answer is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crosscheck.checks.lattice.states import NAMES, _away, at_densities, gas_scene, momentum, named_density
from crosscheck.checks.lattice.thesis import CELL, SAMPLES, Box, _cosine, _peak
from crosscheck.checks.lattice.transport import decay_rate, longitudinal, standing_wave, wavenumber
from crosscheck.scene import Occupations, Output
from refimpl.lattice.models import MODELS
from refimpl.lattice.theory import modes

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


@pytest.mark.parametrize("name", NAMES)
def test_long_sound_is_damped_by_the_longitudinal_viscosity(name: str) -> None:
    k = wavenumber(MODELS[name], 4000)
    assert 4000 * MODELS[name].velocities.row_height * k == pytest.approx(2 * math.pi, rel=1e-15)
    for density in (0.2, 0.5):
        damping = modes(MODELS[name], density, (0.0, k)).sound_damping
        assert 2 * damping / k**2 == pytest.approx(longitudinal(name, density), rel=1e-3)


# -- occupations -------------------------------------------------------------------------------------------------------


@given(data=st.data())
def test_occupations_away_from_equilibrium(data: st.DataObject) -> None:
    model = MODELS[data.draw(st.sampled_from(NAMES))]
    f = data.draw(arrays(np.float64, model.channels, elements=st.floats(0.01, 0.99)))
    moved = _away(model, f)
    assert (moved >= 0).all()
    assert (moved <= 1).all()
    charges = np.vstack([np.ones(model.channels), model.velocities.cartesian.T])
    np.testing.assert_allclose(charges @ moved, charges @ f, atol=1e-13)
    # twice as far, one channel is empty or full
    twice = 2 * moved - f
    np.testing.assert_allclose(np.minimum(twice, 1 - twice).min(), 0, atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_momentum_is_in_whole_numbers(name: str) -> None:
    model = MODELS[name]
    counts = np.random.default_rng(1).integers(0, 10, (3, 2, model.channels)).astype(float)
    found = momentum(model, counts)
    np.testing.assert_array_equal(found, np.round(found))
    np.testing.assert_allclose(found * model.velocities.unit, counts @ model.velocities.cartesian, atol=1e-12)


# -- names and scenes --------------------------------------------------------------------------------------------------


def test_names_of_variants() -> None:
    assert at_densities(("hpp", "fhp1"), (0.1, 0.25)) == ("hpp-d0.1", "hpp-d0.25", "fhp1-d0.1", "fhp1-d0.25")
    assert named_density("fhp_saturated_identity-d0.3") == ("fhp_saturated_identity", 0.3)


@given(name=st.sampled_from(NAMES), density=st.integers(1, 99).map(lambda percent: percent / 100))
def test_names_of_variants_are_read_back(name: str, density: float) -> None:
    (variant,) = at_densities((name,), (density,))
    assert named_density(variant) == (name, density)


def test_rows_and_columns_of_a_scene() -> None:
    start = Occupations(kind="occupations", density=0.3, seed=1)
    scene = gas_scene("gas", "hpp", 3, 5, 7, start, Output(), force=0.1)
    assert scene.initial_sites().shape == (3, 5)
    assert (scene.duration, scene.lattice_gas.force) == (7, 0.1)


# -- the thesis --------------------------------------------------------------------------------------------------------


@given(
    peak=st.integers(1, SAMPLES // 2),
    away=st.floats(-0.4, 0.4),
    mean=st.floats(-10, 10),
    more=st.integers(0, 100),
)
def test_peaks_are_those_of_the_nearest_bin(peak: int, away: float, mean: float, more: int) -> None:
    """Bin n is that of n periods in the samples, counted from 0; further samples and the mean are left out."""
    bins = peak if peak in (1, SAMPLES // 2) else peak + away
    times = np.arange(SAMPLES + more)
    signal = mean + np.cos(2 * np.pi * bins * times / SAMPLES)
    signal[SAMPLES:] = 1e3
    assert _peak(signal) == peak


def test_the_largest_of_two_lines_and_other_lengths() -> None:
    times = np.arange(SAMPLES) / SAMPLES
    signal = np.cos(2 * np.pi * 36 * times) + 1.5 * np.sin(2 * np.pi * 12 * times)
    assert _peak(signal) == 12
    assert _peak(signal, SAMPLES // 4) == 3


@pytest.mark.parametrize("number", [1, 2, 3])
def test_projections_on_cosines_between_the_walls(number: int) -> None:
    columns = 305
    x = (np.arange(columns // CELL) + 0.5) * CELL - 0.5
    amplitudes = np.array([[0.1, 0.05], [-0.2, 0.0]])
    strips = amplitudes[..., None] * np.cos(number * math.pi * x / (columns - 1))
    box = Box(np.arange(2.0), strips, columns)
    # cells reach half a site beyond the wall sites
    np.testing.assert_allclose(_cosine(box, number), amplitudes, rtol=0.01, atol=1e-15)
    assert np.abs(_cosine(box, number + 1)).max() < 0.01 * np.abs(amplitudes).max()
