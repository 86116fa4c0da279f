"""Each formula by another road: quadrature, exact limits, small Monte Carlo, and independent simulations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from crosscheck.references import hard_spheres as hs

#: Standard errors allowed to a seeded Monte Carlo mean: fixed by the seed, once in 10^5 by chance otherwise.
SIGMAS = 4.5
both = pytest.mark.parametrize("dimension", [2, 3])


def mean_within(samples: np.ndarray, expected: float) -> None:
    error = samples.std(ddof=1) / samples.size**0.5
    assert abs(samples.mean() - expected) < SIGMAS * error


# -- equations of state --------------------------------------------------------------------------------


@both
@given(eta=st.floats(0, 0.6))
def test_packing_fraction_and_density_are_inverse(dimension: int, eta: float) -> None:
    assert hs.packing_fraction(hs.number_density(eta, dimension, 1.3), dimension, 1.3) == pytest.approx(eta, rel=1e-14)


def test_dimension_must_be_2_or_3() -> None:
    with pytest.raises(ValueError, match="dimension must be 2 or 3"):
        hs.pade(0.1, 1)


def test_fourth_virial_coefficients_are_the_exact_ones() -> None:
    assert hs.VIRIAL_RATIOS[2][2] == pytest.approx(0.7820044, abs=5e-8)
    assert hs.VIRIAL_RATIOS[2][3] == pytest.approx(0.53223180, abs=1e-8)  # truncated
    exact = (2707 * math.pi + 438 * 2**0.5 - 4131 * math.acos(1 / 3)) / (70 * math.pi) / 64
    assert hs.VIRIAL_RATIOS[3][3] == pytest.approx(exact, abs=5e-8)


def test_third_virial_coefficient_of_disks_by_monte_carlo() -> None:
    """B_3 = -(1/3) int f12 f13 f23 = (pi^2/3) times the chance that two points in a disk are within a radius."""
    rng = np.random.default_rng(6)
    r, angle = rng.random((2, 400000)) ** 0.5, rng.uniform(0, 2 * np.pi, (2, 400000))
    x, y = r * np.cos(angle), r * np.sin(angle)
    near = (np.diff(x, axis=0)[0] ** 2 + np.diff(y, axis=0)[0] ** 2 < 1).astype(float)
    mean_within(4 / 3 * near, hs.VIRIAL_RATIOS[2][2])


@both
@pytest.mark.parametrize("numerator", [3, 4, 5])
def test_pade_has_the_virial_series(dimension: int, numerator: int) -> None:
    """Its expansion, from values at Chebyshev nodes around 0; the next coefficient is of the size of the last."""
    radius, count = 0.1, 32
    b = hs.virial_coefficients(dimension)
    nodes = radius * np.cos(np.pi * (np.arange(count) + 0.5) / count)
    values = [hs.pade(x, dimension, numerator) for x in nodes]
    fit = np.polynomial.chebyshev.Chebyshev.fit(nodes, values, 18, domain=[-radius, radius]).convert(
        kind=np.polynomial.Polynomial
    )
    assert abs(np.array(values) - np.polynomial.polynomial.polyval(nodes, b)).max() < 20 * b[-1] * radius**10
    np.testing.assert_allclose(fit.coef[:6], b[:6], rtol=1e-6)


@pytest.mark.parametrize(
    ("eta", "pade", "luding", "henderson"),
    [
        (0.05, 1.108388, 1.108379, 1.108380),
        (0.1, 1.236144, 1.236109, 1.236111),
        (0.2, 1.570366, 1.570251, 1.570312),
        (0.3, 2.063260, 2.063248, 2.063776),
        (0.4, 2.82932, 2.83025, 2.83333),
        (0.5, 4.1062, 4.1094, 4.1250),
        (0.6, 6.456, 6.452, 6.531),
        (0.65, 8.445, 8.409, 8.594),
    ],
)
def test_disk_equations_of_state_at_known_points(eta: float, pade: float, luding: float, henderson: float) -> None:
    digits = 1e-6 if eta < 0.35 else 6e-6 if eta < 0.45 else 6e-5 if eta < 0.55 else 6e-4
    assert hs.pade(eta, 2) == pytest.approx(pade, abs=digits)
    assert hs.luding_fluid(eta) == pytest.approx(luding, abs=digits)
    assert hs.henderson(eta) == pytest.approx(henderson, abs=digits)
    best = hs.disk_compressibility(eta)
    assert abs(best.value - pade) < best.doubt + digits
    assert abs(best.value - luding) < best.doubt + digits


@given(eta=st.floats(0, 0.65))
def test_henderson_s_contact_value(eta: float) -> None:
    assert hs.henderson(eta) == pytest.approx(1 + 2 * eta * (1 - 7 * eta / 16) / (1 - eta) ** 2, rel=1e-13)


@given(eta=st.floats(0, 0.52))
def test_carnahan_starling_s_contact_value(eta: float) -> None:
    assert hs.carnahan_starling(eta) == pytest.approx(1 + 4 * eta * (1 - eta / 2) / (1 - eta) ** 3, rel=1e-13)


def test_luding_global_joins_the_fluid_to_free_volume() -> None:
    assert hs.luding_global(0.5) == pytest.approx(hs.luding_fluid(0.5), rel=1e-7)
    densest = math.pi / (2 * 3**0.5)
    alpha = 1e-3
    # Alder, Hoover and Young (1968): Z = 2/alpha + 1.90(1) + O(alpha); Luding's constant is 1.927
    assert hs.luding_global(densest / (1 + alpha)) - 2 / alpha == pytest.approx(1.90, abs=0.03)
    with pytest.raises(ValueError, match="close packing"):
        hs.luding_global(0.91)


def test_fluids_end() -> None:
    with pytest.raises(ValueError, match=r"0 to 0\.65"):
        hs.disk_compressibility(0.66)
    with pytest.raises(ValueError, match=r"0 to 0\.9"):
        hs.sphere_compressibility(0.5)


def test_spheres_of_nist_follow_the_virial_series_once_n_is_finite() -> None:
    """The raw table is low by 1/N when dilute; corrected for N, it is the Pade approximant's to 2e-5 for n <= 0.6."""
    n, z = hs.nist_compressibilities()
    series = np.array([hs.pade(hs.packing_fraction(x, 3), 3, 5) for x in n])
    assert abs(z / series - 1)[:6].max() < 2.5e-5
    assert abs(z / series - 1)[:8].max() < 1e-4
    raw = np.array([p / x for x, p in hs.NIST_PRESSURES])
    assert raw[0] / series[0] - 1 == pytest.approx(-2.4e-4, abs=1e-5)


