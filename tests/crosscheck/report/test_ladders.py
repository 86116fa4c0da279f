"""Which method is the cheapest: interpolation between runs, never beyond them; fronts and sentences."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.report.ladders import Case, Climb, Point, cases, overview, power, reached, times


def climb(errors: list[float], cpu: list[float], engine: str = "refimpl", label: str = "verlet", **more: Any) -> Climb:
    failures = more.get("failures", [""] * len(errors))
    points = tuple(
        Point(0.1 / 2**k, error, 0.0, time, time, time, 100.0 * 2**k, failure)
        for k, (error, time, failure) in enumerate(zip(errors, cpu, failures, strict=True))
    )
    return Climb(engine, label, "symplectic", "dt", points, "evaluations", f"c/{label}", f"--engine {engine}")


def case(*climbs: Climb) -> Case:
    return Case("an orbit", "largest error/a", "performance/work-precision-kepler", "c1", list(climbs))


@given(order=st.floats(0.5, 8), factor=st.floats(1e-6, 1e3), share=st.floats(0.01, 0.99))
def test_power_laws_are_interpolated_exactly(order: float, factor: float, share: float) -> None:
    cpu = [factor * 2**k for k in range(5)]
    errors = [2.0 ** (-order * k) for k in range(5)]
    target = 2.0 ** (-order * 4 * share)
    found = reached(climb(errors, cpu), target)
    assert found is not None
    assert found.cpu == pytest.approx(factor * 2 ** (4 * share), rel=1e-9)
    assert found.control == pytest.approx(0.1 / 2 ** (4 * share), rel=1e-9)
    assert found.count == pytest.approx(100 * 2 ** (4 * share), rel=1e-9)


def test_nothing_is_extrapolated() -> None:
    ladder = climb([1e-1, 1e-3], [1.0, 10.0])
    assert reached(ladder, 1e-4) is None
    coarsest = reached(ladder, 0.5)
    assert coarsest is not None
    assert not coarsest.between
    assert coarsest.time == "≤\u00a01\u00a0s"


def test_failed_runs_count_for_nothing() -> None:
    ladder = climb([1e-9, 1e-2, 1e-4], [1.0, 2.0, 4.0], failures=["diverged", "", ""])
    found = reached(ladder, 1e-3)
    assert found is not None
    assert found.cpu == pytest.approx(8**0.5)
    assert reached(climb([math.inf, math.nan], [1.0, 2.0]), 1.0) is None


def test_the_least_cost_counts_where_errors_do_not_fall_steadily() -> None:
    """Below 1e-3 after the second run, above it after the third, below it again."""
    found = reached(climb([1e-2, 1e-4, 1e-2, 1e-5], [1.0, 2.0, 4.0, 8.0]), 1e-3)
    assert found is not None
    assert 1.0 < found.cpu < 2.0


def test_the_front_is_beaten_by_no_run() -> None:
    rng = np.random.default_rng(0)
    ladders = [
        climb((10.0 ** rng.uniform(-8, 0, 6)).tolist(), (10.0 ** rng.uniform(-3, 1, 6)).tolist()) for _ in range(5)
    ]
    every = [point for one in ladders for point in one.points]
    front = [point for _, point in case(*ladders).front]
    for point in front:
        assert not any(other.cpu < point.cpu and other.error <= point.error for other in every)
    for point in every:
        assert any(one.cpu <= point.cpu and one.error <= point.error for one in front)


def test_rows_and_sentences() -> None:
    fast = climb([1e-1, 1e-3, 1e-5], [1.0, 10.0, 100.0])
    exact = climb([1e-1, 1e-13], [20.0, 40.0], "scipy", "DOP853")
    found = case(fast, exact)
    rows = found.rows
    assert [row.target for row in rows] == pytest.approx([1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
    assert rows[0].best.climb is fast
    assert rows[0].cells["scipy"].times == f"{times(rows[0].cells['scipy'].factor)}\u00a0×"
    assert "refimpl" not in rows[3].cells
    first, second, last = found.answer
    assert first.startswith("For an error of 1e-2: verlet, refimpl, in 3.2")
    assert "scipy takes 6.7 times as long" in first
    assert second.startswith("For an error of 1e-4 to 1e-12: DOP853, scipy")
    assert last == "The smallest error of all is 1e-13."


def test_the_cost_is_as_uncertain_as_repeats_and_errors_are() -> None:
    """An error known to 15 % that falls as the square root of the cost: the cost is known to 30 %."""
    points = tuple(Point(n, n**-0.5, 0.15 * n**-0.5, n, 0.9 * n, 1.1 * n, n, "") for n in (1.0, 4.0, 16.0))
    ladder = Climb("refimpl", "edmd", "event-driven", "n", points, "collisions", "c/edmd", "")
    found = reached(ladder, 0.3)
    assert found is not None
    assert found.spread == pytest.approx((0.1**2 + 0.3**2) ** 0.5)
    assert found.timed == f"{found.time} ±\u00a032\u00a0%"


def test_commands_are_said_once_an_engine() -> None:
    found = case(climb([1.0], [1.0]), climb([1.0], [1.0], label="euler"), climb([1.0], [1.0], "scipy", "RK45"))
    assert found.commands == [
        ("crosscheck run c/METHOD --engine refimpl", ["verlet", "euler"]),
        ("crosscheck run c/RK45 --engine scipy", ["RK45"]),
    ]


def test_averages_are_compared_at_every_decade() -> None:
    found = case(climb([0.3, 0.15, 0.04], [1.0, 4.0, 64.0]))
    assert [row.target for row in found.rows] == pytest.approx([0.1])


def test_cases_of_a_record() -> None:
    ladder = {
        "label": "verlet", "family": "symplectic", "control": "dt", "controls": [0.1, 0.05], "error": [None, 1e-3],
        "uncertainty": [0.0, 0.0], "cpu": [1.0, 2.0], "cpu_low": [1.0, 2.0], "cpu_high": [1.0, 2.0], "count": [],
        "count_label": "steps", "failures": ["diverged", ""],
    }  # fmt: skip
    line = {
        "check": "performance/work-precision-kepler", "variant": "verlet", "engine": "refimpl", "tier": "full",
        "provenance": {"seed": 3}, "figures": [{"title": "an orbit", "y_label": "error", "ladder": ladder}],
    }  # fmt: skip
    (found,) = cases("performance/work-precision-kepler", "c1", [line, line | {"figures": []}])
    (only,) = found.climbs
    command = "crosscheck run performance/work-precision-kepler/verlet --tier full --engine refimpl --seed 3"
    assert found.commands == [(command, ["verlet"])]
    assert (found.runs, found.failed) == (2, 1)
    assert math.isnan(only.points[1].count)
    ((_, cells),) = overview([found], (1e-2, 1e-4))
    assert cells[0] is not None
    assert cells[1] is None


@pytest.mark.parametrize(
    ("factor", "text"), [(1.0, "1.0"), (9.94, "9.9"), (9.96, "10"), (123.4, "120"), (5678.0, "5700")]
)
def test_factors(factor: float, text: str) -> None:
    assert times(factor) == text
    assert power(1e-12) == "1e-12"
