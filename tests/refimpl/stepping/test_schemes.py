"""Every claim of the tables of schemes: as plain Python and compiled, counted, and against the exact matrices."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.references import oscillator
from refimpl.compilation import implements
from refimpl.stepping.forces.generic import accelerate, derivatives
from refimpl.stepping.forces.spring import Spring, spring
from refimpl.stepping.integrate import integrate
from refimpl.stepping.schemes import SCHEMES, Scheme

DOCS = Path(__file__).parents[3] / "docs/schemes.md"

each_scheme = pytest.mark.parametrize("name", SCHEMES)
DT = 0.05
FORCE = spring(2.0, 0.5, 0.3)
R, V = np.array([1.0, -0.4, 0.2, 3.0]), np.array([0.1, 0.5, -2.0, 0.7])


class Counted(NamedTuple):
    """A damped spring that counts its evaluations, for plain Python only."""

    spring: Spring
    count: np.ndarray


@implements(accelerate, Counted)
def _accelerate(force: Counted, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    force.count[0] += 1
    return accelerate(force.spring, r, v)


@implements(derivatives, Counted)
def _derivatives(force: Counted, r: np.ndarray, v: np.ndarray, count: int) -> np.ndarray:
    return derivatives(force.spring, r, v, count)


class Cubic(NamedTuple):
    """a = -r^3, beyond any linear problem; plain Python only."""


@implements(accelerate, Cubic)
def _accelerate_cubic(force: Cubic, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    return -(r**3)


def plain(name: str, force: object, r: np.ndarray, v: np.ndarray, dt: float, steps: int) -> np.ndarray:
    """(steps + 1, 2, N*d): the scheme's own functions, called one after the other."""
    record = SCHEMES[name].record
    memory = record.start(force, r, v, dt)
    out = [(r, v)]
    for _ in range(steps):
        r, v, memory = record.step(force, r, v, memory, dt)
        out.append((r, v))
    return np.array(out)


# -- the table is whole ----------------------------------------------------------------------------


@each_scheme
def test_scheme_is_documented_and_has_an_exact_matrix(name: str) -> None:
    scheme = SCHEMES[name]
    assert type(scheme.record).__doc__
    assert not type(scheme.record).__doc__.startswith(type(scheme.record).__name__ + "(")  # what NamedTuple writes
    oscillator.matrices(name, 0.01, 0.0)


# -- plain and compiled -----------------------------------------------------------------------------


@each_scheme
def test_plain_python_equals_the_compiled_loop(name: str) -> None:
    steps = 60
    run = integrate(name, FORCE, R, V, DT, steps, every=1, trajectory=True)
    expected = plain(name, FORCE, R, V, DT, steps)
    np.testing.assert_allclose(run.positions, expected[:, 0], rtol=0, atol=4e-16 * steps * 4)
    np.testing.assert_allclose(run.velocities, expected[:, 1], rtol=0, atol=4e-16 * steps * 4)


@each_scheme
def test_evaluations_are_those_claimed(name: str) -> None:
    scheme, force = SCHEMES[name], Counted(FORCE, np.zeros(1, dtype=int))
    memory = scheme.record.start(force, R, V, DT)
    assert force.count[0] == scheme.start_evaluations
    for _ in range(3):
        force.count[0] = 0
        _, _, memory = scheme.record.step(force, R, V, memory, DT)
        assert force.count[0] == scheme.evaluations
    assert integrate(name, FORCE, R, V, DT, 60, every=1, trajectory=True).evaluations == (
        scheme.start_evaluations + 60 * scheme.evaluations
    )


@each_scheme
def test_functions_are_pure(name: str) -> None:
    record = SCHEMES[name].record
    r, v = R.copy(), V.copy()
    memory = record.start(FORCE, r, v, DT)
    kept = [part.copy() for part in memory]
    first = record.step(FORCE, r, v, memory, DT)
    second = record.step(FORCE, r, v, memory, DT)
    np.testing.assert_array_equal(r, R)
    np.testing.assert_array_equal(v, V)
    for part, before in zip(memory, kept, strict=True):
        np.testing.assert_array_equal(part, before)
    for one, two in zip((*first[:2], *first[2]), (*second[:2], *second[2]), strict=True):
        np.testing.assert_array_equal(one, two)


