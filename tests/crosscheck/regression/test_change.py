"""Numbers change where two right runs would not, and as rarely by chance as is promised."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, t
from two_results import bound, by_tolerance, statistical

from crosscheck.regression.change import FALSE_ALARM, MOVED, WORSE, change
from crosscheck.regression.results import Number
from crosscheck.verdict import FALSE_ALARM_OF_A_RUN

LEVEL = 1e-4


def moved(old: Number, new: Number, level: float = LEVEL, same_seed: bool = True) -> float:
    share = change(old, new, level, same_seed)
    assert share is not None
    return share


# -- standard errors ------------------------------------------------------------------------------------------


def test_the_promise_is_that_of_a_run() -> None:
    assert FALSE_ALARM == FALSE_ALARM_OF_A_RUN == 1e-3


def test_errors_of_both_runs_add_and_the_quantile_is_students() -> None:
    old, new = statistical(1.0, 0.3, freedom=9), statistical(2.0, 0.4, freedom=12)
    freedom = 0.25**2 / (0.09**2 / 9 + 0.16**2 / 12)  # Welch's sum
    assert moved(old, new) == pytest.approx(1 / (t.isf(LEVEL / 2, freedom) * 0.5))


def test_deviations_are_compared_not_what_was_measured() -> None:
    """An expected value that follows from the temperature of the run moves with what is measured."""
    old, new = statistical(-3.1, 0.001, expected=-3.1), statistical(-3.2, 0.001, expected=-3.2)
    assert moved(old, new) == 0
    assert moved(old, statistical(-3.1, 0.001, expected=-3.2)) > 10


def test_an_error_of_what_is_expected_counts_if_it_is_another_one() -> None:
    more = {"expected_uncertainty": 3.0, "freedom": 1e6}
    alone = moved(statistical(0.0, 1.0, expected=5.0, **more), statistical(4.0, 1.0, expected=5.0, **more))
    assert alone == pytest.approx(4 / (t.isf(LEVEL / 2, 1e4) * 2**0.5), rel=1e-3)
    # to the digits of a baseline it is the same
    rounded = moved(statistical(0.0, 1.0, expected=5.0, **more), statistical(4.1, 1.0, expected=5.1, **more))
    assert rounded == pytest.approx(alone, rel=1e-3)
    other = moved(statistical(0.0, 1.0, expected=5.0, **more), statistical(6.0, 1.0, expected=7.0, **more))
    assert other == pytest.approx(4 / (t.isf(LEVEL / 2, 1e6) * 20**0.5), rel=1e-3)


def test_what_is_measured_has_fewer_degrees_of_freedom_than_the_sum() -> None:
    """20 of the sum of two equal errors: 5 at least of one; 6 if it was green, which it is not with fewer."""
    more = {"expected_uncertainty": 1.0, "freedom": 20}
    for outcome, freedom in (("fail", 5), ("pass", 6)):
        one, other = statistical(0.0, 1.0, outcome, **more), statistical(9.0, 1.0, outcome, **more)
        assert moved(one, other) == pytest.approx(9 / (t.isf(LEVEL / 2, 2 * freedom) * 2**0.5))


def test_degrees_of_freedom_that_are_not_known_are_few() -> None:
    old, new = statistical(0.0, 1.0, freedom=None), statistical(9.0, 1.0, freedom=None)
    assert moved(old, new) == pytest.approx(9 / (t.isf(LEVEL / 2, 12) * 2**0.5))


def test_numbers_that_do_not_scatter_must_be_equal() -> None:
    assert moved(statistical(2.0, 0.0), statistical(2.0, 0.0)) == 0
    assert moved(statistical(2.0, 0.0), statistical(2.0 + 1e-12, 0.0)) == 0  # rounding
    assert moved(statistical(2.0, 0.0), statistical(2.1, 0.0)) == math.inf


numbers = st.floats(-1e3, 1e3)
errors = st.floats(1e-3, 1e3)
freedoms = st.floats(6, 1e4)


@given(numbers, numbers, errors, errors, freedoms, freedoms, st.sampled_from(["pass", "fail"]))
def test_the_order_of_the_runs_does_not_matter(
    x: float, y: float, u: float, v: float, f: float, g: float, outcome: str
) -> None:
    old, new = statistical(x, u, outcome, freedom=f), statistical(y, v, outcome, freedom=g)
    assert moved(old, new) == moved(new, old)
    assert moved(old, new) <= moved(old, new, level=1e-2)
    assert moved(old, new, same_seed=False) == moved(old, new)


def test_right_runs_change_as_rarely_as_is_promised() -> None:
    """Means of 7 to 60 normal numbers, with the errors that they show: 20 judgements in each of 1000 pairs of runs."""
    random, family, size = np.random.default_rng(14), 0.1, 20
    pairs = changed = 0
    for _ in range(1000):
        lengths, scales = random.integers(7, 60, (size, 2)), random.uniform(0.1, 10, (size, 2))
        alarm = False
        for number, scale in zip(lengths, scales, strict=True):
            rows = [random.normal(3.0, s, n) for n, s in zip(number, scale, strict=True)]
            one, other = (
                statistical(float(row.mean()), float(row.std(ddof=1)) / row.size**0.5, freedom=row.size - 1.0)
                for row in rows
            )
            alarm |= moved(one, other, family / size) > 1
            pairs += 1
        changed += alarm
    assert pairs == 20_000
    low, high = binom.ppf([1e-4, 1 - 1e-4], 1000, family)
    assert low <= changed <= high


def test_a_change_of_many_errors_is_seen() -> None:
    """By the level of 14 judgements: 7.0 standard errors of one run."""
    level = FALSE_ALARM / 14
    assert moved(statistical(0.0, 1.0, freedom=60), statistical(7.0, 1.0, freedom=60), level) > 1
    assert moved(statistical(0.0, 1.0, freedom=60), statistical(5.0, 1.0, freedom=60), level) < 1


# -- tolerances and bounds ------------------------------------------------------------------------------------


def test_half_of_the_tolerance() -> None:
    assert moved(by_tolerance(0.0), by_tolerance(0.51)) > 1 > moved(by_tolerance(0.0), by_tolerance(0.49))
    assert moved(by_tolerance(-0.3), by_tolerance(0.3), same_seed=False) > 1
    # of two tolerances the larger
    assert moved(by_tolerance(0.0), by_tolerance(0.9, tolerance=2.0)) == pytest.approx(0.9)


def test_a_red_number_of_another_seed_is_of_another_scene() -> None:
    old, twice, thrice = (by_tolerance(x, "fail") for x in (100.0, 190.0, 210.0))
    assert moved(old, twice) == pytest.approx(90 / MOVED)
    assert moved(old, twice, same_seed=False) < 1 < moved(old, thrice, same_seed=False)
    assert moved(by_tolerance(1.1, "fail"), by_tolerance(-1.1, "fail"), same_seed=False) > 1


@pytest.mark.parametrize(
    ("old", "new", "share"),
    [
        (bound(0.1, 1.0), bound(0.9, 1.0), None),
        (bound(2.0, 1.0, "fail"), bound(2.9, 1.0, "fail"), 2.9 / 3),
        (bound(2.0, 1.0, "fail"), bound(3.1, 1.0, "fail"), 3.1 / 3),
        (bound(2.0, 1.0, "fail"), bound(1.1, 1.0, "fail"), 1.1 / 3),
        (bound(0.5, 1.0, "fail", "at_least"), bound(0.3, 1.0, "fail", "at_least"), (1 / 0.3) / 3),
        (bound(0.5, 1.0, "fail", "at_least"), bound(-1.0, 1.0, "fail", "at_least"), math.inf),
        # a limit of 0, as of scenes that are refused
        (bound(1.0, 0.0, "fail"), bound(2.0, 0.0, "fail"), 2 / 1.5),
        (bound(4.0, 0.0, "fail"), bound(5.0, 0.0, "fail"), 5 / 6),
        (bound(-1.0, 1.0, "fail", "at_least"), bound(-9.0, 1.0, "fail", "at_least"), None),
    ],
)
def test_of_bounds_red_ones_alone(old: Number, new: Number, share: float | None) -> None:
    assert WORSE == 1.5
    found = change(old, new, LEVEL, True)
    assert found == (None if share is None else pytest.approx(share))


def test_what_is_not_finite() -> None:
    for one in (statistical, by_tolerance):
        finite, lost = (
            one(0.0, 1.0) if one is statistical else one(0.0),
            one(None, 1.0) if one is statistical else one(None),
        )
        assert change(finite, lost, LEVEL, True) == math.inf
        assert change(lost, finite, LEVEL, True) == math.inf
        assert change(lost, lost, LEVEL, True) is None


def test_numbers_of_other_criteria_cannot_be_compared() -> None:
    assert change(statistical(0.0, 1.0), by_tolerance(9.0), LEVEL, True) is None
    assert change(bound(9.0, 1.0, "fail"), bound(0.1, 1.0, "fail", "at_least"), LEVEL, True) is None
    assert change(by_tolerance(0.0, kind="order"), by_tolerance(9.0, kind="round_off"), LEVEL, True) is None
