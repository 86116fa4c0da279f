"""Each criterion at, just inside and just outside its tolerance; what cannot be judged is never a pass."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from scipy.stats import binom

from crosscheck.figure import Figure, Series
from crosscheck.statistics import Mean, Trend, correlated_mean
from crosscheck.verdict import (
    FALSE_ALARM,
    Judgement,
    Verdict,
    bounded,
    controls,
    findings,
    order,
    round_off,
    statistical,
    within,
    worst,
)

finite = st.floats(-1e6, 1e6)


def judged(measured: float, expected: float = 0.0, samples: float = 1e6, **more: Any) -> Judgement:
    """A statistical judgement with an error bar of 1."""
    return statistical("x", measured, 1.0, expected, 0.0, "why", samples=samples, **more)


# -- within --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("measured", "outcome"),
    [
        (2.5, "pass"),
        (1.5, "pass"),
        (np.nextafter(2.5, 3), "fail"),
        (np.nextafter(1.5, 1), "fail"),
        (np.nextafter(2.5, 2), "pass"),
        (math.nan, "fail"),
        (math.inf, "fail"),
        (-math.inf, "fail"),
    ],
)
def test_within(measured: float, outcome: str) -> None:
    judgement = order("slope", measured, 2.0, 0.5, "why")
    assert judgement.outcome == outcome
    assert judgement.criterion.kind == "order"
    assert (judgement.deviation > 1) == (outcome == "fail")


@given(measured=finite, expected=finite, tolerance=st.floats(1e-6, 1e6))
def test_red_is_a_deviation_above_one(measured: float, expected: float, tolerance: float) -> None:
    judgement = within("round_off", "x", measured, expected, tolerance, "why")
    assert (judgement.outcome == "fail") == (judgement.deviation > 1)
    relative = tolerance / abs(expected) if expected else tolerance
    assert judgement.sensitivity == relative


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan])
def test_a_tolerance_is_positive(tolerance: float) -> None:
    with pytest.raises(ValueError, match="tolerance of 'x' must be positive"):
        round_off("x", 0.0, tolerance, "why")


# -- bounds --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "measured", "outcome"),
    [
        ({}, 2.0, "pass"),
        ({}, np.nextafter(2.0, 3), "fail"),
        ({}, -5.0, "pass"),
        ({}, math.nan, "fail"),
        ({"at_least": True}, 2.0, "pass"),
        ({"at_least": True}, np.nextafter(2.0, 1), "fail"),
        ({"at_least": True}, 0.0, "fail"),
        ({"at_least": True}, -5.0, "fail"),
        ({"at_least": True}, math.nan, "fail"),
        ({"expected_failure": True}, 3.0, "pass"),
        ({"expected_failure": True}, 1.0, "fail"),
        ({"expected_failure": True}, math.nan, "fail"),
        ({"expected_failure": True}, math.inf, "pass"),
    ],
)
def test_bounded(options: dict[str, bool], measured: float, outcome: str) -> None:
    judgement = bounded("x", measured, 2.0, "why", **options)
    assert judgement.outcome == outcome
    assert judgement.criterion.kind == ("expected_failure" if "expected_failure" in options else "bound")
    assert (judgement.deviation > 1) == (outcome == "fail")


@given(measured=finite, limit=finite, at_least=st.booleans())
def test_red_bounds_deviate_by_more_than_one(measured: float, limit: float, at_least: bool) -> None:
    judgement = bounded("x", measured, limit, "why", at_least=at_least)
    assert judgement.criterion.sense == ("at_least" if at_least else "at_most")
    # a change of the measured value by more than this would have turned the verdict
    distance = abs(limit - measured)
    assert judgement.sensitivity == (distance / abs(limit) if limit else distance)
    assert judgement.outcome == ("pass" if (measured >= limit if at_least else measured <= limit) else "fail")
    if judgement.outcome == "fail":
        assert judgement.deviation >= 1
    else:
        assert judgement.deviation <= 1


# -- statistics ----------------------------------------------------------------------------------------


def test_statistical_at_the_quantile() -> None:
    # two-sided quantile of the normal distribution for 1e-4
    quantile = 3.890592
    assert judged(quantile - 1e-3).outcome == "pass"
    assert judged(-quantile - 1e-3).outcome == "fail"
    assert judged(quantile + 1e-3).sigmas == pytest.approx(quantile + 1e-3)
    assert judged(2 * quantile).deviation == pytest.approx(2, rel=1e-5)


def test_both_error_bars_count() -> None:
    judgement = statistical("x", 10.0, 3.0, 5.0, 4.0, "why", samples=100)
    assert judgement.sigmas == 1
    assert judgement.deviation == pytest.approx(5 / judgement.criterion.tolerance)
    assert judgement.sensitivity == pytest.approx(judgement.criterion.tolerance / 5)


def test_a_doubt_is_added_once() -> None:
    """A systematic bound is no standard error: no quantile multiplies it."""
    plain, doubtful = judged(0.0), judged(0.0, doubt=7.0)
    assert doubtful.criterion.tolerance == plain.criterion.tolerance + 7.0
    edge = doubtful.criterion.tolerance
    assert judged(edge - 1e-9, doubt=7.0).outcome == "pass"
    assert judged(edge + 1e-9, doubt=7.0).outcome == "fail"
    assert judged(2 * edge, doubt=7.0).deviation == pytest.approx(2)
    assert "and the doubt 7" in doubtful.criterion.why


def test_what_has_no_scatter_may_still_be_doubted() -> None:
    for measured, outcome in ((2.5, "pass"), (2.5001, "fail"), (math.nan, "fail")):
        assert statistical("x", measured, 0.0, 2.0, 0.0, "why", samples=100, doubt=0.5).outcome == outcome


@pytest.mark.parametrize("doubt", [-1.0, math.nan, math.inf])
def test_a_doubt_is_a_bound(doubt: float) -> None:
    with pytest.raises(ValueError, match="doubt of 'x' must be a number that is not negative"):
        judged(0.0, doubt=doubt)


def test_false_alarms_are_as_rare_as_stated() -> None:
    """1e5 right codes: the number of red ones within the central 99.99 % of the binomial distribution."""
    draws = np.random.default_rng(5).normal(size=100_000)
    # the outcome is that of |z|: only the tail has to be asked
    red = sum(judged(float(z)).outcome == "fail" for z in draws[abs(draws) > 3])
    assert all(judged(z).outcome == "pass" for z in (-3.0, 0.0, 3.0))
    low, high = binom.interval(0.9999, draws.size, FALSE_ALARM)
    assert low <= red <= high


def test_false_alarms_with_few_samples() -> None:
    """Means of 12 normal numbers with their own error bars: Student's t, not the normal distribution."""
    draws = np.random.default_rng(6).normal(size=(100_000, 12))
    means, errors = draws.mean(axis=1), draws.std(axis=1, ddof=1) / 12**0.5
    suspicious = np.flatnonzero(abs(means) > 3 * errors)
    red = sum(
        statistical("x", float(means[i]), float(errors[i]), 0.0, 0.0, "why", samples=12).outcome == "fail"
        for i in suspicious
    )
    low, high = binom.interval(0.9999, len(draws), FALSE_ALARM)
    assert low <= red <= high


