"""Numbers, cases and results to be compared, made up."""

from __future__ import annotations

from typing import Any

from crosscheck.regression.results import Case, Number, Results

NAME, ENGINE = "a/b/c", "mine"
KEY = (NAME, ENGINE)


def statistical(measured: float | None, u: float, outcome: str = "pass", **more: Any) -> Number:
    entries = {"expected": 0.0, "expected_uncertainty": 0.0, "freedom": 1e6} | more
    return Number(
        outcome,
        "statistical",
        "both",
        measured,
        u,
        entries["expected"],
        entries["expected_uncertainty"],
        None,
        entries["freedom"],
    )


def by_tolerance(measured: float | None, outcome: str = "pass", tolerance: float = 1.0, kind: str = "order") -> Number:
    return Number(outcome, kind, "both", measured, None, 0.0, None, tolerance, None)


def bound(measured: float | None, limit: float, outcome: str = "pass", sense: str = "at_most") -> Number:
    return Number(outcome, "bound", sense, measured, None, limit, None, limit, None)


def judged(**numbers: Number) -> Case:
    """A case with these judgements."""
    outcomes = {one.outcome for one in numbers.values()}
    outcome = next((one for one in ("fail", "inconclusive") if one in outcomes), "pass")
    return Case("quick", outcome, numbers=numbers)


def results(case: Case | None, seed: int = 0, **more: Any) -> Results:
    """Results of one case, or of none, beside one that never changes."""
    always = judged(always=by_tolerance(0.1))
    cases = {("a/b/always", ENGINE): always} | ({} if case is None else {KEY: case})
    return Results("run", cases, seed, **more)