@given(density=st.floats(0.0, 0.9))
def test_sphere_compressibility_is_within_its_uncertainty_of_the_series(density: float) -> None:
    eta = hs.packing_fraction(density, 3)
    z = hs.sphere_compressibility(eta)
    assert z.doubt == pytest.approx(5e-4 * z.value)
    assert abs(z.value - hs.pade(eta, 3, 5)) < z.doubt
    # known deviation of Carnahan and Starling: low, by 0.28 % at most
    assert -1e-5 < z.value / hs.carnahan_starling(eta) - 1 < 3.3e-3


@both
def test_contact_value_and_collision_rate(dimension: int) -> None:
    """Rate = flux through the sphere of contact: n g S sigma^(d-1) <u_+>, u normal, of variance 2T/m, by quadrature."""
    eta, temperature, mass, sigma = 0.2, 1.7, 0.6, 1.4
    variance = 2 * temperature / mass
    flux, _ = quad(lambda u: u * np.exp(-(u**2) / (2 * variance)) / (2 * np.pi * variance) ** 0.5, 0, np.inf)
    surface = 2 * np.pi * sigma if dimension == 2 else 4 * np.pi * sigma**2
    g = hs.contact_value(eta, dimension)
    expected = hs.number_density(eta, dimension, sigma) * g.value * surface * flux
    rate = hs.collision_rate(eta, dimension, temperature, mass, sigma)
    assert rate.value == pytest.approx(expected, rel=1e-9)
    assert rate.doubt / rate.value == pytest.approx(g.doubt / g.value)
    assert hs.contact_value(0.0, dimension) == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(("eta", "rate"), [(0.1, 0.5328), (0.3, 2.3995), (0.5, 7.0171), (0.6, 12.304)])