@each_scheme
def test_results_share_no_memory_with_what_is_carried_on(name: str) -> None:
    # a caller may write into r and v between steps only if they are not the memory
    record = SCHEMES[name].record
    _, v, memory = record.step(FORCE, R, V, record.start(FORCE, R, V, DT), DT)
    assert not any(np.shares_memory(v, part) for part in memory)


# -- claims against the exact matrices ---------------------------------------------------------------


@each_scheme
@settings(max_examples=15)
@given(r0=st.floats(-2, 2), v0=st.floats(-2, 2), dt=st.floats(0.001, 0.3), gamma=st.floats(0, 1))
def test_steps_are_powers_of_the_matrix(name: str, r0: float, v0: float, dt: float, gamma: float) -> None:
    k, mass, steps = 1.3, 0.7, 12
    run = plain(name, spring(k, mass, gamma), np.array([r0]), np.array([v0]), dt, steps)[:, :, 0]
    r, v = oscillator.numerical_solution(name, steps, dt, r0, v0, (k / mass) ** 0.5, gamma / (2 * mass))
    # v is a difference over dt where a scheme has no other
    scale = 1e-15 * steps * (abs(r0) + abs(v0) + 1e-300)
    np.testing.assert_allclose(run[:, 0], r, rtol=0, atol=8 * scale)
    np.testing.assert_allclose(run[:, 1], v, rtol=0, atol=8 * scale * (1 + 1 / dt))


def documented_limits() -> dict[str, tuple[str, str]]:
    """What docs/schemes.md says by scheme: the step below which it is stable, and that of a growth of 1 %."""
    rows = [line.strip("|").split("|") for line in DOCS.read_text(encoding="utf-8").splitlines() if line[:1] == "|"]
    return {row[0].strip(): (row[3].strip(), row[4].strip()) for row in rows[2:]}


def test_the_documented_table_has_every_scheme_but_the_zero_starts() -> None:
    assert list(documented_limits()) == [name for name in SCHEMES if not name.endswith("_zero_start")]


@pytest.mark.parametrize("name", documented_limits())
def test_documented_stability_limits(name: str) -> None:
    stable, practical = documented_limits()[name]
    strict = oscillator.strict_limit(name)
    if strict is not None:
        assert {"sqrt 2": 2**0.5, "2/sqrt 3": 2 / 3**0.5, "2": 2.0}[stable] == pytest.approx(strict, rel=1e-15)
    elif stable == "none":
        for h in (0.05, 0.2, 0.5):
            assert oscillator.growth_rate(name, h) > 0
    else:
        assert oscillator.growth_rate(name, float(stable) - 5e-5) < 0
        assert oscillator.growth_rate(name, float(stable) + 5e-5) > 0
    assert float(practical) == pytest.approx(oscillator.practical_limit(name, 1.01), abs=5.1e-5)


@each_scheme
@settings(max_examples=10)
@given(h=st.fractions(Fraction(1, 100), Fraction(3, 2), max_denominator=100), c=st.just(Fraction(0)))
def test_symplectic_means_a_map_of_determinant_one(name: str, h: Fraction, c: Fraction) -> None:
    """In one degree of freedom; the map is that of the first step, start included, in exact rationals."""
    start, advance, read = oscillator.matrices(name, h**2, c)
    for power in (1, 3):
        m = start
        for _ in range(power):
            m = advance @ m
        m = read @ m
        determinant = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
        assert (determinant == 1) == SCHEMES[name].symplectic


@each_scheme
def test_reversible_means_there_and_back(name: str) -> None:
    there = plain(name, Cubic(), R, V, DT, 10)[-1]
    back = plain(name, Cubic(), there[0], -there[1], DT, 10)[-1]
    error = max(abs(back[0] - R).max(), abs(back[1] + V).max())
    assert (error < 1e-12) == SCHEMES[name].reversible


