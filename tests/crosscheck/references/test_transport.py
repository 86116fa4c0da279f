"""Enskog's theory by collision integrals and Monte Carlo; few spheres by independent simulations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import eval_genlaguerre

from crosscheck.references import hard_spheres as hs
from crosscheck.references import transport

#: Standard errors allowed to a seeded Monte Carlo mean: fixed by the seed, once in 10^5 by chance otherwise.
SIGMAS = 4.5
both = pytest.mark.parametrize("dimension", [2, 3])


def mean_within(samples: np.ndarray, expected: float) -> None:
    error = samples.std(ddof=1) / samples.size**0.5
    assert abs(samples.mean() - expected) < SIGMAS * error


def sonine_ratio(dimension: int, order: int, nodes: int = 40) -> float:
    """D in the given Sonine approximation over the first: M_00 (M^-1)_00 of the collision integrals of v S_k(v^2/2).

    Equal masses exchange the normal components a, b; with p, q = (a +- b)/sqrt 2 the weight |q| exp(-q^2/2) is
    Laguerre's, and all integrands are polynomials: the quadrature is exact.
    """
    y, wy = np.polynomial.laguerre.laggauss(nodes)
    p, wp = np.polynomial.hermite_e.hermegauss(nodes)
    if dimension == 2:
        s, ws = p**2, wp
    else:
        s, ws = 2 * y, wy
    p, y, s = np.meshgrid(p, y, s, indexing="ij")
    weight = wp[:, None, None] * wy[None, :, None] * ws[None, None, :]
    q = (2 * y) ** 0.5
    a, b = (p + q) / 2**0.5, (p - q) / 2**0.5
    f, h = ([eval_genlaguerre(k, dimension / 2, (x * x + s) / 2) for k in range(order)] for x in (a, b))
    matrix = np.array(
        [
            [
                (weight * ((a * f[i] - b * h[i]) * (a * f[j] - b * h[j]) + s * (f[i] - h[i]) * (f[j] - h[j]))).sum()
                for j in range(order)
            ]
            for i in range(order)
        ]
    )
    return float(matrix[0, 0] * np.linalg.inv(matrix)[0, 0])


@both
def test_sonine_factor(dimension: int) -> None:
    assert sonine_ratio(dimension, 1) == pytest.approx(1, rel=1e-12)
    assert sonine_ratio(dimension, 12) == pytest.approx(transport.SONINE_DIFFUSION[dimension], abs=1e-6)
    assert transport.SONINE_DIFFUSION[3] == pytest.approx(1.01896, abs=1e-5)


@both
def test_first_approximation_of_diffusion(dimension: int) -> None:
    eta, temperature, mass, sigma = 0.15, 1.7, 0.6, 1.4
    n, g = hs.number_density(eta, dimension, sigma), hs.contact_value(eta, dimension).value
    root = (temperature / (np.pi * mass)) ** 0.5
    textbook = root / (2 * n * sigma * g) if dimension == 2 else 3 * root / (8 * n * sigma**2 * g)
    plain = transport.enskog_diffusion(eta, dimension, temperature, mass, sigma, sonine=False)
    assert plain.value == pytest.approx(textbook, rel=1e-13)
    full = transport.enskog_diffusion(eta, dimension, temperature, mass, sigma)
    assert full.value == pytest.approx(textbook * transport.SONINE_DIFFUSION[dimension], rel=1e-13)


@both
@pytest.mark.parametrize("ratio", [1.0, 20.0])
def test_friction_by_monte_carlo(dimension: int, ratio: float) -> None:
    """-<v.dv> per time over <v^2> of a tracer at the bath's temperature, collisions with a uniform normal."""
    rng = np.random.default_rng(9)
    count, n, s, temperature, mass, g = 400000, 0.3, 0.8, 1.7, 0.6, 1.4
    v = rng.standard_normal((count, dimension)) * (temperature / (ratio * mass)) ** 0.5
    w = rng.standard_normal((count, dimension)) * (temperature / mass) ** 0.5
    k = rng.standard_normal((count, dimension))
    k /= np.linalg.norm(k, axis=1, keepdims=True)
    approach = ((v - w) * k).sum(axis=1)
    surface = 2 * np.pi * s if dimension == 2 else 4 * np.pi * s**2
    rate = n * g * surface * np.maximum(approach, 0)
    change = -2 / (1 + ratio) * approach[:, None] * k
    loss = -rate * (v * change).sum(axis=1) / (dimension * temperature / (ratio * mass))
    mean_within(loss, transport.friction(n, s, mass, ratio * mass, dimension, temperature, g))


def test_viscosity_of_a_dilute_gas() -> None:
    assert transport.enskog_viscosity(1e-6) == pytest.approx(1.016 * 5 / (16 * np.pi**0.5), rel=1e-5)


