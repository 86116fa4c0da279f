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
    """value +- error, from `independent` effectively independent samples."""

    value: float
    error: float
    independent: float


def correlated_mean(series: ArrayLike, window: float = 6.0) -> Mean:
    """Mean of a stationary series and its standard error, sqrt(2 tau var/n).

    tau = 1/2 + sum_k rho(k), summed to the first k >= window * tau (Wolff; Madras and Sokal). The variance is corrected
    for the correlation, var (1 + 2 tau/n). ValueError for fewer than 4 values or values that are not finite.
    """
    x = np.asarray(series, dtype=np.float64)
    n = x.size
    if n < 4 or not np.isfinite(x).all():
        raise ValueError(f"a mean with an error needs at least 4 finite values, got {n}")
    if x.min() == x.max():  # exactly: the mean, and with it the variance, may be rounded
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
    """Of the mean over the first axis, of n independent values: s/n^(1/2), s^2 = sum (x - mean)^2/(n - 1)."""
    x = np.asarray(values, dtype=np.float64)
    return x.std(axis=0, ddof=1) / len(x) ** 0.5


def independent_mean(values: ArrayLike) -> tuple[float, float]:
    """Mean of independent values, and its standard error."""
    return float(np.asarray(values).mean()), float(standard_error(values))


class Slope(NamedTuple):
    """Fitted d ln y/d ln x, its standard error from the scatter of the local slopes, and the points used."""

    value: float
    error: float
    used: int


def fitted_order(steps: ArrayLike, errors: ArrayLike, floor: float) -> Slope:
    """Order of convergence: slope of ln(error) against ln(step) in the asymptotic window.

    Points at or below `floor` (rounding) are left out. The window is the three smallest remaining steps: the fit
    there is straightest. The error is the largest departure of a local slope from the fit. Where fewer than 3 points
    remain: no number if some have diverged, else ValueError.
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
    """Bayesian information criterion (smaller is better) and coefficients of a + b f(N), or a alone."""

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
    factor (Schwarz, Ann. Stat. 6, 461 (1978)). ValueError for fewer than 4 sizes, or an error that is not positive.
    """
    n, y, u = (np.asarray(column, dtype=np.float64) for column in (sizes, values, errors))
    if n.size < 4 or not (u > 0).all():
        raise ValueError(f"a comparison of laws needs 4 sizes and positive errors, got {n.size} and {u}")
    fits = {}
    for law in laws:
        columns = [np.ones_like(n)] + ([] if law == "constant" else [_LAWS[law](n)])
        design = np.stack(columns, axis=1) / u[:, None]
        # columns of one size: sums of N^2 and of 1 differ by many orders
        scale = np.linalg.norm(design, axis=0)
        solution, *_ = np.linalg.lstsq(design / scale, y / u)
        chi2 = float(np.sum((design / scale @ solution - y / u) ** 2))
        bic = n.size * np.log(max(chi2, 1e-300) / n.size) + len(columns) * np.log(n.size)
        fits[law] = Fit(float(bic), tuple(map(float, solution / scale)))
    return fits