def order_from_the_matrices(name: str, v0: float, beta: float) -> np.ndarray:
    """Of the largest (position, velocity) error over two time units, from one halving of a small step.

    In long double: rounding is far below.
    """
    scheme: Scheme = SCHEMES[name]
    t = np.linspace(0, 2, 17)
    errors = []
    for steps in (1 << 10, 1 << 11) if min(scheme.order) < 4 else (1 << 7, 1 << 8):
        dt = np.longdouble(2) / steps
        start, advance, read = (m.astype(np.longdouble) for m in oscillator.matrices(name, dt**2, 2 * beta * dt))
        state, out = start @ np.array([1, v0 * dt]), []
        for n in range(steps + 1):
            if n % (steps // 16) == 0:
                out.append(read @ state / np.array([1, dt]))
            state = advance @ state
        exact = np.array(oscillator_in_long_double(t, v0, beta))
        errors.append(np.abs(np.array(out).T - exact).max(axis=1))
    return np.log2((errors[0] / errors[1]).astype(float))


def oscillator_in_long_double(t: np.ndarray, v0: float, beta: float) -> tuple[np.ndarray, np.ndarray]:
    """r and v for omega0 = 1, r0 = 1, by the power series of r'' = -r - 2 beta r'."""
    t, beta = t.astype(np.longdouble), np.longdouble(beta)
    coefficients = [np.longdouble(1), np.longdouble(v0)]
    for q in range(58):
        coefficients.append(-(coefficients[q] + 2 * beta * (q + 1) * coefficients[q + 1]) / ((q + 2) * (q + 1)))
    series = np.array(coefficients[::-1])
    return np.polyval(series, t), np.polyval(np.polyder(series), t)


@each_scheme
@pytest.mark.parametrize("beta", [0.0, 0.3])
def test_orders(name: str, beta: float) -> None:
    # from a general phase: from rest, some orders look better than they are
    v0 = 0.0 if name == "gear4" and beta == 0 else 0.7
    claimed = SCHEMES[name].order_damped if beta else SCHEMES[name].order
    np.testing.assert_allclose(order_from_the_matrices(name, v0, beta), claimed, atol=0.1)


def test_gear4_has_a_small_term_of_order_4_from_a_velocity() -> None:
    # the exception above is needed, and no larger than the table of schemes says
    assert order_from_the_matrices("gear4", 0.7, 0.0)[0] == pytest.approx(4, abs=0.1)
    h, steps, v0 = 2.0**-9, 1024, 0.7
    r, _ = oscillator.numerical_solution("gear4", steps, h, 0.0, v0, 1.0, 0.0)
    t = h * np.arange(steps + 1)
    np.testing.assert_allclose(r - v0 * np.sin(t), h**4 / 720 * v0 * np.sin(t), rtol=0, atol=0.1 * h**4 / 720)


# -- schemes that are one and the same ---------------------------------------------------------------


def test_gear2_is_velocity_verlet() -> None:
    one, two = (plain(name, Cubic(), R, V, DT, 40) for name in ("gear2", "velocity_verlet"))
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-12)


@pytest.mark.parametrize("other", ["leapfrog", "velocity_verlet"])
def test_verlets_are_one(other: str) -> None:
    one, two = (plain(name, Cubic(), R, V, DT, 40) for name in ("verlet", other))
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-11)


def test_both_beemans_are_one_without_velocity_dependence() -> None:
    one, two = (plain(name, Cubic(), R, V, DT, 40) for name in ("beeman", "beeman_pc"))
    np.testing.assert_array_equal(one, two)


def test_beeman_positions_follow_verlets_recurrence() -> None:
    r = plain("beeman", Cubic(), R, V, DT, 40)[:, 0]
    np.testing.assert_allclose(r[2:] - 2 * r[1:-1] + r[:-2], -(DT**2) * r[1:-1] ** 3, rtol=0, atol=1e-13)