def test_rates_of_disks_at_known_points(eta: float, rate: float) -> None:
    best = hs.collision_rate(eta, 2)
    assert abs(best.value - rate) < best.doubt + 5e-5 * rate


# -- few particles --------------------------------------------------------------------------------------


@both
def test_number_correction_has_the_exact_virial_series_of_n_particles(dimension: int) -> None:
    """Z_N = 1 + (1 - 1/N) B2 n + ((1-1/N)(1-2/N) B3 + 2 (1-1/N)/N B2^2) n^2 + ...; to order 1/N."""
    number = 1000
    b = hs.virial_coefficients(dimension)
    for eta in (0.002, 0.004):
        exact = (b[1] * eta + (3 * b[2] - 2 * b[1] ** 2) * eta**2) / number
        found = hs.compressibility(eta, dimension).value - hs.finite_compressibility(eta, number, dimension).value
        # the next order in density
        assert found == pytest.approx(exact, rel=(3 * b[1] * eta) ** 2 + 1e-6)


#: N, eta, Z and rate at T = 2K/(2(N-1)) with their errors: own event-driven runs of disks, eight of 4e5 collisions.
FEW_DISKS = [
    (16, 0.3, 2.01512, 0.00032, 2.30914, 0.00048),
    (16, 0.5, 4.0108, 0.0023, 6.8512, 0.0048),
    (8, 0.3, 1.96623, 0.00028, 2.21963, 0.00075),
    (8, 0.1, 1.20914, 0.00015, 0.48060, 0.00034),
]


@pytest.mark.parametrize(("number", "eta", "z", "z_error", "rate", "rate_error"), FEW_DISKS)
def test_few_disks(number: int, eta: float, z: float, z_error: float, rate: float, rate_error: float) -> None:
    for found, value, error in (
        (hs.finite_compressibility(eta, number, 2), z, z_error),
        (hs.finite_collision_rate(eta, number, 2), rate, rate_error),
    ):
        assert abs(found.value - value) < found.doubt + 2 * error
        # without the correction the deviation would be many times that
    assert hs.compressibility(eta, 2).value - z > 20 * z_error


def test_no_collisions_without_density() -> None:
    assert hs.finite_collision_rate(0.0, 10, 2).value == 0
    assert hs.finite_compressibility(0.0, 10, 3).value == 1


@both
def test_rate_and_pressure_of_few_particles_agree(dimension: int) -> None:
    """The excess from `finite_collision_rate` is that of `finite_compressibility`: they are computed apart."""
    eta, number = 0.2, 12
    rate = hs.finite_collision_rate(eta, number, dimension).value
    expected = hs.finite_compressibility(eta, number, dimension).value - 1
    assert hs.excess_from_rate(np.array([rate, 2 * rate]), number, dimension) == pytest.approx(
        [expected, 2 * expected], rel=1e-12
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_smooth_compressibility_is_within_a_few_per_mille_of_the_fluid(dimension: int) -> None:
    for eta in np.linspace(0.01, 0.45, 12):
        known = hs.compressibility(eta, dimension)
        assert hs.smooth_compressibility(eta, dimension) == pytest.approx(known.value, rel=4e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_number_correction_is_that_of_the_pressure_s_derivatives(dimension: int) -> None:
    """(eta/2N) d(ln P')/d eta, from a polynomial through P = eta Z in place of differences."""
    eta, number = 0.3, 50
    nodes = eta + 0.1 * np.cos(np.pi * (np.arange(12) + 0.5) / 12)
    pressure = np.polynomial.Chebyshev.fit(nodes, [x * hs.smooth_compressibility(x, dimension) for x in nodes], 11)
    curvature, slope = pressure.deriv(2)(eta), pressure.deriv(1)(eta)
    expected = eta / (2 * number) * curvature / slope
    assert hs.number_correction(eta, number, dimension) == pytest.approx(expected, rel=2e-5)
