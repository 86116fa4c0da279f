"""The recurrences against the exact matrices on the oscillator, and against laws that hold for any force."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crosscheck.references import oscillator
from crosscheck.references.recurrences import MAPS, Problem, solutions

OMEGA, BETA, DT, STEPS = 1.3, 0.2, 0.1, 30
LINEAR = Problem(
    lambda r, v: -(OMEGA**2) * r - 2 * BETA * v,
    lambda r, v, count: chain(r, v, count),
)
START = np.array([0.8]), np.array([0.5])


def chain(r: Any, v: Any, count: int) -> list[Any]:
    found = [r, v, LINEAR.acceleration(r, v)]
    for _ in range(count):
        found.append(LINEAR.acceleration(found[-2], found[-1]))
    return found[3:]


def anharmonic(r: Any, v: Any) -> Any:
    return -r - r**3


@pytest.mark.parametrize("scheme", list(MAPS))
def test_a_recurrence_is_the_matrix_of_its_scheme(scheme: str) -> None:
    """Two derivations, by hand and from the recurrence, of the damped oscillator's numerical solution."""
    r, v = oscillator.numerical_solution(scheme, STEPS, DT, 0.8, 0.5, OMEGA, BETA)
    start = tuple(part.astype(np.longdouble) for part in START)
    positions, velocities, _ = solutions(scheme, LINEAR, *start, DT, STEPS)[0]
    assert abs(positions[:, 0] - r).max() < 1e-14
    assert abs(velocities[:, 0] - v).max() < 1e-14


def test_verlet_leapfrog_and_velocity_verlet_have_one_path() -> None:
    paths = [
        solutions(name, Problem(anharmonic), *START, DT, STEPS)[0] for name in ("verlet", "leapfrog", "velocity_verlet")
    ]
    for path in paths[1:]:
        for a, b in zip(path[:2], paths[0][:2], strict=True):
            assert abs(a - b).max() < 1e-13


@pytest.mark.parametrize("number", [0, 1])
def test_both_leapfrogs_return(number: int) -> None:
    positions, velocities, _ = solutions("leapfrog", Problem(anharmonic), *START, DT, STEPS)[number]
    back, turned, _ = solutions("leapfrog", Problem(anharmonic), positions[-1], -velocities[-1], DT, STEPS)[number]
    assert abs(back[-1] - START[0]).max() < 1e-13
    assert abs(turned[-1] + START[1]).max() < 1e-13


def test_without_higher_derivatives_gear_starts_from_zero() -> None:
    plain = Problem(LINEAR.acceleration)
    for known, zero in (("gear4_velocity", "gear4_zero_start"), ("gear5_velocity", "gear5_zero_start")):
        (a, *_), (b, *_) = (solutions(name, plain, *START, DT, STEPS)[0] for name in (known, zero))
        assert (a == b).all()


def test_unknown_scheme() -> None:
    with pytest.raises(KeyError):
        solutions("magic", LINEAR, *START, DT, 1)
