"""Red goes before what was not judged, before what is inconclusive; green only if something was judged."""

from __future__ import annotations

from typing import Any

import pytest

from crosscheck import status
from crosscheck.status import Status
from crosscheck.verdict import LEFT_OUT


def line(outcome: str, engine: str = "refimpl", message: str = "") -> dict[str, Any]:
    return {"outcome": outcome, "engine": engine, "message": message}


@pytest.mark.parametrize(
    ("outcomes", "unjudged", "expected"),
    [
        (["pass"], [], Status.PASSED),
        (["pass", "skip"], [], Status.PASSED),
        (["pass", "fail"], [], Status.FAILED),
        (["pass", "error"], [], Status.UNJUDGED),
        (["error", "inconclusive"], [], Status.UNJUDGED),
        (["fail", "error"], [], Status.FAILED),
        (["pass", "inconclusive"], [], Status.INCONCLUSIVE),
        (["fail", "inconclusive"], ["x"], Status.FAILED),
        (["pass", "inconclusive"], ["x"], Status.UNJUDGED),
        (["skip"], ["x"], Status.UNJUDGED),
    ],
)
def test_of_several_the_worst(outcomes: list[str], unjudged: list[str], expected: Status) -> None:
    lines = [line(outcome) for outcome in outcomes]
    assert status.of(lines, unjudged, allow_inconclusive=False) == expected
    allowed = Status.PASSED if expected == Status.INCONCLUSIVE else expected
    assert status.of(lines, unjudged, allow_inconclusive=True) == allowed


def test_the_first_that_counts() -> None:
    assert status.decisive() == Status.PASSED
    assert status.decisive(Status.PASSED, Status.INCONCLUSIVE) == Status.INCONCLUSIVE
    assert status.decisive(Status.INCONCLUSIVE, Status.UNJUDGED) == Status.UNJUDGED
    assert status.decisive(Status.INCONCLUSIVE, Status.UNJUDGED, Status.FAILED) == Status.FAILED


def test_skips_alone_are_nothing() -> None:
    lines = [line("skip", message="one"), line("skip", message="two"), line("skip", message="two")]
    assert status.unjudged(lines, []) == ["nothing was judged: 3 skipped (two, and 1 more)"]
    assert status.unjudged([], []) == [
        "nothing was judged: no check that was asked for matches what it declares (docs/engines.md)"
    ]
    for outcome in ("pass", "fail", "error", "inconclusive"):
        assert status.unjudged([*lines, line(outcome)], []) == []


def test_cases_without_time_are_one_reason() -> None:
    lines = [line("skip", message=f"{LEFT_OUT}: predicted {seconds} s") for seconds in (3, 40)]
    assert status.unjudged(lines, []) == [f"nothing was judged: 2 skipped ({LEFT_OUT})"]


def test_each_named_engine_is_judged() -> None:
    lines = [line("pass"), line("skip", "lammps", "lammps: ImportError: absent")]
    assert status.unjudged(lines, ["refimpl"]) == []
    assert status.unjudged(lines, ["refimpl", "lammps", "ase", "lammps"]) == [
        "nothing was judged of lammps: 1 skipped (lammps: ImportError: absent)",
        "nothing was judged of ase: no check that was asked for matches what it declares (docs/engines.md)",
    ]


def test_false_alarms_of_a_run_add_up() -> None:
    def judged(*rates: float | None) -> dict[str, Any]:
        return {"judgements": [{"false_alarm": rate} for rate in rates]}

    assert status.false_alarms([judged(None), judged()]) == ""
    assert status.false_alarms([judged(None, 1e-6), judged(1e-6), judged(1.44e-6)]) == (
        "false alarms: 3 statistical judgements, each red with the probability 1e-06 to 1.4e-06 of a right code: 3e-06 "
        "for the run, below the 0.001 that are promised"
    )
    assert "0.002 for the run, more than the 0.001" in status.false_alarms([judged(*[1e-6] * 2000)])
