"""Extrapolation to no step; orders with their windows on made-up ladders."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.convergence import CLEAR, FEWEST, extrapolate, fitted_order, observed_order


def test_even_polynomials_are_extrapolated_exactly() -> None:
    steps = 0.1 / np.array([1, 2, 3, 4])
    values = [np.array([1.0 + 3 * h**2 - 50 * h**4 + 7 * h**6, -2.0 + h**2]) for h in steps]
    limit = extrapolate(steps, values)
    assert limit.value == pytest.approx([1.0, -2.0], abs=1e-14)
    assert limit.weights.sum() == pytest.approx(1.0)


def test_the_error_estimate_is_not_too_small() -> None:
    def scheme(n: int) -> float:
        """Velocity Verlet's cosine after one radian: cos(n w), sin(w/2) = h/2."""
        return float(np.cos(2 * n * np.arcsin(0.5 / n)))

    numbers = np.array([2, 4, 6])
    limit = extrapolate(1 / numbers, [scheme(n) for n in numbers])
    true = abs(float(limit.value) - np.cos(1.0))
    assert true < limit.error < 1000 * true


def test_three_runs_at_least() -> None:
    with pytest.raises(ValueError, match="at least 3 runs"):
        extrapolate([0.2, 0.1], [1.0, 1.0])


orders = st.floats(0.5, 8.0)
factors = st.floats(1e-3, 1e3)
numbers = st.integers(5, 10)
#: Terms of the next order, D h^q, that are a third of the first one at most at the largest step, 0.3.
seconds = st.floats(-1.0, 1.0)
powers = st.sampled_from([1, 2])


@given(order=orders, factor=factors, number=numbers, permutation=st.randoms(use_true_random=False))
def test_a_power_law_gives_its_order(order: float, factor: float, number: int, permutation) -> None:  # type: ignore[no-untyped-def]
    exponents = list(range(number))
    permutation.shuffle(exponents)
    steps = 0.3 * 0.5 ** np.array(exponents)
    found = observed_order(steps, factor * steps**order)
    assert found.value == pytest.approx(order, abs=1e-8)
    assert found.half < 1e-7
    assert len(found.used) >= FEWEST


@given(order=orders, factor=factors, number=numbers, second=seconds, power=powers)
def test_a_second_term_is_within_the_interval(
    order: float, factor: float, number: int, second: float, power: int
) -> None:
    steps = 0.3 * 0.5 ** np.arange(number)
    found = observed_order(steps, factor * steps**order * (1 + second * steps**power))
    assert abs(found.value - order) <= found.half + 1e-9


@given(order=st.floats(1.0, 6.0), second=seconds, floor=st.floats(1e-14, 1e-8), seed=st.integers(0, 2**32 - 1))
def test_runs_at_the_floor_are_not_in_the_window(order: float, second: float, floor: float, seed: int) -> None:
    steps = 0.3 * 0.5 ** np.arange(20)
    noise = floor * np.random.default_rng(seed).uniform(-1, 1, steps.size)
    errors = abs(steps**order * (1 + second * steps) + noise)
    found = observed_order(steps, errors, floor)
    if not found.used:
        assert sum(errors >= CLEAR * floor) < FEWEST
        return
    assert (errors[list(found.used)] >= CLEAR * floor).all()
    # neighbours, from the finest on
    assert list(found.used) == list(range(found.used[0], found.used[-1] - 1, -1))


def test_the_window_leaves_out_what_is_not_yet_asymptotic() -> None:
    steps = 0.5 ** np.arange(12)
    errors = steps**2 / (1 + 30 * steps**2)  # flat above h = 0.2
    found = observed_order(steps, errors)
    assert found.value == pytest.approx(2, abs=0.02)
    assert steps[list(found.used)].max() < 0.1


def test_runs_as_wrong_as_can_be_are_left_out() -> None:
    steps = 0.5 ** np.arange(8)
    errors = np.where(steps > 0.2, 1e200, steps**3)
    assert observed_order(steps, errors, ceiling=1.0).value == pytest.approx(3)


