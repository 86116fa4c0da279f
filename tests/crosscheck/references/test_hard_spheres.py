"""Each formula by another road: quadrature, exact limits, small Monte Carlo, and independent simulations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import eval_genlaguerre

from crosscheck.references import hard_spheres as hs

#: Standard errors allowed to a seeded Monte Carlo mean: fixed by the seed, once in 10^5 by chance otherwise.
SIGMAS = 4.5
both = pytest.mark.parametrize("dimension", [2, 3])


def mean_within(samples: np.ndarray, expected: float) -> None:
    error = samples.std(ddof=1) / samples.size**0.5
    assert abs(samples.mean() - expected) < SIGMAS * error


# -- speeds --------------------------------------------------------------------------------------------


@both
@given(temperature=st.floats(0.1, 10), mass=st.floats(0.1, 10))
def test_maxwell_moments_by_quadrature(dimension: int, temperature: float, mass: float) -> None:
    top = 12 * (temperature / mass) ** 0.5

    def moment(power: int) -> float:
        return quad(
            lambda v: v**power * hs.maxwell_density(v, dimension, temperature, mass), 0, top, epsabs=0, epsrel=1e-11
        )[0]

    assert moment(0) == pytest.approx(1, rel=1e-9)
    assert moment(1) == pytest.approx(hs.maxwell_mean_speed(dimension, temperature, mass), rel=1e-9)
    assert moment(2) == pytest.approx(dimension * temperature / mass, rel=1e-9)
    assert moment(4) / moment(2) ** 2 == pytest.approx(hs.moment_ratio(dimension), rel=1e-9)


@both
def test_cumulative_is_the_integral_of_the_density(dimension: int) -> None:
    for v in (0.0, 0.3, 1.0, 2.5):
        integral, _ = quad(lambda x: hs.maxwell_density(x, dimension, 1.3, 0.7), 0, v)
        assert hs.maxwell_cumulative(v, dimension, 1.3, 0.7) == pytest.approx(integral, abs=1e-12)
    assert hs.maxwell_cumulative(-1.0, dimension) == 0


def test_the_first_exercise_s_law_is_maxwell_s_in_two_dimensions() -> None:
    v, v0 = np.linspace(0, 4, 9), 1.7
    temperature = hs.mono_speed_temperature(v0, 2)
    np.testing.assert_allclose(
        hs.maxwell_density(v, 2, temperature), 2 * v / v0**2 * np.exp(-((v / v0) ** 2)), rtol=1e-14
    )
    assert hs.maxwell_mean_speed(2, temperature) == pytest.approx(v0 * math.pi**0.5 / 2, rel=1e-14)


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
    mean_within(ratio, hs.moment_ratio(dimension, freedoms))
    # the speed of a pair at the temperature 2K/f: mean over that of the Maxwellian
    scaled = np.linalg.norm(v[:, 0] - v[:, 1], axis=1) / (square.sum(axis=1) / freedoms) ** 0.5
    if momentum_conserved:
        mean_within(scaled, hs.maxwell_mean_speed(dimension, 2.0) * hs.finite_speed_factor(freedoms))


@both
def test_fluctuation_of_the_moment_ratio(dimension: int) -> None:
    number, rng = 2000, np.random.default_rng(4)
    square = (rng.standard_normal((2000, number, dimension)) ** 2).sum(axis=2)
    ratio = (square**2).mean(axis=1) / square.mean(axis=1) ** 2
    # relative error of a standard deviation from 2000 samples, 1/sqrt(4000), and terms of order 1/N
    assert ratio.std() == pytest.approx(hs.moment_ratio_fluctuation(number, dimension), rel=SIGMAS / 4000**0.5 + 0.01)


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
    rows = hs.MONO_SPEED[dimension]
    # two rows give the slope at the start to second order; third order is C^2/3 of a curve of rate about 1
    slope = 2 * (rows[0].moment_ratio - 1) / 0.05 - (rows[1].moment_ratio - 1) / 0.1
    third = 0.05 * 0.1 / 3
    table = math.hypot(2 * rows[0].standard_error / 0.05, rows[1].standard_error / 0.1)
    assert abs(slope - expected) < SIGMAS * math.hypot(error, table) + third


def test_relaxation_of_disks_is_that_of_an_earlier_simulation() -> None:
    """One run of 1e6 particles: its own scatter is 2/sqrt(N) at most."""
    earlier = (1.028, 1.056, 1.137, 1.261, 1.471, 1.630, 1.746, 1.887, 1.982, 2.003)
    for row, value in zip(hs.MONO_SPEED[2], earlier, strict=True):
        assert row.moment_ratio == pytest.approx(value, abs=SIGMAS * math.hypot(2e-3, row.standard_error) / 2 + 5e-4)


@both
def test_relaxation_of_one_run(dimension: int) -> None:
    exact = hs.mono_speed_moment_ratio(1.0, math.inf, dimension)
    assert exact == (hs.MONO_SPEED[dimension][4].moment_ratio, hs.MONO_SPEED[dimension][4].standard_error)
    assert hs.mono_speed_moment_ratio(1.0, 400, 2).uncertainty == pytest.approx(0.1, rel=1e-4)
    with pytest.raises(ValueError, match=r"no value after 0\.7"):
        hs.mono_speed_moment_ratio(0.7, 400, dimension)


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
    assert abs(best.value - pade) < best.uncertainty + digits
    assert abs(best.value - luding) < best.uncertainty + digits


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
    assert z.uncertainty == pytest.approx(5e-4 * z.value)
    assert abs(z.value - hs.pade(eta, 3, 5)) < z.uncertainty
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
    assert rate.uncertainty / rate.value == pytest.approx(g.uncertainty / g.value)
    assert hs.contact_value(0.0, dimension) == (1.0, 0.0)


@pytest.mark.parametrize(("eta", "rate"), [(0.1, 0.5328), (0.3, 2.3995), (0.5, 7.0171), (0.6, 12.304)])
def test_rates_of_disks_at_known_points(eta: float, rate: float) -> None:
    best = hs.collision_rate(eta, 2)
    assert abs(best.value - rate) < best.uncertainty + 5e-5 * rate


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
        assert abs(found.value - value) < math.hypot(found.uncertainty, 2 * error)
        # without the correction the deviation would be many times that
    assert hs.compressibility(eta, 2).value - z > 20 * z_error


def test_no_collisions_without_density() -> None:
    assert hs.finite_collision_rate(0.0, 10, 2).value == 0
    assert hs.finite_compressibility(0.0, 10, 3).value == 1


# -- walls ----------------------------------------------------------------------------------------------


@both
def test_ideal_wall_pressure_of_bouncing_particles(dimension: int) -> None:
    """2 m |v_x| every 2 l/|v_x| on each wall: N <v_x^2>/l over the wall's area."""
    number, length, diameter, v0 = 50000, 7.0, 1.0, 1.3
    v = np.random.default_rng(7).standard_normal((number, dimension))
    v *= v0 / np.linalg.norm(v, axis=1, keepdims=True)
    force = number * v[:, 0] ** 2 / (length - diameter) / length ** (dimension - 1)
    mean_within(
        force,
        hs.ideal_wall_pressure(number, length, dimension, hs.mono_speed_temperature(v0, dimension), diameter),
    )