@pytest.mark.parametrize(
    ("number", "density", "diffusion", "error"),
    [
        (108, 0.3, 0.4982, 0.0015),
        (108, 0.5, 0.22064, 0.00046),
        (256, 0.5, 0.23478, 0.00082),
        (108, 0.7, 0.09999, 0.00054),
    ],
)
def test_diffusion_of_few_spheres(number: int, density: float, diffusion: float, error: float) -> None:
    """Own event-driven runs, eight of 2e5 collisions."""
    found = transport.sphere_diffusion(density, number)
    assert abs(found.value - diffusion) < found.doubt + math.hypot(found.uncertainty, 2 * error)
    assert abs(transport.sphere_diffusion(density).value - diffusion) > 5 * error


def test_diffusion_table_is_met_at_its_own_number() -> None:
    for density, d, error in transport.NIST_DIFFUSION:
        found = transport.sphere_diffusion(density, hs.NIST_PARTICLES)
        assert found.value == pytest.approx(d, rel=1e-12)
        assert found.uncertainty == pytest.approx(error)
    with pytest.raises(ValueError, match="tabulated for number densities"):
        transport.sphere_diffusion(0.05)


def test_decay_times_of_a_dilute_gas() -> None:
    """Both from first Sonine approximations written out: nu = viscosity/n, L^3 = N/n."""
    n, number = 1e-5, 1000
    viscosity = 1.016 * 5 / (16 * np.pi**0.5)
    length = (number / n) ** (1 / 3)
    assert transport.shear_decay_time(n, number) == pytest.approx(length**2 * n / (4 * np.pi**2 * viscosity), rel=1e-3)
    free_time = 1 / (4 * n * np.pi**0.5)
    expected = 1.5 * free_time * transport.SONINE_DIFFUSION[3]
    assert transport.velocity_decay_time(n) == pytest.approx(expected, rel=1e-3)


def test_slip_friction_is_the_force_of_a_stokeslet() -> None:
    """The flow of a point force, u = F.(I + nn)/(8 pi viscosity r), has no shear on a sphere and u.n = U.n there."""
    viscosity, radius, h = 0.7, 1.3, 1e-5
    force = transport.slip_friction(viscosity, radius) * np.array([0.0, 0.0, 1.0])  # of a sphere with U = 1 along z

    def flow(x: np.ndarray) -> np.ndarray:
        r = float(np.linalg.norm(x))
        return (force + x * (x @ force) / r**2) / (8 * np.pi * viscosity * r)

    for angle in (0.3, 1.1, 2.5):
        n = np.array([np.sin(angle), 0.0, np.cos(angle)])
        x = radius * n
        assert flow(x) @ n == pytest.approx(n[2], rel=1e-12)
        gradient = np.array([(flow(x + h * e) - flow(x - h * e)) / (2 * h) for e in np.eye(3)])
        traction = (gradient + gradient.T) @ n
        along = np.array([np.cos(angle), 0.0, -np.sin(angle)])
        assert traction @ along == pytest.approx(0, abs=1e-8)


def test_frictions_in_series() -> None:
    gamma, mass = 0.2, 50.0
    assert transport.friction_in_series(gamma, mass, 1e12) == pytest.approx(gamma, rel=1e-9)
    assert transport.friction_in_series(1e12, mass, 3.0) == pytest.approx(3.0 / mass, rel=1e-9)
    one = transport.friction_in_series(gamma, mass, 3.0)
    assert 1 / (mass * one) == pytest.approx(1 / (mass * gamma) + 1 / 3.0, rel=1e-12)


def test_periodic_diffusion_shift_is_the_sum_over_periodic_images() -> None:
    """D lacks 2.837297 T/(6 pi viscosity L): the mean over directions of Oseen's tensor, summed by Ewald's method."""
    density, number = 0.5, 200
    side = (number / density) ** (1 / 3)
    # sum over images of 1/(6 pi viscosity r) less its uniform background, in the units of 1/L: -2.837297
    spread = 2.0
    cells = np.stack(np.meshgrid(*[np.arange(-6, 7)] * 3), axis=-1).reshape(-1, 3)
    square = (cells**2).sum(axis=-1)
    square = square[square > 0]
    near = sum(math.erfc(spread * r) / r for r in np.sqrt(square))
    far = np.sum(np.exp(-(np.pi**2) * square / spread**2) / (np.pi * square))
    wigner = near + far - np.pi / spread**2 - 2 * spread / math.sqrt(np.pi)
    viscosity = transport.enskog_viscosity(hs.packing_fraction(density, 3))
    shift = transport.periodic_diffusion_shift(density, number)
    assert shift == pytest.approx(-wigner / (6 * np.pi * viscosity * side), rel=1e-6)
    assert transport.periodic_diffusion_shift(density, math.inf) == 0.0
