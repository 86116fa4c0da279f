"""Results as two runs are compared by them: numbers of judgements, numbers of operations, computing times."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from crosscheck.record import Line, case_name
from crosscheck.text import printable

#: Entries of the cost of a case that are no numbers of operations: the same run does not repeat them.
_MEASURED = ("seconds", "wall", "cpu", "compile", "peak_bytes")


class Number(NamedTuple):
    """What a judgement says of one number. Of what is not finite, or not known: None.

    outcome: "pass", "fail" or "inconclusive". kind, sense: of its criterion, see `crosscheck.verdict`. measured,
    uncertainty, expected, expected_uncertainty: as there. tolerance: the allowed deviation, where the criterion is
    `round_off` or `order`; the limit, where the number may lie on one side of it alone; else None. freedom: degrees of
    freedom of the standard error of a statistical judgement.
    """

    outcome: str
    kind: str
    sense: str
    measured: float | None
    uncertainty: float | None
    expected: float | None
    expected_uncertainty: float | None
    tolerance: float | None
    freedom: float | None

    @property
    def off(self) -> float | None:
        """The measured value less the expected one, which two runs are compared by: what is expected may be random too.

        It is so where it follows from another run, or from a temperature of the same one.
        """
        return None if self.measured is None or self.expected is None else self.measured - self.expected

    @property
    def share(self) -> float:
        """Of a bound, the measured value as a share of the limit, or the inverse: red above 1, infinite for none."""
        if self.measured is None or self.tolerance is None:
            return math.inf
        over, under = self.measured, self.tolerance
        if self.sense == "at_least":
            over, under = under, over
        if over > 0 and under > 0:
            return over / under
        return math.inf if self.outcome == "fail" else 0.0

    @property
    def judgement(self) -> dict[str, Any]:
        """As the record has it, with what is needed to show the number."""
        return {
            "outcome": self.outcome,
            "measured": self.measured,
            "uncertainty": self.uncertainty,
            "expected": self.expected,
            "expected_uncertainty": self.expected_uncertainty,
            "criterion": {"kind": self.kind, "sense": self.sense, "tolerance": self.tolerance},
        }


@dataclass(frozen=True)
class Case:
    """What came of a case.

    tier: "quick" or "full". outcome: of its verdict. message: why it was skipped or ended in an error. numbers: what
    was judged, by its name, see `names`. counters: numbers of operations, by the names of `Cost`. cpu: seconds; None:
    not known. refused: number of scenes that the engine could not run, and that were left out; None: not known.
    """

    tier: str
    outcome: str
    message: str = ""
    numbers: Mapping[str, Number] = field(default_factory=dict)
    counters: Mapping[str, int] = field(default_factory=dict)
    cpu: float | None = None
    refused: int | None = None

    @property
    def judged(self) -> bool:
        """Whether there is a verdict on the engine: neither a skip nor an error."""
        return self.outcome not in ("skip", "error")


#: The name of a case and its engine.
Key = tuple[str, str]


@dataclass(frozen=True)
class Results:
    """The results of a run.

    name: where they are from, as the user has named it. cases: by name and engine. seed: of the suite; None: lines of
    several seeds. rounded: the numbers are those of a baseline, to the digits that it keeps. provenance: of a run, see
    docs/record.md; empty: of a baseline.
    """

    name: str
    cases: Mapping[Key, Case]
    seed: int | None
    rounded: bool = False
    provenance: Mapping[str, Any] = field(default_factory=dict)


def of_lines(lines: Iterable[Line], name: str) -> Results:
    """The results in lines of a record. name: where they are from."""
    kept = list(lines)
    seeds = {line["provenance"]["seed"] for line in kept}
    cases = {(printable(case_name(line)), printable(line["engine"])): _case(line) for line in kept}
    source = kept[-1]["provenance"] if kept else {}
    return Results(name, cases, seeds.pop() if len(seeds) == 1 else None, provenance=source)


def names(quantities: Iterable[str]) -> list[str]:
    """Names of the judgements of a case: their quantities, numbered from the second of the same on, "x", "x (2)".

    A run may judge several numbers of one quantity; their order is always the same.
    """
    found: list[str] = []
    counts: Counter[str] = Counter()
    for quantity in map(printable, quantities):
        counts[quantity] += 1
        name = quantity if counts[quantity] == 1 else f"{quantity} ({counts[quantity]})"
        while name in found:  # a quantity that is called so itself
            counts[quantity] += 1
            name = f"{quantity} ({counts[quantity]})"
        found.append(name)
    return found


def _case(line: Line) -> Case:
    judged = line["judgements"]
    quantities = names(one["quantity"] for one in judged)
    return Case(
        line["tier"],
        line["outcome"],
        line["message"],
        {name: _number(one) for name, one in zip(quantities, judged, strict=True)},
        {
            name: int(value)
            for name, value in line["cost"].items()
            if value is not None and name not in _MEASURED and (value or name not in _NOT_COUNTED_OR_NONE)
        },
        line["cost"].get("cpu"),
        line["refused"],
    )


#: Of these, 0 may mean that the engine does not count them.
_NOT_COUNTED_OR_NONE = ("steps", "evaluations", "events")


def _number(judgement: Mapping[str, Any]) -> Number:
    criterion = judgement["criterion"]
    by_error = criterion["kind"] == "statistical" and criterion["sense"] == "both"
    return Number(
        judgement["outcome"],
        criterion["kind"],
        criterion["sense"],
        judgement["measured"],
        judgement["uncertainty"] if by_error else None,
        judgement["expected"],
        judgement["expected_uncertainty"] if by_error else None,
        None if by_error else criterion["tolerance"],
        judgement.get("freedom") if by_error else None,
    )