def test_wall_hit_rate_by_quadrature() -> None:
    half, _ = quad(lambda v: v * np.exp(-(v**2) / (2 * 1.7 / 0.6)) / (2 * np.pi * 1.7 / 0.6) ** 0.5, 0, np.inf)
    assert hs.wall_hit_rate(0.3, 1.7, 0.6) == pytest.approx(0.3 * half, rel=1e-9)


def test_wall_tension_of_dilute_disks() -> None:
    """gamma = -n^2/2 times the integral of the part of the disk of contact that a wall cuts off: 2/3."""
    cut, _ = quad(lambda z: np.arccos(z) - z * (1 - z * z) ** 0.5, 0, 1)
    assert cut == pytest.approx(2 / 3, rel=1e-9)
    n = 1e-5
    assert hs.disk_wall_tension(n) == pytest.approx(-(n**2) / 2 * cut, rel=3 * n)


def test_third_surface_cluster_of_disks() -> None:
    rng = np.random.default_rng(8)
    r, angle = rng.random((2, 400000)) ** 0.5, rng.uniform(0, 2 * np.pi, (2, 400000))
    x, z = r * np.cos(angle), r * np.sin(angle)
    heights = np.stack([np.zeros_like(z[0]), z[0], z[1]])
    depth = heights.mean(axis=0) - heights.min(axis=0)
    closed = (np.diff(x, axis=0)[0] ** 2 + np.diff(z, axis=0)[0] ** 2 < 1).astype(float)
    mean_within(-(np.pi**2) / 6 * (3 - closed) * depth, hs._SURFACE_CLUSTER)


