"""JUnit XML of a synthetic record."""

import xml.etree.ElementTree as ET
from collections import Counter

import pytest
import synthetic

from crosscheck.record import read
from crosscheck.report.junit import write_junit


@pytest.fixture
def lines(tmp_path):
    return read(synthetic.write(tmp_path))


@pytest.fixture
def suite(lines, tmp_path):
    path = tmp_path / "new" / "junit.xml"
    write_junit(lines, path)
    (suite,) = ET.parse(path).getroot()
    return suite


def test_counts(lines, suite):
    outcomes = Counter(line["outcome"] for line in lines)
    assert int(suite.get("tests")) == len(suite.findall("testcase")) == len(lines)
    failures = outcomes["fail"] + outcomes["inconclusive"]
    assert int(suite.get("failures")) == len(suite.findall("testcase/failure")) == failures
    assert int(suite.get("errors")) == len(suite.findall("testcase/error")) == outcomes["error"]
    assert int(suite.get("skipped")) == len(suite.findall("testcase/skipped")) == outcomes["skip"]
    assert float(suite.get("time")) == pytest.approx(sum(line["cost"]["seconds"] for line in lines), abs=0.05)


def test_false_alarms_of_the_run_are_a_property(lines, suite):
    one = suite.find("properties/property[@name='false alarms']")
    number = sum(judged["criterion"]["kind"] == "statistical" for line in lines for judged in line["judgements"])
    assert one.get("value").startswith(
        f"{number} statistical judgements, each red with the probability 1e-06 of a right"
    )


def test_names(suite):
    cases = {(case.get("classname"), case.get("name")) for case in suite}
    assert len(cases) == len(suite)
    assert ("stepping.oscillator-damped", "velocity_verlet[lammps]") in cases


def test_messages(suite):
    failure = suite.find("testcase[@name='rk4[refimpl]']/failure")
    assert failure.get("message") == "order of the position error: measured 5.010(12), expected 4, off by 4.04 tol."
    assert failure.text == "orders are whole numbers\nerror at the largest step: 0.013 r₀"
    error = suite.find("testcase/error")
    assert error.get("message") == "refimpl was killed by signal 11"
    assert "Traceback" in error.text
    reasons = [skipped.get("message") for skipped in suite.iter("skipped")]
    inconclusive = suite.findall("testcase/failure[@type='inconclusive']")
    assert sum(one.get("message").startswith("inconclusive: pressure") for one in inconclusive) == 2
    assert "Mine: no lattice gases" in reasons


def test_a_failure_lists_every_red_judgement_with_its_reason_and_no_other(suite):
    failure = suite.find("testcase[@name='faulty[refimpl]']/failure")
    assert failure.get("type") == "statistical"
    assert failure.get("message") == "pressure: measured 1.500(10), expected 1, off by 50 σ"
    assert failure.text.splitlines() == [
        "blocking; red beyond 3.32 sigma, twice: false-alarm rate 1e-06",
        "of 64 disks",
        "share of fast particles: measured 0.02, expected ≥ 0.04, off by 2 tol.",
        "made up: the start",
        "a box of 1234 disks",
    ]


def test_characters_that_xml_cannot_hold_are_escaped_not_lost(lines, tmp_path):
    error = next(line for line in lines if line["outcome"] == "error")
    write_junit([error | {"message": "first \x1b[31m\udcff\nsecond \x00", "variant": "\ud800"}], tmp_path / "junit.xml")
    (case,) = ET.parse(tmp_path / "junit.xml").getroot().iter("testcase")
    assert case.get("name").startswith("\\ud800[")
    assert case.find("error").get("message") == "first \\x1b[31m\\udcff"
    assert case.find("error").text == "second \\x00"


def test_inconclusive_verdicts_are_skipped_where_they_are_allowed(lines, tmp_path):
    write_junit(lines, tmp_path / "junit.xml", allow_inconclusive=True)
    suite = ET.parse(tmp_path / "junit.xml").getroot()[0]
    outcomes = Counter(line["outcome"] for line in lines)
    assert int(suite.get("failures")) == outcomes["fail"]
    assert int(suite.get("skipped")) == outcomes["skip"] + outcomes["inconclusive"]
    reasons = [skipped.get("message") for skipped in suite.iter("skipped")]
    assert sum(reason.startswith("inconclusive: pressure") for reason in reasons) == 2


def test_what_was_not_judged_is_an_error_of_the_suite(lines, tmp_path):
    skipped = [line for line in lines if line["outcome"] == "skip"]
    write_junit(skipped, tmp_path / "junit.xml", ["nothing was judged: 3 skipped (Mine: no)"])
    suite = ET.parse(tmp_path / "junit.xml").getroot()[0]
    assert (suite.get("tests"), suite.get("errors")) == (str(len(skipped) + 1), "1")
    assert suite.find("testcase[@name='nothing was judged']/error").get("message").endswith("(Mine: no)")
