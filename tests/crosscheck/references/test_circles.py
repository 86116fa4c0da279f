"""Bodies on circles: they solve Verlet's equation with the accelerations of all others, written out here."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references.circles import Circles, satellites, triangle

lengths = st.floats(0.5, 3.0)
G, SOFTENING = 1.3, 0.4


def accelerations(bodies: Circles, r: np.ndarray) -> np.ndarray:
    """-G sum_j m_j (r_i - r_j)/(r_ij^2 + s^2)^(3/2), (N, 3)."""
    apart = r[:, None] - r[None]
    return -G * (bodies.masses[:, None] * apart / ((apart**2).sum(-1) + SOFTENING**2)[..., None] ** 1.5).sum(1)


def agrees(bodies: Circles, dt: float, n: int) -> None:
    before, now, after = (bodies.positions(dt, n + by) for by in (-1, 0, 1))
    # the angle is a double: its last digit is the rounding of all that follows from it
    rounding = 8 * 2.0**-52 * (2 * np.pi + (n + 1) * bodies.angle(dt).max()) * bodies.radii.max()
    assert after - 2 * now + before == pytest.approx(dt**2 * accelerations(bodies, now), rel=1e-12, abs=rounding)
    assert bodies.velocities(dt, n) == pytest.approx((after - before) / (2 * dt), rel=1e-12, abs=rounding / dt)


@given(masses=st.tuples(lengths, lengths, lengths), side=lengths, dt=st.floats(0.01, 0.3), n=st.integers(1, 10**5))
def test_the_triangle_solves_the_difference_equation(
    masses: tuple[float, float, float], side: float, dt: float, n: int
) -> None:
    bodies = triangle(masses, side, G, SOFTENING)
    agrees(bodies, dt, n)
    assert bodies.masses @ bodies.positions(dt, n) == pytest.approx(np.zeros(3), abs=1e-12)
    corners = bodies.positions(dt, n)
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1) == pytest.approx([side] * 3)


@given(number=st.integers(2, 16), mass=lengths, dt=st.floats(0.01, 0.3), n=st.integers(1, 10**5), data=st.data())
def test_satellites_solve_it_wherever_the_body_with_mass_stands(
    number: int, mass: float, dt: float, n: int, data: st.DataObject
) -> None:
    centre = data.draw(st.integers(0, number - 1))
    bodies = satellites(number, centre, mass, G, SOFTENING)
    assert np.flatnonzero(bodies.masses).tolist() == [centre]
    agrees(bodies, dt, n)


def test_rounding_is_that_of_a_random_walk() -> None:
    """Steps of Verlet with other roundings part by less than the bound says, and by more than a tenth of it."""
    bodies = triangle((0.01, 2.0, 0.005), 1.0, G, SOFTENING)
    dt, steps = 0.05, 4000
    rng = np.random.default_rng(1)
    r, v = bodies.positions(dt, 0), bodies.velocities(dt, 0)
    ends = []
    for _ in range(12):
        x, u = r.copy(), v.copy()
        a = accelerations(bodies, x)
        for _ in range(steps):
            u = (u + 0.5 * dt * a) * (1 + 1e-8 * rng.uniform(-0.5, 0.5, 9).reshape(3, 3))
            x = (x + dt * u) * (1 + 1e-8 * rng.uniform(-0.5, 0.5, 9).reshape(3, 3))
            a = accelerations(bodies, x)
            u = u + 0.5 * dt * a
        ends.append(x)
    spread = np.linalg.norm(np.std(ends, axis=0), axis=1) / bodies.radii
    bound = bodies.rounding_error(dt, steps) * 1e-8 / 2.0**-52
    assert 0.1 * bound < spread.max() < bound
