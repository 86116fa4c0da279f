"""How well statistical judgements are calibrated: a case judged with many seeds of the suite.

Of a right code, p-values are uniform between 0 and 1 (Kolmogorov and Smirnov), and a deviation of the size of the
stated sensitivity, added to what was measured, is seen with the probability `crosscheck.verdict.SEEN`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosscheck.statistics import seen_beyond, student_probability, student_quantile
from crosscheck.verdict import SEEN, SUSPICIOUS, Judgement


@dataclass(frozen=True)
class Calibration:
    """What many seeds say of one statistical judgement of a case.

    quantity: name of what is measured. seeds: number of runs. freedom: degrees of freedom of the error, the median;
    None: of a test statistic. about: what deviations are counted from: "expected", or "mean", where the expected value
    has an error of its own, the same in all runs, or a doubt. discrete: the p-values take few values, and are no more
    than roughly uniform. mean: of the p-values. uniform: probability that uniform ones are as far from uniform, by
    Kolmogorov and Smirnov. suspicious: runs that were red. inconclusive: runs that decided nothing. seen: the
    probability that a deviation of the size of the sensitivity is red in two runs; None: of a test statistic.
    """

    quantity: str
    seeds: int
    freedom: float | None
    about: str
    discrete: bool
    mean: float
    uniform: float
    suspicious: int
    inconclusive: int
    seen: float | None


def calibration(judged: Sequence[Judgement]) -> Calibration:
    """What the judgements of one quantity, by runs that differ in their seed alone, say of how it is judged.

    judged: statistical ones, with finite numbers, two at least; each of one run, not of two.
    """
    from scipy.stats import kstest

    about, p_values = "expected", np.array([one.p_value for one in judged], dtype=float)
    freedom, seen = None, None
    if judged[0].freedom is not None:
        about, off, error, freedoms = _deviations(judged)
        freedom = float(np.median(freedoms))
        if about == "mean":
            p_values = np.array(
                [student_probability(abs(x / u), f) for x, u, f in zip(off, error, freedoms, strict=True)]
            )
        seen = _seen(off, error, freedoms)
    return Calibration(
        judged[0].quantity,
        len(judged),
        freedom,
        about,
        len(set(p_values.tolist())) < len(judged) / 2,
        float(p_values.mean()),
        float(kstest(p_values, "uniform").pvalue),
        sum(one.outcome == "fail" for one in judged),
        sum(one.outcome == "inconclusive" for one in judged),
        seen,
    )


_Numbers = NDArray[np.float64]


def _deviations(judged: Sequence[Judgement]) -> tuple[str, _Numbers, _Numbers, _Numbers]:
    """What deviations are counted from; the deviations, their standard errors and degrees of freedom, (runs,)."""
    columns = ("measured", "expected", "uncertainty", "expected_uncertainty", "freedom", "doubt")
    measured, expected, error, own, freedom, doubt = (
        np.array([getattr(one, name) for one in judged], dtype=float) for name in columns
    )
    shared = bool((own > 0).any()) and len(set(own.tolist())) == 1 and len(set(expected.tolist())) == 1
    off, total = measured - expected, np.hypot(error, own)
    if not shared and not doubt.any():
        return "expected", off, total, freedom
    # the mean of n runs takes a part of each deviation with it
    return "mean", (off - off.mean()) / (1 - 1 / off.size) ** 0.5, error if shared else total, freedom


def _seen(off: _Numbers, error: _Numbers, freedom: _Numbers) -> float:
    """The probability that a deviation of the size of the sensitivity, to either side, is beyond the quantile twice."""
    quantile = np.array([student_quantile(SUSPICIOUS, one) for one in freedom])
    beyond = np.array([seen_beyond(q, f, SEEN**0.5) for q, f in zip(quantile, freedom, strict=True)])
    injected = float(np.sqrt(np.mean((beyond * error) ** 2)))
    both = np.concatenate([abs(off + injected), abs(off - injected)]) > np.tile(quantile * error, 2)
    return float(both.mean() ** 2)
