"""Jump conditions by conservation laws, virials by quadrature, the sum rule on the simulated states."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from crosscheck.references import hard_spheres
from crosscheck.references import square_well as sw

both = pytest.mark.parametrize("dimension", [2, 3])


@given(u=st.floats(0.01, 10), depth=st.floats(0.1, 3), mass=st.floats(0.1, 5))
def test_energy_is_kept_at_the_edge(u: float, depth: float, mass: float) -> None:
    """Reduced mass m/2: (m/4) u^2 - epsilon inside."""
    entered = sw.entering(-u, depth, mass)
    assert entered.inside
    assert entered.velocity < 0
    assert mass / 4 * entered.velocity**2 - depth == pytest.approx(mass / 4 * u * u, abs=1e-12)
    left = sw.leaving(u, depth, mass)
    assert left.inside == (mass / 4 * u * u <= depth)
    energy = mass / 4 * left.velocity**2 - (depth if left.inside else 0)
    assert energy == pytest.approx(mass / 4 * u * u - depth, abs=1e-12)
    assert (left.velocity < 0) == left.inside
    # time reversal: what went in with u comes out with it
    assert sw.leaving(-entered.velocity, depth, mass).velocity == pytest.approx(u, rel=1e-6)


def test_edge_needs_the_right_sign() -> None:
    assert sw.leaving(2.0).inside
    with pytest.raises(ValueError, match="approaches"):
        sw.entering(0.0)
    with pytest.raises(ValueError, match="recedes"):
        sw.leaving(-1.0)


@given(temperature=st.floats(0.3, 10))
def test_escaping_fraction_by_quadrature(temperature: float) -> None:
    escaping, _ = quad(lambda u: u / (2 * temperature) * math.exp(-u * u / (4 * temperature)), 2, math.inf)
    assert sw.escaping_fraction(temperature) == pytest.approx(escaping, rel=1e-7)
    # detailed balance: inside g(lambda-) escape as many as enter outside g(lambda+)
    assert sw.edge_ratio(temperature) * sw.escaping_fraction(temperature) == pytest.approx(1, rel=1e-13)


@both
@given(temperature=st.floats(0.3, 20), width=st.floats(1.05, 2.5))
def test_second_virial_coefficient_by_quadrature(dimension: int, temperature: float, width: float) -> None:
    surface = 2 * np.pi if dimension == 2 else 4 * np.pi
    core, _ = quad(lambda r: -surface * r ** (dimension - 1), 0, 1)
    well, _ = quad(lambda r: surface * r ** (dimension - 1) * math.expm1(1 / temperature), 1, width)
    expected = -(core + well) / 2
    scale = abs(core) + abs(well)
    assert float(sw.second_virial(temperature, width, dimension)) == pytest.approx(expected, abs=1e-12 * scale)
    dilute = sw.dilute_compressibility(1e-4, temperature, width, dimension)
    assert dilute.value == pytest.approx(1 + 1e-4 * expected, abs=1e-15 * (1 + scale))
    energy = sw.dilute_energy(1e-4, temperature, width, dimension)
    inside, _ = quad(lambda r: surface * r ** (dimension - 1) * math.exp(1 / temperature), 1, width)
    assert energy.value == pytest.approx(-1e-4 * inside / 2, rel=1e-10)


@both
@pytest.mark.parametrize("width", [1.1, 1.5, 2.0])
def test_energy_is_the_temperature_derivative_of_the_virial(dimension: int, width: float) -> None:
    """u = -n T^2 dB2/dT."""
    t, h = 1.4, 1e-4
    slope = (sw.second_virial(t + h, width, dimension) - sw.second_virial(t - h, width, dimension)) / (2 * h)
    assert sw.dilute_energy(0.01, t, width, dimension).value == pytest.approx(-0.01 * t * t * float(slope), rel=1e-7)


@both
def test_boyle_temperature(dimension: int) -> None:
    boyle = sw.boyle_temperature(1.7, dimension)
    assert float(sw.second_virial(boyle, 1.7, dimension)) == pytest.approx(0, abs=1e-14)
    assert sw.boyle_temperature(1.5, 3) == pytest.approx(2.84578, abs=5e-6)


@both
@given(temperature=st.floats(0.5, 10), width=st.floats(1.05, 2.5))
def test_sum_rule_gives_the_second_virial_coefficient(dimension: int, temperature: float, width: float) -> None:
    """Dilute: g = exp(1/T) in the well, 1 outside."""
    n, inside = 1e-3, math.exp(1 / temperature)
    z = sw.virial_compressibility(n, inside, inside, 1.0, width, dimension)
    b2 = float(sw.second_virial(temperature, width, dimension))
    assert z - 1 == pytest.approx(n * b2, abs=1e-13 * inside * width**dimension)


@pytest.mark.parametrize("state", sw.STATES, ids=lambda state: f"{state.density}-{state.temperature}")
def test_simulated_states_agree_with_the_exact_relations(state: sw.StatePoint) -> None:
    ratio = state.inner.value / state.outer.value
    # printed to three digits: 0.05 to 0.1 %, and 0.4 % found
    assert ratio == pytest.approx(sw.edge_ratio(state.temperature), rel=0.005)
    z = sw.virial_compressibility(state.density, state.core.value, state.inner.value, state.outer.value, sw.WIDTH, 3)
    assert abs(z - state.compressibility.value) < state.compressibility.doubt
    assert state.compressibility.doubt < 0.05 + 0.02 * state.compressibility.value
    # of the order of the well's volume times the density
    assert -13 / 2 < state.energy.value < sw.dilute_energy(state.density, 1e9, sw.WIDTH, 3).value


def test_dilute_energy_is_near_the_most_dilute_state() -> None:
    """n = 0.1 is not dilute: the estimate must know it."""
    state = sw.STATES[0]
    dilute = sw.dilute_energy(state.density, state.temperature, sw.WIDTH, 3)
    assert abs(dilute.value - state.energy.value) < dilute.doubt
    z = sw.dilute_compressibility(state.density, state.temperature, sw.WIDTH, 3)
    assert abs(z.value - state.compressibility.value) < z.doubt


def test_critical_points_agree() -> None:
    for one in sw.CRITICAL_POINTS:
        for two in sw.CRITICAL_POINTS:
            gap = one.temperature.value - two.temperature.value
            assert abs(gap) < 2 * math.hypot(one.temperature.uncertainty, two.temperature.uncertainty)
            gap = one.density.value - two.density.value
            assert abs(gap) < 2 * math.hypot(one.density.uncertainty, two.density.uncertainty)


@both
def test_third_virial_of_a_hot_gas_is_that_of_hard_cores(dimension: int) -> None:
    exact = hard_spheres.virial_coefficients(dimension)[2] * hard_spheres.packing_fraction(1.0, dimension) ** 2
    assert sw.third_virial(1e12, 1.5, dimension) == pytest.approx(exact, rel=1e-9)


@both
def test_third_virial_is_the_integral_over_triangles(dimension: int) -> None:
    temperature, width, number = 2.0, 1.5, 400_000
    rng = np.random.default_rng(1)
    f = lambda r: np.where(r < 1, -1.0, np.where(r < width, np.expm1(1 / temperature), 0.0))  # noqa: E731
    one, two = rng.uniform(-width, width, (2, number, dimension))
    sides = [np.linalg.norm(r, axis=1) for r in (one, two, one - two)]
    values = -(f(sides[0]) * f(sides[1]) * f(sides[2])) / 3 * (2 * width) ** (2 * dimension)
    error = values.std() / number**0.5
    assert abs(sw.third_virial(temperature, width, dimension) - values.mean()) < 4 * error


@both
def test_absolute_virial_by_quadrature(dimension: int) -> None:
    temperature, width = 1.3, 1.5
    surface = 2 * np.pi if dimension == 2 else 4 * np.pi
    mayer = lambda r: 1.0 if r < 1 else math.expm1(1 / temperature)  # noqa: E731
    whole, _ = quad(lambda r: surface * r ** (dimension - 1) * mayer(r), 0, width, points=[1.0])
    assert sw.absolute_virial(temperature, width, dimension) == pytest.approx(whole / 2, rel=1e-10)


@both
@pytest.mark.parametrize("case", [(0.8, 1.0, 1.5), (2.2, 1.0, 1.5), (2.6, 1.0, 1.5), (0.2, 1.0, 1.5)])
def test_common_volume_by_slices(dimension: int, case: tuple[float, float, float]) -> None:
    """Two balls on the x axis: at each x the smaller of the two cross-sections."""
    r, p, q = case

    def section(x: float) -> float:
        square = min(p * p - x * x, q * q - (x - r) ** 2)
        return 0.0 if square <= 0 else 2 * square**0.5 if dimension == 2 else np.pi * square

    meet = (r * r + p * p - q * q) / (2 * r)
    expected, _ = quad(section, -p, p, points=[x for x in (meet, r - q) if -p < x < p], limit=200)
    assert sw.common_volume(r, p, q, dimension) == pytest.approx(expected, abs=1e-7)


def test_a_pair_that_falls_straight_into_the_core_and_out_again() -> None:
    """By hand: 1 at speed 1 to the edge, the well at speed sqrt(5), the core, and the same way back."""
    path = sw.pair_path(np.array([2.5, 0.0]), np.array([-1.0, 0.0]), 10.0, 1.5)
    inside = 2 * 0.5 / 5**0.5
    assert (path.entered, path.left, path.reflected, path.hits) == (1, 1, 0, 1)
    assert path.velocity == pytest.approx([1.0, 0.0], abs=1e-12)
    assert path.position == pytest.approx([1.5 + 10.0 - 1.0 - inside, 0.0])
