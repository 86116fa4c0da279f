"""Equilibrium, collisions, transport and modes: closed forms, and another way to each quantity.

The thesis is M. Pliego Diaz, Simulaciones hidrodinamicas bidimensionales usando modelos discretos, UNAM (1991). Where
its formulas are wrong the test says so.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from lattice_gases import ALL, DENSITIES, every_fhp, every_model, every_set, mass_and_momentum, mean_state

from refimpl.lattice import theory
from refimpl.lattice.models import MODELS, Model
from refimpl.lattice.velocities import SQUARE, TRIANGULAR, TRIANGULAR_REST, VelocitySet

occupation = st.floats(0.001, 0.999)

# -- equilibrium -------------------------------------------------------------------------------------------------------


@every_set
@given(data=st.data())
def test_fermi_dirac_has_the_sums_asked_for_and_the_right_form(velocities: VelocitySet, data: st.DataObject) -> None:
    given_f = data.draw(arrays(np.float64, (3, velocities.channels), elements=occupation))
    d, u = mean_state(velocities, given_f)
    f = theory.fermi_dirac(velocities, d, u)
    np.testing.assert_allclose(
        mass_and_momentum(velocities, f), mass_and_momentum(velocities, given_f), rtol=0, atol=1e-14
    )
    invariants = np.column_stack([np.ones(velocities.channels), velocities.cartesian])
    exponents = np.log(f / (1 - f))
    outside = exponents.T - invariants @ np.linalg.lstsq(invariants, exponents.T)[0]
    # a rounding of f moves its logarithm by 1/(f (1 - f)) as much; the sums above are met to 1e-14
    assert np.abs(outside).max() <= max(1e-8, 1e-13 / float((f * (1 - f)).min()))


@every_set
@given(h=st.floats(-12, 12), q=st.tuples(st.floats(-12, 12), st.floats(-12, 12)))
def test_fermi_dirac_finds_the_occupations_of_any_h_and_q(
    velocities: VelocitySet, h: float, q: tuple[float, float]
) -> None:
    f = 1 / (1 + np.exp(h + velocities.cartesian @ q))
    d, u = mean_state(velocities, f)
    if 0 < d < 1:
        np.testing.assert_allclose(theory.fermi_dirac(velocities, d, u), f, rtol=0, atol=3e-15)


@every_set
def test_fermi_dirac_at_the_edge_of_what_is_feasible(velocities: VelocitySet) -> None:
    """Bisection to the largest speed in a direction; there the sums must still be met, relative to the mass."""
    for d, angle in product((1e-300, 0.2, 1 - 1e-9), (0.0, 1.1)):
        direction = np.array([math.cos(angle), math.sin(angle)])
        low, high = 0.0, 2.0
        for _ in range(60):
            speed = (low + high) / 2
            try:
                theory.fermi_dirac(velocities, d, speed * direction)
                low = speed
            except ValueError:
                high = speed
        assert low > 0.4 * min(1, 1 / d - 1)
        for speed in (low, low * (1 - 1e-12), low * (1 - 1e-4), 1e-12 * low):
            u = speed * direction
            f = theory.fermi_dirac(velocities, d, u)
            expected = velocities.channels * d * np.array([1, *u])
            np.testing.assert_allclose(mass_and_momentum(velocities, f), expected, rtol=0, atol=3e-15 * expected[0])


@every_set
def test_fermi_dirac_at_rest_and_broadcast(velocities: VelocitySet) -> None:
    b = velocities.channels
    np.testing.assert_array_equal(theory.fermi_dirac(velocities, 0.3, (0, 0)), np.full(b, 0.3))
    d, u = np.array([[0.2], [0.5]]), np.array([[0.0, 0.0], [0.1, -0.2], [0.3, 0.0]])
    f = theory.fermi_dirac(velocities, d, u)
    assert f.shape == theory.low_speed_equilibrium(velocities, d, u).shape == (2, 3, b)
    for i, j in np.ndindex(2, 3):
        np.testing.assert_allclose(f[i, j], theory.fermi_dirac(velocities, d[i, 0], u[j]), rtol=1e-14)
    many = np.linspace(0.2, 0.7, 10_000)
    np.testing.assert_allclose(
        theory.fermi_dirac(velocities, many, (0.2, 0.1))[-1], theory.fermi_dirac(velocities, 0.7, (0.2, 0.1))
    )


def test_fermi_dirac_at_half_filling_by_hand() -> None:
    """f_i + f_-i = 1 and f_i - f_-i = tanh(q.c_i/2): the momentum is a sum of three terms."""
    q = 0.8
    u = (2 * math.tanh(q / 2) + 2 * math.tanh(q / 4)) / 6
    expected = 1 / (1 + np.exp(-q * TRIANGULAR.cartesian[:, 0]))
    np.testing.assert_allclose(theory.fermi_dirac(TRIANGULAR, 0.5, (u, 0)), expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("density", "velocity", "message"),
    [
        (0.0, (0, 0), "between 0 and 1, got 0.0"),
        ([0.3, 1.0], (0, 0), "between 0 and 1, got 1.0"),
        (math.nan, (0, 0), "between 0 and 1, got nan"),
        (0.5, (0.67, 0), r"mean 0.5 and velocity \(0.67, 0.0\)"),
        ([0.5, 0.1], [(0.1, 0.1), (0.0, -0.87)], r"mean 0.1 and velocity \(0.0, -0.87\)"),
        (0.125, (1, 0), r"mean 0.125 and velocity \(1.0, 0.0\)"),
        (0.125, (0.75, -(3**0.5) / 4), r"mean 0.125 and velocity \(0.75, -0.43"),
        (0.5, (math.nan, 0), r"velocity \(nan, 0.0\)"),
        (0.5, 0.1, "two components"),
        (0.5, (0.1, 0.1, 0.1), "two components"),
    ],
)
def test_states_that_there_are_not(density: float, velocity: tuple[float, ...], message: str) -> None:
    """Half filling has at most three of six channels full, along one another: u < 2/3 along an axis."""
    with pytest.raises(ValueError, match=message):
        theory.fermi_dirac(TRIANGULAR, density, velocity)
    theory.fermi_dirac(TRIANGULAR, 0.5, (0.66, 0))


@every_set
@pytest.mark.parametrize("density", [0.15, 0.5, 0.7])
def test_order_of_the_low_speed_expansion(velocities: VelocitySet, density: float) -> None:
    """The odd part is wrong by O(u^3), the even part by O(u^4); at half filling there is no even part at all.

    On the square lattice there is no odd one: f_i - f_-i = 2 d u.c_i is exact.
    """
    u = np.array([[0.06, 0.02]]) / np.array([[1], [2]])
    error = theory.fermi_dirac(velocities, density, [u, -u]) - theory.low_speed_equilibrium(
        velocities, density, [u, -u]
    )
    odd, even = (np.abs(error[0] + sign * error[1]).max(axis=-1) / 2 for sign in (-1, 1))
    if velocities is SQUARE:
        assert odd.max() < 1e-15
    else:
        assert 2**2.9 < odd[0] / odd[1] < 2**3.1
    if density == 0.5:
        assert even.max() < 1e-15
    else:
        assert 2**3.9 < even[0] / even[1] < 2**4.1


@every_set
def test_low_speed_equilibrium_has_the_exact_sums(velocities: VelocitySet) -> None:
    u = np.array([0.31, -0.12])
    for d in DENSITIES:
        f = theory.low_speed_equilibrium(velocities, d, u)
        np.testing.assert_allclose(
            mass_and_momentum(velocities, f), velocities.channels * d * np.array([1, *u]), atol=1e-15
        )


def test_low_speed_equilibrium_is_that_of_the_thesis() -> None:
    """(3.60), with rho D/(c^2 b) in the linear term: as printed, with d for b, the momentum is not rho u."""
    u = np.array([0.1, 0.05])
    for velocities, d in product((SQUARE, TRIANGULAR), DENSITIES):
        c, b = velocities.cartesian, velocities.channels
        rho, dimension = b * d, 2
        g = dimension**2 / (2 * b) * (b - 2 * rho) / (b - rho)
        q = np.einsum("ia,ib->iab", c, c) - np.eye(2) / dimension
        expected = rho / b + rho * dimension / b * (c @ u) + rho * g * np.einsum("iab,a,b->i", q, u, u)
        np.testing.assert_allclose(theory.low_speed_equilibrium(velocities, d, u), expected, rtol=1e-14)


def test_speed_of_sound() -> None:
    assert theory.sound_speed(SQUARE) == pytest.approx(0.5**0.5, rel=1e-15)
    assert theory.sound_speed(TRIANGULAR) == pytest.approx(0.5**0.5, rel=1e-15)
    assert theory.sound_speed(TRIANGULAR_REST) == pytest.approx((3 / 7) ** 0.5, rel=1e-15)


@pytest.mark.parametrize("density", DENSITIES)
def test_galilean_factor(density: float) -> None:
    d = density
    assert theory.galilean_factor(TRIANGULAR, d) == pytest.approx((1 - 2 * d) / (2 * (1 - d)), rel=1e-13, abs=1e-15)
    rest = 7 * (1 - 2 * d) / (12 * (1 - d))
    assert theory.galilean_factor(TRIANGULAR_REST, d) == pytest.approx(rest, rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("velocities", [TRIANGULAR, TRIANGULAR_REST])
def test_momentum_flux_is_isotropic_and_advects_with_g(velocities: VelocitySet) -> None:
    """P_ab = p delta_ab + rho g u_a u_b, p = rho (c_s^2 - g u^2 (c_s^2 (1 + D/2) - 1/2)).

    Thesis (3.92) without a resting particle.
    """
    d, rho = 0.3, 0.3 * velocities.channels
    g, square = theory.galilean_factor(velocities, d), theory.sound_speed(velocities) ** 2
    for angle in (0.0, 0.4, 1.0):
        u = 0.02 * np.array([math.cos(angle), math.sin(angle)])
        pressure = rho * (square - g * (u @ u) * (2 * square - 0.5))
        expected = pressure * np.eye(2) + rho * g * np.outer(u, u)
        flux = theory.momentum_flux(velocities, theory.low_speed_equilibrium(velocities, d, u))
        np.testing.assert_allclose(flux, expected, rtol=0, atol=1e-15)
        exact = theory.momentum_flux(velocities, theory.fermi_dirac(velocities, d, u))
        np.testing.assert_allclose(exact, expected, rtol=0, atol=20 * 0.02**4)


def test_momentum_flux_of_hpp_is_anisotropic() -> None:
    """Thesis (3.83), (3.84)."""
    d, u = 0.3, np.array([0.03, 0.011])
    rho = 4 * d
    g = (2 - rho) / (4 - rho)
    flux = theory.momentum_flux(SQUARE, theory.low_speed_equilibrium(SQUARE, d, u))
    difference = rho * g * (u[0] ** 2 - u[1] ** 2)
    np.testing.assert_allclose(flux, [[rho / 2 + difference, 0], [0, rho / 2 - difference]], rtol=0, atol=1e-15)
    exact = theory.momentum_flux(SQUARE, theory.fermi_dirac(SQUARE, d, u))
    np.testing.assert_allclose(exact, flux, rtol=0, atol=2 * 0.032**4)
    with pytest.raises(ValueError, match="not isotropic"):
        theory.galilean_factor(SQUARE, d)


def test_entropy_density() -> None:
    np.testing.assert_array_equal(theory.entropy_density([[0.0, 1.0], [1.0, 1.0]]), [0, 0])
    np.testing.assert_allclose(theory.entropy_density(np.full((2, 3, 4), 0.5)), np.full((2, 3), -4 * math.log(2)))
    assert theory.entropy_density([0.2, 0.9]) == pytest.approx(
        0.2 * math.log(0.2) + 0.8 * math.log(0.8) + 0.9 * math.log(0.9) + 0.1 * math.log(0.1)
    )


@every_set
@given(data=st.data())
def test_equilibrium_has_the_least_h(velocities: VelocitySet, data: st.DataObject) -> None:
    f = data.draw(arrays(np.float64, (velocities.channels,), elements=occupation))
    equilibrium = theory.fermi_dirac(velocities, *mean_state(velocities, f))
    assert theory.entropy_density(equilibrium) <= theory.entropy_density(f) + 1e-13


# -- collisions --------------------------------------------------------------------------------------------------------


def all_states(model: Model) -> np.ndarray:
    """s_i, (2^b, b)."""
    return np.array([[s >> i & 1 for i in range(model.channels)] for s in range(model.velocities.states)])


def naive_collision_term(model: Model, f: np.ndarray) -> np.ndarray:
    states = all_states(model)
    probability = np.prod(np.where(states, f, 1 - f), axis=1)
    return probability @ (model.transitions @ states - states)


@every_model
@given(data=st.data())
def test_collision_term_against_the_sum_over_all_states(model: Model, data: st.DataObject) -> None:
    f = data.draw(arrays(np.float64, (2, model.channels), elements=st.floats(0, 1)))
    found = theory.collision_term(model, f)
    for site in range(2):
        np.testing.assert_allclose(found[site], naive_collision_term(model, f[site]), rtol=0, atol=1e-15)
    np.testing.assert_allclose(mass_and_momentum(model.velocities, found), 0, atol=1e-14)
    assert ((f + found > -1e-15) & (f + found < 1 + 1e-15)).all()


@every_model
def test_collisions_leave_equilibrium_alone(model: Model) -> None:
    u = np.array([(0.0, 0.0), (0.2, 0.0), (-0.05, 0.3)])
    for d in DENSITIES:
        f = theory.fermi_dirac(model.velocities, d, u)
        np.testing.assert_allclose(theory.collision_term(model, f), 0, atol=2e-16)


@every_model
@pytest.mark.parametrize("density", DENSITIES)
def test_collision_matrix_is_that_of_the_thesis(model: Model, density: float) -> None:
    """(3.89), p = sum_i s_i."""
    states, a = all_states(model), model.transitions
    p = states.sum(axis=1)
    weight = a * (density ** (p - 1.0) * (1 - density) ** (model.channels - p - 1.0))[:, None]
    difference = states[:, None, :] - states[None, :, :]
    expected = -0.5 * np.einsum("sti,st,stj->ij", difference, weight, difference)
    found = theory.collision_matrix(model, np.full(model.channels, density))
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-15)


@every_model
@given(data=st.data())
def test_collision_matrix_by_differences(model: Model, data: st.DataObject) -> None:
    f, change = data.draw(arrays(np.float64, (2, model.channels), elements=st.floats(0.1, 0.9)))
    eps = 1e-5
    slope = (theory.collision_term(model, f + eps * change) - theory.collision_term(model, f - eps * change)) / (
        2 * eps
    )
    matrix = theory.collision_matrix(model, f)
    np.testing.assert_allclose(matrix @ change, slope, rtol=0, atol=1e-8)
    np.testing.assert_allclose(mass_and_momentum(model.velocities, matrix.T), 0, atol=1e-14)


@every_model
def test_collision_matrix_at_full_and_empty_channels(model: Model) -> None:
    f = np.resize([0.0, 1.0, 0.4], model.channels)
    found = theory.collision_matrix(model, f)
    for j in range(model.channels):
        change = np.zeros(model.channels)
        change[j] = 0.25 - f[j]
        found_j = naive_collision_term(model, f + change) - naive_collision_term(model, f)
        np.testing.assert_allclose(found[:, j] * change[j], found_j, rtol=0, atol=1e-15)


# -- transport ---------------------------------------------------------------------------------------------------------

RATES = {
    "fhp1": lambda d: 3 * d * (1 - d) ** 3,
    "fhp2": lambda d: 7 * d * (1 - d) ** 3 * (1 - 4 * d / 7),
    "fhp3": lambda d: 7 * d * (1 - d) * (1 - 8 * d * (1 - d) / 7),
    "fhp_saturated": lambda d: 3 * d * (1 - d) * (1 + 2 * d * (1 - d)),
    "fhp_saturated_identity": lambda d: 2 * d * (1 - d) * (1 + d * (1 - d)),
}
#: nu at the DENSITIES
VISCOSITIES = {
    "fhp1": (1.01812, 0.68880, 0.68485, 0.83951, 1.20833, 2.04514),
    "fhp2": (0.39460, 0.26878, 0.29389, 0.41084, 0.67500, 1.29031),
    "fhp3": (0.31732, 0.14816, 0.09877, 0.08005, 0.07500, 0.08005),
    "fhp_saturated": (0.65968, 0.26957, 0.15445, 0.10961, 0.09722, 0.10961),
    "fhp_saturated_identity": (1.14921, 0.54849, 0.36693, 0.29503, 0.27500, 0.29503),
    "sat7": (0.32051, 0.15204, 0.10328, 0.08501, 0.08013, 0.08501),
    "sat7_identity": (0.62575, 0.32572, 0.23575, 0.20052, 0.19079, 0.20052),
}


@pytest.mark.parametrize("density", [0.01, *DENSITIES, 0.95])
@pytest.mark.parametrize("name", RATES)
def test_closed_forms_of_the_viscosity(name: str, density: float) -> None:
    model, rate = MODELS[name], RATES[name](density)
    c = model.velocities.cartesian
    for moment in (c[:, 0] * c[:, 1], c[:, 0] ** 2 - c[:, 1] ** 2):
        assert theory.relaxation_rate(model, density, moment) == pytest.approx(rate, rel=1e-12)
    assert theory.shear_viscosity(model, density) == pytest.approx(1 / (4 * rate) - 1 / 8, rel=1e-12)


@pytest.mark.parametrize("name", VISCOSITIES)
def test_table_of_viscosities(name: str) -> None:
    found = [theory.shear_viscosity(ALL[name], d) for d in DENSITIES]
    np.testing.assert_allclose(found, VISCOSITIES[name], rtol=0, atol=6e-6)


def test_viscosity_from_the_sums_of_the_thesis() -> None:
    """nu = -b c^4/(D(D + 2)) psi + nu_p, psi = D/(b c^2) sum Q_i Q_i/sum Q_i A_ij Q_j.

    (3.87) has the factor D/(b c^2) upside down, nine times too much for b = 6; and (3.86) is followed by the words that
    nu_p = -1/8 is not negative.
    """
    model, d, b = MODELS["fhp_saturated"], 0.2, 6
    c = model.velocities.cartesian
    q = np.einsum("ia,ib->iab", c, c) - np.eye(2) / 2
    a = theory.collision_matrix(model, np.full(b, d))
    quotient = (q**2).sum() / np.einsum("iab,ij,jab->", q, a, q)
    collisions = theory.shear_viscosity(model, d) + 1 / 8
    assert -b / 8 * (2 / b) * quotient == pytest.approx(collisions, rel=1e-12)
    assert -b / 8 * (b / 2) * quotient == pytest.approx(9 * collisions, rel=1e-12)


def test_bulk_viscosity() -> None:
    """zeta/rho; 1/(98 d (1-d)^4) - 1/28 of FHP-II, 1/(98 d (1-d) (1 - 2d(1-d))) - 1/28 of FHP-III."""
    for d in DENSITIES:
        v = d * (1 - d)
        assert theory.bulk_viscosity(MODELS["fhp2"], d) == pytest.approx(
            1 / (98 * d * (1 - d) ** 4) - 1 / 28, rel=1e-12
        )
        assert theory.bulk_viscosity(MODELS["fhp3"], d) == pytest.approx(1 / (98 * v * (1 - 2 * v)) - 1 / 28, rel=1e-12)
        for name in ("hpp", "fhp1", "fhp_saturated", "fhp_saturated_identity"):
            assert theory.bulk_viscosity(MODELS[name], d) == 0


def test_dual_models_have_dual_viscosities() -> None:
    for name in ("fhp3", "fhp_saturated", "fhp_saturated_identity", "sat7", "sat7_identity"):
        for d in (0.1, 0.37):
            for viscosity in (theory.shear_viscosity, theory.bulk_viscosity):
                assert viscosity(ALL[name], d) == pytest.approx(viscosity(ALL[name], 1 - d), rel=1e-11)


def test_hpp_has_no_shear_viscosity() -> None:
    hpp = MODELS["hpp"]
    with pytest.raises(ValueError, match="not isotropic"):
        theory.shear_viscosity(hpp, 0.3)
    assert theory.relaxation_rate(hpp, 0.3, [1, -1, 1, -1]) == pytest.approx(4 * 0.3 * 0.7, rel=1e-13)
    with pytest.raises(ValueError, match="not an eigenvector"):
        theory.relaxation_rate(hpp, 0.3, hpp.velocities.cartesian.prod(axis=1))


@every_model
def test_what_is_conserved_does_not_relax(model: Model) -> None:
    for moment in (np.ones(model.channels), *model.velocities.cartesian.T):
        assert theory.relaxation_rate(model, 0.3, moment) == pytest.approx(0, abs=1e-15)
    with pytest.raises(ValueError, match="not an eigenvector"):
        theory.relaxation_rate(model, 0.3, np.arange(model.channels) ** 2)
    with pytest.raises(ValueError, match="between 0 and 1"):
        theory.relaxation_rate(model, 1.2, np.ones(model.channels))


# -- modes -------------------------------------------------------------------------------------------------------------


@every_fhp
@pytest.mark.parametrize("density", [0.15, 0.5, 0.8])
def test_long_waves_have_the_transport_coefficients(model: Model, density: float) -> None:
    """Each approaches its limit as k^2, in any direction."""
    nu, bulk = theory.shear_viscosity(model, density), theory.bulk_viscosity(model, density)
    limits = np.array([nu, theory.sound_speed(model.velocities), (nu + bulk) / 2])
    # short enough for the expansion: k nu and k zeta/rho are the small parameters
    longest = 0.01 / max(1.0, nu, bulk)
    for angle in (0.0, 0.3, math.pi / 2):
        error = []
        for k in (longest, longest / 2):
            found = theory.modes(model, density, (k * math.cos(angle), k * math.sin(angle)))
            rates = found.shear_decay / k**2, found.sound_frequency / k, found.sound_damping / k**2
            error.append(np.array(rates) - limits)
            assert found.shear_frequency == pytest.approx(0, abs=1e-14)
            assert len(found.eigenvalues) == model.channels
            assert (np.abs(found.eigenvalues) < 1 + 1e-13).all()
        assert (np.abs(error[0]) < 5e-3 * limits).all()
        resolved = np.abs(error[1]) > 1e-7
        np.testing.assert_allclose((error[0] / error[1])[resolved], 4, rtol=0.03)


def test_sound_in_hpp_along_an_axis() -> None:
    """alpha = k^2/4 (1/lambda - 1/2), lambda = 4 d (1 - d); the transverse momentum of each line is kept."""
    k = 1e-3
    for d in DENSITIES:
        for wavevector in ((k, 0), (0, -k)):
            found = theory.modes(MODELS["hpp"], d, wavevector)
            assert found.sound_frequency == pytest.approx(0.5**0.5 * k, rel=1e-5)
            assert found.sound_damping == pytest.approx(k**2 / 4 * (1 / (4 * d * (1 - d)) - 0.5), rel=1e-5)
            assert found.shear_decay == pytest.approx(0, abs=1e-14)
    diagonal = theory.modes(MODELS["hpp"], 0.5, (k / 2**0.5, k / 2**0.5))
    assert diagonal.shear_decay == pytest.approx(k**2 / 4, rel=1e-5)
    assert diagonal.sound_damping == pytest.approx(0, abs=1e-13)


@every_fhp
def test_modes_of_a_moving_gas(model: Model) -> None:
    """A shear wave drifts with g u.k, not u.k; along u sound is faster, and the wave of -k is the other one."""
    d, k, u = 0.2, 1e-3, 1e-3
    g = theory.galilean_factor(model.velocities, d)
    across = theory.modes(model, d, (0, k), (u, 0))
    assert across.shear_frequency == pytest.approx(0, abs=1e-13)
    found = theory.modes(model, d, (k, 0), (u, 0))
    assert found.shear_frequency == pytest.approx(g * k * u, rel=1e-4)
    other = theory.modes(model, d, (-k, 0), (u, 0))
    at_rest = theory.modes(model, d, (k, 0))
    assert found.sound_frequency > at_rest.sound_frequency > other.sound_frequency > 0
    assert other.shear_frequency == pytest.approx(-found.shear_frequency, rel=1e-6)
    both = {complex(np.exp(-m.sound_damping - 1j * s * m.sound_frequency)) for m, s in ((found, 1), (other, -1))}
    for value in both:
        assert np.abs(found.eigenvalues - value).min() < 1e-14


@every_fhp
def test_staggered_momentum_is_conserved_too(model: Model) -> None:
    """A spurious invariant (Kadanoff, McNamara and Zanetti 1989): the momentum across rows, with the rows' parity."""
    corner = (0, 2 * math.pi / 3**0.5)
    assert np.abs(theory.modes(model, 0.3, corner).eigenvalues + 1).min() < 1e-13


def test_shear_and_sound_are_two_modes() -> None:
    """Far from hydrodynamics one mode can have the largest part in both; sound is then the second."""
    found = theory.modes(MODELS["hpp"], 0.08, (-0.59, -0.81), (-0.33, 0.1))
    assert found.sound_damping > found.shear_decay + 0.01


def test_there_is_no_mode_without_a_wave() -> None:
    with pytest.raises(ValueError, match="wave vector"):
        theory.modes(MODELS["fhp1"], 0.3, (0, 0))
