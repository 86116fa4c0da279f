"""JUnit XML: one test case a verdict, for tools that show test results."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from pathlib import Path

from crosscheck.files import naming
from crosscheck.record import Line, deciding
from crosscheck.report.numbers import comparison
from crosscheck.status import false_alarms
from crosscheck.text import printable


def write_junit(
    lines: Iterable[Line], path: Path, unjudged: Sequence[str] = (), allow_inconclusive: bool = False
) -> None:
    """Writes one test suite, which other tools show as green only if it may be taken for a success.

    A failed verdict is a failure, and so is an inconclusive one, of the type "inconclusive". lines: of the record.
    path: the file to write. unjudged: sentences on what was not judged, each an error of the suite. allow_inconclusive:
    inconclusive verdicts are skipped test cases, with their reason.
    """
    judged = list(lines)
    cases = [_case(line, allow_inconclusive) for line in judged] + [_problem(reason) for reason in unjudged]
    found = [child.tag for case in cases for child in case]
    totals: dict[str, str] = {
        "name": "particle-crosscheck",
        "tests": str(len(cases)),
        "failures": str(found.count("failure")),
        "errors": str(found.count("error")),
        "skipped": str(found.count("skipped")),
        "time": f"{sum(float(case.attrib['time']) for case in cases):.3f}",
    }
    root = ET.Element("testsuites", totals)
    suite = ET.SubElement(root, "testsuite", totals)
    if alarms := false_alarms(judged):
        properties = ET.SubElement(suite, "properties")
        ET.SubElement(properties, "property", name="false alarms", value=_clean(alarms.removeprefix("false alarms: ")))
    suite.extend(cases)
    ET.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    with naming(path):
        ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _problem(reason: str) -> ET.Element:
    """An error of no case: a suite without any would be green."""
    case = ET.Element("testcase", classname="crosscheck", name=_clean(reason.partition(":")[0]), time="0.000")
    ET.SubElement(case, "error", message=_clean(reason))
    return case


def _case(line: Line, allow_inconclusive: bool) -> ET.Element:
    case = ET.Element(
        "testcase",
        classname=_clean(line["check"].replace("/", ".")),
        name=_clean(f"{line['variant']}[{line['engine']}]"),
        time=f"{line['cost'].get('seconds') or 0.0:.3f}",
    )
    outcome, message = line["outcome"], _clean(line["message"])
    if outcome == "fail":
        red = deciding(line)
        failure = ET.SubElement(case, "failure", message=_clean(comparison(red[0])), type=red[0]["criterion"]["kind"])
        text = [part for one in red for part in (comparison(one), one["criterion"]["why"], one["note"])]
        # the first comparison is the message
        failure.text = _clean("\n".join(dict.fromkeys(filter(None, (*text[1:], line["note"], line["message"])))))
    elif outcome == "error":
        first, _, rest = message.partition("\n")
        ET.SubElement(case, "error", message=first).text = rest
    elif outcome == "skip":
        ET.SubElement(case, "skipped", message=message)
    elif outcome == "inconclusive":
        message = _clean(f"inconclusive: {comparison(deciding(line)[0])}")
        if allow_inconclusive:
            ET.SubElement(case, "skipped", message=message)
        else:
            ET.SubElement(case, "failure", message=message, type="inconclusive")
    return case


def _clean(text: str) -> str:
    """The text with escapes for what XML cannot hold: control characters and surrogates."""
    return printable(text, keep="\t\n")
