"""Walls by kinetic theory, quadrature, exact virial terms and independent simulations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from crosscheck.references import hard_spheres as hs
from crosscheck.references import hard_walls, speeds

#: Standard errors allowed to a seeded Monte Carlo mean: fixed by the seed, once in 10^5 by chance otherwise.
SIGMAS = 4.5
both = pytest.mark.parametrize("dimension", [2, 3])


def mean_within(samples: np.ndarray, expected: float) -> None:
    error = samples.std(ddof=1) / samples.size**0.5
    assert abs(samples.mean() - expected) < SIGMAS * error


@both
def test_ideal_wall_pressure_of_bouncing_particles(dimension: int) -> None:
    """2 m |v_x| every 2 l/|v_x| on each wall: N <v_x^2>/l over the wall's area."""
    number, length, diameter, v0 = 50000, 7.0, 1.0, 1.3
    v = np.random.default_rng(7).standard_normal((number, dimension))
    v *= v0 / np.linalg.norm(v, axis=1, keepdims=True)
    force = number * v[:, 0] ** 2 / (length - diameter) / length ** (dimension - 1)
    mean_within(
        force,
        hard_walls.ideal_wall_pressure(
            number, length, dimension, speeds.mono_speed_temperature(v0, dimension), diameter
        ),
    )


def test_wall_hit_rate_by_quadrature() -> None:
    half, _ = quad(lambda v: v * np.exp(-(v**2) / (2 * 1.7 / 0.6)) / (2 * np.pi * 1.7 / 0.6) ** 0.5, 0, np.inf)
    assert hard_walls.wall_hit_rate(0.3, 1.7, 0.6) == pytest.approx(0.3 * half, rel=1e-9)


def test_wall_tension_of_dilute_disks() -> None:
    """gamma = -n^2/2 times the integral of the part of the disk of contact that a wall cuts off: 2/3."""
    cut, _ = quad(lambda z: np.arccos(z) - z * (1 - z * z) ** 0.5, 0, 1)
    assert cut == pytest.approx(2 / 3, rel=1e-9)
    n = 1e-5
    assert hard_walls.disk_wall_tension(n) == pytest.approx(-(n**2) / 2 * cut, rel=3 * n)


def test_third_surface_cluster_of_disks() -> None:
    rng = np.random.default_rng(8)
    r, angle = rng.random((2, 400000)) ** 0.5, rng.uniform(0, 2 * np.pi, (2, 400000))
    x, z = r * np.cos(angle), r * np.sin(angle)
    heights = np.stack([np.zeros_like(z[0]), z[0], z[1]])
    depth = heights.mean(axis=0) - heights.min(axis=0)
    closed = (np.diff(x, axis=0)[0] ** 2 + np.diff(z, axis=0)[0] ** 2 < 1).astype(float)
    mean_within(-(np.pi**2) / 6 * (3 - closed) * depth, hard_walls._SURFACE_CLUSTER)


def test_box_of_disks_has_the_exact_second_virial_term() -> None:
    """Two disks overlap in a square of side l with chance (pi l^2 - (8/3) l + 1/2)/l^4; p = (T/2L) d ln Z/dl."""
    number, side = 30, 400.0
    q = (np.pi * side**2 - 8 / 3 * side + 0.5) / side**4
    slope = -(2 * np.pi / side**3 - 8 / side**4 + 2 / side**5)
    exact = (2 * number / side - number * (number - 1) / 2 * slope / (1 - q)) / (2 * (side + 1))
    found = hard_walls.disk_box_pressure(number, side + 1)
    bulk = number / side**2 * np.pi / 2
    ideal = hard_walls.ideal_wall_pressure(number, side + 1, 2, diameter=1.0)
    # left out: B_3 n^2, and the corners' second term, 1/l^2 of the first
    assert found.value - exact == pytest.approx(0, abs=ideal * (bulk**2 + bulk / side**2))
    assert exact / ideal - 1 > 500 * (bulk**2 + bulk / side**2)


@pytest.mark.parametrize(
    ("number", "eta", "pressure", "error"),
    [
        (25, 0.02, 1.07473, 5e-5),
        (400, 0.02, 1.0498, 2e-4),
        (25, 0.1, 1.33407, 2e-4),
        (100, 0.1, 1.28615, 3e-4),
        (400, 0.1, 1.2620, 2e-4),
    ],
)
def test_box_of_disks_against_event_driven_runs(number: int, eta: float, pressure: float, error: float) -> None:
    length = (number * np.pi / 4 / eta) ** 0.5
    found = hard_walls.disk_box_pressure(number, length)
    ideal = number / length**2
    assert abs(found.value / ideal - pressure) < found.doubt / ideal + 2 * error
    assert abs(hs.disk_compressibility(eta).value - pressure) > 5 * found.doubt / ideal


def test_impulse_of_a_hit_is_pressure_over_rate_of_hits() -> None:
    temperature, mass, n = 1.7, 0.6, 0.3
    many = hard_walls.impulse_of_a_hit(temperature, 10**6, mass)
    assert many == pytest.approx(n * temperature / hard_walls.wall_hit_rate(n, temperature, mass), rel=1e-6)


def test_impulse_of_a_hit_of_few_components() -> None:
    """Velocities uniform on a sphere in f dimensions: 2 m <v_x^2>/<|v_x|>."""
    freedoms, samples = 6, 400000
    v = np.random.default_rng(11).standard_normal((samples, freedoms))
    v *= freedoms**0.5 / np.linalg.norm(v, axis=1, keepdims=True)  # T = 1
    slow = abs(v[:, 0])
    expected = 2 / slow.mean()
    error = 2 * slow.std() / samples**0.5 / slow.mean() ** 2
    assert abs(hard_walls.impulse_of_a_hit(1.0, freedoms) - expected) < SIGMAS * error


def test_flight_between_walls_by_reflections() -> None:
    room, x, v, step = 3.0, 0.0, 1.0, 1e-3
    found = []
    for _ in range(10000):
        x += v * step
        if not 0 <= x <= room:
            x, v = (-x if x < 0 else 2 * room - x), -v
        found.append(x)
    way = step * np.arange(1, 10001)
    assert hard_walls.between_walls(way, room) == pytest.approx(np.array(found), abs=1e-9)
