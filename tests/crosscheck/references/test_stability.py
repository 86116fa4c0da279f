"""Boundaries of stability against closed forms, and bounds of rounding against steps in double."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references.oscillator import matrices, strict_limit
from crosscheck.references.stability import boundaries, log_growth, steps_of

SCHEMES = ("euler", "symplectic_euler", "velocity_verlet", "beeman_pc", "gear3", "gear5_velocity")


@pytest.mark.parametrize("scheme", ["modified_euler", "velocity_verlet", "beeman", "euler_pc", "gear2", "gear3"])
def test_without_damping_a_boundary_is_the_limit_in_closed_form(scheme: str) -> None:
    limit = strict_limit(scheme)
    assert limit is not None
    assert min(abs(edge - limit) for edge in boundaries(scheme, 0.0, 1e-3, 10.0)) < 1e-6 * limit


@pytest.mark.parametrize("scheme", ["verlet", "leapfrog", "velocity_verlet"])
@pytest.mark.parametrize("ratio", [1e-2, 1.0, 1e4])
def test_leap_frogs_boundary_with_damping(scheme: str, ratio: float) -> None:
    """lambda^2 - (2 - kappa - c) lambda + 1 - c: by Jury's criterion kappa + 2 c = 4, with c = 2 ratio kappa."""
    (edge,) = boundaries(scheme, ratio, 1e-4, 10.0)
    assert edge == pytest.approx((4 / (1 + 4 * ratio)) ** 0.5, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 100.0])
def test_eulers_boundary_with_damping(ratio: float) -> None:
    """lambda = -1: 1 + trace + determinant = 4 - 2 c, for determinant 1 + kappa/2 - c and trace 2 - kappa/2 - c."""
    (edge,) = boundaries("euler", ratio, 1e-4, 10.0)
    assert edge == pytest.approx(ratio**-0.5, rel=1e-9)


def test_euler_with_little_damping_is_stable_for_no_step() -> None:
    assert boundaries("euler", 0.2, 1e-4, 10.0) == []
    assert log_growth("euler", 0.1, 0.02) > 0


@given(
    scheme=st.sampled_from(SCHEMES),
    h=st.floats(1e-3, 3.0),
    zeta=st.floats(1e-2, 1e3),
    start=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
)
def test_the_bound_of_rounding_holds_for_steps_in_double(
    scheme: str, h: float, zeta: float, start: tuple[float, float]
) -> None:
    one = np.ones(1)
    exact = steps_of(scheme, h * one, zeta * one, start[0] * one, start[1] * one, 12)
    begin, advance, read = (m.astype(float) for m in matrices(scheme, h * h, 2 * zeta * h))
    state = begin @ np.array(start)
    for n in range(1, 13):
        state = advance @ state
        r, u = read @ state
        tiny = 1e-300
        assert abs(r - exact.r[n, 0]) <= exact.r_error[n, 0] + tiny
        assert abs(u - exact.u[n, 0]) <= exact.u_error[n, 0] + tiny


def test_several_oscillators_are_those_alone() -> None:
    h, zeta = np.array([0.1, 0.5]), np.array([0.3, 2.0])
    both = steps_of("gear4", h, zeta, np.array([1.0, 0.5]), np.array([0.0, 0.2]), 5)
    alone = steps_of("gear4", h[1:], zeta[1:], np.array([0.5]), np.array([0.2]), 5)
    np.testing.assert_array_equal(both.r[:, 1:], alone.r)
    np.testing.assert_array_equal(both.u_error[:, 1:], alone.u_error)
    assert both.r.shape == (6, 2)
    assert math.isclose(both.r[0, 0], 1.0)