@pytest.mark.parametrize("measured", [0.0, 1e9])
def test_few_samples_are_no_pass(measured: float) -> None:
    """However few, a deviation beyond the quantile for as many is not believable: 6366 for two samples."""
    assert judged(measured, samples=9.9).outcome == ("fail" if measured else "inconclusive")
    assert judged(measured, samples=10).outcome == ("fail" if measured else "pass")
    assert judged(6366.0, samples=2).outcome == "inconclusive"
    assert judged(6367.0, samples=2).outcome == "fail"


def test_what_could_not_have_been_seen_is_no_pass() -> None:
    assert judged(100.0, 100.0, needed=0.05).outcome == "pass"
    assert judged(100.0, 100.0, needed=0.03).outcome == "inconclusive"
    assert judged(200.0, 100.0, needed=0.03).outcome == "fail"


@pytest.mark.parametrize("samples", [2, 100])
@pytest.mark.parametrize(
    ("measured", "uncertainty"), [(math.nan, 1.0), (1.0, math.nan), (math.inf, 1.0), (1.0, math.inf), (1.0, 0.0)]
)
def test_numbers_that_are_broken_fail(measured: float, uncertainty: float, samples: int) -> None:
    judgement = statistical("x", measured, uncertainty, 2.0, 0.0, "why", samples=samples)
    if uncertainty == 0 and samples < 10:
        assert judgement.outcome == "inconclusive"
    else:
        assert judgement.outcome == "fail"


