"""Closed forms of lattice gases against the velocities and the collisions they follow from, as papers print them.

The thesis is M. Pliego Diaz, Simulaciones hidrodinamicas bidimensionales usando modelos discretos, UNAM (1991). Where
its formulas are wrong the test says so.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import (
    MODELS,
    VELOCITIES,
    fermi_dirac,
    green_kubo,
    linearised_collision,
    low_speed_equilibrium,
    modes,
    momentum_flux,
)

FHP = tuple(name for name in MODELS if name != "hpp")
densities = st.floats(0.01, 0.99)
DENSITIES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


def rate_of(name: str, d: float, moment: np.ndarray) -> float:
    """lambda of an eigenvector of the collisions, J moment = -lambda moment, at rest."""
    image = linearised_collision(name, np.full(len(moment), d)) @ moment
    rate = -float(moment @ image / (moment @ moment))
    np.testing.assert_allclose(image, -rate * moment, rtol=0, atol=1e-12)
    return rate


# -- closed forms ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FHP)
@given(d=densities)
def test_viscosities_are_those_of_the_collisions(name: str, d: float) -> None:
    """nu = <c_x^2 c_y^2>/c_s^2 (1/lambda - 1/2); zeta/rho = <r^2>/(D^2 c_s^2) (1/mu - 1/2), mu of r = c^2 - D c_s^2."""
    c = VELOCITIES[name].cartesian
    square, near = float((c**2).mean()), {"rel": 1e-9, "abs": 1e-9}
    nu = (
        float((c[:, 0] * c[:, 1]) @ (c[:, 0] * c[:, 1]))
        / len(c)
        / square
        * (1 / rate_of(name, d, c.prod(axis=1)) - 0.5)
    )
    # differences of nearly equal terms where a viscosity passes through zero
    assert known.shear_viscosity(name, d) == pytest.approx(nu, **near)
    excess = (c**2).sum(axis=1) - 2 * square
    if VELOCITIES[name].rest:
        zeta = float((excess**2).mean()) / (4 * square) * (1 / rate_of(name, d, excess) - 0.5)
        assert known.bulk_viscosity(name, d) == pytest.approx(zeta, **near)
    else:  # all particles have one speed: their energy is their mass
        np.testing.assert_allclose(excess, 0, atol=1e-15)
        assert known.bulk_viscosity(name, d) == 0


@pytest.mark.parametrize("name", FHP)
@given(d=densities)
def test_galilean_factor_is_that_of_the_velocities(name: str, d: float) -> None:
    c = VELOCITIES[name].cartesian
    fourth = float((c[:, 0] ** 2 * c[:, 1] ** 2).mean()) / float((c**2).mean()) ** 2
    assert known.galilean_factor(name, d) == pytest.approx(fourth * (1 - 2 * d) / (1 - d), rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("d", DENSITIES)
def test_galilean_factor_with_and_without_a_rest_particle(d: float) -> None:
    assert known.galilean_factor("fhp1", d) == pytest.approx((1 - 2 * d) / (2 * (1 - d)), rel=1e-13, abs=1e-15)
    assert known.galilean_factor("fhp3", d) == pytest.approx(7 * (1 - 2 * d) / (12 * (1 - d)), rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("name", ["fhp1", "fhp3"])
def test_momentum_flux_is_isotropic_and_advects_with_g(name: str) -> None:
    """P_ab = p delta_ab + rho g u_a u_b, p = rho (c_s^2 - g u^2 (c_s^2 (1 + D/2) - 1/2)).

    Thesis (3.92) without a resting particle.
    """
    d, rho = 0.3, 0.3 * VELOCITIES[name].channels
    g, square = known.galilean_factor(name, d), known.SOUND_SPEED[name] ** 2
    for angle in (0.0, 0.4, 1.0):
        u = 0.02 * np.array([math.cos(angle), math.sin(angle)])
        pressure = rho * (square - g * (u @ u) * (2 * square - 0.5))
        expected = pressure * np.eye(2) + rho * g * np.outer(u, u)
        flux = momentum_flux(name, low_speed_equilibrium(name, d, u))
        np.testing.assert_allclose(flux, expected, rtol=0, atol=1e-15)
        exact = momentum_flux(name, fermi_dirac(name, d, u))
        np.testing.assert_allclose(exact, expected, rtol=0, atol=20 * 0.02**4)


def test_momentum_flux_of_hpp_is_anisotropic() -> None:
    """Thesis (3.83), (3.84)."""
    d, u = 0.3, np.array([0.03, 0.011])
    rho = 4 * d
    g = (2 - rho) / (4 - rho)
    flux = momentum_flux("hpp", low_speed_equilibrium("hpp", d, u))
    difference = rho * g * (u[0] ** 2 - u[1] ** 2)
    np.testing.assert_allclose(flux, [[rho / 2 + difference, 0], [0, rho / 2 - difference]], rtol=0, atol=1e-15)
    exact = momentum_flux("hpp", fermi_dirac("hpp", d, u))
    np.testing.assert_allclose(exact, flux, rtol=0, atol=2 * 0.032**4)


#: nu at d = 0.1 ... 0.6: FHP-I, II, III, and all collisions without and with the state that enters.
VISCOSITIES = {
    "fhp1": (1.01812, 0.68880, 0.68485, 0.83951, 1.20833, 2.04514),
    "fhp2": (0.39460, 0.26878, 0.29389, 0.41084, 0.67500, 1.29031),
    "fhp3": (0.31732, 0.14816, 0.09877, 0.08005, 0.07500, 0.08005),
    "fhp_saturated": (0.65968, 0.26957, 0.15445, 0.10961, 0.09722, 0.10961),
    "fhp_saturated_identity": (1.14921, 0.54849, 0.36693, 0.29503, 0.27500, 0.29503),
}


@pytest.mark.parametrize("name", FHP)
def test_table_of_viscosities(name: str) -> None:
    found = [known.shear_viscosity(name, d) for d in DENSITIES]
    np.testing.assert_allclose(found, VISCOSITIES[name], rtol=0, atol=5.1e-6)


def test_what_there_is_not() -> None:
    with pytest.raises(ValueError, match="HPP is not isotropic and has no shear viscosity"):
        known.shear_viscosity("hpp", 0.3)
    with pytest.raises(ValueError, match="HPP is not isotropic and has no one factor of advection"):
        known.galilean_factor("hpp", 0.3)
    with pytest.raises(KeyError):
        known.relaxation_rate("fhp", 0.3)


def test_viscosity_from_the_sums_of_the_thesis() -> None:
    """nu = -b c^4/(D(D + 2)) psi + nu_p, psi = D/(b c^2) sum Q_i Q_i/sum Q_i A_ij Q_j.

    (3.87) has the factor D/(b c^2) upside down, nine times too much for b = 6; and (3.86) is followed by the words that
    nu_p = -1/8 is not negative.
    """
    d, b = 0.2, 6
    c = VELOCITIES["fhp_saturated"].cartesian
    q = np.einsum("ia,ib->iab", c, c) - np.eye(2) / 2
    a = linearised_collision("fhp_saturated", np.full(b, d))
    quotient = (q**2).sum() / np.einsum("iab,ij,jab->", q, a, q)
    collisions = known.shear_viscosity("fhp_saturated", d) + 1 / 8
    assert -b / 8 * (2 / b) * quotient == pytest.approx(collisions, rel=1e-12)
    assert -b / 8 * (b / 2) * quotient == pytest.approx(9 * collisions, rel=1e-12)


def test_bulk_viscosity() -> None:
    """zeta/rho; 1/(98 d (1-d)^4) - 1/28 of FHP-II, 1/(98 d (1-d) (1 - 2d(1-d))) - 1/28 of FHP-III."""
    for d in DENSITIES:
        v = d * (1 - d)
        assert known.bulk_viscosity("fhp2", d) == pytest.approx(1 / (98 * d * (1 - d) ** 4) - 1 / 28, rel=1e-12)
        assert known.bulk_viscosity("fhp3", d) == pytest.approx(1 / (98 * v * (1 - 2 * v)) - 1 / 28, rel=1e-12)
        for name in ("hpp", "fhp1", "fhp_saturated", "fhp_saturated_identity"):
            assert known.bulk_viscosity(name, d) == 0


def test_dual_models_have_dual_viscosities() -> None:
    for name in ("fhp3", "fhp_saturated", "fhp_saturated_identity"):
        for d in (0.1, 0.37):
            for viscosity in (known.shear_viscosity, known.bulk_viscosity):
                assert viscosity(name, d) == pytest.approx(viscosity(name, 1 - d), rel=1e-11)


# -- against the models as they are printed ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
@given(d=densities)
def test_relaxation_rate_is_an_eigenvalue_of_the_collisions(name: str, d: float) -> None:
    """Of FHP, of both components of the shear stress; c_x c_y is 0 in HPP."""
    c = VELOCITIES[name].cartesian
    stresses = [c[:, 0] ** 2 - c[:, 1] ** 2, c[:, 0] * c[:, 1]][: 1 if name == "hpp" else 2]
    for stress in stresses:
        assert rate_of(name, d, stress) == pytest.approx(known.relaxation_rate(name, d), rel=1e-11, abs=1e-13)
        found = linearised_collision(name, np.full(len(c), d)) @ stress
        np.testing.assert_allclose(found, -known.relaxation_rate(name, d) * stress, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", MODELS)
def test_what_is_conserved_does_not_relax(name: str) -> None:
    c = VELOCITIES[name].cartesian
    for moment in (np.ones(len(c)), *c.T):
        assert rate_of(name, 0.3, moment) == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("name", MODELS)
def test_speed_of_sound_is_that_of_the_velocities(name: str) -> None:
    assert known.SOUND_SPEED[name] == pytest.approx(math.sqrt((VELOCITIES[name].cartesian ** 2).mean()), rel=1e-15)


@pytest.mark.parametrize("name", MODELS)
def test_long_sound_is_damped_by_the_longitudinal_viscosity(name: str) -> None:
    k = 2 * math.pi / (4000 * VELOCITIES[name].row_height)
    for density in (0.2, 0.5):
        found = modes(name, density, (0.0, k))
        assert 2 * found.sound_damping / k**2 == pytest.approx(known.longitudinal_viscosity(name, density), rel=1e-3)
        assert found.sound_frequency / k == pytest.approx(known.SOUND_SPEED[name], rel=1e-5)


@pytest.mark.parametrize("name", MODELS)
def test_fluctuations_of_the_stress_give_the_viscosities(name: str) -> None:
    c_x, c_y = VELOCITIES[name].cartesian.T
    for density in (0.2, 0.5):
        found = green_kubo(name, density, c_y**2 - known.SOUND_SPEED[name] ** 2, 0.0)
        assert found == pytest.approx(known.longitudinal_viscosity(name, density), rel=1e-12)
        if name != "hpp":
            found = green_kubo(name, density, c_x * c_y, 0.0)
            assert found == pytest.approx(known.shear_viscosity(name, density), rel=1e-12)


@pytest.mark.parametrize("name", FHP)
@given(density=densities, frequency=st.floats(0.0, 3.0))
def test_a_stress_that_decays_by_one_rate_has_the_sum_of_a_geometric_series(
    name: str, density: float, frequency: float
) -> None:
    c_x, c_y = VELOCITIES[name].cartesian.T
    kept = 1 - known.relaxation_rate(name, density)
    expected = ((1 / (1 - kept * cmath.exp(1j * frequency))).real - 0.5) / 4
    assert green_kubo(name, density, c_x * c_y, frequency) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", FHP)
def test_long_shear_waves_have_the_viscosity_and_drift_with_g(name: str) -> None:
    k, u = 2 * math.pi / (4000 * VELOCITIES[name].row_height), 1e-3
    for density in (0.2, 0.4):
        found = modes(name, density, (0.0, k), (0.0, u))
        assert found.shear_decay / k**2 == pytest.approx(known.shear_viscosity(name, density), rel=1e-3)
        assert found.shear_frequency / (k * u) == pytest.approx(known.galilean_factor(name, density), rel=1e-3)


@pytest.mark.parametrize("name", FHP)
@pytest.mark.parametrize("density", [0.15, 0.5, 0.8])
def test_long_waves_have_the_transport_coefficients(name: str, density: float) -> None:
    """Each approaches its limit as k^2, in any direction."""
    nu, bulk = known.shear_viscosity(name, density), known.bulk_viscosity(name, density)
    limits = np.array([nu, known.SOUND_SPEED[name], (nu + bulk) / 2])
    # short enough for the expansion: k nu and k zeta/rho are the small parameters
    longest = 0.01 / max(1.0, nu, bulk)
    for angle in (0.0, 0.3, math.pi / 2):
        error = []
        for k in (longest, longest / 2):
            found = modes(name, density, (k * math.cos(angle), k * math.sin(angle)))
            rates = found.shear_decay / k**2, found.sound_frequency / k, found.sound_damping / k**2
            error.append(np.array(rates) - limits)
            assert found.shear_frequency == pytest.approx(0, abs=1e-14)
            assert found.kinetic < 1
        assert (np.abs(error[0]) < 5e-3 * limits).all()
        resolved = np.abs(error[1]) > 1e-7
        np.testing.assert_allclose((error[0] / error[1])[resolved], 4, rtol=0.03)


def test_sound_in_hpp_along_an_axis() -> None:
    """alpha = k^2/4 (1/lambda - 1/2), lambda = 4 d (1 - d); the transverse momentum of each line is kept."""
    k = 1e-3
    for d in DENSITIES:
        for wavevector in ((k, 0), (0, -k)):
            found = modes("hpp", d, wavevector)
            assert found.sound_frequency == pytest.approx(0.5**0.5 * k, rel=1e-5)
            assert found.sound_damping == pytest.approx(k**2 / 4 * (1 / (4 * d * (1 - d)) - 0.5), rel=1e-5)
            assert found.shear_decay == pytest.approx(0, abs=1e-14)
            assert found.kinetic == pytest.approx(1 - 4 * d * (1 - d), abs=1e-5)
    diagonal = modes("hpp", 0.5, (k / 2**0.5, k / 2**0.5))
    assert diagonal.shear_decay == pytest.approx(k**2 / 4, rel=1e-5)
    assert diagonal.sound_damping == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize("d", DENSITIES)
def test_slowest_of_the_other_modes(d: float) -> None:
    """Of FHP-I: the shear stress, or what triples change, at the rate 6 d^2 (1 - d)^2."""
    rates = 3 * d * (1 - d) ** 3, 6 * d**2 * (1 - d) ** 2
    assert modes("fhp1", d, (0.0, 1e-4)).kinetic == pytest.approx(max(abs(1 - rate) for rate in rates), abs=1e-5)


@pytest.mark.parametrize("name", FHP)
def test_modes_of_a_moving_gas(name: str) -> None:
    """A shear wave drifts with g u.k, not u.k; along u sound is faster, and the wave of -k is the other one."""
    d, k, u = 0.2, 1e-3, 1e-3
    g = known.galilean_factor(name, d)
    across = modes(name, d, (0, k), (u, 0))
    assert across.shear_frequency == pytest.approx(0, abs=1e-13)
    found, other, at_rest = modes(name, d, (k, 0), (u, 0)), modes(name, d, (-k, 0), (u, 0)), modes(name, d, (k, 0))
    assert found.shear_frequency == pytest.approx(g * k * u, rel=1e-4)
    assert found.sound_frequency > at_rest.sound_frequency > other.sound_frequency > 0
    assert other.shear_frequency == pytest.approx(-found.shear_frequency, rel=1e-6)
    f, c = fermi_dirac(name, d, (u, 0)), VELOCITIES[name].cartesian
    values = np.linalg.eigvals((np.eye(len(c)) + linearised_collision(name, f)) * np.exp(-1j * k * c[:, 0]))
    both = {complex(np.exp(-m.sound_damping - 1j * s * m.sound_frequency)) for m, s in ((found, 1), (other, -1))}
    for value in both:
        assert np.abs(values - value).min() < 1e-14


@pytest.mark.parametrize("name", FHP)
def test_staggered_momentum_is_conserved_too(name: str) -> None:
    """A spurious invariant (Kadanoff, McNamara and Zanetti 1989): the momentum across rows, with the rows' parity."""
    c = VELOCITIES[name].cartesian
    turned = np.exp(-2j * math.pi / 3**0.5 * c[:, 1])
    values = np.linalg.eigvals((np.eye(len(c)) + linearised_collision(name, np.full(len(c), 0.3))) * turned)
    assert np.abs(values + 1).min() < 1e-13
