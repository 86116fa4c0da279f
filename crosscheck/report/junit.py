"""JUnit XML: one test case a verdict, for tools that show test results."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from crosscheck.files import naming
from crosscheck.record import Line, deciding
from crosscheck.report.numbers import deviation, expected, measured
from crosscheck.text import printable


def write_junit(lines: Iterable[Line], path: Path) -> None:
    """Writes one test suite; a failed verdict is a failure, an inconclusive one is skipped, with its reason.

    lines: of the record. path: the file to write.
    """
    cases = [_case(line) for line in lines]
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
    ET.SubElement(root, "testsuite", totals).extend(cases)
    ET.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    with naming(path):
        ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _case(line: Line) -> ET.Element:
    case = ET.Element(
        "testcase",
        classname=_clean(line["check"].replace("/", ".")),
        name=_clean(f"{line['variant']}[{line['engine']}]"),
        time=f"{line['cost'].get('seconds') or 0.0:.3f}",
    )
    outcome, message = line["outcome"], _clean(line["message"])
    if outcome == "fail":
        red = deciding(line)
        failure = ET.SubElement(case, "failure", message=_clean(_comparison(red[0])), type=red[0]["criterion"]["kind"])
        text = [part for one in red for part in (_comparison(one), one["criterion"]["why"], one["note"])]
        # the first comparison is the message
        failure.text = _clean("\n".join(dict.fromkeys(filter(None, (*text[1:], line["note"], line["message"])))))
    elif outcome == "error":
        first, _, rest = message.partition("\n")
        ET.SubElement(case, "error", message=first).text = rest
    elif outcome == "skip":
        ET.SubElement(case, "skipped", message=message)
    elif outcome == "inconclusive":
        ET.SubElement(case, "skipped", message=_clean(f"inconclusive: {_comparison(deciding(line)[0])}"))
    return case


def _comparison(judgement: dict[str, Any]) -> str:
    off = f"measured {measured(judgement)}, expected {expected(judgement)}, off by {deviation(judgement)}"
    return f"{judgement['quantity']}: {off}"


def _clean(text: str) -> str:
    """The text with escapes for what XML cannot hold: control characters and surrogates."""
    return printable(text, keep="\t\n")
