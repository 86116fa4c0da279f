"""Hertz and Mindlin against derivatives, and against numbers from the textbook."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references.hertz_mindlin import (
    Material,
    Pressed,
    normal_modulus,
    overlap_under,
    tangential_modulus,
)
from crosscheck.references.soft_impact import HERTZ_TIME, HertzImpact

materials = st.builds(Material, st.floats(1.0, 1e9), st.floats(-0.5, 0.5))


@given(materials, materials)
def test_moduli_are_symmetric_and_those_of_springs_in_series(one: Material, other: Material) -> None:
    for modulus in (normal_modulus, tangential_modulus):
        assert modulus(one, other) == pytest.approx(modulus(other, one), rel=1e-14)
        alone = [2 * modulus(body, body) for body in (one, other)]
        assert 1 / modulus(one, other) == pytest.approx(1 / alone[0] + 1 / alone[1], rel=1e-12)


@given(materials, st.floats(0.1, 10.0), st.floats(1e-6, 1e-2))
def test_stiffnesses(material: Material, radius: float, overlap: float) -> None:
    """dF/d delta by differences; the ratio of Mindlin; and the inverse of the force."""
    pressed = Pressed(material, radius, overlap)
    step = 1e-4 * overlap
    forces = [pressed._replace(overlap=overlap + sign * step).force for sign in (1, -1)]
    assert (forces[0] - forces[1]) / (2 * step) == pytest.approx(pressed.normal_stiffness, rel=1e-8)
    ratio = 2 * (1 - material.poisson) / (2 - material.poisson)
    assert pressed.tangential_stiffness / pressed.normal_stiffness == pytest.approx(ratio, rel=1e-12)
    assert overlap_under(pressed.force, material, radius) == pytest.approx(overlap, rel=1e-12)


def test_two_steel_balls() -> None:
    """Two balls of 20 mm pressed by 100 N: a^3 = 3 F R/(4 E_eff), E_eff = 206e9/(2 (1 - 0.3^2)) Pa, R = 5 mm."""
    steel = Material(206e9, 0.3)
    assert normal_modulus(steel, steel) == pytest.approx(113.187e9, rel=1e-5)
    assert steel.shear == pytest.approx(79.2308e9, rel=1e-5)
    pressed = Pressed(steel, 5e-3, overlap_under(100.0, steel, 5e-3))
    assert pressed.circle == pytest.approx((3 * 100 * 5e-3 / (4 * 113.187e9)) ** (1 / 3), rel=1e-5)
    assert pressed.force == pytest.approx(100.0, rel=1e-12)


def test_duration_of_an_impact_in_landau_and_lifshitz() -> None:
    """t = 2.94 (m^2/(k^2 v))^(1/5) with F = k delta^(3/2), m the reduced mass over 5/4."""
    material, radius, mass, speed = Material(2e6, 0.3), 0.25, 0.5, 0.7
    force = 4 / 3 * normal_modulus(material, material) * math.sqrt(radius)
    impact = HertzImpact(mass, 4 / 3 * normal_modulus(material, material), radius, speed)
    expected = HERTZ_TIME * ((1.25 * mass / force) ** 2 / speed) ** 0.2
    assert impact.contact_time == pytest.approx(expected, rel=1e-12)
    assert pytest.approx(2.94, abs=5e-3) == HERTZ_TIME
