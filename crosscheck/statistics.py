"""Uncertainties of correlated data, and fitted slopes.

Literature: U. K. Müller, J. Econometrics 141, 1331 (2007), and E. Lazarus, D. J. Lewis, J. H. Stock and M. W. Watson,
J. Bus. Econ. Stat. 36, 541 (2018) (the error of a mean from the slowest cosines of its series); U. Wolff, Comput. Phys.
Commun. 156, 143 (2004) (autocorrelation times and their bias).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Window of the sum over the autocorrelation function, in autocorrelation times: what is left out is exp(-4) of it.
WINDOW = 4.0
#: How many of the slowest components of a series give the error of its mean and of its trend: a share of the number N
#: of independent samples, so that they are all slow (6 at N = 20); 2 + 0.7 sqrt(N), so that an error of N hardly
#: matters; no more than 12, since correlations that decay slowly are found among the slowest components alone. Chosen
#: by the false-alarm rates of simulated series: see docs/verdicts.md.
_SHARE, _FEWEST, _MOST = 0.3, 6, 12
#: What the mean of the slowest components is raised by for correlations with long tails: see `_fall`.
_CUSP = 0.3
#: The shortest series whose trend is tested.
_SHORTEST_TREND = 8


class Trend(NamedTuple):
    """A straight line through a series. change: from its first value to its last. error: the standard error of that.
    freedom: degrees of freedom of that error, for the quantiles of Student's distribution.
    """

    change: float
    error: float
    freedom: float

    @property
    def sigmas(self) -> float:
        """The change in standard errors."""
        if self.error > 0:
            return abs(self.change) / self.error
        return np.inf if self.change else 0.0


class Mean(NamedTuple):
    """A mean. value: the mean. error: its standard error. independent: effective number of independent samples.
    freedom: degrees of freedom of the error, in the quantiles of Student's distribution. trend: of the series; None: it
    has none, or is too short for one.
    """

    value: float
    error: float
    independent: float
    freedom: float
    trend: Trend | None = None


def correlated_mean(series: ArrayLike) -> Mean:
    """Mean of a stationary series, its standard error, and its trend, which shows a drift.

    The amplitudes of the slowest cosines of a series scatter as its mean does: a_j = sqrt(2/n) sum_t x_t cos(pi j (t +
    1/2)/n), for j small beside the number N of independent samples, is independent of the others, and of variance n
    error^2. So the mean of q such squares gives an error of q degrees of freedom, whatever the correlation; only N,
    which says how many are slow, follows from the autocorrelation time tau. What the spectrum of an exponential
    correlation falls by up to the last of them is made up for, and so is part of what it falls by where the correlation
    has a long tail. series: (n,), at equal distances in time. ValueError for fewer than 4 values or values that are not
    finite.
    """
    from scipy.fft import dct

    x = np.asarray(series, dtype=np.float64)
    n = x.size
    if n < 4 or not np.isfinite(x).all():
        raise ValueError(f"a mean with an error needs at least 4 finite values, got {n}")
    if x.min() == x.max():  # a constant: rounding of its mean would give a variance that is not 0
        return Mean(float(x[0]), 0.0, float(n), n - 1.0)
    centred = x - x.mean()
    independent = n / (2 * _autocorrelation_time(centred, 1))
    number = _slow_components(independent)
    amplitudes = dct(centred, norm="ortho")[1 : number + 1]
    error = np.sqrt(np.mean(amplitudes**2) / n * _fall(number, independent, n))
    if number < _FEWEST:  # of so few, all may be small by chance
        error = max(error, np.sqrt(np.mean(centred**2) / independent))
    return Mean(float(x.mean()), float(error), independent, float(number), _trend(x))


def mean_of_stretches(values: ArrayLike) -> Mean:
    """Mean of values (n,) that are averages over stretches of a run, each much longer than its correlation time.

    They are independent: the error has n - 1 degrees of freedom, that of the trend n - 2. Correlation that is left
    raises the error, by sqrt(2 tau). ValueError as in `correlated_mean`.
    """
    x = np.asarray(values, dtype=np.float64)
    mean = correlated_mean(x)
    error = 0.0
    if mean.error > 0:
        error = float(standard_error(x)) * (2 * _autocorrelation_time(x - x.mean(), 1)) ** 0.5
    trend = None
    if x.size >= _SHORTEST_TREND and mean.trend is not None:
        line = _along(x, 1)
        scatter = float(np.sqrt(np.sum(line.residual**2) / (x.size - 2)))
        trend = Trend(line.change, line.per_unit * scatter, x.size - 2.0)
    return Mean(mean.value, error, float(x.size), x.size - 1.0, trend)


def combined(value: float, error: float, means: Sequence[Mean]) -> Mean:
    """A mean derived from others, with its error, whose certainty is that of the least certain of them.

    value, error: derived from `means`. The trend is the most significant one.
    """
    from scipy.stats import t

    trends = [mean.trend for mean in means if mean.trend is not None]
    return Mean(
        value,
        error,
        min(mean.independent for mean in means),
        min(mean.freedom for mean in means),
        min(trends, key=lambda trend: float(t.sf(trend.sigmas, trend.freedom)), default=None),
    )


def _autocorrelation_time(centred: NDArray[np.float64], fitted: int) -> float:
    """tau of values (n,) from which a polynomial with `fitted` coefficients was taken, not all 0; at least 1/2.

    tau = 1/2 + sum_k rho(k), summed to the first k = W >= 4 tau (N. Madras and A. D. Sokal, J. Stat. Phys. 50, 109
    (1988)). What the fit takes with it makes it too short by the factor 1 - (2 W + 1)/n for each coefficient, to first
    order (Wolff 2004, of the mean).
    """
    n = centred.size
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(centred, size)
    rho = np.fft.irfft(spectrum * spectrum.conj(), size)[:n] / (np.arange(n, 0, -1) * np.mean(centred**2))
    tau = 0.5 + np.cumsum(rho[1:])
    stop = np.flatnonzero(np.arange(1, n) >= WINDOW * tau)
    last = int(stop[0]) if stop.size else n // 2 - 1
    return max(0.5, float(tau[last]) * (1 + fitted * (2 * last + 3) / n))


def _slow_components(independent: float) -> int:
    """How many components of a series are slow beside its correlations. independent: number of independent samples."""
    return max(1, int(min(_SHARE * independent + 1e-9, max(_FEWEST, 2 + 0.7 * independent**0.5), _MOST)))


def _fall(last: int, independent: float, length: int) -> float:
    """By how much the square of an error is too small: the spectrum of a correlation falls from its value at 0.

    last: number of the fastest component, cos(pi last (t + 1/2)/n). independent: number of independent samples N.
    length: number of values n. With x = pi last/2N, that of exponentials is 1/(1 + x^2) there, 1 - x^2/3 in the mean
    over all components up to the last. That of correlations which end as t^-3/2 has a cusp, 1 - (pi x)^1/2/2: 0.6 to
    0.65 x^1/2 in the mean, of which the variance of the mean of n values lacks N^-1/2 itself, for 6 to 12 components
    0.2 to 0.3 x^1/2. What one series is like does not show; so most of the rest is made up for in all of them, as far
    as they are correlated: the share 1/2 tau = N/n of the spectrum at 0 is that of single values, which is flat.
    """
    x = np.pi * last / (2 * independent)
    return float(1 + x**2 / 3 + _CUSP * (1 - independent / length) * x**0.5)


class _Line(NamedTuple):
    """The part of a series along a straight line. change: from first to last value. per_unit: change by a part of norm
    1. residual: what the polynomial leaves.
    """

    change: float
    per_unit: float
    residual: NDArray[np.float64]


def _polynomials(n: int, degree: int) -> NDArray[np.float64]:
    """Polynomials of the degrees 0 to `degree` on n equidistant points, (degree + 1, n), orthonormal (Gram's).

    By their recurrence, p_k+1 ~ x p_k - (x p_k, p_k-1) p_k-1: a factorisation would start threads, which on a busy
    machine wait for each other.
    """
    x = np.linspace(-1, 1, n)
    found = [np.full(n, n**-0.5)]
    for k in range(degree):
        following = x * found[k]
        if k > 0:
            following -= np.sum(following * found[k - 1]) * found[k - 1]
        found.append(following / np.sum(following**2) ** 0.5)
    return np.array(found)


def _along(x: NDArray[np.float64], degree: int) -> _Line:
    """The straight line in a polynomial of this degree that is fitted to x (n,) by least squares."""
    polynomials = _polynomials(x.size, degree)
    # the mean first: what is large and constant must not cost digits
    parts = polynomials @ (x - x.mean())
    per_unit = float(polynomials[1, -1] - polynomials[1, 0])
    return _Line(float(parts[1]) * per_unit, abs(per_unit), x - x.mean() - parts @ polynomials)


def _trend(x: NDArray[np.float64]) -> Trend | None:
    """The linear trend of a correlated series (n,); None where there are fewer than 8 values, or rounding errors alone.

    Its error follows from the parts of the series along the polynomials of the next degrees, which are as slow, as that
    of the mean does from cosines. The parabola is left out: the bend of a slow decay does not count as noise.
    """
    n = x.size
    if n < _SHORTEST_TREND:
        return None
    line = _along(x, 2)
    largest = float(np.abs(x).max())
    if abs(line.change) <= np.finfo(np.float64).eps * n * largest:
        return None
    left = line.residual
    if float(np.sum(left**2)) / (n - 3) <= (np.finfo(np.float64).eps * largest) ** 2:  # the trend, and rounding
        return Trend(line.change, float(np.finfo(np.float64).eps * n * largest), n / 6)
    independent = n / (2 * _autocorrelation_time(left, 3))
    number = min(_slow_components(independent), n - 4)
    parts = _polynomials(n, number + 2)[3:] @ left
    error = line.per_unit * np.sqrt(np.mean(parts**2) * _fall(number + 2, independent, n))
    return Trend(line.change, float(error), float(number))


def standard_error(values: ArrayLike) -> Any:
    """Standard error of the mean over the first axis: s/n^(1/2), s^2 = sum (x - mean)^2/(n - 1).

    values: (n, ...), independent of each other along the first axis.
    """
    x = np.asarray(values, dtype=np.float64)
    return x.std(axis=0, ddof=1) / len(x) ** 0.5


def independent_mean(values: ArrayLike) -> tuple[float, float]:
    """Mean of independent values (n,), and its standard error."""
    return float(np.asarray(values).mean()), float(standard_error(values))


@cache
def student_quantile(level: float, freedom: float) -> float:
    """What Student's t exceeds, to either side, with the probability `level`; freedom: degrees of it, 1 at least."""
    from scipy.stats import t

    return float(t.isf(level / 2, max(freedom, 1.0)))


def student_probability(sigmas: float, freedom: float) -> float:
    """The probability that Student's t is at least `sigmas` to either side; freedom: degrees of it, 1 at least."""
    from scipy.stats import t

    return float(2 * t.sf(sigmas, max(freedom, 1.0)))


@cache
def seen_beyond(quantile: float, freedom: float, probability: float) -> float:
    """The true deviation, in standard errors, that Student's t shows beyond a quantile with a probability.

    From the noncentral distribution: the error is itself uncertain, so that this is more than the quantile and the
    scatter of the mean. quantile: of the measured deviation over its error. freedom: degrees of freedom of that error,
    1 at least. probability: of going beyond.
    """
    from scipy.optimize import brentq
    from scipy.stats import nct

    freedom = max(freedom, 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # series of nct that end early, far from the root
        return float(
            brentq(lambda true: nct.sf(quantile, freedom, true) - probability, 0.0, 4 * quantile + 10, xtol=1e-6)
        )


class Fit(NamedTuple):
    """A fitted law of growth. bic: Bayesian information criterion; the best law has the smallest. coefficients: a and b
    of a + b f(N), or a alone.
    """

    bic: float
    coefficients: tuple[float, ...]


_LAWS: dict[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
    "log N": np.log,
    "sqrt N": np.sqrt,
    "N": lambda n: n,
    "N^2": lambda n: n**2,
}


def model_comparison(
    sizes: ArrayLike,
    values: ArrayLike,
    errors: ArrayLike,
    laws: Sequence[str] = ("constant", "log N", "sqrt N", "N"),
    beside: ArrayLike | None = None,
) -> dict[str, Fit]:
    """Fits `values` +- `errors` by each law of growth: constant, or a + b f(N) with f = log N, sqrt N, N, N^2.

    Weighted least squares; BIC = n ln(chi^2/n) + k ln n with k coefficients, for errors that are known up to a common
    factor (G. Schwarz, Ann. Stat. 6, 461 (1978)). sizes: N, (n,). values, errors: (n,), in one unit. laws: names of the
    laws to fit. beside: (n,), what every law has as a further term, with a coefficient of its own, the last one; None:
    nothing. ValueError for fewer than 4 sizes, or an error that is not positive.
    """
    n, y, u = (np.asarray(column, dtype=np.float64) for column in (sizes, values, errors))
    if n.size < 4 or not (u > 0).all():
        raise ValueError(f"a comparison of laws needs 4 sizes and positive errors, got {n.size} and {u}")
    fits = {}
    for law in laws:
        columns = [np.ones_like(n)] + ([] if law == "constant" else [_LAWS[law](n)])
        columns += [] if beside is None else [np.asarray(beside, dtype=np.float64)]
        design = np.stack(columns, axis=1) / u[:, None]
        # columns of norm 1: the sums of N^2 and of 1 differ by many orders of magnitude
        scale = np.linalg.norm(design, axis=0)
        solution, *_ = np.linalg.lstsq(design / scale, y / u)
        chi2 = float(np.sum((design / scale @ solution - y / u) ** 2))
        bic = n.size * np.log(max(chi2, 1e-300) / n.size) + len(columns) * np.log(n.size)
        fits[law] = Fit(float(bic), tuple(map(float, solution / scale)))
    return fits
