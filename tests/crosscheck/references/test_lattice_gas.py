"""Closed forms of lattice gases against the theory of any table, and the numbers of the thesis against one another."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references import lattice_gas as known
from refimpl.lattice import theory
from refimpl.lattice.models import MODELS

FHP = tuple(name for name in MODELS if name != "hpp")
densities = st.floats(0.01, 0.99)


# -- closed forms ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
@given(d=densities)
def test_relaxation_rate(name: str, d: float) -> None:
    c = MODELS[name].velocities.cartesian
    stress = c[:, 0] ** 2 - c[:, 1] ** 2 if name == "hpp" else c[:, 0] * c[:, 1]
    assert known.relaxation_rate(name, d) == pytest.approx(theory.relaxation_rate(MODELS[name], d, stress), rel=1e-9)


@pytest.mark.parametrize("name", FHP)
@given(d=densities)
def test_viscosities_and_galilean_factor(name: str, d: float) -> None:
    model = MODELS[name]
    # differences of nearly equal terms where a viscosity passes through zero
    near = {"rel": 1e-9, "abs": 1e-9}
    assert known.shear_viscosity(name, d) == pytest.approx(theory.shear_viscosity(model, d), **near)
    assert known.bulk_viscosity(name, d) == pytest.approx(theory.bulk_viscosity(model, d), **near)
    assert known.galilean_factor(name, d) == pytest.approx(theory.galilean_factor(model.velocities, d), **near)


@pytest.mark.parametrize("name", MODELS)
def test_speed_of_sound(name: str) -> None:
    assert known.SOUND_SPEED[name] == pytest.approx(theory.sound_speed(MODELS[name].velocities), rel=1e-15)


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
    found = [known.shear_viscosity(name, d) for d in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)]
    np.testing.assert_allclose(found, VISCOSITIES[name], rtol=0, atol=5.1e-6)


def test_what_there_is_not() -> None:
    with pytest.raises(ValueError, match="HPP is not isotropic and has no shear viscosity"):
        known.shear_viscosity("hpp", 0.3)
    with pytest.raises(KeyError):
        known.relaxation_rate("fhp", 0.3)


# -- sound in a channel ------------------------------------------------------------------------------------------------

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
    nu = known.shear_viscosity("fhp_saturated", density)
    s = known.channel_sound(C, nu, math.pi / 294, 85.7)
    assert round(2 * math.pi / s.imag) == period
    assert round(-s.real * 1e4, 1) == damping


# -- the thesis --------------------------------------------------------------------------------------------------------


def test_modes_of_half_a_sine_sum_to_it() -> None:
    number = 2000
    x = np.linspace(0, 1, 201)
    b = known.half_sine_modes(number)
    cosines = np.cos(np.pi * np.arange(1, number + 1) * x[:, None])
    # what is left out is less than the sum of 8/(pi n^2) over odd n
    np.testing.assert_allclose(cosines @ b, np.sin(2 * np.pi * x), rtol=0, atol=4 / (math.pi * (number - 2)))


def test_modes_of_half_a_sine_are_its_projections() -> None:
    from scipy.integrate import quad

    for n, b in enumerate(known.half_sine_modes(7), start=1):
        projection = 2 * quad(lambda x, n=n: math.sin(2 * math.pi * x) * math.cos(n * math.pi * x), 0, 1)[0]
        assert b == pytest.approx(projection, abs=1e-12)
    np.testing.assert_allclose(known.half_sine_modes(3), [0.849, 0, -0.509], atol=5e-4)


def test_viscosities_of_the_thesis_are_whole_slopes() -> None:
    """nu = 2 L^2/pi^2 alpha with slopes in whole 1e-4: multiples of 1.7405, to the last digits of both."""
    slopes = {d: [round(nu / 1.7405) for nu in pair] for d, pair in known.THESIS_VISCOSITY.items()}
    assert slopes == {0.1: [81, 81], 0.2: [50, 51], 0.3: [36, 33], 0.4: [28, 28], 0.5: [22, 21], 0.6: [26, 25]}
    for d, pair in known.THESIS_VISCOSITY.items():
        for nu, slope in zip(pair, slopes[d], strict=True):
            assert abs(nu - 1.7405 * slope) <= 0.005 + 5e-5 * slope + 1e-9
    assert math.sqrt(1.7405e4 * math.pi**2 / 2) == pytest.approx(293, abs=0.5)


def test_periods_and_speeds_of_the_thesis_are_consistent() -> None:
    period, speed = known.THESIS_FHP
    assert 2 * 295 / period == pytest.approx(speed, abs=1e-4)
    assert period == pytest.approx(10240 / 13, rel=1e-3)
    period, speed = known.THESIS_HPP
    assert 305 / period == pytest.approx(speed, abs=1e-4)