def test_an_exact_value_without_error_passes() -> None:
    assert statistical("x", 2.0, 0.0, 2.0, 0.0, "why", samples=100).outcome == "pass"


# -- means of series ----------------------------------------------------------------------------------


def autoregressive(tau: float, count: int, length: int, seed: int) -> np.ndarray:
    """Stationary series of variance 1, mean 0 and integrated autocorrelation time tau, shape (count, length)."""
    rho = (2 * tau - 1) / (2 * tau + 1)
    noise = np.random.default_rng(seed).normal(size=(count, length))
    noise[:, 1:] *= (1 - rho**2) ** 0.5
    return lfilter([1.0], [1.0, -rho], noise, axis=1)


def judged_series(series: np.ndarray, expected: float = 0.0) -> Judgement:
    mean = correlated_mean(series)
    return statistical("x", mean.value, mean.error, expected, 0.0, "why", samples=mean)


@pytest.mark.parametrize(("length", "tau"), [(50, 0.5), (50, 1.2), (400, 0.5), (400, 4.0), (400, 10.0)])
def test_false_alarms_of_correlated_series(length: int, tau: float) -> None:
    """Of means and drifts, at most 2e-4 each (benchmarks/false_alarms.py): more than two of 2000 once in a hundred."""
    outcomes = Counter(judged_series(x).outcome for x in autoregressive(tau, 2000, length, seed=11))
    assert outcomes["fail"] <= 2
    assert outcomes["pass"] + outcomes["inconclusive"] >= 1998


SHAPES = {
    "line": lambda t: t,
    "decay": lambda t: (1 - np.exp(-t)) / (1 - np.exp(-1)),
}


@pytest.mark.parametrize("shape", SHAPES)
@given(
    tau=st.floats(0.5, 3), length=st.integers(300, 500), sign=st.sampled_from([-1.0, 1.0]), seed=st.integers(0, 2**32)
)
@settings(max_examples=20)
def test_a_series_that_drifts_is_red_and_says_so(shape: str, tau: float, length: int, sign: float, seed: int) -> None:
    """Whatever its mean: that is what is expected here. The drift is by ten standard deviations of a value."""
    t = np.linspace(0, 1, length)
    series = autoregressive(tau, 1, length, seed)[0] + 10 * sign * SHAPES[shape](t)
    judgement = judged_series(series, float(series.mean()))
    assert judgement.outcome == "fail"
    assert judgement.deviation is not None
    assert judgement.deviation > 1
    assert judgement.note.startswith(f"drifts: by {'-' if sign < 0 else ''}")


def test_a_slow_series_far_off_is_red_however_few_its_samples() -> None:
    """Half a wave, which is no trend: few independent samples, which decide nothing unless they are far away."""
    series = np.cos(2 * np.pi * np.linspace(0, 1, 400))
    mean = correlated_mean(series)
    assert mean.independent < 10
    assert judged_series(series, mean.value + 11 * float(series.std())).outcome == "inconclusive"
    assert judged_series(series, mean.value + 14 * float(series.std())).outcome == "fail"


def test_a_jump_is_never_green() -> None:
    """Half of the series elsewhere: as long a correlation as the series."""
    series = autoregressive(0.5, 1, 400, seed=5)[0] + 10.0 * (np.arange(400) > 200)
    assert judged_series(series, float(series.mean())).outcome != "pass"


def test_the_least_certain_of_several_series_counts() -> None:
    sure, unsure = Mean(1.0, 0.1, 1000.0, 200.0), Mean(1.0, 0.1, 15.0, 3.0)
    options = {"why": "why", "expected_uncertainty": 0.1}
    for means, outcome in (((sure,), "pass"), ((sure, unsure), "inconclusive"), ((unsure, sure), "inconclusive")):
        assert statistical("x", 1.0, 0.1, 1.0, samples=means, **options).outcome == outcome
    drifting = sure._replace(trend=Trend(5.0, 0.1, 30.0))
    judgement = statistical("x", 1.0, 0.1, 1.0, samples=(sure, drifting), **options)
    assert judgement.outcome == "fail"
    assert judgement.note == (
        "drifts: by 5 from the first to the last value of the series, 50 standard errors, red beyond 4.48; "
        "a mean of it has no meaning"
    )


