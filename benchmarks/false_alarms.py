"""How often a right code is red: judgements of simulated series whose mean is what is expected, and which do not drift.

    python benchmarks/false_alarms.py [number of series of each kind]

Normal series with known correlations: autoregressive ones of first order, with positive and negative coefficients, and
of second order, which oscillate; sums of two exponentials; and correlations that decay as t^-3/2, as hydrodynamic ones
do. Of each series the deviations from its own mean are drawn. Given these, the mean is normal, with a mean and a
variance that follow from the correlations; so each series gives the probability of a red judgement, and a few thousand
tell rates of 1e-4. The same for the drift.

Printed, for series of n values with N independent samples: at the rates stated, what was found, as a multiple; how much
wider the tolerance is than with a known error; the share of inconclusive judgements. With pymbar installed also what
its statistical inefficiency g gives, error^2 = g var/n with n/g - 1 degrees of freedom.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.stats import norm

from crosscheck.statistics import Mean, correlated_mean, student_quantile
from crosscheck.verdict import DRIFTING, LEAST_FREEDOM, SUSPICIOUS

LEVELS = (1e-2, SUSPICIOUS, 1e-4)
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

    def draw(self, rng: np.random.Generator) -> np.ndarray:
        """A series (n,)."""
        noise = np.fft.rfft(rng.normal(size=2 * self.length))
        return np.fft.irfft(noise * self.amplitudes, 2 * self.length)[: self.length]

    def given_the_rest(self, direction: np.ndarray) -> tuple[np.ndarray, float]:
        """Weights w and standard deviation s: the part of a series along `direction` is normal around -w . the rest."""
        inverse = solve_toeplitz(self.correlation(np.arange(self.length)), direction)
        variance = float(1 / (direction @ inverse))
        return inverse * variance, variance**0.5


KINDS = (
    *(
        Kind(f"first order, tau = {tau:g}", n, first_order(tau))
        for n, tau in ((50, 4), (50, 1.25), (50, 0.5), (200, 2), (400, 10), (400, 1), (400, 0.5), (4000, 20))
    ),
    *(Kind(f"first order, rho = {rho:g}", n, exponential(rho)) for n, rho in ((50, -0.5), (400, -0.5), (400, -0.9))),
    *(
        Kind(f"oscillating, r = {r:g}, angle {angle:g}", n, oscillating(r, angle))
        for n, r, angle in ((100, 0.8, 1.0), (400, 0.9, 0.5), (400, 0.97, 0.2), (2000, 0.97, 0.2))
    ),
    Kind("0.8 exp(-t) + 0.2 exp(-t/10)", 400, two_exponentials(0.2, 1, 10)),
    Kind("0.9 exp(-t/2) + 0.1 exp(-t/20)", 400, two_exponentials(0.1, 2, 20)),
    Kind("0.9 exp(-t/2) + 0.1 exp(-t/40)", 2000, two_exponentials(0.1, 2, 40)),
    *(Kind(f"(1 + t/{a})^-3/2", n, power_law(a)) for n, a in ((400, 1), (400, 2), (2000, 2), (2000, 10))),
)


def beyond(tolerance: float, middle: float, scatter: float) -> float:
    """The probability that a normal number is further from 0 than the tolerance."""
    return float(norm.sf((tolerance - middle) / scatter) + norm.sf((tolerance + middle) / scatter))


def by_inefficiency(series: np.ndarray) -> Mean:
    """The mean with the error by pymbar's statistical inefficiency."""
    from pymbar.timeseries import statistical_inefficiency

    g, n = statistical_inefficiency(series), series.size
    return Mean(float(series.mean()), float((g * series.var() / n) ** 0.5), n / g, n / g - 1)


def measure(kind: Kind, estimate: Callable[[np.ndarray], Mean], count: int) -> str:
    """A row of the table, without the name."""
    rng = np.random.default_rng(2026)
    n = kind.length
    ones, line = np.ones(n) / n, np.linspace(-1, 1, n)
    weights, scatter = kind.given_the_rest(np.ones(n))
    along, change_scatter = kind.given_the_rest(line)
    red, drift, widths, undecided = np.zeros(len(LEVELS)), 0.0, [], 0
    for _ in range(count):
        x = kind.draw(rng)
        mean = estimate(x)
        middle = -float(weights @ (x - x @ ones))
        red += [beyond(student_quantile(level, mean.freedom) * mean.error, middle, scatter) for level in LEVELS]
        widths.append(student_quantile(SUSPICIOUS, mean.freedom) * mean.error)
        undecided += mean.freedom < LEAST_FREEDOM
        if mean.trend is not None:
            rest = x - (x @ line) / (line @ line) * line
            limit = student_quantile(DRIFTING, mean.trend.freedom) * mean.trend.error / 2  # the line rises by 2
            drift += beyond(limit, -float(along @ rest), change_scatter)
    width = float(np.median(widths)) / (norm.isf(SUSPICIOUS / 2) * kind.error)
    rates = [f"{rate / count / level:.2f}" for rate, level in zip(red, LEVELS, strict=True)]
    return " | ".join([*rates, f"{drift / count / DRIFTING:.2f}", f"{width:.2f}", f"{undecided / count:.2f}"])


def main() -> None:
    """Prints the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 3000
    estimates = {"": correlated_mean}
    if importlib.util.find_spec("pymbar"):
        estimates["pymbar"] = by_inefficiency
    rates = " | ".join(f"{level:g}" for level in LEVELS)
    print(f"| series | n | N | {rates} | drift, {DRIFTING:g} | width | inconclusive |")
    print("|---|---|---|---|---|---|---|---|---|")
    for kind in KINDS:
        for name, estimate in estimates.items():
            label = f"the same, {name} | | " if name else f"{kind.name} | {kind.length} | {kind.independent:.0f}"
            print(f"| {label} | {measure(kind, estimate, count)} |", flush=True)


if __name__ == "__main__":
    main()
