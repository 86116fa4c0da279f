"""Collapse by eigenvalues of sequences of collisions, and from positions and velocities; the ball by adding bounces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.references import collapse


def pair(size: int, k: int, r: float) -> np.ndarray:
    """Velocities of a line of particles after particles k and k + 1 collide."""
    matrix = np.eye(size)
    matrix[k : k + 2, k : k + 2] = [[(1 - r) / 2, (1 + r) / 2], [(1 + r) / 2, (1 - r) / 2]]
    return matrix


def collapses(sequence: np.ndarray) -> bool:
    """A sequence of collisions repeats for ever only if all velocities shrink alike: a real eigenvalue in (0, 1)."""
    values = np.linalg.eigvals(sequence)
    return bool(((abs(values.imag) < 1e-9) & (values.real > 0) & (values.real < 1 - 1e-9)).any())


@pytest.mark.parametrize("shift", [-1e-4, 1e-4])
def test_three_particles_collapse_below_the_threshold(shift: float) -> None:
    r = collapse.THREE_PARTICLE_COLLAPSE + shift
    assert collapses(pair(3, 0, r) @ pair(3, 1, r)) == (shift < 0)
    assert collapse.STABLE_COLLAPSE < collapse.THREE_PARTICLE_COLLAPSE


@pytest.mark.parametrize("number", [2, 3, 4, 5])
@pytest.mark.parametrize("shift", [-1e-3, 1e-3])
def test_collapse_on_a_wall_of_the_same_restitution(number: int, shift: float) -> None:
    """Waves of collisions: all pairs of one parity and then of the other, in a line of N particles and their images."""
    r = collapse.wall_collapse(number) + shift
    even, odd = np.eye(2 * number), np.eye(2 * number)
    for k in range(0, 2 * number - 1, 2):
        even = even @ pair(2 * number, k, r)
    for k in range(1, 2 * number - 1, 2):
        odd = odd @ pair(2 * number, k, r)
    # the motion that mirrors itself: v_k = -v_(2N-1-k)
    mirror = np.vstack([np.eye(number), -np.eye(number)[::-1]])
    step = (even @ odd @ mirror)[:number]
    assert collapses(step) == (shift < 0)


def test_collapse_limits() -> None:
    assert collapse.wall_collapse(1) == 0
    assert collapse.wall_collapse(2) == pytest.approx(3 - 8**0.5)
    assert collapse.wall_collapse(3) == pytest.approx(1 / 3)
    # N (1 - alpha) -> pi
    assert 1e5 * (1 - collapse.wall_collapse(10**5)) == pytest.approx(math.pi, rel=1e-4)


@given(alpha=st.floats(0.05, 0.95), height=st.floats(0.1, 10), gravity=st.floats(0.1, 10))
def test_bouncing_ball_is_the_sum_of_its_bounces(alpha: float, height: float, gravity: float) -> None:
    ball = collapse.BouncingBall(height, alpha, gravity)
    speed, time, path = (2 * gravity * height) ** 0.5, (2 * height / gravity) ** 0.5, height
    for bounce in range(1, 800):
        assert ball.impact_time(bounce) == pytest.approx(time, rel=1e-11)
        speed *= alpha
        assert ball.apex(bounce) == pytest.approx(speed**2 / (2 * gravity), rel=1e-11)
        time, path = time + 2 * speed / gravity, path + speed**2 / gravity
        if speed < 1e-18:
            break
    assert ball.rest == pytest.approx(time, rel=1e-11)
    assert ball.path == pytest.approx(path, rel=1e-11)


def test_bouncing_ball_at_a_known_point() -> None:
    assert collapse.BouncingBall(1.0, 0.8, 9.81).rest == pytest.approx(4.063713, abs=5e-7)


# -- particles on a line -----------------------------------------------------------------------------------------------


def _plain(gaps: list[float], velocities: list[float], alpha: float, wall: bool) -> list[float]:
    """Times of the collisions from positions and velocities; the wall is a particle of mass 1e30."""
    x = np.cumsum([0.0, *gaps])
    v = np.array([0.0] * wall + velocities)
    masses = np.ones(v.size)
    masses[0] = 1e30 if wall else 1.0
    now, times = 0.0, []
    while (np.diff(v) < -1e-12).any():
        closing = np.diff(v) < -1e-12
        spans = np.where(closing, np.diff(x) / np.where(closing, -np.diff(v), 1), np.inf)
        k = int(spans.argmin())
        now, x = now + spans[k], x + v * spans[k]
        momentum = (1 + alpha) * (v[k] - v[k + 1]) / (1 / masses[k] + 1 / masses[k + 1])
        v[k] -= momentum / masses[k]
        v[k + 1] += momentum / masses[k + 1]
        x[k + 1] = x[k]
        times.append(now)
    return times


@given(
    st.lists(st.floats(0.1, 2.0), min_size=4, max_size=4),
    st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=5),
    st.floats(0.8, 1.0),
    st.booleans(),
)
@settings(deadline=None, max_examples=50)
def test_line_agrees_with_positions_and_velocities(
    gaps: list[float], velocities: list[float], alpha: float, wall: bool
) -> None:
    velocities = velocities[wall:]
    times = _plain(gaps, velocities, alpha, wall)
    line = collapse.line_collisions(gaps, velocities, alpha, wall)
    assert not line.collapsed
    common = min(len(times), line.times.size)
    np.testing.assert_allclose(line.times[:common], times[:common], rtol=1e-6)


def test_elastic_particles_pass_on_their_velocities() -> None:
    # five that all approach each other meet ten times, as if they went through each other
    assert collapse.line_collisions([1.0, 1.1, 0.9, 1.3], [5.0, 3.0, 0.0, -2.0, -7.0], 1.0, False).pairs == 10


@pytest.mark.parametrize("share", [0.9, 0.98, 1.02, 1.1])
def test_three_collapse_below_the_limit_only(share: float) -> None:
    line = collapse.line_collisions([1.0, 1.3], [1.0, 0.0, -0.8], share * collapse.THREE_PARTICLE_COLLAPSE, False)
    assert line.collapsed == (share < 1)
    assert line.wall == 0
    assert (np.diff(line.times) >= 0).all()


@pytest.mark.parametrize("number", [2, 3, 5])
@pytest.mark.parametrize("share", [0.95, 1.05])
def test_a_row_collapses_on_a_wall_below_the_limit_only(number: int, share: float) -> None:
    alpha = share * collapse.wall_collapse(number)
    line = collapse.line_collisions(np.linspace(1.0, 2.0, number), np.full(number, -1.0), alpha, True)
    assert line.collapsed == (share < 1)


def test_first_impact_of_a_bouncing_ball_is_where_the_parabola_meets_the_floor() -> None:
    ball = collapse.BouncingBall(0.7, 0.6, 9.81)
    assert ball.height - ball.gravity * ball.fall**2 / 2 == pytest.approx(0.0, abs=1e-15)
    assert ball.fall == ball.impact_time(1)