# -- several ------------------------------------------------------------------------------------------


def test_a_broken_number_is_the_worst() -> None:
    good, broken = (round_off("x", error, 1.0, "why") for error in (0.9, math.nan))
    for pair in ([good, broken], [broken, good]):
        assert worst(pair, "").outcome == "fail"


def test_all_judgements_are_kept_in_their_order_and_the_worst_is_shown() -> None:
    parts = [
        round_off("a", 0.5, 1.0, "why"),
        judged(3.0),  # 0.77 of its tolerance
        bounded("c", 0.9, 1.0, "why"),
        order("d", 2.0, 2.0, 0.25, "why"),
    ]
    for few in (parts, parts[::-1]):
        found = worst(few, "a note")
        assert [one.quantity for one in found.judgements] == [one.quantity for one in few]
        assert found.shown.quantity == "c"
        assert found.note == "a note"
        assert found.outcome == "pass"


def test_red_goes_before_undecided_before_green() -> None:
    red, undecided, green = order("v", 1.7, 2, 0.25, ""), judged(0.5, samples=5), round_off("x", 0.99, 1.0, "why")
    assert worst([green, undecided]).shown.outcome == "inconclusive"
    assert worst([green, undecided, red]).shown.quantity == "v"


def test_a_control_is_shown_only_if_it_is_not_green() -> None:
    sharp, control = round_off("x", 0.01, 1.0, "why"), bounded("there is something", 1.1, 1.0, "w", at_least=True)
    assert worst([replace(control, control=True), sharp]).shown.quantity == "x"
    assert worst([controls(control), sharp]).shown.quantity == "x"
    broken = bounded("there is something", 0.9, 1.0, "why", at_least=True, control=True)
    assert worst([sharp, broken]).shown.quantity == "there is something"
    assert worst([broken]).outcome == "fail"


def test_findings_are_flattened_with_their_notes_and_figures() -> None:
    figure = Figure("t", "x", "y")
    one = round_off("a", 0.1, 1.0, "why", note="of a", figures=(figure,))
    inner = worst([one, round_off("b", 0.2, 1.0, "why")], "of both")
    found = worst([inner, round_off("c", 0.3, 1.0, "why", note="of c")], "of all")
    assert [judgement.quantity for judgement in found.judgements] == ["a", "b", "c"]
    assert [judgement.note for judgement in found.judgements] == ["of a", "", "of c"]
    assert found.note == "of both; of all"
    assert found.figures == (figure,)


def test_one_judgement_gives_its_note_and_figures_to_the_verdict() -> None:
    figure = Figure("t", "x", "y")
    found = findings(round_off("a", 0.1, 1.0, "why", note="a note", figures=(figure,)))
    assert (found.note, found.figures) == ("a note", (figure,))
    assert found.judgements[0].note == ""


# -- the record ----------------------------------------------------------------------------------------


@given(value=st.sampled_from([math.nan, math.inf, -math.inf, 1.5, np.float64(2), np.int64(3), np.bool_(True)]))
def test_record_is_strict_json(value: Any) -> None:
    curve = Series("a", [1.0, value], np.array([2.0, math.nan]))
    judgement = round_off("x", value, 1.0, "why", uncertainty=value, figures=(Figure("t", "x", "y", series=(curve,)),))
    found = findings(judgement)
    record = Verdict("a/b", "c", "refimpl", judgement.outcome, found, "", {"seconds": value}).as_record()
    again = json.loads(json.dumps(record, allow_nan=False))
    assert again["judgements"][again["worst"]]["measured"] == (float(value) if math.isfinite(value) else None)
    assert again["figures"][0]["series"][0]["y"] == [2.0, None]


def test_a_verdict_without_findings_has_all_keys() -> None:
    found = findings(round_off("x", 0.0, 1.0, "why"))
    with_some = Verdict("a/b", "c", "refimpl", "pass", found, "").as_record()
    without = Verdict("a/b", "c", "refimpl", "error", None, "it broke").as_record()
    assert with_some.keys() == without.keys()
    assert (without["judgements"], without["worst"]) == ([], None)
    assert without["outcome"] == "error"
    assert with_some["outcome"] == "pass"
