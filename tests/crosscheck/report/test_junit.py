"""JUnit XML of a synthetic record, also by the schema that CI servers check it against."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
import synthetic
from xmlschema import XMLSchema, XMLSchemaValidationError

from crosscheck.record import Line, case_name, read
from crosscheck.report.junit import Mark, write_junit

SCHEMA = XMLSchema(Path(__file__).parents[2] / "support" / "junit.xsd")


@pytest.fixture
def lines(tmp_path: Path) -> list[Line]:
    return read(synthetic.write(tmp_path))


def written(directory: Path, lines: Iterable[Line], *more: Any, **options: Any) -> ET.Element:
    """What is written of lines, once it is valid."""
    path = directory / "new" / "junit.xml"
    write_junit(lines, path, *more, **options)
    SCHEMA.validate(path)
    return ET.parse(path).getroot()


@pytest.fixture
def root(lines: list[Line], tmp_path: Path) -> ET.Element:
    return written(tmp_path, lines)


def total(root: ET.Element, name: str) -> float:
    return sum(float(suite.attrib[name]) for suite in root)


def test_counts(lines: list[Line], root: ET.Element) -> None:
    outcomes = Counter(line["outcome"] for line in lines)
    assert total(root, "tests") == len(root.findall("*/testcase")) == len(lines)
    failures = outcomes["fail"] + outcomes["inconclusive"]
    assert total(root, "failures") == len(root.findall("*/testcase/failure")) == failures
    assert total(root, "errors") == len(root.findall("*/testcase/error")) == outcomes["error"]
    assert total(root, "skipped") == len(root.findall("*/testcase/skipped")) == outcomes["skip"]
    assert total(root, "time") == pytest.approx(sum(line["cost"]["seconds"] for line in lines), abs=0.05)


def test_a_suite_for_each_check(lines: list[Line], root: ET.Element) -> None:
    checks = dict.fromkeys(line["check"] for line in lines)
    assert [suite.attrib["name"] for suite in root] == ["crosscheck", *(check.replace("/", ".") for check in checks)]
    assert [suite.attrib["id"] for suite in root] == [str(number) for number in range(len(root))]
    cases = {(case.get("classname"), case.get("name")) for case in root.iter("testcase")}
    assert len(cases) == len(lines)
    assert ("stepping.oscillator-damped", "velocity_verlet[lammps]") in cases


def test_false_alarms_of_the_run_are_a_property(lines: list[Line], root: ET.Element) -> None:
    one = root.find("testsuite[@name='crosscheck']/properties/property[@name='false alarms']")
    assert one is not None
    number = sum(judged["criterion"]["kind"] == "statistical" for line in lines for judged in line["judgements"])
    assert one.attrib["value"].startswith(
        f"{number} statistical judgements, each red with the probability 1e-06 of a right"
    )


def test_all_judgements_are_properties(lines: list[Line], root: ET.Element) -> None:
    properties = root.findall("testsuite/properties/property")
    assert len(properties) == 1 + sum(len(line["judgements"]) for line in lines)
    suite = root.find("testsuite[@name='events.several']")
    assert suite is not None
    found = {one.attrib["name"]: one.attrib["value"] for one in suite.findall("properties/property")}
    assert [name.partition("] ")[2] for name in found] == [*synthetic.SEVERAL, *synthetic.SEVERAL]
    assert found["faulty[refimpl] pressure"] == (
        "outcome=fail; measured=1.500(10); uncertainty=0.01; expected=1; deviation=15.1 tolerances; "
        "criterion=statistical; tolerance=0.0332"
    )
    assert found["right[refimpl] share of fast particles"] == (
        "outcome=pass; measured=0.08; uncertainty=–; expected=≥ 0.04; deviation=0.5 tolerances; criterion=bound; "
        "tolerance=0.04"
    )


def test_messages(root: ET.Element) -> None:
    failure = root.find("*/testcase[@name='rk4[refimpl]']/failure")
    assert failure is not None
    assert failure.get("message") == "order of the position error: measured 5.010(12), expected 4, off by 4.04 tol."
    assert failure.text == "orders are whole numbers\nerror at the largest step: 0.013 r₀"
    error = root.find("*/testcase/error")
    assert error is not None
    assert error.get("message") == "refimpl was killed by signal 11"
    assert "Traceback" in (error.text or "")
    reasons = [skipped.get("message") for skipped in root.iter("skipped")]
    inconclusive = root.findall("*/testcase/failure[@type='inconclusive']")
    assert sum(one.attrib["message"].startswith("inconclusive: pressure") for one in inconclusive) == 2
    assert "Mine: no lattice gases" in reasons


def test_a_failure_lists_every_red_judgement_with_its_reason_and_no_other(root: ET.Element) -> None:
    failure = root.find("*/testcase[@name='faulty[refimpl]']/failure")
    assert failure is not None
    assert failure.get("type") == "statistical"
    assert failure.get("message") == "pressure: measured 1.500(10), expected 1, off by 50 σ"
    assert (failure.text or "").splitlines() == [
        "blocking; red beyond 3.32 sigma, twice: false-alarm rate 1e-06",
        "of 64 disks",
        "share of fast particles: measured 0.02, expected ≥ 0.04, off by 2 tol.",
        "made up: the start",
        "a box of 1234 disks",
    ]


def test_characters_that_xml_cannot_hold_are_escaped_not_lost(lines: list[Line], tmp_path: Path) -> None:
    error = next(line for line in lines if line["outcome"] == "error")
    changed = error | {"message": "first \x1b[31m\udcff\nsecond \x00", "variant": "\ud800", "time": "some day"}
    (case,) = written(tmp_path, [changed]).iter("testcase")
    assert case.attrib["name"].startswith("\\ud800[")
    found = case.find("error")
    assert found is not None
    assert (found.get("message"), found.text) == ("first \\x1b[31m\\udcff", "second \\x00")


def test_inconclusive_verdicts_are_skipped_where_they_are_allowed(lines: list[Line], tmp_path: Path) -> None:
    root = written(tmp_path, lines, allow_inconclusive=True)
    outcomes = Counter(line["outcome"] for line in lines)
    assert total(root, "failures") == outcomes["fail"]
    assert total(root, "skipped") == outcomes["skip"] + outcomes["inconclusive"]
    reasons = [skipped.attrib["message"] for skipped in root.iter("skipped")]
    assert sum(reason.startswith("inconclusive: pressure") for reason in reasons) == 2


def test_what_was_not_judged_is_an_error_of_the_suite(lines: list[Line], tmp_path: Path) -> None:
    skipped = [line for line in lines if line["outcome"] == "skip"]
    root = written(tmp_path, skipped, ["nothing was judged: 3 skipped (Mine: no)"])
    assert (total(root, "tests"), total(root, "errors")) == (len(skipped) + 1, 1)
    error = root.find("*/testcase[@name='nothing was judged']/error")
    assert error is not None
    assert error.attrib["message"].endswith("(Mine: no)")


def test_nothing_at_all_is_valid_too(tmp_path: Path) -> None:
    (suite,) = written(tmp_path, [])
    assert suite.attrib["tests"] == "0"


@pytest.mark.parametrize(
    ("outcome", "state", "tag"),
    [
        ("fail", "known", "skipped"),
        ("error", "known", "skipped"),
        ("inconclusive", "known", "skipped"),
        ("pass", "failure", "failure"),
        ("pass", "error", "error"),
        ("skip", "error", "error"),
        ("fail", "failure", "failure"),
    ],
)
def test_what_a_baseline_says_of_a_case(lines: list[Line], tmp_path: Path, outcome: str, state: Any, tag: str) -> None:
    line = next(line for line in lines if line["outcome"] == outcome)
    mark = {(case_name(line), line["engine"]): Mark(state, "as the baseline says")}
    (case,) = written(tmp_path, [line], marks=mark).iter("testcase")
    (child,) = case
    assert child.tag == tag
    assert "as the baseline says" in f"{child.get('message')} {child.text}"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<testsuites>", "<testsuites skipped='1'>"),
        (' type="bound"', ""),
        (' hostname="localhost"', ""),
        ("</testcase>", "<properties /></testcase>"),
        ("<system-out />", ""),
    ],
)
def test_the_schema_sees_what_a_server_would_refuse(lines: list[Line], tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "junit.xml"
    line = next(line for line in lines if line["variant"] == "faulty")
    bound = line | {"judgements": line["judgements"][1:2], "worst": 0}
    write_junit([bound], path)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(XMLSchemaValidationError):
        SCHEMA.validate(path)
