"""benchmarks/evidence/sensitivities.py on numbers that are drawn, not simulated: what it says of errors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from benchmark_modules import benchmark_named
from scipy.stats import nct

from crosscheck.engines.protocol import Run
from crosscheck.engines.workers.pool import Pool
from crosscheck.statistics import seen_beyond, student_quantile
from crosscheck.verdict import SEEN, SUSPICIOUS, Judged, round_off, statistical, worst

SEEDS, SAMPLES = 200, 25
#: Large, so that a deviation which is seen is a small share of it.
MIDDLE = 300.0
#: Of the mean, to be injected.
DEVIATION = 1.0


@pytest.fixture(scope="module")
def benchmark_module() -> Any:
    return benchmark_named("evidence/sensitivities")


def mean_of(scale: float, doubt: float = 0.0) -> Callable[[Any], Callable[[], Judged]]:
    """A check of the mean of "x", whose error is given `scale` times too large; and of "y", exactly."""

    def judge(laboratory: Any) -> Judged:
        run = laboratory.run(None, "event_driven")
        x = run["x"]
        error = scale * float(x.std(ddof=1)) / SAMPLES**0.5
        mean = statistical("x", float(x.mean()), error, MIDDLE, 0.0, "why", samples=SAMPLES, doubt=doubt)
        return worst([mean, round_off("y", float(run["y"][0]), 1e-6, "why")])

    return lambda laboratory: lambda: judge(laboratory)


def runs(module: Any, judges: Callable[[Any], Callable[[], Judged]]) -> list[Any]:
    """Two of each seed, judged."""
    rng = np.random.default_rng(1)

    def one() -> Any:
        run = Run(time=np.arange(SAMPLES), x=rng.normal(MIDDLE, 1.0, SAMPLES), y=np.zeros(1))
        laboratory = module.Replaying("refimpl", {}, Pool(), "a/b", kept=[("refimpl", run)])
        judge = judges(laboratory)
        return module.Judged(laboratory, judge, laboratory.judged(judge))

    return [one() for _ in range(2 * SEEDS)]


@pytest.mark.parametrize(("scale", "doubt"), [(1.0, 0.0), (1.0, 0.5), (0.5, 0.0)])
def test_sensitivities_are_seen_as_often_as_stated_if_errors_are_right(
    benchmark_module: Any, scale: float, doubt: float
) -> None:
    """By the noncentral t distribution, also where errors are given too small."""
    judged = runs(benchmark_module, mean_of(scale, doubt))
    answer = next(benchmark_module.moving(judged[0], 0, DEVIATION))
    assert answer.alteration == benchmark_module.Alteration("x", "times 1 + e")
    assert answer.slope == pytest.approx(MIDDLE, rel=0.01)
    up, down = (benchmark_module.injected(judged, 0, answer, side) for side in (1, -1))
    quantile = student_quantile(SUSPICIOUS, SAMPLES - 1)
    beyond = seen_beyond(quantile, SAMPLES - 1, SEEN**0.5)
    seen = float(nct.sf(scale * quantile, SAMPLES - 1, scale * beyond)) ** 2
    assert seen == pytest.approx(SEEN) or scale < 1
    share = (up.twice + down.twice) / (2 * SEEDS)
    assert share == pytest.approx(seen, abs=4 * (seen * (1 - seen) / (2 * SEEDS)) ** 0.5)
    assert up.others == set()


def test_what_cannot_be_moved_is_said(benchmark_module: Any) -> None:
    def constant(laboratory: Any) -> Judged:
        laboratory.run(None, "event_driven")
        return statistical("x", 0.1, 1.0, 0.0, 0.0, "why", samples=SAMPLES)

    judged = runs(benchmark_module, lambda laboratory: lambda: constant(laboratory))
    assert list(benchmark_module.moving(judged[0], 0, 1.0)) == []


def test_what_is_expected_of_the_same_data_moves_with_them(benchmark_module: Any) -> None:
    """A share of the first component: it moves with that alone, and nothing larger than it can be injected."""

    def share(laboratory: Any) -> Judged:
        x = laboratory.run(None, "event_driven")["x"].reshape(-1, 5)
        return statistical("x", float(x[:, 0].mean()), 1.0, float(x.mean()), 0.0, "why", samples=SAMPLES)

    judged = runs(benchmark_module, lambda laboratory: lambda: share(laboratory))[0]
    judged.laboratory.kept[0][1]["x"] = judged.laboratory.kept[0][1]["x"].reshape(-1, 5)
    answer = next(benchmark_module.moving(judged, 0, DEVIATION))
    assert answer.alteration == benchmark_module.Alteration("x", "first component times 1 + e")
    assert answer.slope == pytest.approx(0.8 * MIDDLE, rel=0.01)
    assert list(benchmark_module.moving(judged, 0, MIDDLE)) == []


def test_half_of_the_particles(benchmark_module: Any) -> None:
    change = benchmark_module.Alteration("velocities", "of half of the particles times 1 + e")
    run = change.apply(Run(velocities=np.ones((2, 4, 3))), 0, 0.5)
    assert run["velocities"].tolist() == [[[1.5] * 3] * 2 + [[1.0] * 3] * 2] * 2


def test_a_check_that_ends_before_the_judgement_sees_nothing(benchmark_module: Any) -> None:
    def stopping(laboratory: Any) -> Judged:
        x = laboratory.run(None, "event_driven")["x"]
        kept = round_off("mean of x less what it is", float(x.mean()) - MIDDLE, 2.0, "why")
        mean = statistical("x", float(x.mean()), 1.0, MIDDLE, 0.0, "why", samples=SAMPLES)
        return kept if kept.outcome == "fail" else worst([kept, mean])

    judged = runs(benchmark_module, lambda laboratory: lambda: stopping(laboratory))
    answer = next(benchmark_module.moving(judged[0], 1, DEVIATION))
    assert benchmark_module.injected(judged, 1, answer, 1) is None


def test_only_the_engine_under_judgement_is_altered(benchmark_module: Any) -> None:
    laboratory = benchmark_module.Replaying(
        "refimpl", {}, Pool(), "a/b", kept=[("lammps", Run(x=np.ones(3))), ("refimpl", Run(x=np.ones(3)))]
    )
    change = benchmark_module.Alteration("x", "plus e rms")
    found: list[Run] = []

    def judge() -> Judged:
        found.extend(laboratory.run(None, "event_driven", engine) for engine in ("lammps", None))
        return round_off("y", 0.0, 1.0, "why")

    laboratory.judged(judge, change, 0.5)
    assert [run["x"][0] for run in found] == [1.0, 1.5]
