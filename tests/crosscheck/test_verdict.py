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
from scipy.stats import binom, chi2, kstest, nct
from scipy.stats import t as student

from crosscheck.errors import UsageError
from crosscheck.figure import Figure, Series
from crosscheck.statistics import Mean, Trend, correlated_mean
from crosscheck.verdict import (
    SEEN,
    SUSPICIOUS,
    Judgement,
    Verdict,
    again,
    bounded,
    by_chance,
    controls,
    findings,
    less_certain,
    order,
    round_off,
    statistical,
    suspicious,
    unrepeated,
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
    # two-sided quantile of the normal distribution for 1e-3
    quantile = 3.290527
    assert judged(quantile - 1e-3).outcome == "pass"
    assert judged(-quantile - 1e-3).outcome == "fail"
    assert judged(quantile + 1e-3).sigmas == pytest.approx(quantile + 1e-3)
    assert judged(2 * quantile).deviation == pytest.approx(2, rel=1e-5)


def test_both_error_bars_count() -> None:
    judgement = statistical("x", 10.0, 3.0, 5.0, 4.0, "why", samples=100)
    assert judgement.sigmas == 1
    assert judgement.deviation == pytest.approx(5 / judgement.criterion.tolerance)
    t = student(99)
    assert judgement.criterion.tolerance == pytest.approx(5 * t.isf(5e-4))
    # of a normal deviate with an error of 99 degrees of freedom, beyond it twice in 90 % of all cases
    seen = nct(99, judgement.sensitivity).sf(t.isf(5e-4))
    assert seen**2 == pytest.approx(0.9, abs=1e-4)
    assert judgement.p_value == pytest.approx(2 * t.sf(1))
    assert (judgement.freedom, judgement.doubt) == (99, 0)


def test_a_doubt_is_added_once() -> None:
    """A systematic bound is no standard error: no quantile multiplies it."""
    plain, doubtful = judged(0.0), judged(0.0, doubt=7.0)
    assert doubtful.criterion.tolerance == plain.criterion.tolerance + 7.0
    assert doubtful.sensitivity == plain.sensitivity + 7.0
    assert judged(8.5, doubt=7.0).p_value == judged(1.5).p_value
    assert judged(6.5, doubt=7.0).p_value == 1
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


def test_suspicions_are_as_rare_as_stated() -> None:
    """1e5 right codes: the number of red ones within the central 99.99 % of the binomial distribution."""
    draws = np.random.default_rng(5).normal(size=100_000)
    # the outcome is that of |z|: only the tail has to be asked
    red = sum(judged(float(z)).outcome == "fail" for z in draws[abs(draws) > 3])
    assert all(judged(z).outcome == "pass" for z in (-3.0, 0.0, 3.0))
    low, high = binom.interval(0.9999, draws.size, SUSPICIOUS)
    assert low <= red <= high


def test_suspicions_with_few_samples() -> None:
    """Means of 12 normal numbers with their own error bars: Student's t, not the normal distribution."""
    draws = np.random.default_rng(6).normal(size=(100_000, 12))
    means, errors = draws.mean(axis=1), draws.std(axis=1, ddof=1) / 12**0.5
    suspicious = np.flatnonzero(abs(means) > 3 * errors)
    red = sum(
        statistical("x", float(means[i]), float(errors[i]), 0.0, 0.0, "why", samples=12).outcome == "fail"
        for i in suspicious
    )
    low, high = binom.interval(0.9999, len(draws), SUSPICIOUS)
    assert low <= red <= high


@pytest.mark.parametrize("samples", [10, 13, 41])
def test_a_deviation_of_the_sensitivity_is_seen_in_nine_of_ten_cases(samples: int) -> None:
    """2000 wrong codes, each measured twice; the true error is 1, that of a verdict is estimated from the samples."""
    off = statistical("x", 0.0, 1.0, 0.0, 0.0, "why", samples=samples).sensitivity
    assert off is not None
    draws = np.random.default_rng(7).normal(off, samples**0.5, size=(2000, 2, samples))
    means, errors = draws.mean(axis=2), draws.std(axis=2, ddof=1) / samples**0.5
    limit = judged(0.0, samples=samples).criterion.tolerance
    seen = (abs(means) > limit * errors).all(axis=1).mean()
    assert seen == pytest.approx(SEEN, abs=4 * (0.9 * 0.1 / 2000) ** 0.5)


@pytest.mark.parametrize("samples", [10, 100])
def test_p_values_are_uniform(samples: int) -> None:
    draws = np.random.default_rng(8).normal(size=(2000, samples))
    means, errors = draws.mean(axis=1), draws.std(axis=1, ddof=1) / samples**0.5
    found = [
        statistical("x", float(m), float(u), 0.0, 0.0, "why", samples=samples).p_value
        for m, u in zip(means, errors, strict=True)
    ]
    assert kstest(found, "uniform").pvalue > 1e-3


def test_a_test_statistic_is_judged_by_its_distribution() -> None:
    law = chi2(7)
    for p_value, outcome in ((0.5, "pass"), (1.01e-3, "pass"), (0.99e-3, "fail"), (0.0, "fail")):
        judgement = by_chance("chi^2 of counts", float(law.isf(p_value)), law, "7 free counts")
        assert judgement.outcome == outcome
        assert judgement.p_value == pytest.approx(p_value)
        assert (judgement.criterion.kind, judgement.criterion.sense) == ("statistical", "at_most")
    assert by_chance("chi^2", float(law.isf(1e-3)), law, "why").sigmas == pytest.approx(3.290527)
    assert by_chance("chi^2", math.nan, law, "why").outcome == "fail"


# -- again ---------------------------------------------------------------------------------------------


def test_what_is_suspicious_twice_is_red() -> None:
    far, near = findings(judged(3.5)), findings(judged(0.5))
    assert suspicious(far)
    assert not suspicious(near)
    assert again(far, findings(judged(-3.6))).outcome == "fail"
    refuted = again(far, near)
    assert refuted.outcome == "pass"
    assert refuted.shown.measured == 0.5
    assert refuted.shown.note == "run again: at first 3.5, 3.5 sigma"


def test_each_judgement_is_red_only_if_both_runs_are() -> None:
    """Of two judgements each of which is red in one of the runs, none is."""
    first, second = worst([judged(3.5), judged(1.0)]), worst([judged(1.5), judged(3.5)])
    found = again(first, second)
    assert [one.measured for one in found.judgements] == [1.5, 1.0]
    assert found.outcome == "pass"
    undecided = worst([judged(0.0, samples=5), judged(0.0)])
    assert again(first, undecided).outcome == "inconclusive"


def test_what_is_not_statistical_must_hold_in_both_runs() -> None:
    good, bad = bounded("b", 1.0, 2.0, "why"), bounded("b", 3.0, 2.0, "why")
    assert not suspicious(worst([judged(3.5), bad]))
    assert suspicious(worst([judged(3.5), good]))
    for pair in ((good, bad), (bad, good)):
        one, two = (worst([judged(value), other]) for value, other in zip((3.5, 0.0), pair, strict=True))
        assert again(one, two).outcome == "fail"


def test_broken_numbers_are_not_measured_again() -> None:
    assert not suspicious(findings(judged(math.nan)))
    assert not suspicious(findings(judged(math.inf)))


@pytest.mark.parametrize(("measured", "outcome"), [(3.5, "inconclusive"), (5.5, "fail")])
def test_the_same_number_twice_is_no_second_measurement(measured: float, outcome: str) -> None:
    """An engine without random numbers: the rate of both runs must be that of the one, 1e-6, at 4.89 sigma."""
    found = again(findings(judged(measured)), findings(judged(measured)))
    assert found.outcome == outcome
    assert "not random" in found.shown.note


def test_two_runs_judge_the_same_quantities() -> None:
    with pytest.raises(ValueError, match="2 judgements, and 1 in the run that repeats it"):
        again(worst([judged(1.0), judged(2.0)]), findings(judged(1.0)))


@pytest.mark.parametrize("measured", [0.0, 1e9])
def test_few_samples_are_no_pass(measured: float) -> None:
    """However few, a deviation beyond the quantile for as many is not believable: 637 for two samples."""
    assert judged(measured, samples=9.9).outcome == ("fail" if measured else "inconclusive")
    assert judged(measured, samples=10).outcome == ("fail" if measured else "pass")
    assert judged(636.0, samples=2).outcome == "inconclusive"
    assert judged(637.0, samples=2).outcome == "fail"


def test_what_could_not_have_been_seen_is_no_pass() -> None:
    assert judged(100.0, 100.0, needed=0.05).outcome == "pass"
    # the tolerance is 3.3, but 4.92 is what is seen
    assert judged(100.0, 100.0, needed=0.0493).outcome == "pass"
    assert judged(100.0, 100.0, needed=0.0492).outcome == "inconclusive"
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
    """Means and drifts: 1.2e-3 stated, 1.9e-3 at most (benchmarks/evidence/false_alarms.py): 9 of 2000 once in 5000."""
    outcomes = Counter(judged_series(x).outcome for x in autoregressive(tau, 2000, length, seed=11))
    assert outcomes["fail"] <= 9
    assert outcomes["pass"] + outcomes["inconclusive"] >= 1991


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
    sure, unsure = Mean(1.0, 0.1, 1000.0, 200.0), Mean(1.0, 0.1, 15.0, 4.0)
    options = {"why": "why", "expected_uncertainty": 0.1}
    for means, outcome in (((sure,), "pass"), ((sure, unsure), "inconclusive"), ((unsure, sure), "inconclusive")):
        assert statistical("x", 1.0, 0.1, 1.0, samples=means, **options).outcome == outcome
    drifting = sure._replace(trend=Trend(5.0, 0.1, 30.0))
    judgement = statistical("x", 1.0, 0.1, 1.0, samples=(sure, drifting), **options)
    assert judgement.outcome == "fail"
    assert judgement.note == (
        "drifts: by 5 from the first to the last value of the series, 50 standard errors, red beyond 4.23; "
        "a mean of it has no meaning"
    )


def test_errors_of_two_series_have_the_freedom_of_both() -> None:
    one, other = Mean(1.0, 0.3, 100.0, 10.0), Mean(1.2, 0.4, 100.0, 12.0)

    def freedom(measured: float, expected: float, *means: Mean) -> float | None:
        return statistical("x", 1.0, measured, 1.2, expected, "why", samples=means).freedom

    assert freedom(0.3, 0.4, one, other) == pytest.approx(0.25**2 / (0.3**4 / 10 + 0.4**4 / 12))  # Welch
    assert freedom(0.3, 0.4, one) == pytest.approx(0.25**2 / (0.3**4 / 10))  # that of what is expected is known
    assert freedom(0.3, 0.0, one) == pytest.approx(10)
    assert freedom(0.2, 0.4, one) == 10  # derived from the mean, not its own
    assert freedom(0.3, 0.4, one, other, one) == 10
    few = Mean(1.0, 0.01, 15.0, 4.0)
    assert statistical("x", 1.0, 0.01, 1.2, 0.4, "why", samples=few).outcome == "inconclusive"


def test_suspicions_of_two_series_are_as_rare_as_stated() -> None:
    """Errors of 6 and 12 degrees of freedom, unlike: the rate within a third."""
    rng = np.random.default_rng(12)
    off = rng.normal(size=200_000) * 0.5
    errors = [scale * (rng.chisquare(nu, 200_000) / nu) ** 0.5 for scale, nu in ((0.3, 6), (0.4, 12))]
    u = np.hypot(*errors)
    freedom = u**4 / (errors[0] ** 4 / 6 + errors[1] ** 4 / 12)
    rate = np.mean(abs(off) > student.isf(SUSPICIOUS / 2, freedom) * u)
    assert rate == pytest.approx(SUSPICIOUS, rel=1 / 3)


# -- several ------------------------------------------------------------------------------------------


def test_a_broken_number_is_the_worst() -> None:
    good, broken = (round_off("x", error, 1.0, "why") for error in (0.9, math.nan))
    for pair in ([good, broken], [broken, good]):
        assert worst(pair, "").outcome == "fail"


def test_all_judgements_are_kept_in_their_order_and_the_worst_is_shown() -> None:
    parts = [
        round_off("a", 0.5, 1.0, "why"),
        judged(2.5),  # 0.76 of its tolerance
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


def test_what_was_not_measured_again_is_undecided() -> None:
    found = unrepeated(worst([judged(5.0), judged(1.0), round_off("y", 0.0, 1.0, "why")]))
    assert [one.outcome for one in found.judgements] == ["inconclusive", "pass", "pass"]
    assert found.judgements[0].note == "suspicious, and not run again: the time was over"
    assert found.outcome == "inconclusive"


@given(st.floats(0.01, 1.0), st.floats(0.01, 1.0))
def test_green_needs_the_sensitivity_that_is_asked_for(first: float, second: float) -> None:
    good = [replace(judged(0.0, 1.0), quantity=name, sensitivity=sees) for name, sees in (("x", first), ("y", second))]
    for needed, limits in (
        (0.5, (0.5, 0.5)),
        ({"x": 0.5}, (0.5, math.inf)),
        ({"*": 0.3}, (0.3, 0.3)),
        ({"[x]": 0.7, "*": 0.9}, (0.7, 0.9)),
    ):
        found = less_certain(worst(good), needed)  # type: ignore[arg-type]
        expected = [
            "pass" if sees <= limit else "inconclusive" for sees, limit in zip((first, second), limits, strict=True)
        ]
        assert [one.outcome for one in found.judgements] == expected


def test_what_has_no_sensitivity_or_is_red_stays() -> None:
    bound, red = bounded("steps", 1.0, 2.0, "why"), replace(judged(9.0), quantity="x")
    chance = by_chance("distance", 0.1, chi2(3), "why")
    blind = replace(judged(0.0), quantity="y", sensitivity=None)
    found = less_certain(worst([bound, red, chance, blind]), 1e-9)
    assert [one.outcome for one in found.judgements] == ["pass", "fail", "pass", "inconclusive"]
    assert less_certain(worst([bound, chance]), 1e-9).outcome == "pass", "nothing that is needed"
    for name in ("steps", "distance", "z"):
        with pytest.raises(UsageError, match=f"no quantity with a sensitivity is called '{name}'; there are: x; y"):
            less_certain(worst([bound, red, chance, blind]), {name: 0.1})


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


# -- once ----------------------------------------------------------------------------------------------


def test_what_cannot_be_measured_again_has_a_level_of_its_own() -> None:
    """The quantile is that of the level, there is no second run, and what is seen is seen at once."""
    one = judged(4.0, once=1e-5)
    quantile = student.isf(0.5e-5, 1e6 - 1)
    assert one.outcome == "pass"
    assert one.criterion.tolerance == pytest.approx(quantile)
    assert one.false_alarm == 1e-5
    assert "twice" not in one.criterion.why
    assert nct.sf(quantile, 1e6 - 1, one.sensitivity) == pytest.approx(SEEN, abs=1e-5)
    assert judged(4.5, once=1e-5).outcome == "fail"
    assert judged(4.0).outcome == "fail"


def test_mean_and_drift_share_the_level() -> None:
    trend = Trend(4.9, 1.0, 1e6)
    mean = Mean(0.0, 1.0, 1e6, 1e6, trend)
    share = 1e-5 / 6  # of the drift: 2e-4 of 1.2e-3
    one = statistical("x", 0.0, 1.0, 0.0, 0.0, "why", samples=mean, once=1e-5)
    assert one.criterion.tolerance == pytest.approx(student.isf((1e-5 - share) / 2, 1e6))
    assert (one.outcome, one.false_alarm) == ("fail", 1e-5)
    assert student.isf(share / 2, 1e6) < trend.change
    assert statistical("x", 0.0, 1.0, 0.0, 0.0, "why", samples=mean, once=1e-6).outcome == "pass"


def test_a_test_statistic_that_cannot_be_measured_again() -> None:
    law = chi2(5)
    limit = law.isf(1e-4)
    assert by_chance("x", limit * 1.001, law, "why", once=1e-4).outcome == "fail"
    one = by_chance("x", limit * 0.999, law, "why", once=1e-4)
    assert (one.outcome, one.false_alarm) == ("pass", 1e-4)
    assert "twice" not in one.criterion.why
