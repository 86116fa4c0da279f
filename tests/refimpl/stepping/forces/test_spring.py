"""Damped springs: the closed form, the energy, the higher derivatives, the errors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from energies import potential_energy, virial
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from refimpl.stepping.forces.generic import (
    GOOD,
    accelerate,
    derivatives,
    kinetic_energy,
    status,
)
from refimpl.stepping.forces.spring import Spring, spring

positive = st.floats(1e-3, 1e3)
coordinates = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=12).map(np.array)


@njit
def _every_answer(force, r, v):  # type: ignore[no-untyped-def]
    a = accelerate(force, r, v)
    higher = derivatives(force, r, v, 3)
    return a, higher, potential_energy(force, r), kinetic_energy(force, v), virial(force, r), status(force)


@settings(deadline=None)
@given(positive, positive, st.none() | positive, coordinates)
def test_acceleration_is_hookes_and_stokes_law(k: float, mass: float, gamma: float | None, r: np.ndarray) -> None:
    v = r[::-1].copy()
    expected = [-(k * x + (gamma or 0.0) * u) / mass for x, u in zip(r, v, strict=True)]
    bound = 1e-14 * (k + (gamma or 0.0)) / mass * np.abs(r).max() + 1e-300  # or subnormal
    np.testing.assert_allclose(accelerate(spring(k, mass, gamma), r, v), expected, rtol=1e-14, atol=bound)


@pytest.mark.parametrize("gamma", [0.0, 0.4])
def test_closed_form_satisfies_the_equation_of_motion(gamma: float) -> None:
    k, mass = 2.0, 0.5
    force = spring(k, mass, gamma)
    # r = exp(p t) with m p^2 + gamma p + k = 0, real part
    p = -gamma / (2 * mass) + 1j * math.sqrt(k / mass - (gamma / (2 * mass)) ** 2)
    t = np.linspace(0.0, 5.0, 41)
    moved = [(p**q * np.exp(p * t)).real for q in range(6)]
    np.testing.assert_allclose(accelerate(force, moved[0], moved[1]), moved[2], atol=1e-13)
    np.testing.assert_allclose(derivatives(force, moved[0], moved[1], 3), moved[3:], atol=1e-12)


def test_no_damping_is_damping_of_zero() -> None:
    r, v = np.array([0.3, -1.2]), np.array([2.0, 0.7])
    pruned, kept = spring(2.0, 3.0), Spring(2.0, 3.0, 0.0)
    assert pruned.gamma is None
    assert spring(2.0, 3.0, gamma=0.0).gamma is None
    np.testing.assert_array_equal(accelerate(pruned, r, v), accelerate(kept, r, v))
    np.testing.assert_array_equal(derivatives(pruned, r, v, 3), derivatives(kept, r, v, 3))


@settings(deadline=None)
@given(positive, positive, coordinates)
def test_energies_and_virial(k: float, mass: float, r: np.ndarray) -> None:
    force = spring(k, mass)
    assert potential_energy(force, r) == pytest.approx(0.5 * k * math.fsum(r**2), rel=1e-13)
    assert kinetic_energy(force, r) == pytest.approx(0.5 * mass * math.fsum(r**2), rel=1e-13)
    # r . F; U is homogeneous of degree 2
    assert virial(force, r) == pytest.approx(mass * float(r @ accelerate(force, r, r)), rel=1e-12)
    assert virial(force, r) == pytest.approx(-2 * potential_energy(force, r), rel=1e-14)


def test_force_is_minus_the_gradient_of_the_energy() -> None:
    force, r, step = spring(1.7, 0.6), np.array([0.4, -2.0, 1.1]), 1e-4
    a = accelerate(force, r, np.zeros(3))
    for q in range(3):
        change = step * np.eye(3)[q]
        slope = (potential_energy(force, r + change) - potential_energy(force, r - change)) / (2 * step)
        assert 0.6 * a[q] == pytest.approx(-slope, rel=1e-9)


@pytest.mark.parametrize("gamma", [None, 0.3])
def test_same_answers_inside_a_kernel(gamma: float | None) -> None:
    force, r, v = spring(1.3, 0.7, gamma), np.array([1.0, -0.4, 0.2]), np.array([0.1, 0.5, -2.0])
    a, higher, potential, kinetic, w, outcome = _every_answer(force, r, v)
    np.testing.assert_allclose(a, accelerate(force, r, v), rtol=1e-15)
    np.testing.assert_allclose(higher, derivatives(force, r, v, 3), rtol=1e-14)
    assert potential == pytest.approx(potential_energy(force, r), rel=1e-15)
    assert kinetic == pytest.approx(kinetic_energy(force, v), rel=1e-15)
    assert w == pytest.approx(virial(force, r), rel=1e-15)
    assert outcome == status(force) == GOOD


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"k": 0.0}, "stiffness k must be positive and finite, got 0.0"),
        ({"k": math.nan}, "stiffness k must be positive"),
        ({"mass": -1.0}, "mass must be positive and finite, got -1.0"),
        ({"mass": math.inf}, "mass must be positive"),
        ({"gamma": -0.1}, "gamma must be non-negative and finite, got -0.1"),
        ({"gamma": math.nan}, "gamma must be non-negative"),
    ],
)
def test_bad_input_is_named(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        spring(**{"k": 1.0} | arguments)


@settings(deadline=None)
@given(positive, st.none() | positive, st.lists(st.tuples(positive, st.floats(-9, 9)), min_size=2, max_size=6))
def test_every_coordinate_moves_with_its_own_mass(
    k: float, gamma: float | None, particles: list[tuple[float, float]]
) -> None:
    masses, r = map(np.array, zip(*particles, strict=True))
    v = r[::-1].copy()
    force = spring(k, masses, gamma)
    apart = [spring(k, mass, gamma) for mass in masses]
    one_by_one = [accelerate(own, r[i : i + 1], v[i : i + 1])[0] for i, own in enumerate(apart)]
    np.testing.assert_array_equal(accelerate(force, r, v), one_by_one)
    higher = [derivatives(own, r[i : i + 1], v[i : i + 1], 3)[:, 0] for i, own in enumerate(apart)]
    np.testing.assert_array_equal(derivatives(force, r, v, 3), np.transpose(higher))
    kinetic = math.fsum(kinetic_energy(own, v[i : i + 1]) for i, own in enumerate(apart))
    assert kinetic_energy(force, v) == pytest.approx(kinetic, rel=1e-14)


def test_equal_masses_are_one_mass_and_cost_no_array() -> None:
    assert spring(2.0, np.full(4, 3.0)) == spring(2.0, 3.0)


@pytest.mark.parametrize("mass", [np.array([1.0, 0.0]), np.array([1.0, np.nan]), np.zeros(0), np.ones((2, 2))])
def test_bad_masses_are_refused(mass: np.ndarray) -> None:
    with pytest.raises(ValueError, match="mass must be positive and finite"):
        spring(2.0, mass)
