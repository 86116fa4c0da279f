"""Free paths by Monte Carlo and quadrature, diffusion by cross-sections."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from crosscheck.references import lorentz

#: Standard errors allowed to a seeded Monte Carlo mean: fixed by the seed, once in 10^5 by chance otherwise.
SIGMAS = 4.5
both = pytest.mark.parametrize("dimension", [2, 3])


def mean_within(samples: np.ndarray, expected: float) -> None:
    error = samples.std(ddof=1) / samples.size**0.5
    assert abs(samples.mean() - expected) < SIGMAS * error


@both
def test_free_path_on_a_lattice(dimension: int) -> None:
    """Points anywhere in the free space hit within a short path e with chance e/lambda: no second hit fits in e."""
    rng, radius, path, count = np.random.default_rng(10), 0.35, 0.2, 400000
    x = rng.uniform(-0.5, 0.5, (count, dimension))
    x = x[(x**2).sum(axis=1) > radius**2]
    u = rng.standard_normal(x.shape)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    hit = np.zeros(len(x), dtype=bool)
    for cell in np.ndindex(*(3,) * dimension):
        apart = x - (np.array(cell) - 1)
        b = (apart * u).sum(axis=1)
        discriminant = b**2 - (apart**2).sum(axis=1) + radius**2
        first = -b - np.sqrt(np.maximum(discriminant, 0))
        hit |= (b < 0) & (discriminant > 0) & (first < path)
    mean_within(hit / path, 1 / lorentz.free_path(1.0, radius, dimension))


@both
def test_free_path_among_overlapping_scatterers(dimension: int) -> None:
    """A free path r needs a tube without centres: chance exp(-n sigma r), whatever the point started from."""
    n, radius = 0.3, 0.7
    tube = 2 * radius if dimension == 2 else np.pi * radius**2
    mean, _ = quad(lambda r: np.exp(-n * tube * r), 0, np.inf)
    assert lorentz.free_path(n, radius, dimension, overlapping=True) == pytest.approx(mean, rel=1e-9)
    assert lorentz.free_path(n, radius, dimension) < mean
    with pytest.raises(ValueError, match="no room"):
        lorentz.free_path(1.0, 1.0, dimension)


def test_transport_cross_sections_by_quadrature() -> None:
    """Impact parameter R sin(a): deflection pi - 2a, 1 - cos = 1 + cos 2a."""
    radius, n, v = 0.7, 0.02, 1.3
    disk, _ = quad(lambda a: (1 + np.cos(2 * a)) * radius * np.cos(a), -np.pi / 2, np.pi / 2)
    sphere, _ = quad(lambda a: (1 + np.cos(2 * a)) * 2 * np.pi * radius**2 * np.sin(a) * np.cos(a), 0, np.pi / 2)
    assert lorentz.boltzmann_diffusion(n, radius, 2, v) == pytest.approx(v / (2 * n * disk), rel=1e-12)
    assert lorentz.boltzmann_diffusion(n, radius, 3, v) == pytest.approx(v / (3 * n * sphere), rel=1e-12)
    path = lorentz.free_path(n, radius, 3, overlapping=True)
    assert lorentz.boltzmann_diffusion(n, radius, 3, v) == pytest.approx(v * path / 3, rel=1e-12)


def test_lorentz_series_against_simulation() -> None:
    """What is left out is of the order of (x ln x)^3, with a coefficient of some 10; a wrong sign is 9 % at 0.02."""
    for x, simulated in lorentz.DIFFUSION[2].items():
        left_out = 10 * abs(x * math.log(x)) ** 3
        assert abs(lorentz.diffusion_series(x) - simulated.value) < left_out + 4 * simulated.uncertainty
    for table in lorentz.DIFFUSION.values():
        values = [entry.value for entry in table.values()]
        assert 1 > values[0] > values[1] > values[2]
    assert lorentz.diffusion_series(1e-9) == pytest.approx(1, abs=1e-7)
