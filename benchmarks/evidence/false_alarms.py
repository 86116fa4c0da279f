"""How often a right code is red: judgements of simulated series whose mean is what is expected, and which do not drift.

    python benchmarks/evidence/false_alarms.py [number of series of each kind]

Normal series with known correlations: autoregressive ones of first order, with positive and negative coefficients, and
of second order, which oscillate; sums of two exponentials; and correlations that decay as t^-3/2, as hydrodynamic ones
do. Of each series the deviations from its own mean are drawn. Given these, the mean is normal, with a mean and a
variance that follow from the correlations; so each series gives the probability of a red judgement, and a few thousand
tell rates of 1e-4. The same for the drift.

Printed, for series of n values with N independent samples: at the rates stated, what was found, as a multiple; the
error over the true one; how much wider the tolerance is than with a known error; the share of inconclusive judgements.
With pymbar installed also what its statistical inefficiency g gives, error^2 = g var/n with n/g - 1 degrees of freedom.
"""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.stats import norm
from scipy.stats import t as student

from crosscheck.statistics import Mean, correlated_mean
from crosscheck.verdict import DRIFTING, LEAST_FREEDOM, SUSPICIOUS

LEVELS = (1e-2, SUSPICIOUS, 1e-4)
#: Series drawn at a time.
BATCH = 500
Correlation = Callable[[np.ndarray], np.ndarray]


def exponential(rho: float) -> Correlation:
    """Autoregressive of first order."""
    return lambda k: rho**k


def first_order(tau: float) -> Correlation:
    """Autoregressive of first order with the autocorrelation time tau = 1/2 + sum_k rho^k."""
    return exponential((2 * tau - 1) / (2 * tau + 1))


def oscillating(radius: float, angle: float) -> Correlation:
    """Autoregressive of second order with the roots radius exp(+- i angle)."""
    shift = np.arctan((1 - radius**2) / (1 + radius**2) / np.tan(angle))
    return lambda k: radius**k * np.cos(angle * k - shift) / np.cos(shift)


def two_exponentials(share: float, fast: float, slow: float) -> Correlation:
    """(1 - share) exp(-t/fast) + share exp(-t/slow)."""
    return lambda k: (1 - share) * np.exp(-k / fast) + share * np.exp(-k / slow)


def power_law(time: float) -> Correlation:
    """(1 + t/time)^-3/2."""
    return lambda k: (1 + k / time) ** -1.5