def test_box_of_disks_has_the_exact_second_virial_term() -> None:
    """Two disks overlap in a square of side l with chance (pi l^2 - (8/3) l + 1/2)/l^4; p = (T/2L) d ln Z/dl."""
    number, side = 30, 400.0
    q = (np.pi * side**2 - 8 / 3 * side + 0.5) / side**4
    slope = -(2 * np.pi / side**3 - 8 / side**4 + 2 / side**5)
    exact = (2 * number / side - number * (number - 1) / 2 * slope / (1 - q)) / (2 * (side + 1))
    found = hs.disk_box_pressure(number, side + 1)
    bulk = number / side**2 * np.pi / 2
    ideal = hs.ideal_wall_pressure(number, side + 1, 2, diameter=1.0)
    # left out: B_3 n^2, and the corners' second term, 1/l^2 of the first
    assert found.value - exact == pytest.approx(0, abs=ideal * (bulk**2 + bulk / side**2))
    assert exact / ideal - 1 > 500 * (bulk**2 + bulk / side**2)


@pytest.mark.parametrize(
    ("number", "eta", "pressure", "error"),
    [
        (25, 0.02, 1.07473, 5e-5),
        (400, 0.02, 1.0498, 2e-4),
        (25, 0.1, 1.33407, 2e-4),
        (100, 0.1, 1.28615, 3e-4),
        (400, 0.1, 1.2620, 2e-4),
    ],
)
def test_box_of_disks_against_event_driven_runs(number: int, eta: float, pressure: float, error: float) -> None:
    length = (number * np.pi / 4 / eta) ** 0.5
    found = hs.disk_box_pressure(number, length)
    ideal = number / length**2
    assert abs(found.value / ideal - pressure) < found.uncertainty / ideal + 2 * error
    assert abs(hs.disk_compressibility(eta).value - pressure) > 5 * found.uncertainty / ideal


# -- mixtures -------------------------------------------------------------------------------------------

species_lists = st.lists(st.tuples(st.floats(0.01, 0.1), st.floats(0.4, 1.2)), min_size=1, max_size=3)


@both
def test_like_species_are_one(dimension: int) -> None:
    parts = hs.mixture([0.1, 0.2], [1.0, 1.0], [1.0, 1.0])
    eta = hs.packing_fraction(0.3, dimension)
    textbook = (1 - 7 * eta / 16) / (1 - eta) ** 2 if dimension == 2 else (1 - eta / 2) / (1 - eta) ** 3
    np.testing.assert_allclose(hs.mixture_contact_values(parts, dimension), textbook, rtol=1e-13)
    pure, mixed = hs.compressibility(eta, dimension), hs.mixture_compressibility(parts, dimension)
    assert mixed.value == pytest.approx(pure.value, rel=1e-13)
    rates = hs.species_collision_rates(parts, dimension, 1.3).sum(axis=1)
    g = hs.contact_value(eta, dimension).value
    np.testing.assert_allclose(rates, hs.collision_rate(eta, dimension, 1.3).value / g * textbook, rtol=1e-13)


