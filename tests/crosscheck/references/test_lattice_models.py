"""Lattice gases as printed: against lists of collisions, sums in other orders, differences, and `refimpl`.

The thesis is M. Pliego Diaz, Simulaciones hidrodinamicas bidimensionales usando modelos discretos, UNAM (1991).
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from lattice_gases import table_of

from crosscheck.references import lattice_models as known
from refimpl.lattice.equilibrium import fermi_dirac
from refimpl.lattice.models import MODELS

each_model = pytest.mark.parametrize("name", known.MODELS)
occupation = st.floats(0.01, 0.99)


def draw_occupations(data: st.DataObject, name: str) -> np.ndarray:
    return np.array(data.draw(arrays(np.float64, known.VELOCITIES[name].channels, elements=occupation)))


# -- velocities --------------------------------------------------------------------------------------------------------


@each_model
def test_velocities_are_unit_vectors_in_order(name: str) -> None:
    velocities = known.VELOCITIES[name]
    moving = velocities.channels - velocities.rest
    angles = 2 * math.pi * np.arange(moving) / moving
    np.testing.assert_allclose(
        velocities.cartesian[:moving], np.stack([np.cos(angles), np.sin(angles)], axis=1), atol=1e-15
    )
    assert not velocities.cartesian[moving:].any()
    assert velocities.row_height == pytest.approx(math.sin(angles[1]), rel=1e-15)
    np.testing.assert_array_equal(velocities.cartesian, MODELS[name].velocities.cartesian)


@each_model
def test_momentum_is_in_whole_numbers(name: str) -> None:
    velocities = known.VELOCITIES[name]
    counts = np.random.default_rng(1).integers(0, 10, (3, 2, velocities.channels)).astype(float)
    found = known.momenta(name, counts)
    np.testing.assert_array_equal(found, np.round(found))
    np.testing.assert_allclose(found * velocities.unit, counts @ velocities.cartesian, atol=1e-12)


@each_model
def test_momentum_flux_of_single_particles(name: str) -> None:
    c = known.VELOCITIES[name].cartesian
    for i, velocity in enumerate(c):
        np.testing.assert_array_equal(known.momentum_flux(name, np.eye(len(c))[i]), np.outer(velocity, velocity))


# -- equilibrium -------------------------------------------------------------------------------------------------------


@each_model
@given(h=st.floats(-2, 2), q=st.tuples(st.floats(-1, 1), st.floats(-1, 1)))
def test_fermi_dirac_finds_the_occupations_of_h_and_q(name: str, h: float, q: tuple[float, float]) -> None:
    c = known.VELOCITIES[name].cartesian
    f = 1 / (1 + np.exp(h + c @ q))
    found = known.fermi_dirac(name, f.mean(), f @ c / f.sum())
    np.testing.assert_allclose(found, f, rtol=0, atol=1e-14)
    np.testing.assert_allclose(found, fermi_dirac(MODELS[name].velocities, f.mean(), f @ c / f.sum()), atol=1e-14)


def test_fermi_dirac_that_there_is_not() -> None:
    with pytest.raises((ArithmeticError, np.linalg.LinAlgError)):
        known.fermi_dirac("fhp1", 0.5, (0.9, 0.0))


@each_model
def test_low_speed_equilibrium(name: str) -> None:
    """Right to O(u^2), by its distance from Fermi-Dirac; and the sums are exact."""
    c, u = known.VELOCITIES[name].cartesian, np.array([0.06, 0.02])
    for d in (0.15, 0.3, 0.5):
        found = known.low_speed_equilibrium(name, d, u)
        np.testing.assert_allclose([found.sum(), *(found @ c)], len(c) * d * np.array([1, *u]), rtol=0, atol=1e-15)
        far, near = (
            np.abs(known.fermi_dirac(name, d, v) - known.low_speed_equilibrium(name, d, v)).max() for v in (u, u / 2)
        )
        assert far < 1e-15 or far / near > 2**2.9


@each_model
@pytest.mark.parametrize("d", [0.15, 0.5, 0.7])
def test_order_of_the_low_speed_expansion(name: str, d: float) -> None:
    """The odd part is wrong by O(u^3), the even part by O(u^4); at half filling there is no even part at all.

    On the square lattice there is no odd one: f_i - f_-i = 2 d u.c_i is exact.
    """
    odd, even = [], []
    for u in (np.array([0.06, 0.02]), np.array([0.03, 0.01])):
        there, back = (known.fermi_dirac(name, d, v) - known.low_speed_equilibrium(name, d, v) for v in (u, -u))
        odd.append(np.abs(there - back).max() / 2)
        even.append(np.abs(there + back).max() / 2)
    if name == "hpp":
        assert max(odd) < 1e-15
    else:
        assert 2**2.9 < odd[0] / odd[1] < 2**3.1
    if d == 0.5:
        assert max(even) < 1e-15
    else:
        assert 2**3.9 < even[0] / even[1] < 2**4.1


@pytest.mark.parametrize("name", ["hpp", "fhp1"])
def test_low_speed_equilibrium_is_that_of_the_thesis(name: str) -> None:
    """(3.60), with rho D/(c^2 b) in the linear term: as printed, with d for b, the momentum is not rho u."""
    u, c, dimension = np.array([0.1, 0.05]), known.VELOCITIES[name].cartesian, 2
    b = len(c)
    for d in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6):
        rho = b * d
        g = dimension**2 / (2 * b) * (b - 2 * rho) / (b - rho)
        q = np.einsum("ia,ib->iab", c, c) - np.eye(2) / dimension
        expected = rho / b + rho * dimension / b * (c @ u) + rho * g * np.einsum("iab,a,b->i", q, u, u)
        np.testing.assert_allclose(known.low_speed_equilibrium(name, d, u), expected, rtol=1e-14)


@given(f=arrays(np.float64, (2, 6), elements=st.floats(0, 1)))
def test_entropy_density(f: np.ndarray) -> None:
    from scipy.special import xlogy

    np.testing.assert_allclose(
        known.entropy_density(f), (xlogy(f, f) + xlogy(1 - f, 1 - f)).sum(axis=-1), rtol=0, atol=1e-13
    )


# -- collisions --------------------------------------------------------------------------------------------------------


def code(*channels: int) -> int:
    return sum(1 << i for i in channels)


def turned(classes: list[list[int]], size: int) -> np.ndarray:
    """A of disjoint classes of states, within which every other state is equally likely."""
    a = np.eye(size)
    for one in classes:
        for s, t in product(one, one):
            a[s, t] = 0.0 if s == t else 1 / (len(one) - 1)
    return a


def listed(name: str) -> np.ndarray:
    """The collisions that the papers draw, one by one."""
    if name == "hpp":
        return turned([[code(0, 2), code(1, 3)]], 16)
    pairs, triples = [code(i, i + 3) for i in range(3)], [code(0, 2, 4), code(1, 3, 5)]
    if name == "fhp1":
        return turned([pairs, triples], 64)
    rest = code(6)
    merging = [[code(6, i), code((i + 1) % 6, (i + 5) % 6)] for i in range(6)]
    beside = [[state | rest for state in one] for one in (pairs, triples)]
    return turned([pairs, triples, *beside, *merging], 128)


@pytest.mark.parametrize("name", ["hpp", "fhp1", "fhp2"])
def test_collisions_of_the_first_papers(name: str) -> None:
    np.testing.assert_array_equal(known.transitions(name), listed(name))


def test_every_model_is_known() -> None:
    assert set(known.MODELS) == set(MODELS)


@each_model
def test_transitions_conserve_and_are_those_of_refimpl(name: str) -> None:
    a, s = known.transitions(name), known.states(name)
    np.testing.assert_allclose(a.sum(axis=0), 1, rtol=1e-14)  # semi-detailed balance
    np.testing.assert_allclose(a.sum(axis=1), 1, rtol=1e-14)
    charges = np.column_stack([s.sum(axis=1), known.momenta(name, s)])
    np.testing.assert_allclose(a @ charges, charges, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(a, table_of(MODELS[name]))


@each_model
def test_saturated_models_lack_no_collision(name: str) -> None:
    """Where all collisions are meant, states of equal mass and momentum can become each other."""
    if "saturated" not in name and name != "hpp":
        return
    a, s = known.transitions(name), known.states(name)
    for one, other in product(range(len(s)), repeat=2):
        alike = s[one].sum() == s[other].sum() and (known.momenta(name, s[one] - s[other]) == 0).all()
        assert (a[one, other] > 0) <= alike
        if alike and one != other:
            assert a[one, other] > 0


@each_model
@given(data=st.data())
def test_mean_collision_and_its_slope(name: str, data: st.DataObject) -> None:
    """The sum over all states; and J by differences."""
    f = draw_occupations(data, name)
    s, a = known.states(name), known.transitions(name)
    probability = np.exp((s * np.log(f) + (1 - s) * np.log(1 - f)).sum(axis=1))
    np.testing.assert_allclose(known.mean_collision(name, f), probability @ (a @ s - s), rtol=0, atol=1e-15)
    eps, slope = 1e-5, known.linearised_collision(name, f)
    for j, unit in enumerate(np.eye(f.size)):
        up, down = known.mean_collision(name, f + eps * unit), known.mean_collision(name, f - eps * unit)
        np.testing.assert_allclose(slope[:, j], (up - down) / (2 * eps), rtol=0, atol=1e-9)


@each_model
@pytest.mark.parametrize("d", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
def test_linearised_collision_is_that_of_the_thesis(name: str, d: float) -> None:
    """(3.89), p = sum_i s_i."""
    s, a = known.states(name), known.transitions(name)
    p = s.sum(axis=1)
    weight = a * (d ** (p - 1.0) * (1 - d) ** (s.shape[1] - p - 1.0))[:, None]
    difference = s[:, None, :] - s[None, :, :]
    expected = -0.5 * np.einsum("sti,st,stj->ij", difference, weight, difference)
    found = known.linearised_collision(name, np.full(s.shape[1], d))
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-15)


@each_model
@given(data=st.data())
def test_collisions_conserve_and_leave_equilibrium_alone(name: str, data: st.DataObject) -> None:
    f = draw_occupations(data, name)
    charges = np.column_stack([np.ones(f.size), known.VELOCITIES[name].cartesian])
    np.testing.assert_allclose(known.mean_collision(name, f) @ charges, 0, atol=1e-14)
    np.testing.assert_allclose(charges.T @ known.linearised_collision(name, f), 0, atol=1e-13)
    u = np.array([(0.0, 0.0), (0.2, 0.0), (-0.05, 0.3)])
    for d in (0.1, 0.35, 0.6):
        equilibrium = known.fermi_dirac(name, np.full(len(u), d), u)
        np.testing.assert_allclose(known.mean_collision(name, equilibrium), 0, atol=3e-16)


# -- modes -------------------------------------------------------------------------------------------------------------


def modes_by_what_they_carry(name: str, density: float, k: np.ndarray, flow: tuple[float, float]) -> list[float]:
    """Decay and frequency of shear and of sound, as `Modes` has them.

    Shear has the largest part in the autocorrelation of the transverse momentum, sound in that of c_s times mass plus
    longitudinal momentum.
    """
    along = k / np.linalg.norm(k)
    c, f = known.VELOCITIES[name].cartesian, known.fermi_dirac(name, density, flow)
    speed = float((c**2).mean()) ** 0.5
    values, right = np.linalg.eig((np.eye(len(c)) + known.linearised_collision(name, f)) * np.exp(-1j * (c @ k)))
    left = np.linalg.inv(right)
    # rows: mass, momentum along k, momentum across k; `prepared` changes one of them alone, within local equilibrium
    conserved = np.stack([np.ones(len(c)), c @ along, c @ np.array([-along[1], along[0]])])
    response = f * (1 - f) * conserved
    prepared = response.T @ np.linalg.inv(conserved @ response.T)

    def part(measured: list[float], excited: list[float]) -> np.ndarray:
        return np.abs((np.array(measured) @ conserved @ right) * (left @ prepared @ np.array(excited)))

    shear = int(part([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]).argmax())
    wave = part([speed, 1.0, 0.0], [1.0, speed, 0.0])
    wave[shear] = 0
    exponents = np.log(values[[shear, int(wave.argmax())]])
    return [-float(part) for one in exponents for part in (one.real, one.imag)]


@each_model
@pytest.mark.parametrize("density", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("flow", [(0.0, 0.0), (0.0, 0.1), (0.1, 0.05)])
def test_the_slowest_modes_carry_mass_and_momentum(name: str, density: float, flow: tuple[float, float]) -> None:
    for k in ((0.0, 2 * math.pi / 111), (math.pi / 300, 0.0), (0.0, -0.05)):
        found = known.modes(name, density, k, flow)
        assert found[:4] == pytest.approx(
            modes_by_what_they_carry(name, density, np.array(k), flow), rel=1e-9, abs=1e-13
        )


@each_model
def test_modes_are_those_of_the_boltzmann_iteration(name: str) -> None:
    """Step by step: after the fast modes died, momentum across k decays as shear, mass as sound."""
    c, d, k = known.VELOCITIES[name].cartesian, 0.3, np.array([0.0, 0.06])
    found = known.modes(name, d, k)
    step = np.exp(-1j * (c @ k))
    collide = np.eye(len(c)) + known.linearised_collision(name, np.full(len(c), d))
    a, across = c[:, 0].astype(complex), []
    for _ in range(400):
        across.append(c[:, 0] @ a)
        a = step * (collide @ a)
    assert abs(across[-1] / across[-2]) == pytest.approx(math.exp(-found.shear_decay), rel=1e-10)
    a, mass = np.ones(len(c), dtype=complex), []
    for _ in range(400):
        mass.append(a.sum())
        a = step * (collide @ a)
    # two waves, there and back: m(t + 1) + m(t - 1) e^(-2 alpha) = 2 e^(-alpha) cos(omega) m(t)
    decay, turn = math.exp(-found.sound_damping), math.cos(found.sound_frequency)
    left = mass[-1] + decay**2 * mass[-3]
    assert left == pytest.approx(2 * decay * turn * mass[-2], rel=1e-9)
