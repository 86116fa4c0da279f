"""Mixtures by their limits, the sum over contacts and the exact second virial coefficient."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references import hard_mixtures
from crosscheck.references import hard_spheres as hs

both = pytest.mark.parametrize("dimension", [2, 3])


species_lists = st.lists(st.tuples(st.floats(0.01, 0.1), st.floats(0.4, 1.2)), min_size=1, max_size=3)


@both
def test_like_species_are_one(dimension: int) -> None:
    parts = hard_mixtures.mixture([0.1, 0.2], [1.0, 1.0], [1.0, 1.0])
    eta = hs.packing_fraction(0.3, dimension)
    textbook = (1 - 7 * eta / 16) / (1 - eta) ** 2 if dimension == 2 else (1 - eta / 2) / (1 - eta) ** 3
    np.testing.assert_allclose(hard_mixtures.mixture_contact_values(parts, dimension), textbook, rtol=1e-13)
    pure, mixed = hs.compressibility(eta, dimension), hard_mixtures.mixture_compressibility(parts, dimension)
    assert mixed.value == pytest.approx(pure.value, rel=1e-13)
    rates = hard_mixtures.species_collision_rates(parts, dimension, 1.3).sum(axis=1)
    g = hs.contact_value(eta, dimension).value
    np.testing.assert_allclose(rates, hs.collision_rate(eta, dimension, 1.3).value / g * textbook, rtol=1e-13)


@given(parts=species_lists)
def test_pressure_of_a_mixture_is_the_sum_over_its_contacts(parts: list[tuple[float, float]]) -> None:
    """Z = 1 + (S_d/2d) sum_ij x_i x_j n s_ij^d g_ij, for BMCSL and for Jenkins and Mancini with Henderson's Z."""
    species = hard_mixtures.mixture(*np.array(parts).T)
    n, s = species.densities, species.diameters
    pairs = np.outer(n, n) / n.sum()
    distance = (s[:, None] + s[None, :]) / 2
    spheres = 1 + 2 * np.pi / 3 * (pairs * distance**3 * hard_mixtures.mixture_contact_values(species, 3)).sum()
    assert hard_mixtures.bmcsl(species) == pytest.approx(spheres, rel=1e-12)
    eta, x = species.packing_fraction[0], (n * s).sum() ** 2 / (n.sum() * (n * s**2).sum())
    disks = 1 + np.pi / 2 * (pairs * distance**2 * hard_mixtures.mixture_contact_values(species, 2)).sum()
    assert (1 - x) / (1 - eta) + x * hs.henderson(eta) == pytest.approx(disks, rel=1e-12)


@both
@given(parts=species_lists)
def test_species_collide_with_each_other_equally_often(dimension: int, parts: list[tuple[float, float]]) -> None:
    n, s = np.array(parts).T
    species = hard_mixtures.mixture(n, s, 1 + s)
    counts = n[:, None] * hard_mixtures.species_collision_rates(species, dimension)
    np.testing.assert_allclose(counts, counts.T, rtol=1e-13)


@both
def test_a_point_meets_spheres_with_the_free_volume(dimension: int) -> None:
    """g = 1/(1 - eta) exactly between a point and a sphere."""
    species = hard_mixtures.mixture([0.3, 1e-12], [1.0, 1e-9])
    eta = species.packing_fraction[dimension - 2]
    assert hard_mixtures.mixture_contact_values(species, dimension)[0, 1] == pytest.approx(1 / (1 - eta), rel=1e-8)


@both
def test_dilute_mixture_has_the_exact_second_virial_coefficient(dimension: int) -> None:
    n, s = np.array([2e-5, 3e-5]), np.array([1.0, 1.6])
    distance = (s[:, None] + s[None, :]) / 2
    half = np.pi / 2 if dimension == 2 else 2 * np.pi / 3
    b2 = half * (np.outer(n, n) * distance**dimension).sum() / n.sum()
    assert hard_mixtures.mixture_compressibility(hard_mixtures.mixture(n, s), dimension).value - 1 == pytest.approx(
        b2, rel=1e-3
    )


def test_mixtures_need_one_diameter_a_species() -> None:
    with pytest.raises(ValueError, match="one density and one diameter"):
        hard_mixtures.mixture([0.1, 0.2], [1.0])
