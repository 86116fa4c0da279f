"""The matrix of extreme cases in the report, from lines of a record."""

from __future__ import annotations

from typing import Any

from crosscheck.checks import all_checks
from crosscheck.checks.extreme.matrix import ANSWER, GROUP
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.report.extreme import matrix
from crosscheck.verdict import Verdict, bounded, findings, within


def line(variant: str, *judged: Any, engine: str = "refimpl", check: str = "extreme/springs") -> dict[str, Any]:
    judgements = [findings(one).judgements[0] for one in judged]
    found = findings(judged[0]) if judged else None
    record = Verdict(check, variant, engine, "pass" if judged else "skip", found, "" if judged else "no").as_record()
    return record | {"judgements": [one.as_record() for one in judgements]}


def value(measured: float, tolerance: float = 0.1) -> Any:
    return within("round_off", "q", measured, 1.0, tolerance, "why")


def test_methods_with_the_same_expectations_share_a_row() -> None:
    lines = [line("two-scales/verlet", value(1.01)), line("two-scales/leapfrog", value(1.02))]
    (case,) = matrix(lines)
    ((expected, group),) = case.groups.items()
    assert expected == (("q", "1 ± 0.1"),)
    assert sorted(group.methods) == [
        ("leapfrog", "refimpl", "pass", ("1.02",)),
        ("verlet", "refimpl", "pass", ("1.01",)),
    ]
    assert "frequencies of" not in case.what
    assert "frequencies 1 : 1e4" in case.what


def test_other_expectations_have_a_row_of_their_own() -> None:
    lines = [line("two-scales/verlet", value(1.01)), line("two-scales/leapfrog", value(1.02, 0.2))]
    assert len(matrix(lines)[0].groups) == 2


def test_answers_are_words() -> None:
    words = "refused: no"
    for measured, found in ((0.0, "said"), (1.0, "not said")):
        (case,) = matrix([line("no-particle/leapfrog", bounded(f"{ANSWER}{words}", measured, 0.0, "why"))])
        (group,) = case.groups.values()
        assert group.expected == (("answer", words),)
        assert group.methods[0][3] == (found,)


def test_a_skip_shows_its_reason_and_an_unknown_case_its_name() -> None:
    (case,) = matrix([line("new/scheme")])
    (group,) = case.groups.values()
    assert (case.what, group.methods) == ("new", [("scheme", "refimpl", "skip", ("no",))])


def test_other_groups_are_left_out_and_checks_come_in_their_order() -> None:
    names = [check.name for check in all_checks() if check.name.startswith(GROUP)]
    lines = [line(f"{name}/x", value(1.0), check=name) for name in reversed(names)]
    assert [case.check for case in matrix([line("x/y", value(1.0), check="events/haff"), *lines])] == names


def test_every_case_of_the_suite_is_known_in_words() -> None:
    for check in all_checks():
        if check.name.startswith(GROUP):
            for variant in check.offered(RefimplEngine.schemes):
                (case,) = matrix([line(variant.name, value(1.0), check=check.name)])
                assert case.what == variant.value.case.what
