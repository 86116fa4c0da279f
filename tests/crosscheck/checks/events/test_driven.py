"""What the checks of driven systems work out themselves, by a second route."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.events.driven import (
    column_profile,
    enskog_conductivity,
    fixed_energy,
    mean_compressibility,
    neighbour_share,
    structure_factor,
    surface_angle,
)
from crosscheck.checks.events.fields import _through_faces, cell_budgets, temperature
from crosscheck.engines.protocol import Run
from crosscheck.references.hard_spheres import compressibility, packing_fraction


@pytest.mark.parametrize("dimension", [2, 3])
def test_dilute_conductivity_is_the_first_sonine_one_within_3_percent(dimension: int) -> None:
    # kappa = d (d+2)/(2 (d-1)) eta/m, eta = (d+2)/(8 omega) sqrt(pi T) Gamma(d/2) pi^(-d/2), for unit diameter
    d = dimension
    viscosity = (d + 2) / 8 * math.gamma(d / 2) / math.pi ** ((d - 1) / 2) * math.sqrt(2.0)
    first = d * (d + 2) / (2 * (d - 1)) * viscosity
    assert enskog_conductivity(1e-9, 2.0, dimension).value == pytest.approx(1.027 * first, rel=0.003)


@pytest.mark.parametrize("dimension", [2, 3])
def test_dense_conductivity_is_the_square_of_the_transfer_plus_the_collisional_part(dimension: int) -> None:
    # first Sonine: (1/g) ((1 + a y)^2 + c y^2), a = 3/4, c = 1/pi (disks); 3/5, 32/(25 pi) (spheres)
    a, c, sonine = (0.75, 1 / math.pi, 1.02925) if dimension == 2 else (0.6, 32 / (25 * math.pi), 1.02513)
    for n in (0.1, 0.4, 0.7):
        y = compressibility(packing_fraction(n, dimension), dimension).value - 1
        g = y / (math.pi / 2 * n if dimension == 2 else 2 * math.pi / 3 * n)
        dilute = enskog_conductivity(1e-9, 1.0, dimension).value
        expected = dilute / g * ((1 + a * y) ** 2 + c / sonine * y**2)
        assert enskog_conductivity(n, 1.0, dimension).value == pytest.approx(expected, rel=1e-3)


def test_mean_compressibility_of_a_dilute_column_is_that_of_the_second_virial_coefficient() -> None:
    pressure, warmth = 0.02, 2.0
    expected = 1 + math.pi / 2 * pressure / warmth / 2
    assert mean_compressibility(pressure, warmth) == pytest.approx(expected, abs=1e-4)


def test_mean_compressibility_says_when_the_floor_is_too_dense() -> None:
    with pytest.raises(ValueError, match="denser"):
        mean_compressibility(10.0, 1.0)


def test_column_profile_is_barometric_when_dilute_and_has_the_mean_height_of_its_energy() -> None:
    share = np.linspace(0, 0.999, 50)
    np.testing.assert_allclose(column_profile(share, 1e-5, 3.0), -3.0 * np.log1p(-share), atol=1e-3)
    below = (np.arange(200_000) + 0.5) / 200_000
    assert column_profile(below, 0.1, 1.0).mean() == pytest.approx(mean_compressibility(0.1, 1.0), rel=1e-3)


def test_fixed_energy_against_points_drawn_on_the_energy_shell() -> None:
    number, warmth, height = 4, 1.0, 1.3
    rng = np.random.default_rng(3)
    # K of 2N - 1 squares and N heights share the energy as Gamma variables do
    kinetic = rng.gamma((2 * number - 1) / 2, size=400_000)
    heights = rng.exponential(size=(400_000, number))
    energy = (2 * number - 0.5) * warmth
    z = heights[:, 0] * energy / (kinetic + heights.sum(axis=1))
    canonical = 1 - math.exp(-height / warmth)
    assert float(np.mean(z < height)) - canonical == pytest.approx(
        float(fixed_energy(height, number, warmth)), abs=3e-3
    )


def test_structure_factor_at_zero_is_the_compressibility() -> None:
    density, step = 0.1, 1e-4

    def pressure(n: float) -> float:
        return n * compressibility(packing_fraction(n, 2), 2).value

    inverse = (pressure(density + step) - pressure(density - step)) / (2 * step)
    assert float(structure_factor(density, 1e-3)) == pytest.approx(1 / inverse, rel=1e-4)


def test_structure_factor_is_lowest_order_in_the_density_at_any_wave() -> None:
    from scipy.integrate import quad
    from scipy.special import j0

    density, k = 1e-4, 2.0
    mayer = -2 * math.pi * quad(lambda r: r * j0(k * r), 0, 1)[0]
    assert float(structure_factor(density, k)) == pytest.approx(1 + density * mayer, abs=1e-6)


def test_neighbour_share_against_disks_placed_without_overlap() -> None:
    # few disks in a large box, by rejection of whole configurations: exact
    rng = np.random.default_rng(5)
    number, length, reach = 4, 9.0, 1.4
    x = rng.uniform(0, length, size=(120_000, number, 2))
    gaps = x[:, :, None] - x[:, None, :]
    gaps -= length * np.round(gaps / length)
    distance = np.hypot(gaps[..., 0], gaps[..., 1]) + 10 * np.eye(number)
    allowed = (distance >= 1).all(axis=(1, 2))
    near = (distance[allowed] < reach).any(axis=2).mean(axis=1)
    expected = neighbour_share((number - 1) / length**2, reach)
    assert near.mean() == pytest.approx(expected, rel=0.05)


@given(angle=st.floats(-60, 60), seed=st.integers(0, 1000))
def test_surface_angle_of_a_half_full_drum(angle: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = rng.uniform(-10, 10, size=(20_000, 2))
    x = x[(np.hypot(*x.T) < 10) & (x[:, 1] < 0)]
    turn = np.radians(angle)
    turned = x @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert surface_angle(turned + 10, np.full(2, 10.0), 10.0) == pytest.approx(angle, abs=1.5)


def test_surface_angle_needs_four_strips() -> None:
    assert math.isnan(surface_angle(np.array([[10.0, 5.0], [11.0, 5.0]]), np.full(2, 10.0), 10.0))


def test_temperature_leaves_the_mean_motion_out() -> None:
    v = np.random.default_rng(0).normal(size=(1000, 3)) * 2 + [1.0, -3.0, 5.0]
    mass, momentum, kinetic = np.array([1000.0, 0.0]), np.stack([v.sum(axis=0), np.zeros(3)]), np.zeros(2)
    kinetic[0] = 0.5 * np.sum(v**2)
    found = temperature(mass, momentum, kinetic)
    assert found[0] == pytest.approx(v.var(axis=0).mean())
    assert np.isnan(found[1])


def test_what_comes_in_through_faces_adds_up_to_nothing_and_goes_to_the_right_cell() -> None:
    flux = np.random.default_rng(1).normal(size=(2, 4, 5))
    assert _through_faces(flux).sum() == pytest.approx(0.0, abs=1e-12)
    flux = np.zeros((2, 4, 5))
    flux[0, 2, 3] = 1.0  # through the lower face along x: out of cell 1, into cell 2
    found = _through_faces(flux)
    assert (found[2, 3], found[1, 3]) == (1.0, -1.0)
    assert np.count_nonzero(found) == 2


def test_cell_budgets_see_a_change_without_a_cause() -> None:
    names = ("mass", "momentum", "energy")
    shapes = {"mass": (2, 3), "momentum": (2, 3, 2), "energy": (2, 3)}
    t = {f"field_{when}_{name}": np.ones(shapes[name]) for when in ("initial", "final") for name in names}
    t |= {f"field_flux_{name}": np.zeros((2, *shapes[name])) for name in names}
    t |= {"field_mass": np.zeros((2, 3)), "field_momentum": np.zeros((2, 3, 2)), "field_dissipation": np.zeros((2, 3))}
    t |= {"field_wall_momentum": np.zeros((2, 3, 2)), "field_wall_energy": np.zeros((2, 3))}
    run = Run(np.zeros(2), np.zeros((1, 2)), np.zeros((1, 2)), tallies=t)
    assert max(cell_budgets(run, np.array([0.0, -1.0])).values()) == 0.0
    t["field_final_energy"] = t["field_final_energy"] + np.eye(2, 3) * 0.1
    assert cell_budgets(run, np.array([0.0, -1.0]))["energy"] == pytest.approx(0.1 / 1.1)
