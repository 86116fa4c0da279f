"""Numbers as they appear in the report."""

import math
from pathlib import Path

import pytest

from crosscheck.report import numbers
from crosscheck.verdict import SENSITIVITY, Judgement, Verdict, bounded, findings, order, round_off, statistical

DOCS = Path(__file__).parents[3] / "docs"


@pytest.mark.parametrize(
    ("value", "uncertainty", "text"),
    [
        (1.2345, 0.0067, "1.2345(67)"),
        (1.2345, 0.0996, "1.23(10)"),
        (1234.56, 3.4, "1234.6(34)"),
        (1234.56, 120.0, "1.23(12)e3"),
        (1.204e-14, 3.5e-16, "1.204(35)e-14"),
        (-0.0281, 0.00012, "-0.02810(12)"),
        (0.018, 0.21, "0.02(21)"),
        (0.0, 2e-10, "0.0(20)e-10"),
        (6.02214e23, 1e19, "6.02214(10)e23"),
        (2.0, None, "2"),
        (2.5, 0.0, "2.5"),
        (2.5, math.inf, "2.5"),
        (None, 0.1, "–"),
    ],
)
def test_value_and_uncertainty(value, uncertainty, text):
    assert numbers.with_uncertainty(value, uncertainty) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(3.2e-14, "3.2e-14"), (0.5, "0.5"), (1e20, "1e20"), (12345.0, "12345"), (math.nan, "not finite")],
)
def test_plain(value, text):
    assert numbers.plain(value) == text


def test_digits_reach_below_the_tolerance():
    assert numbers.to_tolerance(-0.028097802999, 1e-9) == "-0.028097803"
    assert numbers.to_tolerance(1.98765, 0.25) == "1.99"
    assert numbers.to_tolerance(0.0, 1e-12) == "0"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.012, "12 ms"),
        (0.0996, "0.1 s"),
        (3.42, "3.4 s"),
        (71.2, "71 s"),
        (306, "5 min 06 s"),
        (3720, "1 h 02 min"),
        (None, "–"),
    ],
)
def test_seconds(value, text):
    assert numbers.seconds(value) == text


def as_recorded(judgement):
    line = Verdict("a/b", "", "refimpl", judgement.outcome, findings(judgement), "").as_record()
    return line["judgements"][line["worst"]]


@pytest.mark.parametrize(
    ("judgement", "expected", "deviation", "sensitivity"),
    [
        (round_off("e", 3e-13, 1e-12, "w"), "0", "0.3 tol.", "1e-12 abs."),
        (order("p", 2.1, 2.0, 0.25, "w"), "2", "0.4 tol.", "0.12"),
        (bounded("b", 1.0, 4.0, "w"), "≤ 4", "0.25 tol.", "0.75"),
        (bounded("b", 8.0, 4.0, "w"), "≤ 4", "2 tol.", "1"),
        (bounded("b", 8.0, 4.0, "w", at_least=True), "≥ 4", "0.5 tol.", "1"),
        (bounded("b", 0.0, 4.0, "w", at_least=True), "≥ 4", "∞", "1"),
        (bounded("b", 0.0, 4.0, "w"), "≤ 4", "0 tol.", "1"),
        (bounded("b", 1e9, 4.0, "w", expected_failure=True), "≥ 4", "4e-9 tol.", "2.5e8"),
        (bounded("b", 0.5, 0.0, "w"), "≤ 0", "∞", "0.5 abs."),
        (statistical("s", 1.1, 0.1, 1.0, 0.02, "w", samples=1e6), "1.000(20)", "0.981 σ", "0.5"),
        (round_off("e", math.nan, 1e-12, "w"), "0", "∞", "1e-12 abs."),
    ],
)
def test_of_a_judgement(judgement, expected, deviation, sensitivity):
    recorded = as_recorded(judgement)
    assert numbers.expected(recorded) == expected
    assert numbers.deviation(recorded) == deviation
    assert numbers.sensitivity(recorded) == sensitivity
    assert numbers.measured(recorded) != numbers.ABSENT


def test_nothing_is_shown_of_no_judgement():
    shown = (numbers.measured, numbers.expected, numbers.deviation, numbers.sensitivity)
    assert {number(None) for number in shown} == {numbers.ABSENT}


@pytest.mark.parametrize("text", [Judgement.__doc__, (DOCS / "record.md").read_text(encoding="utf-8")])
def test_sensitivity_is_explained_in_the_same_words_everywhere(text):
    assert SENSITIVITY in " ".join(text.replace("\\|", "|").split())
