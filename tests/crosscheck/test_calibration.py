"""What many seeds say of a judgement: of right codes nothing, of errors that are too small that they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from crosscheck.calibration import calibration
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import SEEN, Judgement, by_chance, statistical

RUNS, SAMPLES = 1000, 25


def judged(
    scale: float = 1.0, offset: float = 0.0, shared: float = 0.0, doubt: float = 0.0, seed: int = 1
) -> list[Judgement]:
    """Means of normal numbers, whose errors are given `scale` times too large; offset, shared: of what is expected."""
    draws = np.random.default_rng(seed).normal(size=(RUNS, SAMPLES))
    return [
        statistical(
            "x",
            float(row.mean()),
            scale * float(row.std(ddof=1)) / SAMPLES**0.5,
            offset,
            shared,
            "why",
            samples=SAMPLES,
            doubt=doubt,
        )
        for row in draws
    ]


def test_right_codes_are_calibrated() -> None:
    found = calibration(judged())
    assert (found.quantity, found.seeds, found.freedom, found.about) == ("x", RUNS, SAMPLES - 1, "expected")
    assert found.uniform > 0.01
    assert found.mean == pytest.approx(0.5, abs=4 / (12 * RUNS) ** 0.5)
    # both signs of a deviation, in runs that are the same
    assert found.seen == pytest.approx(SEEN, abs=4 * 2 * SEEN**0.5 * (0.05 * 0.95 / RUNS) ** 0.5)
    assert not found.discrete


@pytest.mark.parametrize("scale", [0.7, 1.4])
def test_wrong_errors_are_found(scale: float) -> None:
    found = calibration(judged(scale))
    assert found.uniform < 1e-6
    assert (found.mean < 0.45) == (scale < 1)


def test_a_wrong_code_is_found() -> None:
    assert calibration(judged(offset=0.1)).uniform < 1e-3


@pytest.mark.parametrize("options", [{"offset": 0.3, "shared": 0.3}, {"offset": 0.3, "doubt": 0.3}])
def test_what_all_runs_share_is_not_counted(options: dict[str, float]) -> None:
    """An error of the expected value that is the same in all runs, or a doubt: deviations from their own mean."""
    found = calibration(judged(**options))
    assert found.about == "mean"
    assert found.uniform > 0.01
    assert calibration(judged(0.7, **options)).uniform < 1e-6


def test_a_test_statistic_has_p_values_alone() -> None:
    law = chi2(5)
    draws = law.rvs(RUNS, random_state=3)
    found = calibration([by_chance("chi^2", float(one), law, "why") for one in draws])
    assert found.uniform > 0.01
    assert (found.freedom, found.seen) == (None, None)


def test_few_values_are_discrete_and_outcomes_are_counted() -> None:
    some = judged()[:4]
    mixed = [*some, *some, *some, replace(some[0], outcome="fail"), replace(some[0], outcome="inconclusive")]
    found = calibration(mixed)
    assert found.discrete
    assert (found.suspicious, found.inconclusive) == (1, 1)


def test_series_are_calibrated() -> None:
    """Of 400 values with tau = 2, N = 100."""
    from scipy.signal import lfilter

    rho = 3 / 5
    noise = np.random.default_rng(4).normal(size=(600, 400))
    noise[:, 1:] *= (1 - rho**2) ** 0.5
    means = [correlated_mean(row) for row in lfilter([1.0], [1.0, -rho], noise, axis=1)]
    found = calibration([statistical("x", m.value, m.error, 0.0, 0.0, "why", samples=m) for m in means])
    assert found.uniform > 0.01
    assert found.seen == pytest.approx(SEEN, abs=0.05)