@given(parts=species_lists)
def test_pressure_of_a_mixture_is_the_sum_over_its_contacts(parts: list[tuple[float, float]]) -> None:
    """Z = 1 + (S_d/2d) sum_ij x_i x_j n s_ij^d g_ij, for BMCSL and for Jenkins and Mancini with Henderson's Z."""
    species = hs.mixture(*np.array(parts).T)
    n, s = species.densities, species.diameters
    pairs = np.outer(n, n) / n.sum()
    distance = (s[:, None] + s[None, :]) / 2
    spheres = 1 + 2 * np.pi / 3 * (pairs * distance**3 * hs.mixture_contact_values(species, 3)).sum()
    assert hs.bmcsl(species) == pytest.approx(spheres, rel=1e-12)
    eta, x = species.packing_fraction[0], (n * s).sum() ** 2 / (n.sum() * (n * s**2).sum())
    disks = 1 + np.pi / 2 * (pairs * distance**2 * hs.mixture_contact_values(species, 2)).sum()
    assert (1 - x) / (1 - eta) + x * hs.henderson(eta) == pytest.approx(disks, rel=1e-12)


@both
@given(parts=species_lists)
def test_species_collide_with_each_other_equally_often(dimension: int, parts: list[tuple[float, float]]) -> None:
    n, s = np.array(parts).T
    species = hs.mixture(n, s, 1 + s)
    counts = n[:, None] * hs.species_collision_rates(species, dimension)
    np.testing.assert_allclose(counts, counts.T, rtol=1e-13)


@both
def test_a_point_meets_spheres_with_the_free_volume(dimension: int) -> None:
    """g = 1/(1 - eta) exactly between a point and a sphere."""
    species = hs.mixture([0.3, 1e-12], [1.0, 1e-9])
    eta = species.packing_fraction[dimension - 2]
    assert hs.mixture_contact_values(species, dimension)[0, 1] == pytest.approx(1 / (1 - eta), rel=1e-8)


@both
def test_dilute_mixture_has_the_exact_second_virial_coefficient(dimension: int) -> None:
    n, s = np.array([2e-5, 3e-5]), np.array([1.0, 1.6])
    distance = (s[:, None] + s[None, :]) / 2
    half = np.pi / 2 if dimension == 2 else 2 * np.pi / 3
    b2 = half * (np.outer(n, n) * distance**dimension).sum() / n.sum()
    assert hs.mixture_compressibility(hs.mixture(n, s), dimension).value - 1 == pytest.approx(b2, rel=1e-3)


def test_mixtures_need_one_diameter_a_species() -> None:
    with pytest.raises(ValueError, match="one density and one diameter"):
        hs.mixture([0.1, 0.2], [1.0])


# -- diffusion ------------------------------------------------------------------------------------------


def sonine_ratio(dimension: int, order: int, nodes: int = 40) -> float:
    """D in the given Sonine approximation over the first: M_00 (M^-1)_00 of the collision integrals of v S_k(v^2/2).

    Equal masses exchange the normal components a, b; with p, q = (a +- b)/sqrt 2 the weight |q| exp(-q^2/2) is
    Laguerre's, and all integrands are polynomials: the quadrature is exact.
    """
    y, wy = np.polynomial.laguerre.laggauss(nodes)
    p, wp = np.polynomial.hermite_e.hermegauss(nodes)
    if dimension == 2:
        s, ws = p**2, wp
    else:
        s, ws = 2 * y, wy
    p, y, s = np.meshgrid(p, y, s, indexing="ij")
    weight = wp[:, None, None] * wy[None, :, None] * ws[None, None, :]
    q = (2 * y) ** 0.5
    a, b = (p + q) / 2**0.5, (p - q) / 2**0.5
    f, h = ([eval_genlaguerre(k, dimension / 2, (x * x + s) / 2) for k in range(order)] for x in (a, b))
    matrix = np.array(
        [
            [
                (weight * ((a * f[i] - b * h[i]) * (a * f[j] - b * h[j]) + s * (f[i] - h[i]) * (f[j] - h[j]))).sum()
                for j in range(order)
            ]
            for i in range(order)
        ]
    )
    return float(matrix[0, 0] * np.linalg.inv(matrix)[0, 0])


