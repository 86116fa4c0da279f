"""The matrix of stiff and extreme cases in the report: what each must give, and what it gave by which method."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import Any

from crosscheck.checks import all_checks
from crosscheck.checks.extreme.matrix import ANSWER, GROUP, Row
from crosscheck.engines.registry import engine_class, shipped_engines
from crosscheck.record import Line
from crosscheck.report import numbers


@dataclass
class Group:
    """Methods of a case with the same expectations.

    expected: of each judgement, quantity and what was expected. methods: name, engine, outcome, and what was measured
    in each judgement, of each verdict; after a skip or an error the message.
    """

    expected: tuple[tuple[str, str], ...]
    methods: list[tuple[str, str, str, tuple[str, ...]]] = field(default_factory=list)


@dataclass
class Case:
    """A case of a check. check: its name. what: the case in words. groups: see `Group`."""

    check: str
    what: str
    groups: dict[tuple[tuple[str, str], ...], Group] = field(default_factory=dict)


@cache
def _words() -> dict[tuple[str, str], Row]:
    """The declared rows by check and variant, of all methods of the engines that come with the suite."""
    return {
        (check.name, variant.name): variant.value
        for check in all_checks()
        if check.name.startswith(GROUP)
        for engine in shipped_engines()
        for variant in check.offered(engine_class(engine).schemes)
    }


def matrix(lines: list[Line]) -> list[Case]:
    """The cases of the group in a record, in the order of checks and of their declaration; lines: of the record."""
    cases: dict[tuple[str, str], Case] = {}
    order = {key: number for number, key in enumerate(_words())}
    own = [line for line in lines if line["check"].startswith(GROUP)]
    own.sort(key=lambda line: (line["check"], order.get((line["check"], line["variant"]), len(order)), line["engine"]))
    for line in own:
        name, _, method = line["variant"].rpartition("/")
        row = _words().get((line["check"], line["variant"]))
        case = cases.setdefault((line["check"], name), Case(line["check"], name if row is None else row.case.what))
        judgements = line["judgements"]
        expected = tuple(_expected(one) for one in judgements)
        group = case.groups.setdefault(expected, Group(expected))
        found = tuple(_found(one) for one in judgements) or (line["message"].partition("\n")[0],)
        group.methods.append((method, line["engine"], line["outcome"], found))
    return list(cases.values())


def _expected(judgement: dict[str, Any]) -> tuple[str, str]:
    """Quantity, and what was expected: words, or a number with its tolerance where it is a value."""
    quantity, criterion = judgement["quantity"], judgement["criterion"]
    if quantity.startswith(ANSWER):
        return "answer", quantity.removeprefix(ANSWER)
    text = numbers.expected(judgement)
    if criterion["sense"] == "both" and criterion["kind"] != "statistical" and criterion["tolerance"] is not None:
        text += f" ± {numbers.plain(criterion['tolerance'], 2)}"
    return quantity, text


def _found(judgement: dict[str, Any]) -> str:
    """What was measured; of an answer whether it was this one."""
    if judgement["quantity"].startswith(ANSWER):
        return "said" if judgement["outcome"] == "pass" else "not said"
    return numbers.measured(judgement)
