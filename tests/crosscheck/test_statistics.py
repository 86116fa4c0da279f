"""Error bars of correlated series against what repeated series scatter by, and fitted slopes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from benchmark_modules import benchmark_named
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crosscheck.statistics import (
    Mean,
    Trend,
    combined,
    correlated_mean,
    independent_mean,
    mean_of_stretches,
    standard_error,
)


@pytest.fixture(scope="module")
def benchmark_module() -> Any:
    """benchmarks/evidence/false_alarms.py, which has series with known correlations."""
    return benchmark_named("evidence/false_alarms")


def autoregressive(rho: float, count: int, length: int, seed: int) -> np.ndarray:
    """Stationary series x' = rho x + noise of variance 1, shape (count, length)."""
    from scipy.signal import lfilter

    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(count, length)) * (1 - rho**2) ** 0.5
    noise[:, 0] /= (1 - rho**2) ** 0.5
    return lfilter([1.0], [1.0, -rho], noise, axis=1)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_error_bars_cover_the_true_mean(rho: float) -> None:
    """One sigma covers 68.3 % of the time, two 95.4 %; +- 4 standard deviations of a count of 300, and the bias."""
    means = [correlated_mean(series) for series in autoregressive(rho, 300, 4000, seed=1)]
    z = np.array([mean.value / mean.error for mean in means])
    for sigmas, nominal in ((1, 0.683), (2, 0.954)):
        scatter = (nominal * (1 - nominal) / 300) ** 0.5
        assert np.mean(abs(z) < sigmas) == pytest.approx(nominal, abs=4 * scatter)
    # var(mean) = (1 + rho)/(1 - rho)/n
    expected = ((1 + rho) / (1 - rho) / 4000) ** 0.5
    assert np.mean([mean.error for mean in means]) == pytest.approx(expected, rel=0.05)
    assert np.mean([mean.independent for mean in means]) == pytest.approx(4000 * (1 - rho) / (1 + rho), rel=0.1)


def test_white_noise_has_the_textbook_error() -> None:
    x = np.random.default_rng(2).normal(3.0, 2.0, 100_000)
    mean = correlated_mean(x)
    assert mean.value == x.mean()
    errors = [correlated_mean(x[i : i + 500]).error for i in range(0, 100_000, 500)]
    # each of 12 degrees of freedom
    assert np.mean(np.square(errors)) == pytest.approx(4 / 500, rel=4 * (2 / 12 / 200) ** 0.5)
    assert mean.independent == pytest.approx(100_000, rel=0.05)


def test_independent_values_have_the_error_of_the_textbook() -> None:
    assert independent_mean([1.0, 2.0, 6.0]) == pytest.approx((3.0, (7 / 3) ** 0.5), rel=1e-15)
    rows = np.array([[1.0, 5.0], [2.0, 5.0], [6.0, 5.0]])
    np.testing.assert_allclose(standard_error(rows), [(7 / 3) ** 0.5, 0.0], rtol=1e-15)


@pytest.mark.parametrize("value", [0.0, 1.0, 0.1, -1e300, 1e-300])
def test_constant_series_has_no_error(value: float) -> None:
    assert correlated_mean(np.full(1000, value)) == (value, 0.0, 1000.0, 999.0, None)


@given(
    arrays(float, st.integers(4, 60), elements=st.floats(-100, 100).map(lambda x: round(x, 3))),
    st.sampled_from([0.25, 0.5, 2.0, 8.0]),
    st.sampled_from([-64.0, 0.0, 16.0]),
)
def test_error_follows_scale_and_shift(x: np.ndarray, scale: float, shift: float) -> None:
    one, two = correlated_mean(x), correlated_mean(scale * x + shift)
    assert two.value == pytest.approx(scale * one.value + shift, abs=1e-10)
    assert two.error == pytest.approx(scale * one.error, rel=1e-6, abs=1e-10)
    assert 0 < one.independent <= x.size


@pytest.mark.parametrize("x", [[], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0, np.nan], [1.0, 2.0, 3.0, np.inf]])
def test_too_few_or_broken_values_are_refused(x: list[float]) -> None:
    with pytest.raises(ValueError, match="at least 4 finite values"):
        correlated_mean(x)


# -- trends ------------------------------------------------------------------------------------------


