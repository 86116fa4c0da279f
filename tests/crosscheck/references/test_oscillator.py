"""The closed form against the equation of motion, and the matrices against roots known in closed form."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from crosscheck.references import EPSILON
from crosscheck.references.oscillator import (
    energy_growth,
    fastest_rate,
    growth_per_step,
    growth_rate,
    has_matrix,
    matrices,
    numerical_solution,
    practical_limit,
    rounding_error,
    rounding_lever,
    solution,
    strict_limit,
)

SCHEMES = [
    *("euler", "modified_euler", "symplectic_euler", "euler_pc", "verlet", "leapfrog", "velocity_verlet"),
    *("beeman", "beeman_pc", "gear2", "gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity"),
    *("gear4_zero_start", "gear5_zero_start"),
]
steps_of_h = st.fractions(Fraction(1, 50), Fraction(1), max_denominator=50)


# -- closed form --------------------------------------------------------------------------------------


def series(t: float, r0: float, v0: float, omega0: float, beta: float) -> tuple[float, float]:
    """r and v by the power series of the equation of motion, in rationals: exact to the last bit for small t."""
    t, w2, b = Fraction(t), Fraction(omega0) ** 2, Fraction(beta)
    below, last, power, r, v = Fraction(r0), Fraction(v0), Fraction(1), Fraction(r0), Fraction(v0)
    for q in range(1, 40):
        power *= t / q  # t^q/q!
        r += last * power
        below, last = last, -w2 * below - 2 * b * last
        v += last * power
    return float(r), float(v)


@given(
    t=st.floats(0, 2), r0=st.floats(-2, 2), v0=st.floats(-2, 2), omega0=st.floats(0.5, 1.5), beta=st.floats(0.0, 1.5)
)
def test_closed_form_is_the_power_series(t: float, r0: float, v0: float, omega0: float, beta: float) -> None:
    np.testing.assert_allclose(solution(t, r0, v0, omega0, beta), series(t, r0, v0, omega0, beta), rtol=0, atol=2e-14)


@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("sign", [-1, 1])
def test_continuous_across_critical_damping(gap: float, sign: int) -> None:
    beta = 1.0 + sign * gap
    np.testing.assert_allclose(solution(1.7, 1.0, 0.6, 1.0, beta), series(1.7, 1.0, 0.6, 1.0, beta), rtol=1e-14)


@pytest.mark.parametrize("beta", [0.0, 0.1, 1.0, 2.0, 20.0])
def test_closed_form_solves_the_equation_of_motion(beta: float) -> None:
    t = np.linspace(0, 12, 25)
    found = solve_ivp(
        lambda _, y: (y[1], -(1.7**2) * y[0] - 2 * beta * y[1]),
        (0, 12),
        (1.0, -0.4),
        "DOP853",
        t,
        rtol=1e-13,
        atol=1e-15,
    )
    np.testing.assert_allclose(solution(t, 1.0, -0.4, 1.7, beta), found.y, rtol=0, atol=1e-11)


def test_long_over_damped_times_do_not_overflow() -> None:
    with np.errstate(over="raise", invalid="raise"):
        r, v = solution(np.array([1e3, 1e5, 1e300]), 1.0, 0.5, 1.0, 50.0)
    # what is left is the slow exponential, rate omega0^2/(beta + w)
    slow = 1 / (50 + (50**2 - 1) ** 0.5)
    w = (50**2 - 1) ** 0.5
    assert r[0] == pytest.approx((0.5 + (0.5 + 50) / (2 * w)) * np.exp(-slow * 1e3), rel=1e-12)
    assert v[0] == pytest.approx(-slow * r[0], rel=1e-10)
    assert r[2] == v[2] == 0


def test_strongly_over_damped_rate_keeps_its_digits() -> None:
    # the slow rate is 5e-9, and beta - w would have lost half of its digits
    beta = 1e8
    r, _ = solution(np.array(1e8), 1.0, 0.0, 1.0, beta)
    assert r == pytest.approx(np.exp(-0.5), rel=1e-14)


def test_the_documented_case() -> None:
    m, k, gamma = 70.0, 1e4, 100.0
    r, v = solution(5.0, 1.0, -gamma / (2 * m), (k / m) ** 0.5, gamma / (2 * m))
    assert r == pytest.approx(-0.028097802999337, abs=1e-15)
    assert v == pytest.approx(0.0081163495371, abs=1e-13)


def test_shape_is_that_of_the_times() -> None:
    r, v = solution([[0.0, 1.0, 2.0]], 3.0, 4.0, 1.0, 0.1)
    assert r.shape == v.shape == (1, 3)
    assert (r[0, 0], v[0, 0]) == (3, 4)


# -- matrices ----------------------------------------------------------------------------------------


def determinant(advance: np.ndarray) -> Fraction:
    return advance[0, 0] * advance[1, 1] - advance[0, 1] * advance[1, 0]


@given(h=steps_of_h)
def test_determinants_of_the_one_step_schemes(h: Fraction) -> None:
    """|root|^2 where the roots are complex."""
    expected = {
        "euler": 1 + h**2 / 2,
        "modified_euler": 1 - h**2 / 2,
        "symplectic_euler": 1,
        "euler_pc": 1 - h**2,
    }
    for scheme, value in expected.items():
        advance = matrices(scheme, h**2, Fraction(0))[1]
        assert determinant(advance) == value
        assert growth_per_step(scheme, float(h)) == pytest.approx(float(value) ** 0.5, rel=1e-14)


@pytest.mark.parametrize("scheme", ["verlet", "leapfrog", "velocity_verlet", "beeman", "beeman_pc", "gear2"])
@settings(max_examples=20)
@given(h=st.floats(0.01, 1.9))
def test_verlets_roots_are_on_the_unit_circle(scheme: str, h: float) -> None:
    """lambda + 1/lambda = 2 - h^2: sin(omega_num dt/2) = h/2."""
    root = np.exp(2j * np.arcsin(h / 2))
    eigenvalues = np.linalg.eigvals(matrices(scheme, h**2, 0.0)[1].astype(float))
    for value in (root, root.conjugate()):
        assert abs(eigenvalues - value).min() < 1e-13
    assert abs(growth_rate(scheme, h)) < 1e-15


@pytest.mark.parametrize(
    ("scheme", "coefficient", "power"),
    [
        ("euler", 0.25, 2),
        ("modified_euler", -0.25, 2),
        ("euler_pc", -0.5, 2),
        ("gear3", -0.042, 6),
        ("gear4", 0.037, 6),
        ("gear4_velocity", 0.063, 6),
        ("gear5", 0.072, 8),
        ("gear5_velocity", -0.0083, 6),
    ],
)
def test_growth_rates_at_small_steps(scheme: str, coefficient: float, power: int) -> None:
    """ln|root| = C h^p (1 + O(h^2)); the table of known values, taken at h = 0.1, has two digits."""
    at = {h: growth_rate(scheme, h) / h**power for h in (0.01, 0.02, 0.1)}
    assert at[0.1] == pytest.approx(coefficient, rel=0.02)
    assert at[0.1] == pytest.approx(at[0.01], rel=0.15)
    assert at[0.02] == pytest.approx(at[0.01], rel=0.15 / 25)


def test_gear4_grows_by_3_7e_7_a_radian_at_a_tenth() -> None:
    assert growth_rate("gear4", 0.1) / 0.1 == pytest.approx(3.7e-7, rel=0.02)


@pytest.mark.parametrize("scheme", SCHEMES)
@settings(max_examples=8)
@given(kappa=steps_of_h, c=steps_of_h)
def test_solution_in_rationals_and_in_long_double_are_one(scheme: str, kappa: Fraction, c: Fraction) -> None:
    steps, dt = 5, 0.5
    omega0, beta = float(kappa) ** 0.5 / dt, float(c) / (2 * dt)
    start, advance, read = matrices(scheme, Fraction(omega0 * dt) ** 2, 2 * Fraction(beta) * Fraction(dt))
    state = start @ np.array([Fraction(1), Fraction(3, 10) * Fraction(dt)])
    for _ in range(steps):
        state = advance @ state
    r, v = numerical_solution(scheme, steps, dt, 1.0, 0.3, omega0, beta)
    np.testing.assert_allclose([r[-1], v[-1] * dt], (read @ state).astype(float), rtol=0, atol=1e-15 * 2**5)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_solution_starts_with_the_initial_state_and_is_linear(scheme: str) -> None:
    one, two, both = (
        np.array(numerical_solution(scheme, 8, 0.1, r0, v0, 1.0, 0.2))
        for r0, v0 in ((1.0, 0.0), (0.0, 2.0), (1.0, 2.0))
    )
    np.testing.assert_array_equal(both[:, 0], [1, 2])
    np.testing.assert_allclose(one + two, both, rtol=0, atol=1e-15)


def test_unknown_scheme_has_no_matrix() -> None:
    with pytest.raises(KeyError):
        matrices("magic", 0.01, 0.0)


# -- stability limits ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scheme", "limit"),
    [
        *((scheme, 2.0) for scheme in ("symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "beeman", "gear2")),
        ("modified_euler", 2**0.5),
        ("gear3", 2**0.5),
        ("euler_pc", 2 / 3**0.5),
        ("euler", None),
        ("gear4", None),
        ("gear5", None),
    ],
)
def test_strict_limits(scheme: str, limit: float | None) -> None:
    assert strict_limit(scheme) == limit


@pytest.mark.parametrize("scheme", [scheme for scheme in SCHEMES if strict_limit(scheme)])
def test_nothing_grows_below_the_strict_limit_and_it_does_above(scheme: str) -> None:
    limit = strict_limit(scheme)
    for h in np.linspace(0.05, 0.999 * limit, 20):
        assert growth_per_step(scheme, float(h)) < 1 + 1e-7  # Beeman's root at 1 is double
    assert growth_per_step(scheme, 1.001 * limit) > 1 + 1e-4


@pytest.mark.parametrize(
    ("scheme", "limit", "digits"),
    [
        ("euler", (2 * (1.01**2 - 1)) ** 0.5, 1e-13),
        ("verlet", (2 + 1.01 + 1 / 1.01) ** 0.5, 1e-13),
        ("gear4", 1.11, 5e-3),
        ("gear4_velocity", 0.94, 5e-3),
        ("gear5", 0.85, 5e-3),
        ("gear5_velocity", 0.81, 5e-3),
    ],
)
def test_practical_limits(scheme: str, limit: float, digits: float) -> None:
    found = practical_limit(scheme, 1.01)
    assert found == pytest.approx(limit, abs=digits)
    assert growth_per_step(scheme, found) == pytest.approx(1.01, abs=1e-12)


# -- rates and rounding -------------------------------------------------------------------------------


@pytest.mark.parametrize("beta", [0.0, 0.3, 1.7, 2.0, 20.0])
def test_fastest_rate_is_the_largest_root(beta: float) -> None:
    assert fastest_rate(1.7, beta) == pytest.approx(abs(np.roots([1.0, 2 * beta, 1.7**2])).max(), rel=1e-7)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_energy_grows_as_the_numerical_solution_does(scheme: str) -> None:
    h = 2 * np.pi / 50
    r, v = numerical_solution(scheme, 5000, h, 1.0, 0.7, 1.0, 0.0)
    energy = (r**2 + v**2)[::50]
    assert has_matrix(scheme)
    measured = np.log(energy[-1] / energy[40]) / (60 * 50 * h)
    # the phase of the samples creeps round, by far less than a period: the energy's swing moves with it
    assert energy_growth(scheme, h) == pytest.approx(measured, rel=0.01, abs=1e-4)
    if strict_limit(scheme) == 2.0:
        assert energy_growth(scheme, h) == 0.0


def test_magic_has_no_matrix() -> None:
    assert not has_matrix("magic")


def test_rounding_error_by_trial() -> None:
    """Independent roundings of r and v, turned to the end by the exact rotation."""
    steps, trials = 1000, 4000
    rng = np.random.default_rng(5)
    phase = np.arange(steps) * 0.1
    r, v = np.cos(phase), -np.sin(phase)
    shift = EPSILON * rng.uniform(-0.5, 0.5, size=(2, trials, steps)) * np.array([r, v])[:, None]
    left = 100.0 - phase
    final = (shift[0] * np.cos(left) + shift[1] * np.sin(left)).sum(1)
    # r^2 and v^2 are 1/2 on average: the estimate takes both as 1
    assert 0.4 < final.std() / rounding_error(steps) < 1


@pytest.mark.parametrize("scheme", ["verlet", "leapfrog", "velocity_verlet"])
def test_a_rounding_of_the_position_is_one_of_the_velocity_for_verlet(scheme: str) -> None:
    """The last position of the state is disturbed by 1; the motion that follows has this amplitude."""
    h = 0.01
    _, advance, read = (part.astype(float) for part in matrices(scheme, h**2, 0.0))
    state = np.zeros(len(advance))
    state[2 if scheme == "verlet" else 0] = 1.0
    amplitude = 0.0
    for _ in range(700):
        state = advance @ state
        r, u = read @ state
        amplitude = max(amplitude, float(np.hypot(r, u / h)))
    assert amplitude == pytest.approx(rounding_lever(scheme, 1 / h), rel=0.01)
