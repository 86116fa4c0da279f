"""The structure factor by its limits, neighbours by placing disks at random."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.references.hard_spheres import compressibility, packing_fraction
from crosscheck.references.structure import neighbour_share, structure_factor


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
