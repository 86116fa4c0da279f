"""Velocity Verlet with compensated summation: the same steps, with what rounding takes kept."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_python import plain_python

from crosscheck.references.oscillator import numerical_solution

R, V = np.array([1.0, -0.4, 0.2]), np.array([0.1, 0.5, -2.0])


def module(name: str) -> Any:
    return plain_python(f"refimpl.stepping.{name}")


def moved(steps: int, compensated: bool, **more: Any) -> Any:
    """Springs of k = m = 1 after so many steps of 0.1."""
    force = module("forces.spring").spring(1.0, 1.0, None)
    return module("integrate").integrate(
        "velocity_verlet", force, R, V, 0.1, steps, compensated=compensated, trajectory=True, every=steps, **more
    )


@given(
    r=st.floats(-1e3, 1e3),
    v=st.floats(-1e3, 1e3),
    rest=st.floats(-1e-13, 1e-13),
    velocity_rest=st.floats(-1e-13, 1e-13),
)
def test_a_step_loses_nothing_but_the_rounding_of_its_increments(
    r: float, v: float, rest: float, velocity_rest: float
) -> None:
    dt = 0.1
    force = module("forces.spring").spring(1.0, 1.0, None)
    scheme = module("schemes").COMPENSATED["velocity_verlet"].record
    memory = np.array([-r]), np.array([rest]), np.array([velocity_rest])
    new_r, new_v, (a, r_lacks, v_lacks) = scheme.step(force, np.array([r]), np.array([v]), memory, dt)
    # the sums of increments and rests are rounded, and nothing else is
    kick = 0.5 * dt * -r + velocity_rest
    half = float(np.float64(v) + np.float64(kick))
    lack = float(Fraction(v) + Fraction(kick) - Fraction(half))
    way = dt * half + (rest + dt * lack)
    assert Fraction(float(new_r[0])) + Fraction(float(r_lacks[0])) == Fraction(r) + Fraction(way)
    second = 0.5 * dt * float(a[0]) + lack
    assert Fraction(float(new_v[0])) + Fraction(float(v_lacks[0])) == Fraction(half) + Fraction(second)


def test_it_is_velocity_verlet_but_for_rounding() -> None:
    plain, kept = moved(500, False), moved(500, True)
    np.testing.assert_allclose(kept.r, plain.r, atol=1e-13)
    np.testing.assert_allclose(kept.v, plain.v, atol=1e-13)
    assert kept.evaluations == plain.evaluations


def test_rounding_is_smaller() -> None:
    """Than half of that of the plain form, against the powers of the step matrix in long double, and of few units."""
    steps = 20_000
    errors = {}
    for compensated in (False, True):
        run = moved(steps, compensated)
        exact = [numerical_solution("velocity_verlet", steps, 0.1, r, v, 1.0, 0.0) for r, v in zip(R, V, strict=True)]
        ends = np.array([(r[-1], v[-1]) for r, v in exact])
        errors[compensated] = np.hypot(*(np.array([run.r, run.v]).T - ends).T).mean()
    assert errors[True] < errors[False] / 2
    assert errors[True] < 1e-14


def test_it_goes_on_with_the_same_bits() -> None:
    whole, half = moved(40, True), moved(20, True)
    rest = moved(20, True, state=half.state)
    np.testing.assert_array_equal(rest.r, whole.r)
    np.testing.assert_array_equal(rest.v, whole.v)


def test_other_schemes_have_no_such_form() -> None:
    with pytest.raises(KeyError):
        module("integrate").scheme_of("euler", compensated=True)