@both
def test_sonine_factor(dimension: int) -> None:
    assert sonine_ratio(dimension, 1) == pytest.approx(1, rel=1e-12)
    assert sonine_ratio(dimension, 12) == pytest.approx(hs.SONINE_DIFFUSION[dimension], abs=1e-6)
    assert hs.SONINE_DIFFUSION[3] == pytest.approx(1.01896, abs=1e-5)


@both
def test_first_approximation_of_diffusion(dimension: int) -> None:
    eta, temperature, mass, sigma = 0.15, 1.7, 0.6, 1.4
    n, g = hs.number_density(eta, dimension, sigma), hs.contact_value(eta, dimension).value
    root = (temperature / (np.pi * mass)) ** 0.5
    textbook = root / (2 * n * sigma * g) if dimension == 2 else 3 * root / (8 * n * sigma**2 * g)
    plain = hs.enskog_diffusion(eta, dimension, temperature, mass, sigma, sonine=False)
    assert plain.value == pytest.approx(textbook, rel=1e-13)
    full = hs.enskog_diffusion(eta, dimension, temperature, mass, sigma)
    assert full.value == pytest.approx(textbook * hs.SONINE_DIFFUSION[dimension], rel=1e-13)


@both
@pytest.mark.parametrize("ratio", [1.0, 20.0])
def test_friction_by_monte_carlo(dimension: int, ratio: float) -> None:
    """-<v.dv> per time over <v^2> of a tracer at the bath's temperature, collisions with a uniform normal."""
    rng = np.random.default_rng(9)
    count, n, s, temperature, mass, g = 400000, 0.3, 0.8, 1.7, 0.6, 1.4
    v = rng.standard_normal((count, dimension)) * (temperature / (ratio * mass)) ** 0.5
    w = rng.standard_normal((count, dimension)) * (temperature / mass) ** 0.5
    k = rng.standard_normal((count, dimension))
    k /= np.linalg.norm(k, axis=1, keepdims=True)
    approach = ((v - w) * k).sum(axis=1)
    surface = 2 * np.pi * s if dimension == 2 else 4 * np.pi * s**2
    rate = n * g * surface * np.maximum(approach, 0)
    change = -2 / (1 + ratio) * approach[:, None] * k
    loss = -rate * (v * change).sum(axis=1) / (dimension * temperature / (ratio * mass))
    mean_within(loss, hs.friction(n, s, mass, ratio * mass, dimension, temperature, g))


def test_viscosity_of_a_dilute_gas() -> None:
    assert hs.enskog_viscosity(1e-6) == pytest.approx(1.016 * 5 / (16 * np.pi**0.5), rel=1e-5)


@pytest.mark.parametrize(
    ("number", "density", "diffusion", "error"),
    [
        (108, 0.3, 0.4982, 0.0015),
        (108, 0.5, 0.22064, 0.00046),
        (256, 0.5, 0.23478, 0.00082),
        (108, 0.7, 0.09999, 0.00054),
    ],
)
def test_diffusion_of_few_spheres(number: int, density: float, diffusion: float, error: float) -> None:
    """Own event-driven runs, eight of 2e5 collisions."""
    found = hs.sphere_diffusion(density, number)
    assert abs(found.value - diffusion) < math.hypot(found.uncertainty, 2 * error)
    assert abs(hs.sphere_diffusion(density).value - diffusion) > 5 * error


def test_diffusion_table_is_met_at_its_own_number() -> None:
    for density, d, error in hs.NIST_DIFFUSION:
        found = hs.sphere_diffusion(density, hs.NIST_PARTICLES)
        assert found.value == pytest.approx(d, rel=1e-12)
        assert found.uncertainty == pytest.approx(error)
    with pytest.raises(ValueError, match="tabulated for number densities"):
        hs.sphere_diffusion(0.05)


# -- Lorentz gas ----------------------------------------------------------------------------------------