def test_intervals_cover_orders_of_noisy_errors() -> None:
    """19 of 20 where errors scatter, second terms are there, and rounding ends the ladder; less 5 deviations."""
    rng = np.random.default_rng(1)
    trials, hit = 0, 0
    for _ in range(600):
        order, steps = rng.uniform(1, 6), 0.3 * 0.5 ** np.arange(rng.integers(6, 11))
        floor = 10 ** rng.uniform(-14, -9)
        errors = steps**order * (1 + rng.uniform(-1, 2) * steps ** rng.integers(1, 3))
        errors = abs(errors * np.exp(0.01 * rng.normal(size=steps.size)) + floor * rng.uniform(-1, 1, steps.size))
        found = observed_order(steps, errors, floor)
        if found.used:
            trials, hit = trials + 1, hit + (found.interval[0] <= order <= found.interval[1])
    assert hit / trials > 0.95 - 5 * (0.95 * 0.05 / trials) ** 0.5


@given(order=orders, factor=factors, number=numbers, second=seconds, power=powers)
def test_right_errors_do_not_leave_their_order(
    order: float, factor: float, number: int, second: float, power: int
) -> None:
    steps = 0.3 * 0.5 ** np.arange(number)
    assert not observed_order(steps, factor * steps**order * (1 + second * steps**power)).leaves(order)


@given(order=st.floats(1.0, 6.0), number=st.integers(4, 10), share=st.floats(0.1, 0.9))
def test_errors_that_saturate_leave_it(order: float, number: int, share: float) -> None:
    """A part that does not vanish with the step, as large as the rest within the ladder, but for its last two runs."""
    steps = 0.3 * 0.5 ** np.arange(number)
    constant = float(steps[-1]) ** order * 2.0 ** (order * (1.5 + share))
    found = observed_order(steps, steps**order + constant)
    assert found.leaves(order) or found.interval[1] < order - 0.25


def test_known_standard_errors_widen_the_interval() -> None:
    steps = 0.5 ** np.arange(6)
    sharp = observed_order(steps, steps**2)
    assert observed_order(steps, steps**2, uncertainties=0.1 * steps**2).half > sharp.half + 0.05


def test_too_few_runs_are_no_order() -> None:
    found = observed_order([0.4, 0.2, 0.1, 0.05], [1e-2, 1e-4, 1e-9, 1e-9], 1e-9)
    assert found.used == ()
    assert "2 neighbouring runs" in found.reason
    assert np.isnan(found.value)


@pytest.mark.parametrize("steps", [[0.1, 0.1, 0.2, 0.4], [0.0, 0.1, 0.2, 0.4]])
def test_steps_are_positive_and_different(steps: list[float]) -> None:
    with pytest.raises(ValueError, match="positive, and differ"):
        observed_order(steps, [1.0, 2.0, 3.0, 4.0])


# -- the three smallest steps -----------------------------------------------------------------------


@given(order=st.floats(0.5, 8), factor=st.floats(1e-3, 1e3), permutation=st.permutations(range(5)))
def test_a_power_law_gives_its_exponent(order: float, factor: float, permutation: list[int]) -> None:
    steps = 0.1 * 2.0 ** -np.array(permutation)
    slope = fitted_order(steps, factor * steps**order, floor=0.0)
    assert slope.value == pytest.approx(order, abs=1e-9)
    assert slope.error < 1e-9
    assert slope.used == 3


def test_points_at_the_floor_and_broken_ones_are_left_out() -> None:
    steps = np.array([0.8, 0.4, 0.2, 0.1, 0.05, 0.025])
    errors = steps**4
    errors[3], errors[4], errors[5] = 1e-15, 1e-14, np.inf
    slope = fitted_order(steps, errors, floor=1e-14)
    assert slope.value == pytest.approx(4, abs=1e-12)


def test_the_smallest_steps_are_fitted() -> None:
    steps = 0.5 ** np.arange(8)
    slope = fitted_order(steps, steps**2 * (1 + steps), floor=0.0)
    assert slope.value == pytest.approx(2, abs=0.03)
    assert slope.error < 0.01


def test_error_is_the_departure_of_the_local_slopes() -> None:
    # local slopes 1 and 3
    slope = fitted_order([1.0, 2.0, 4.0], [1.0, 2.0, 16.0], floor=0.0)
    assert slope.value == pytest.approx(2)
    assert slope.error == pytest.approx(1)


def test_too_few_points_are_refused() -> None:
    with pytest.raises(ValueError, match="3 points above the rounding floor 1e-10, found 2"):
        fitted_order([1.0, 0.5, 0.25], [1e-2, 1e-4, 1e-10], floor=1e-10)
