"""Uncertainties of correlated data, and fitted slopes.

Literature: H. Flyvbjerg and H. G. Petersen, J. Chem. Phys. 91, 461 (1989) (blocking); U. Wolff, Comput. Phys. Commun.
156, 143 (2004) (automatic windowing of the autocorrelation sum).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Mean(NamedTuple):
    """A mean. value: the mean. error: its standard error. independent: effective number of independent samples."""

    value: float
    error: float
    independent: float


def correlated_mean(series: ArrayLike, window: float = 6.0) -> Mean:
    """Mean of a stationary series and its standard error, sqrt(2 tau var/n).

    tau = 1/2 + sum_k rho(k), summed to the first k >= window * tau (Wolff 2004; N. Madras and A. D. Sokal, J. Stat.
    Phys. 50, 109 (1988)). The variance is corrected for the correlation, var (1 + 2 tau/n). series: (n,), at equal
    distances in time. ValueError for fewer than 4 values or values that are not finite.
    """
    x = np.asarray(series, dtype=np.float64)
    n = x.size
    if n < 4 or not np.isfinite(x).all():
        raise ValueError(f"a mean with an error needs at least 4 finite values, got {n}")
    if x.min() == x.max():  # a constant: rounding of its mean would give a variance that is not 0
        return Mean(float(x[0]), 0.0, float(n))
    centred = x - x.mean()
    variance = float(np.mean(centred**2))
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(centred, size)
    rho = np.fft.irfft(spectrum * spectrum.conj(), size)[:n] / (np.arange(n, 0, -1) * variance)
    tau = 0.5 + np.cumsum(rho[1:])
    lags = np.arange(1, n)
    stop = np.flatnonzero(lags >= window * tau)
    tau_sum = max(0.5, float(tau[stop[0]] if stop.size else tau[n // 2 - 1]))
    error = np.sqrt(2 * tau_sum * variance / n * (1 + 2 * tau_sum / n))
    return Mean(float(x.mean()), float(error), n / (2 * tau_sum))


def standard_error(values: ArrayLike) -> Any:
    """Standard error of the mean over the first axis: s/n^(1/2), s^2 = sum (x - mean)^2/(n - 1).

    values: (n, ...), independent of each other along the first axis.
    """
    x = np.asarray(values, dtype=np.float64)
    return x.std(axis=0, ddof=1) / len(x) ** 0.5


def independent_mean(values: ArrayLike) -> tuple[float, float]:
    """Mean of independent values (n,), and its standard error."""
    return float(np.asarray(values).mean()), float(standard_error(values))


class Slope(NamedTuple):
    """A fitted slope d ln y/d ln x. value: the slope. error: see `fitted_order`. used: number of points used."""

    value: float
    error: float
    used: int


def fitted_order(steps: ArrayLike, errors: ArrayLike, floor: float) -> Slope:
    """Order of convergence: slope of ln(error) against ln(step) in the asymptotic window.

    The window is the three smallest steps whose errors are above the rounding errors: there, terms of higher order are
    smallest. The error of the slope is the largest difference of the slope between neighbouring points from it. steps,
    errors: (n,). floor: errors at or below it are rounding errors, and left out. Where fewer than 3 points remain: NaN
    if an error is not finite, since a run has diverged, else ValueError.
    """
    x, y = np.asarray(steps, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    good = np.isfinite(y) & (y > floor)
    diverged = not np.isfinite(y).all()
    x, y = x[good], y[good]
    if x.size < 3 and diverged:
        return Slope(np.nan, np.inf, x.size)
    if x.size < 3:
        raise ValueError(f"an order needs 3 points above the rounding floor {floor:g}, found {x.size}")
    window = np.argsort(x)[:3]
    lx, ly = np.log(x[window]), np.log(y[window])
    slope = float(np.polyfit(lx, ly, 1)[0])
    local = np.diff(ly) / np.diff(lx)
    return Slope(slope, float(np.abs(local - slope).max()), 3)


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
    sizes: ArrayLike, values: ArrayLike, errors: ArrayLike, laws: Sequence[str] = ("constant", "log N", "sqrt N", "N")
) -> dict[str, Fit]:
    """Fits `values` +- `errors` by each law of growth: constant, or a + b f(N) with f = log N, sqrt N, N, N^2.

    Weighted least squares; BIC = n ln(chi^2/n) + k ln n with k coefficients, for errors that are known up to a common
    factor (G. Schwarz, Ann. Stat. 6, 461 (1978)). sizes: N, (n,). values, errors: (n,), in one unit. laws: names of the
    laws to fit. ValueError for fewer than 4 sizes, or an error that is not positive.
    """
    n, y, u = (np.asarray(column, dtype=np.float64) for column in (sizes, values, errors))
    if n.size < 4 or not (u > 0).all():
        raise ValueError(f"a comparison of laws needs 4 sizes and positive errors, got {n.size} and {u}")
    fits = {}
    for law in laws:
        columns = [np.ones_like(n)] + ([] if law == "constant" else [_LAWS[law](n)])
        design = np.stack(columns, axis=1) / u[:, None]
        # columns of norm 1: the sums of N^2 and of 1 differ by many orders of magnitude
        scale = np.linalg.norm(design, axis=0)
        solution, *_ = np.linalg.lstsq(design / scale, y / u)
        chi2 = float(np.sum((design / scale @ solution - y / u) ** 2))
        bic = n.size * np.log(max(chi2, 1e-300) / n.size) + len(columns) * np.log(n.size)
        fits[law] = Fit(float(bic), tuple(map(float, solution / scale)))
    return fits
