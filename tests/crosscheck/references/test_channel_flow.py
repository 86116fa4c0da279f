"""Sound along a channel against its equation and its limits; a forced flow against the closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_banded
from scipy.special import sici

from crosscheck.references import channel_flow as known
from crosscheck.references.lattice_gas import shear_viscosity

# -- forced flow -------------------------------------------------------------------------------------------------------


@given(force=st.floats(-2, 2), spacing=st.floats(0.1, 2), places=st.integers(2, 50))
def test_a_uniform_force_makes_a_parabola(force: float, spacing: float, places: int) -> None:
    y, height = np.arange(places) * spacing, places * spacing
    profile, total = known.forced_profile(np.full(places, force), spacing)
    np.testing.assert_allclose(profile, force * y * (height - y) / 2, rtol=0, atol=1e-12 * (1 + abs(force) * height**2))
    assert total == pytest.approx(force * height, rel=1e-12, abs=1e-300)


def test_a_force_of_one_wave() -> None:
    """F = sin(2 pi y/H): G = F (H/2 pi)^2, to second order in the spacing."""
    errors = []
    for places in (32, 64):
        y = np.arange(places) / places
        force = np.sin(2 * np.pi * y)
        errors.append(np.abs(known.forced_profile(force, 1 / places)[0] - force / (2 * np.pi) ** 2).max())
    assert errors[0] < 4e-3 / (2 * np.pi) ** 2
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.02)


def test_second_differences_are_the_force() -> None:
    force = np.random.default_rng(1).random(20)
    profile, total = known.forced_profile(force, 0.5)
    np.testing.assert_allclose(np.diff([*profile, 0.0], 2), -force[1:] * 0.25, rtol=0, atol=1e-13)
    assert profile[0] == 0
    assert total == pytest.approx(0.5 * force.sum(), rel=1e-14)


# -- sound -------------------------------------------------------------------------------------------------------------

C = math.sqrt(0.5)


@given(
    c=st.floats(0.3, 1.0),
    nu=st.floats(1e-3, 1.0),
    k=st.floats(1e-3, 0.05),
    layers=st.floats(10, 1000),
)
def test_channel_sound_solves_its_equation(c: float, nu: float, k: float, layers: float) -> None:
    height = layers * math.sqrt(2 * nu / (c * k))
    s = known.channel_sound(c, nu, k, height)
    q = height / 2 * np.sqrt(s / nu)
    terms = (s**2 / (1 - np.tanh(q) / q), nu * k**2 * s, c**2 * k**2)
    assert abs(sum(terms)) < 1e-9 * abs(terms[2])
    assert s.imag > 0 > s.real


@given(c=st.floats(0.3, 1.0), k=st.floats(1e-3, 0.1), height=st.floats(10, 1000))
def test_channel_sound_without_viscosity(c: float, k: float, height: float) -> None:
    assert known.channel_sound(c, 1e-16, k, height) == pytest.approx(1j * c * k, rel=1e-5)


@given(nu=st.floats(0.01, 1.0), k=st.floats(1e-4, 1e-2), layers=st.floats(100, 1e4))
def test_channel_sound_between_distant_walls(nu: float, k: float, layers: float) -> None:
    """omega = c k (1 - delta/2H), alpha = omega delta/2H + nu k^2/2, to the next order in delta/H and nu k/c."""
    delta = math.sqrt(2 * nu / (C * k))
    height = layers * delta
    s = known.channel_sound(C, nu, k, height)
    part = delta / (2 * height)
    next_order = 3 * (part + nu * k / C) ** 2 * C * k
    assert s.imag == pytest.approx(C * k * (1 - part), rel=0, abs=next_order)
    assert -s.real == pytest.approx(C * k * part + nu * k**2 / 2, rel=0, abs=next_order)


@pytest.mark.parametrize(
    ("density", "period", "damping"),
    [(0.1, 899, 7.1), (0.2, 874, 4.3), (0.3, 864, 3.1), (0.4, 858, 2.6), (0.5, 857, 2.4), (0.6, 858, 2.6)],
)
def test_channel_sound_in_the_box_of_the_thesis(density: float, period: int, damping: float) -> None:
    nu = shear_viscosity("fhp_saturated", density)
    s = known.channel_sound(C, nu, math.pi / 294, 85.7)
    assert round(2 * math.pi / s.imag) == period
    assert round(-s.real * 1e4, 1) == damping


@given(nu=st.floats(0.01, 1.0), k=st.floats(1e-3, 1e-2), slip=st.floats(-0.5, 2.0))
def test_channel_sound_with_slip_is_that_of_layers_solved_over_the_height(nu: float, k: float, slip: float) -> None:
    """s u = -i k c^2 rho + nu u'' with u = b du/dn at both walls, by finite differences, at the s that is found."""
    height = 40 * math.sqrt(2 * nu / (C * k))
    s = known.channel_sound(C, nu, k, height, slip)
    n = 4000
    h = height / n
    # cells' middles; beyond a wall the line through u there, whose gradient into the fluid is u over the slip
    inside = (2 * slip - h) / (2 * slip + h)
    diagonal = np.full(n, s / nu + 2 / h**2)
    diagonal[[0, -1]] -= inside / h**2
    flow = solve_banded((1, 1), np.array([np.full(n, -1 / h**2), diagonal, np.full(n, -1 / h**2)]), np.ones(n))
    # averaged: u' of the wall over the height is what the layers take
    layers = s / nu * flow.mean()
    rate = s**2 / layers + nu * k**2 * s + C**2 * k**2
    assert abs(rate) < 2e-4 * C**2 * k**2


def test_a_lagging_viscosity_is_the_transform_of_its_tail() -> None:
    """nu(omega) = nu_0 + int A exp(-i omega t)/t from a short time on, at two frequencies a factor of four apart."""
    tail, start = 0.03, 1.0

    def transformed(omega: float) -> complex:
        cosine, sine = sici(omega * start)[1], sici(omega * start)[0]
        return tail * complex(-cosine, -(math.pi / 2 - sine))

    fast, slow = transformed(4e-4), transformed(1e-4)
    lagging = known.lagging_viscosity(0.1 + fast.real, 0.1 + slow.real)
    assert lagging.real == pytest.approx(0.1 + fast.real)
    assert lagging.imag == pytest.approx(fast.imag, rel=1e-3)
