"""How often a right code is red: verdicts on simulated series whose mean is what is expected, and which do not drift.

    python benchmarks/false_alarms.py [number of series of each kind]

Autoregressive series x' = rho x + noise, of variance 1; their autocorrelation time is tau = (1 + rho)/2(1 - rho).
Printed for each length n and each number of independent samples N = n/2 tau: the shares of verdicts that are red by
their mean, red by a drift, inconclusive. Both red ones must be near `crosscheck.verdict.FALSE_ALARM` wherever a verdict
can pass at all, which takes 20 independent samples.
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np
from scipy.signal import lfilter

from crosscheck.statistics import correlated_mean
from crosscheck.verdict import statistical

LENGTHS, SAMPLES, AT_A_TIME = (50, 400), (5, 10, 20, 40, 100), 1000


def autoregressive(tau: float, count: int, length: int, rng: np.random.Generator) -> np.ndarray:
    """Stationary series of variance 1 and mean 0, (count, length); tau: their autocorrelation time, in samples."""
    rho = (2 * tau - 1) / (2 * tau + 1)
    noise = rng.normal(size=(count, length))
    noise[:, 1:] *= (1 - rho**2) ** 0.5
    return np.asarray(lfilter([1.0], [1.0, -rho], noise, axis=1))


def outcome(series: np.ndarray) -> str:
    """What the verdict on one series is, and why."""
    mean = correlated_mean(series)
    judgement = statistical("mean", mean.value, mean.error, 0.0, 0.0, "simulated", samples=mean)
    drifts = judgement.note.startswith("drifts")
    return "drift" if drifts else judgement.outcome


def main() -> None:
    """Prints the table."""
    total = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    rng = np.random.default_rng(2026)
    print(f"{'n':>5} {'N':>5} {'red mean':>10} {'drift':>10} {'inconclusive':>13}")
    for length in LENGTHS:
        for samples in SAMPLES:
            if samples > length:
                continue
            found: Counter[str] = Counter()
            for _ in range(total // AT_A_TIME):
                rows = autoregressive(length / (2 * samples), AT_A_TIME, length, rng)
                found.update(outcome(row) for row in rows)
            shares = [found[name] / found.total() for name in ("fail", "drift", "inconclusive")]
            print(f"{length:5d} {samples:5d} {shares[0]:10.1e} {shares[1]:10.1e} {shares[2]:13.3f}", flush=True)


if __name__ == "__main__":
    main()
