"""JUnit XML: one test case a verdict, for tools that show test results.

There is no standard. This is what two schemas have in common that CI servers check files against: that of Jenkins
(its xunit plugin, junit-10.xsd) and that of the reports of Apache Ant (github.com/windyroad/JUnit-Schema). Properties
belong to a suite in both, and to a test case in neither: so a check is a suite, and its properties hold all judgements
of its cases.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from crosscheck.files import naming
from crosscheck.record import Line, case_name, deciding
from crosscheck.report import numbers
from crosscheck.report.numbers import comparison
from crosscheck.status import false_alarms
from crosscheck.text import printable

#: The suite of what is of no check.
_RUN = "crosscheck"
#: A time as the schemas have it, in UTC; and one where a line has none, which they ask for.
_TIME, _NO_TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d"), "1970-01-01T00:00:00"


class Mark(NamedTuple):
    """What a baseline says of a case.

    state: "known": it is not green, and is known not to be; "failure", "error": it is to be shown as one, whatever its
    verdict. message: why.
    """

    state: Literal["known", "failure", "error"]
    message: str


def write_junit(
    lines: Iterable[Line],
    path: Path,
    unjudged: Sequence[str] = (),
    allow_inconclusive: bool = False,
    marks: Mapping[tuple[str, str], Mark] | None = None,
) -> None:
    """Writes a suite for each check, which other tools show as green only if it may be taken for a success.

    A failed verdict is a failure, and so is an inconclusive one, of the type "inconclusive". lines: of the record.
    path: the file to write. unjudged: sentences on what was not judged, each an error of the suite `crosscheck`.
    allow_inconclusive: inconclusive verdicts are skipped test cases, with their reason. marks: what a baseline says of
    cases, by their name and engine.
    """
    judged = list(lines)
    suites: dict[str, list[Line]] = {}
    for line in judged:
        suites.setdefault(line["check"], []).append(line)
    alarms = false_alarms(judged).removeprefix("false alarms: ")
    properties = [("false alarms", alarms)] if alarms else []
    root = ET.Element("testsuites")
    _suite(root, _RUN, properties, [_problem(reason) for reason in unjudged], judged)
    for check, own in suites.items():
        cases = [_case(line, allow_inconclusive, (marks or {}).get((case_name(line), line["engine"]))) for line in own]
        of_judgements = [one for line in own for one in _properties(line)]
        _suite(root, check.replace("/", "."), of_judgements, cases, own)
    ET.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    with naming(path):
        ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _suite(
    root: ET.Element, name: str, properties: Sequence[tuple[str, str]], cases: Sequence[ET.Element], of: Sequence[Line]
) -> None:
    """Appends a suite. of: the lines whose first time is that of the suite."""
    times = [time[0] for line in of if (time := _TIME.match(line["time"]))]
    found = [child.tag for case in cases for child in case]
    suite = ET.SubElement(
        root,
        "testsuite",
        name=_clean(name),
        package="crosscheck",
        id=str(len(root)),
        timestamp=min(times, default=_NO_TIME),
        hostname="localhost",
        tests=str(len(cases)),
        failures=str(found.count("failure")),
        errors=str(found.count("error")),
        skipped=str(found.count("skipped")),
        time=f"{sum(float(case.attrib['time']) for case in cases):.3f}",
    )
    listed = ET.SubElement(suite, "properties")
    for key, value in properties:
        ET.SubElement(listed, "property", name=_clean(key), value=_clean(value))
    suite.extend(cases)
    ET.SubElement(suite, "system-out")
    ET.SubElement(suite, "system-err")


def _properties(line: Line) -> list[tuple[str, str]]:
    """Each judgement of a verdict: its case and quantity, and its numbers as name=value."""
    return [
        (
            f"{line['variant']}[{line['engine']}] {one['quantity']}",
            "; ".join(f"{name}={value}" for name, value in _values(one).items()),
        )
        for one in line["judgements"]
    ]


def _values(one: Mapping[str, Any]) -> dict[str, str]:
    criterion = one["criterion"]
    return {
        "outcome": one["outcome"],
        "measured": numbers.measured(one),
        "uncertainty": numbers.plain(one["uncertainty"], 2),
        "expected": numbers.expected(one),
        "deviation": f"{'∞' if one['deviation'] is None else numbers.plain(one['deviation'], 3)} tolerances",
        "criterion": criterion["kind"],
        "tolerance": numbers.plain(criterion["tolerance"], 3),
    }


def _problem(reason: str) -> ET.Element:
    """An error of no case: a suite without any would be green."""
    case = ET.Element("testcase", classname=_RUN, name=_clean(reason.partition(":")[0]), time="0.000")
    ET.SubElement(case, "error", type="unjudged", message=_clean(reason))
    return case


def _case(line: Line, allow_inconclusive: bool, mark: Mark | None) -> ET.Element:
    case = ET.Element(
        "testcase",
        classname=_clean(line["check"].replace("/", ".")),
        name=_clean(f"{line['variant']}[{line['engine']}]"),
        time=f"{line['cost'].get('seconds') or 0.0:.3f}",
    )
    outcome, message = line["outcome"], _clean(line["message"])
    if mark is not None and mark.state == "known":
        ET.SubElement(case, "skipped", message=_clean(mark.message))
    elif mark is not None and outcome not in ("fail", "error"):
        ET.SubElement(case, mark.state, type="regression", message=_clean(mark.message))
    elif outcome == "fail":
        red = deciding(line)
        failure = ET.SubElement(case, "failure", message=_clean(comparison(red[0])), type=red[0]["criterion"]["kind"])
        text = [part for one in red for part in (comparison(one), one["criterion"]["why"], one["note"])]
        # the first comparison is the message
        rest = (*text[1:], line["note"], line["message"], "" if mark is None else mark.message)
        failure.text = _clean("\n".join(dict.fromkeys(filter(None, rest))))
    elif outcome == "error":
        first, _, rest_of_it = message.partition("\n")
        ET.SubElement(case, "error", type="error", message=first).text = rest_of_it
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