@both
def test_free_path_on_a_lattice(dimension: int) -> None:
    """Points anywhere in the free space hit within a short path e with chance e/lambda: no second hit fits in e."""
    rng, radius, path, count = np.random.default_rng(10), 0.35, 0.2, 400000
    x = rng.uniform(-0.5, 0.5, (count, dimension))
    x = x[(x**2).sum(axis=1) > radius**2]
    u = rng.standard_normal(x.shape)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    hit = np.zeros(len(x), dtype=bool)
    for cell in np.ndindex(*(3,) * dimension):
        apart = x - (np.array(cell) - 1)
        b = (apart * u).sum(axis=1)
        discriminant = b**2 - (apart**2).sum(axis=1) + radius**2
        first = -b - np.sqrt(np.maximum(discriminant, 0))
        hit |= (b < 0) & (discriminant > 0) & (first < path)
    mean_within(hit / path, 1 / hs.lorentz_free_path(1.0, radius, dimension))


@both
def test_free_path_among_overlapping_scatterers(dimension: int) -> None:
    """A free path r needs a tube without centres: chance exp(-n sigma r), whatever the point started from."""
    n, radius = 0.3, 0.7
    tube = 2 * radius if dimension == 2 else np.pi * radius**2
    mean, _ = quad(lambda r: np.exp(-n * tube * r), 0, np.inf)
    assert hs.lorentz_free_path(n, radius, dimension, overlapping=True) == pytest.approx(mean, rel=1e-9)
    assert hs.lorentz_free_path(n, radius, dimension) < mean
    with pytest.raises(ValueError, match="no room"):
        hs.lorentz_free_path(1.0, 1.0, dimension)


def test_transport_cross_sections_by_quadrature() -> None:
    """Impact parameter R sin(a): deflection pi - 2a, 1 - cos = 1 + cos 2a."""
    radius, n, v = 0.7, 0.02, 1.3
    disk, _ = quad(lambda a: (1 + np.cos(2 * a)) * radius * np.cos(a), -np.pi / 2, np.pi / 2)
    sphere, _ = quad(lambda a: (1 + np.cos(2 * a)) * 2 * np.pi * radius**2 * np.sin(a) * np.cos(a), 0, np.pi / 2)
    assert hs.lorentz_boltzmann_diffusion(n, radius, 2, v) == pytest.approx(v / (2 * n * disk), rel=1e-12)
    assert hs.lorentz_boltzmann_diffusion(n, radius, 3, v) == pytest.approx(v / (3 * n * sphere), rel=1e-12)
    path = hs.lorentz_free_path(n, radius, 3, overlapping=True)
    assert hs.lorentz_boltzmann_diffusion(n, radius, 3, v) == pytest.approx(v * path / 3, rel=1e-12)


def test_lorentz_series_against_simulation() -> None:
    """What is left out is of the order of (x ln x)^3, with a coefficient of some 10; a wrong sign is 9 % at 0.02."""
    for x, simulated in hs.LORENTZ_DIFFUSION[2].items():
        left_out = 10 * abs(x * math.log(x)) ** 3
        assert abs(hs.lorentz_series(x) - simulated.value) < left_out + 4 * simulated.uncertainty
    for table in hs.LORENTZ_DIFFUSION.values():
        values = [entry.value for entry in table.values()]
        assert 1 > values[0] > values[1] > values[2]
    assert hs.lorentz_series(1e-9) == pytest.approx(1, abs=1e-7)


# -- Brownian motion ------------------------------------------------------------------------------------


def test_brownian_autocorrelation_integrates_to_the_diffusion_coefficient() -> None:
    gamma, temperature, mass = 0.3, 1.7, 25.0
    integral, _ = quad(lambda t: hs.brownian_autocorrelation(t, gamma, temperature, mass), 0, np.inf)
    assert integral == pytest.approx(temperature / (mass * gamma), rel=1e-9)
    assert hs.brownian_autocorrelation(0.0, gamma, temperature, mass) == pytest.approx(temperature / mass)