@dataclass(frozen=True)
class Kind:
    """Series of `length` normal values of variance 1 with a correlation."""

    name: str
    length: int
    correlation: Correlation

    @cached_property
    def amplitudes(self) -> np.ndarray:
        """Of the Fourier components of a period of 2n values, of which n are a series (circulant embedding)."""
        rho = self.correlation(np.arange(self.length + 1))
        return np.sqrt(np.clip(np.fft.rfft(np.concatenate([rho, rho[-2:0:-1]])).real, 0, None))

    @property
    def independent(self) -> float:
        """n/2 tau."""
        return float(self.length / (1 + 2 * self.correlation(np.arange(1, 1_000_000)).sum()))

    @property
    def error(self) -> float:
        """Of the mean, by the correlations."""
        k = np.arange(1, self.length)
        rho = self.correlation(np.arange(self.length))
        return float(((1 + 2 * np.sum((1 - k / self.length) * rho[1:])) / self.length) ** 0.5)

    def draw(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """Series (count, n)."""
        noise = np.fft.rfft(rng.normal(size=(count, 2 * self.length)), axis=1)
        return np.fft.irfft(noise * self.amplitudes, 2 * self.length, axis=1)[:, : self.length]

    def given_the_rest(self, direction: np.ndarray) -> tuple[np.ndarray, float]:
        """Weights w and standard deviation s: the part of a series along `direction` is normal around -w . the rest."""
        inverse = solve_toeplitz(self.correlation(np.arange(self.length)), direction)
        variance = float(1 / (direction @ inverse))
        return inverse * variance, variance**0.5


KINDS = (
    *(
        Kind(f"first order, tau = {tau:g}", n, first_order(tau))
        for n, tau in (
            *((50, 4), (50, 1.25), (50, 0.5)),
            *((100, 2), (200, 8), (200, 4), (200, 2), (400, 10), (400, 1), (400, 0.5)),
            *((800, 8), (800, 2), (3200, 8), (3200, 2), (3200, 0.5), (4000, 20)),
        )
    ),
    *(Kind(f"first order, rho = {rho:g}", n, exponential(rho)) for n, rho in ((50, -0.5), (400, -0.5), (400, -0.9))),
    *(
        Kind(f"oscillating, r = {r:g}, angle {angle:g}", n, oscillating(r, angle))
        for n, r, angle in ((100, 0.8, 1.0), (400, 0.9, 0.5), (400, 0.97, 0.2), (2000, 0.97, 0.2))
    ),
    Kind("0.8 exp(-t) + 0.2 exp(-t/10)", 400, two_exponentials(0.2, 1, 10)),
    Kind("0.8 exp(-t) + 0.2 exp(-t/10)", 2000, two_exponentials(0.2, 1, 10)),
    Kind("0.9 exp(-t/2) + 0.1 exp(-t/20)", 400, two_exponentials(0.1, 2, 20)),
    Kind("0.9 exp(-t/2) + 0.1 exp(-t/40)", 2000, two_exponentials(0.1, 2, 40)),
    *(Kind(f"(1 + t/{a})^-3/2", n, power_law(a)) for n, a in ((400, 1), (400, 2), (2000, 2), (8000, 2), (2000, 10))),
)


def beyond(tolerance: np.ndarray, middle: np.ndarray, scatter: float) -> np.ndarray:
    """The probabilities that normal numbers are further from 0 than the tolerances."""
    return np.asarray(norm.sf((tolerance - middle) / scatter) + norm.sf((tolerance + middle) / scatter))


def quantile(level: float, freedom: np.ndarray) -> np.ndarray:
    """Of Student's distribution, two-sided."""
    return np.asarray(student.isf(level / 2, np.maximum(freedom, 1)))


def by_inefficiency(series: np.ndarray) -> Mean:
    """The mean with the error by pymbar's statistical inefficiency."""
    from pymbar.timeseries import statistical_inefficiency

    g, n = statistical_inefficiency(series), series.size
    return Mean(float(series.mean()), float((g * series.var() / n) ** 0.5), n / g, n / g - 1)


class Found(NamedTuple):
    """red: rates at `LEVELS`, and drift: that of drifts, as multiples of those stated; NaN: there is no test of drifts.
    error: the root of its mean square, over the true one. width: of the tolerance, over that of a known error.
    undecided: share of inconclusive judgements.
    """

    red: np.ndarray
    drift: float
    error: float
    width: float
    undecided: float

    def row(self) -> str:
        """Of the table, without the name."""
        values = (*self.red, self.drift, self.error, self.width, self.undecided)
        return " | ".join("–" if math.isnan(value) else f"{value:.2f}" for value in values)


def measure(kind: Kind, estimate: Callable[[np.ndarray], Mean], count: int) -> Found:
    """What `count` series of a kind tell."""
    rng = np.random.default_rng(2026)
    n = kind.length
    line = np.linspace(-1, 1, n)
    weights, scatter = kind.given_the_rest(np.ones(n))
    along, change_scatter = kind.given_the_rest(line)
    middles, changes, means = [], [], []
    for start in range(0, count, BATCH):
        series = kind.draw(rng, min(BATCH, count - start))
        middles.append(-(series - series.mean(axis=1, keepdims=True)) @ weights)
        changes.append(-(series - np.outer(series @ line / (line @ line), line)) @ along)
        means += [estimate(x) for x in series]
    freedom, error = np.array([(mean.freedom, mean.error) for mean in means]).T
    tolerance = {level: quantile(level, freedom) * error for level in (*LEVELS, SUSPICIOUS)}
    middle = np.concatenate(middles)
    red = [beyond(tolerance[level], middle, scatter).mean() / level for level in LEVELS]
    drift = math.nan
    if all(mean.trend is not None for mean in means):
        certain, risen = np.array([(mean.trend.freedom, mean.trend.error) for mean in means if mean.trend]).T
        limit = quantile(DRIFTING, certain) * risen / 2  # the line rises by 2
        drift = float(beyond(limit, np.concatenate(changes), change_scatter).mean() / DRIFTING)
    width = float(np.median(tolerance[SUSPICIOUS])) / (norm.isf(SUSPICIOUS / 2) * kind.error)
    size = float(np.mean(error**2) ** 0.5 / kind.error)
    return Found(np.array(red), drift, size, width, float(np.mean(freedom < LEAST_FREEDOM)))


def main() -> None:
    """Prints the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 3000
    estimates = {"": correlated_mean}
    if importlib.util.find_spec("pymbar"):
        estimates["pymbar"] = by_inefficiency
    rates = " | ".join(f"{level:g}" for level in LEVELS)
    print(f"| series | n | N | {rates} | drift, {DRIFTING:g} | error | width | inconclusive |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for kind in KINDS:
        for name, estimate in estimates.items():
            label = f"the same, {name} | | " if name else f"{kind.name} | {kind.length} | {kind.independent:.0f}"
            print(f"| {label} | {measure(kind, estimate, count).row()} |", flush=True)


if __name__ == "__main__":
    main()
