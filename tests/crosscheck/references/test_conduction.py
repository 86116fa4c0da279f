"""Enskog's conductivity in its first Sonine approximation, another way of writing it; Fourier's law by its integral."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.references.conduction import beyond_enskog, enskog_conductivity, fourier_profile
from crosscheck.references.hard_spheres import compressibility, packing_fraction


@pytest.mark.parametrize("dimension", [2, 3])
def test_dilute_conductivity_is_the_first_sonine_one_within_3_percent(dimension: int) -> None:
    # kappa = d (d+2)/(2 (d-1)) eta/m, eta = (d+2)/(8 omega) sqrt(pi T) Gamma(d/2) pi^(-d/2), for unit diameter
    d = dimension
    viscosity = (d + 2) / 8 * math.gamma(d / 2) / math.pi ** ((d - 1) / 2) * math.sqrt(2.0)
    first = d * (d + 2) / (2 * (d - 1)) * viscosity
    assert enskog_conductivity(1e-9, 2.0, dimension) == pytest.approx(1.027 * first, rel=0.003)


@pytest.mark.parametrize("dimension", [2, 3])
def test_dense_conductivity_is_the_square_of_the_transfer_plus_the_collisional_part(dimension: int) -> None:
    # first Sonine: (1/g) ((1 + a y)^2 + c y^2), a = 3/4, c = 1/pi (disks); 3/5, 32/(25 pi) (spheres)
    a, c, sonine = (0.75, 1 / math.pi, 1.02925) if dimension == 2 else (0.6, 32 / (25 * math.pi), 1.02513)
    for n in (0.1, 0.4, 0.7):
        y = compressibility(packing_fraction(n, dimension), dimension).value - 1
        g = y / (math.pi / 2 * n if dimension == 2 else 2 * math.pi / 3 * n)
        dilute = enskog_conductivity(1e-9, 1.0, dimension)
        expected = dilute / g * ((1 + a * y) ** 2 + c / sonine * y**2)
        assert enskog_conductivity(n, 1.0, dimension) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_fourier_profile_of_a_dilute_gas_is_that_of_the_power_three_halves(dimension: int) -> None:
    # kappa = k sqrt(T) where the density does nothing: T^(3/2) falls linearly, by 3 q x/2k
    places, warmest, coldest = np.linspace(0.0, 10.0, 2001), 4.0, 1.0
    k = enskog_conductivity(1e-9, 1.0, dimension)
    flux = (warmest**1.5 - coldest**1.5) / 10.0 * 2 * k / 3
    exact = (warmest**1.5 + (coldest**1.5 - warmest**1.5) * places / 10.0) ** (2 / 3)
    x, found = fourier_profile(places, np.full(2001, 1e-9), exact, flux, 5.0, dimension)
    assert (x.size, x[0], x[-1]) == (401, 0.0, 10.0)
    np.testing.assert_allclose(found, np.interp(x, places, exact), rtol=1e-5)


@pytest.mark.parametrize(("density", "length"), [(0.1, 30.0), (0.2, 60.0), (0.3, 100.0)])
def test_the_tail_of_disks_grows_with_the_logarithm_of_the_length(density: float, length: float) -> None:
    """By the coefficient of its logarithm, with the relations between the coefficients of a dilute gas."""
    short, long = (beyond_enskog(density, 1.0, 2, size) for size in (length, 2 * length))
    # doubling the length adds one factor of four in time: c_p T/2 ln 4/(4 pi (nu + D)), of the same kappa
    added = (long - short) / math.log(4)
    kappa = enskog_conductivity(density, 1.0, 2)
    # dilute: c_p = 2, D = kappa/(2 n), nu = eta/n, and kappa = 4 eta for disks
    spreading = kappa / (4 * density) + kappa / (2 * density)
    assert added * kappa == pytest.approx(1.0 / (4 * math.pi * spreading), rel=0.6 * density + 0.05)


def test_what_enskog_leaves_out_is_a_few_per_cent_and_less_in_a_dilute_gas() -> None:
    for dimension in (2, 3):  # temperature sets times only
        dilute, dense = (beyond_enskog(n, 1.0, dimension, 200.0) for n in (0.05, 0.2))
        assert 0 < dilute < dense < 0.06
        assert beyond_enskog(0.2, 4.0, dimension, 200.0) == pytest.approx(dense, rel=1e-9)
