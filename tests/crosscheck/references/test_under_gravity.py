"""The column by series, energy and drawn microstates; the channel by its symmetry and a sum over layers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from crosscheck.references.under_gravity import (
    channel_stress,
    column_profile,
    fixed_energy,
    floor_layer,
    mean_compressibility,
)


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


def test_floor_layer_is_twice_the_first_order_excess_of_disks_at_a_wall() -> None:
    # of the unit circle round a disk, the part where no centre can be is not in the way
    beyond = quad(lambda z: math.acos(z) - z * math.sqrt(1 - z * z), 0, 1)[0]
    pressure, warmth = 2.0, 5.0
    excess = (pressure / warmth) ** 2 * beyond
    assert floor_layer(pressure, warmth) == pytest.approx(2 * excess / pressure)


def test_channel_stress_is_the_weight_of_the_layers_between_there_and_the_middle() -> None:
    mass = np.array([[1.0, 2.0, 4.0, 2.0, 1.0]])
    stress = channel_stress(mass, 10.0, 0.5)[0]
    # from the middle of the middle layer outwards
    np.testing.assert_allclose(stress, [-0.5 * (2 + 2), -0.5 * 2, 0.5 * 2, 0.5 * (2 + 2)])
