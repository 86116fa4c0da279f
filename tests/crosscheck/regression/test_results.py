"""What two runs are compared by, from the lines of a record."""

from __future__ import annotations

from pathlib import Path

import pytest
import synthetic
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.record import Line, case_name, read
from crosscheck.regression.results import names, of_lines


@pytest.fixture
def lines(tmp_path: Path) -> list[Line]:
    return read(synthetic.write(tmp_path))


def test_every_case_with_every_judgement(lines: list[Line]) -> None:
    found = of_lines(lines, "there")
    assert (found.name, found.seed, found.rounded) == ("there", 7, False)
    assert found.provenance == synthetic.PROVENANCE
    assert len(found.cases) == len(lines)
    for line in lines:
        case = found.cases[case_name(line), line["engine"].replace("\x1b", "\\x1b")]
        assert case.outcome == line["outcome"]
        assert case.judged == (line["outcome"] not in ("skip", "error"))
        assert len(case.numbers) == len(line["judgements"])
        for one, number in zip(line["judgements"], case.numbers.values(), strict=True):
            assert (number.outcome, number.measured, number.expected) == (
                one["outcome"],
                one["measured"],
                one["expected"],
            )


def test_an_error_is_kept_where_it_decides(lines: list[Line]) -> None:
    """That of an order is the scatter of its fit, the same in every run."""
    numbers = [number for case in of_lines(lines, "").cases.values() for number in case.numbers.values()]
    assert {(n.kind, n.uncertainty is None, n.tolerance is None) for n in numbers} == {
        ("order", True, False),
        ("round_off", True, False),
        ("bound", True, False),
        ("expected_failure", True, False),
        ("statistical", False, True),
    }


def test_operations_without_times(lines: list[Line]) -> None:
    case = of_lines(lines, "").cases["events/several/right", "refimpl"]
    assert case.counters == {"steps": 1000, "evaluations": 12345}
    assert case.cpu == 0.2
    cost = {"cpu": 1.0, "steps": 0, "events": 0, "stale_events": 0, "pair_tests": 7, "peak_bytes": 5}
    (line,) = (one for one in lines if case_name(one) == "events/several/right")
    (case,) = of_lines([line | {"cost": cost}], "").cases.values()
    # 0 steps may be one who does not count; 0 stale events were counted
    assert case.counters == {"stale_events": 0, "pair_tests": 7}


def test_lines_of_several_seeds_have_none(lines: list[Line]) -> None:
    other = lines[1] | {"provenance": {"seed": 8}}
    assert of_lines([lines[0], other], "").seed is None
    assert of_lines([], "").seed is None


def test_quantities_of_one_name_are_numbered() -> None:
    assert names(["x", "y", "x", "x"]) == ["x", "y", "x (2)", "x (3)"]
    assert names(["x (2)", "x", "x"]) == ["x (2)", "x", "x (3)"]
    assert names(["tab\there"]) == ["tab\\there"]


@given(st.lists(st.sampled_from(["x", "x (2)", "x (3)", "y", "x (2) (2)"]), max_size=12))
def test_names_are_different_and_begin_with_the_quantity(quantities: list[str]) -> None:
    found = names(quantities)
    assert len(set(found)) == len(found)
    assert all(name.startswith(quantity) for name, quantity in zip(found, quantities, strict=True))
