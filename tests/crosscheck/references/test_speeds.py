"""Moments by quadrature, few particles by sampling, the start of the relaxation by one collision."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import kstest

from crosscheck.references import hard_spheres as hs
from crosscheck.references import speeds

#: Standard errors allowed to a seeded Monte Carlo mean: fixed by the seed, once in 10^5 by chance otherwise.
SIGMAS = 4.5
both = pytest.mark.parametrize("dimension", [2, 3])


def mean_within(samples: np.ndarray, expected: float) -> None:
    error = samples.std(ddof=1) / samples.size**0.5
    assert abs(samples.mean() - expected) < SIGMAS * error


@both
@given(temperature=st.floats(0.1, 10), mass=st.floats(0.1, 10))
def test_maxwell_moments_by_quadrature(dimension: int, temperature: float, mass: float) -> None:
    top = 12 * (temperature / mass) ** 0.5

    def moment(power: int) -> float:
        return quad(
            lambda v: v**power * speeds.maxwell_density(v, dimension, temperature, mass), 0, top, epsabs=0, epsrel=1e-11
        )[0]

    assert moment(0) == pytest.approx(1, rel=1e-9)
    assert moment(1) == pytest.approx(speeds.maxwell_mean_speed(dimension, temperature, mass), rel=1e-9)
    assert moment(2) == pytest.approx(dimension * temperature / mass, rel=1e-9)
    assert moment(4) / moment(2) ** 2 == pytest.approx(speeds.moment_ratio(dimension), rel=1e-9)


@both
def test_cumulative_is_the_integral_of_the_density(dimension: int) -> None:
    for v in (0.0, 0.3, 1.0, 2.5):
        integral, _ = quad(lambda x: speeds.maxwell_density(x, dimension, 1.3, 0.7), 0, v)
        assert speeds.maxwell_cumulative(v, dimension, 1.3, 0.7) == pytest.approx(integral, abs=1e-12)
    assert speeds.maxwell_cumulative(-1.0, dimension) == 0


def test_the_first_exercise_s_law_is_maxwell_s_in_two_dimensions() -> None:
    v, v0 = np.linspace(0, 4, 9), 1.7
    temperature = speeds.mono_speed_temperature(v0, 2)
    np.testing.assert_allclose(
        speeds.maxwell_density(v, 2, temperature), 2 * v / v0**2 * np.exp(-((v / v0) ** 2)), rtol=1e-14
    )
    assert speeds.maxwell_mean_speed(2, temperature) == pytest.approx(v0 * math.pi**0.5 / 2, rel=1e-14)


@both
@pytest.mark.parametrize("momentum_conserved", [False, True])
def test_few_particles_at_constant_energy(dimension: int, momentum_conserved: bool) -> None:
    number, rng = 5, np.random.default_rng(3)
    v = rng.standard_normal((40000, number, dimension))
    if momentum_conserved:
        v -= v.mean(axis=1, keepdims=True)
    square = (v**2).sum(axis=2)
    ratio = (square**2).mean(axis=1) / square.mean(axis=1) ** 2
    freedoms = hs.degrees_of_freedom(number, dimension, momentum_conserved)
    mean_within(ratio, speeds.moment_ratio(dimension, freedoms))
    # the speed of a pair at the temperature 2K/f: mean over that of the Maxwellian
    scaled = np.linalg.norm(v[:, 0] - v[:, 1], axis=1) / (square.sum(axis=1) / freedoms) ** 0.5
    if momentum_conserved:
        mean_within(scaled, speeds.maxwell_mean_speed(dimension, 2.0) * hs.finite_speed_factor(freedoms))


@both
def test_fluctuation_of_the_moment_ratio(dimension: int) -> None:
    number, rng = 2000, np.random.default_rng(4)
    square = (rng.standard_normal((2000, number, dimension)) ** 2).sum(axis=2)
    ratio = (square**2).mean(axis=1) / square.mean(axis=1) ** 2
    # relative error of a standard deviation from 2000 samples, 1/sqrt(4000), and terms of order 1/N
    assert ratio.std() == pytest.approx(
        speeds.moment_ratio_fluctuation(number, dimension), rel=SIGMAS / 4000**0.5 + 0.01
    )


@both
def test_relaxation_starts_with_the_rate_of_one_speed(dimension: int) -> None:
    """The first collision among particles of speed 1: mean change of v_1^4 + v_2^4, weighted with the approach."""
    rng = np.random.default_rng(5)
    one, two, normal = rng.standard_normal((3, 400000, dimension))
    one, two, normal = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (one, two, normal))
    approach = ((one - two) * normal).sum(axis=1)
    weight = np.maximum(approach, 0)
    after = [one - approach[:, None] * normal, two + approach[:, None] * normal]
    change = sum((x**2).sum(axis=1) ** 2 for x in after) - 2
    expected = (weight * change).mean() / weight.mean()
    error = (weight * (change - expected)).std() / change.size**0.5 / weight.mean()
    rows = speeds.MONO_SPEED[dimension]
    # two rows give the slope at the start to second order; third order is C^2/3 of a curve of rate about 1
    slope = 2 * (rows[0].moment_ratio - 1) / 0.05 - (rows[1].moment_ratio - 1) / 0.1
    third = 0.05 * 0.1 / 3
    table = math.hypot(2 * rows[0].standard_error / 0.05, rows[1].standard_error / 0.1)
    assert abs(slope - expected) < SIGMAS * math.hypot(error, table) + third


def test_relaxation_of_disks_is_that_of_an_earlier_simulation() -> None:
    """One run of 1e6 particles: its own scatter is 2/sqrt(N) at most."""
    earlier = (1.028, 1.056, 1.137, 1.261, 1.471, 1.630, 1.746, 1.887, 1.982, 2.003)
    for row, value in zip(speeds.MONO_SPEED[2], earlier, strict=True):
        assert row.moment_ratio == pytest.approx(value, abs=SIGMAS * math.hypot(2e-3, row.standard_error) / 2 + 5e-4)


@both
def test_relaxation_of_one_run(dimension: int) -> None:
    exact = speeds.mono_speed_moment_ratio(1.0, math.inf, dimension)
    row = speeds.MONO_SPEED[dimension][4]
    assert exact == (row.moment_ratio, row.standard_error, 0.0)
    assert speeds.mono_speed_moment_ratio(1.0, 400, 2).uncertainty == pytest.approx(0.1, rel=1e-4)
    with pytest.raises(ValueError, match=r"no value after 0\.7"):
        speeds.mono_speed_moment_ratio(0.7, 400, dimension)


@both
def test_the_share_of_a_particle_is_that_of_few_components_of_a_point_on_a_sphere(dimension: int) -> None:
    freedoms, rng = 12, np.random.default_rng(5)
    x = rng.standard_normal((20000, freedoms)) ** 2
    share = x[:, :dimension].sum(axis=1) / x.sum(axis=1)
    law = speeds.share_distribution(dimension, freedoms)
    mean_within(share, law.mean())
    mean_within(share**2, law.moment(2))
    assert kstest(share, law.cdf).pvalue > 1e-3
    # its moments are those of the speeds, and of many particles its law is Maxwell's
    assert law.moment(2) / law.mean() ** 2 == pytest.approx(speeds.moment_ratio(dimension, freedoms), rel=1e-12)
    many = speeds.share_distribution(dimension, 1e9)
    assert many.cdf(1.7 / 1e9) == pytest.approx(float(speeds.maxwell_cumulative(1.7**0.5, dimension)), rel=1e-6)