@given(slope=st.floats(-10, 10).filter(lambda x: abs(x) > 0.1), level=st.floats(-100, 100), length=st.integers(8, 300))
def test_the_trend_of_a_line_is_its_rise(slope: float, level: float, length: int) -> None:
    trend = correlated_mean(level + slope * np.linspace(0, 1, length)).trend
    assert trend is not None
    assert trend.change == pytest.approx(slope, rel=1e-9)
    assert trend.sigmas > 1e6


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_errors_of_trends_cover_what_stationary_series_rise_by(rho: float) -> None:
    """As for means: the change between the ends of series without a trend, in its own standard errors."""
    trends = [correlated_mean(series).trend for series in autoregressive(rho, 300, 2000, seed=4)]
    z = np.array([trend.sigmas for trend in trends if trend is not None])
    assert z.size == 300
    for sigmas, nominal in ((1, 0.683), (2, 0.954)):
        scatter = (nominal * (1 - nominal) / 300) ** 0.5
        # where rho = 0.9 the error itself is uncertain by a tenth
        assert np.mean(z < sigmas) == pytest.approx(nominal, abs=5 * scatter)


@pytest.mark.parametrize(
    ("name", "length", "most"),
    [
        ("first order, tau = 1.25", 50, 1.5),
        ("first order, tau = 2", 200, 1.5),
        ("first order, tau = 10", 400, 1.5),
        ("first order, rho = -0.5", 400, 1.5),
        ("oscillating, r = 0.97, angle 0.2", 400, 1.5),
        # 20 and 10 independent samples of the slower part
        ("0.8 exp(-t) + 0.2 exp(-t/10)", 400, 1.5),
        ("0.9 exp(-t/2) + 0.1 exp(-t/20)", 400, 1.7),
        ("(1 + t/2)^-3/2", 2000, 1.5),
        ("(1 + t/2)^-3/2", 400, 2.1),
    ],
)
def test_right_codes_are_red_as_rarely_as_stated(benchmark_module: Any, name: str, length: int, most: float) -> None:
    """Rates at 1e-2 and 1e-3 and of drifts at 2e-4, as multiples of these, with the scatter of 400 series."""
    (kind,) = (one for one in benchmark_module.KINDS if (one.name, one.length) == (name, length))
    found = benchmark_module.measure(kind, correlated_mean, 400)
    assert 0.4 < found.red[0] < most
    assert 0.3 < found.red[1] < 1.3 * most
    assert found.drift < 3 * most
    assert 0.9 < found.error < 1.2
    assert found.width < 2


def test_errors_grow_where_correlations_may_have_long_tails_alone(benchmark_module: Any) -> None:
    """White series have no tail, and the error of the textbook; exponentials have up to a tenth more."""
    by_name = {(one.name, one.length): one for one in benchmark_module.KINDS}
    white = benchmark_module.measure(by_name["first order, tau = 0.5", 400], correlated_mean, 400)
    slow = benchmark_module.measure(by_name["first order, tau = 8", 3200], correlated_mean, 400)
    # of 12 degrees of freedom, in 400 series
    scatter = (1 / 24 / 400) ** 0.5
    assert white.error == pytest.approx(1, abs=4 * scatter)
    assert 1 < slow.error < 1.08


def test_rounding_errors_are_no_trend() -> None:
    steps = 1.0 + np.finfo(float).eps * np.arange(50)
    assert correlated_mean(1e6 * steps).trend is None


def test_short_series_have_no_trend() -> None:
    assert correlated_mean([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]).trend is None
    assert correlated_mean([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.5]).trend is not None


def test_stretches_are_independent() -> None:
    x = np.random.default_rng(3).normal(size=16)
    mean = mean_of_stretches(x)
    assert (mean.value, mean.independent, mean.freedom) == (x.mean(), 16, 15)
    assert mean.error >= standard_error(x)
    assert mean.trend is not None
    from scipy.stats import linregress

    line = linregress(np.arange(16), x)
    assert mean.trend.change == pytest.approx(15 * line.slope)
    assert mean.trend.error == pytest.approx(15 * line.stderr)
    assert mean.trend.freedom == 14


def test_a_derived_mean_is_as_certain_as_the_least_certain() -> None:
    still, rising = Trend(1.0, 1.0, 30.0), Trend(-9.0, 1.0, 20.0)
    one, other = Mean(1.0, 0.1, 100.0, 20.0, rising), Mean(2.0, 0.1, 50.0, 25.0, still)
    assert combined(3.0, 0.2, [one, other]) == Mean(3.0, 0.2, 50.0, 20.0, rising)
    assert combined(3.0, 0.2, [one._replace(trend=None)]).trend is None
