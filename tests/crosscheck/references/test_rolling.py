"""Sliding and rolling against an integration of the equations of motion, and against known values."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from crosscheck.references.rolling import SlideToRoll


def test_a_ball_rolls_at_five_sevenths_and_a_disk_at_two_thirds() -> None:
    ball, disk = SlideToRoll(1.4, 0.0, 0.4, 1.0, 0.4), SlideToRoll(1.4, 0.0, 0.4, 1.0, 0.5)
    assert ball.end == pytest.approx(1.0, rel=1e-15)
    assert ball.time == pytest.approx(2 * 1.4 / (7 * 0.4), rel=1e-15)
    assert ball.dissipated == pytest.approx(2 / 7 * 0.5 * 1.4**2, rel=1e-15)
    assert disk.end == pytest.approx(2 / 3 * 1.4, rel=1e-15)
    assert disk.time == pytest.approx(1.4 / (3 * 0.4), rel=1e-15)
    assert disk.dissipated == pytest.approx(1 / 3 * 0.5 * 1.4**2, rel=1e-15)
    v, s = ball.motion([0.0, 0.5, 1.0, 7.0])
    np.testing.assert_allclose(v, [1.4, 1.2, 1.0, 1.0], rtol=1e-15)
    np.testing.assert_allclose(s, [0.0, 0.5, 1.0, 1.0], rtol=1e-15)


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.1, 1.0), st.floats(0.5, 2.0), st.floats(0.2, 0.9))
def test_angular_momentum_about_the_floor_and_energy(v: float, s: float, mu: float, g: float, q: float) -> None:
    grain = SlideToRoll(v, s, mu, g, q)
    velocities, rolling = grain.motion(np.linspace(0, 2 * grain.time + 0.1, 9))
    np.testing.assert_allclose(velocities + q * rolling, v + q * s, atol=1e-14)
    kept = 0.5 * grain.end**2 * (1 + q)
    assert 0.5 * (v**2 + q * s**2) - kept == pytest.approx(grain.dissipated, abs=1e-14)
    assert velocities[-1] == pytest.approx(rolling[-1], abs=1e-14)
    # friction acts against the slip, by mu m g
    slowing = (velocities[1] - velocities[0]) / (2 * grain.time + 0.1) * 8
    if grain.time > 0.05:
        assert slowing == pytest.approx(-mu * g * math.copysign(1, v - s), rel=1e-12)


@pytest.mark.parametrize("damping", [0.0, 20.0])
@pytest.mark.parametrize(("v", "s"), [(1.0, 0.0), (-0.3, 0.4)])
def test_swings_about_rolling_against_an_integration(damping: float, v: float, s: float) -> None:
    """Cundall and Strack's law, integrated from where the spring is stretched to the limit."""
    q, mu, k = 0.4, 0.5, 2000.0
    grain = SlideToRoll(v, s, mu, 1.0, q, k, damping)
    side = math.copysign(1.0, v - s)

    def rates(_: float, state: np.ndarray) -> list[float]:
        slip, stretch = state
        pull = k * stretch + damping * slip
        over = side * pull >= mu * (1 - 1e-12) and k * slip * side > damping * grain.slowing
        force = side * mu if over else pull
        # on the limit the spring follows the slip's dashpot
        grows = damping * grain.slowing * side / k if over else slip
        return [-(1 + 1 / q) * force, grows]

    start = [v - s, (side * mu - damping * (v - s)) / k]
    times = np.linspace(0, grain.time + 0.3, 200)
    found = solve_ivp(rates, (0, times[-1]), start, t_eval=times, max_step=1e-3, rtol=1e-10, atol=1e-12)
    # where sliding ends is found to a step of 1e-3 of the integration, of which the slip errs by second order
    np.testing.assert_allclose(grain.slip(times), found.y[0], atol=2e-4)
    assert abs(grain.slip(times)[times > grain.time]).max() > 1e-3


def test_a_swing_that_does_not_swing() -> None:
    with pytest.raises(ValueError, match="nothing swings"):
        SlideToRoll(1.0, 0.0, 0.4, 1.0, 0.4, 100.0, 1000.0).slip(1.0)
