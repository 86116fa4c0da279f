"""A baseline: a text file of the results that are known, a line a judgement, which `git` merges line by line.

The first line names the form and the seed. The others are sorted, and their fields are parted by tabs:

    case  engine  tier  quantity    outcome  measured  expected  criterion
    case  engine  tier  operations  counted  name=number ...
    case  engine  tier  -           skip | error

Numbers are kept to the digits by which two runs can be told apart: two of a standard error, a hundredth of a tolerance
or less. There is no time, machine or version in it. Form: docs/regression.md.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple, get_args

from crosscheck.errors import UsageError
from crosscheck.files import shown_path, unreadable
from crosscheck.regression.results import Case, Key, Number, Results
from crosscheck.report import numbers
from crosscheck.text import shortened
from crosscheck.verdict import Kind

FILE = "crosscheck-baseline.txt"
FORM = 1
_HEAD = re.compile(r"# particle-crosscheck baseline, form (\d+), seed (\d+)\b.*")
_FIELDS = ("case", "engine", "tier", "quantity", "outcome", "measured", "expected", "criterion")
_CONFLICT = ("<<<<<<<", "=======", ">>>>>>>", "|||||||")
_NOT_FINITE = "not finite"
_NUMBER = re.compile(r"([-+]?\d+(?:\.\d*)?)(?:\((\d+)\))?(?:e([-+]?\d+))?")
#: Stands among the numbers of operations: how many scenes the engine has refused.
_REFUSED = "refused"
#: Significant digits of bounds and limits.
_DIGITS = 4
#: More digits are those of a double.
_MOST_DIGITS = 16


# -- text -------------------------------------------------------------------------------------------------------------


def lines_of(results: Results) -> dict[Key, list[str]]:
    """The lines of each case of a run. results: of the run."""
    return {key: _lines(key, case) for key, case in results.cases.items()}


def text_of(seed: int, lines: Iterable[str]) -> str:
    """The text of a baseline. seed: of the runs that it is compared with. lines: of cases, in any order."""
    head = f"# particle-crosscheck baseline, form {FORM}, seed {seed}; {' '.join(_FIELDS)}; see docs/regression.md"
    return "".join(line + "\n" for line in (head, *sorted(lines)))


def _lines(key: Key, case: Case) -> list[str]:
    head = [*key, case.tier]
    if not case.judged:
        return ["\t".join([*head, "-", case.outcome])]
    lines = ["\t".join([*head, name, *_cells(number)]) for name, number in case.numbers.items()]
    counters = {**case.counters, **({} if case.refused is None else {_REFUSED: case.refused})}
    if counters:
        counted = " ".join(f"{name}={number}" for name, number in sorted(counters.items()))
        lines.append("\t".join([*head, "operations", "counted", counted]))
    return lines


def _cells(number: Number) -> tuple[str, str, str, str]:
    """Outcome, measured value, expected value and criterion of a number, as a baseline has them."""
    if number.sense != "both":
        sign = "<=" if number.sense == "at_most" else ">="
        limit = f"{sign} {_shown(number.tolerance)}"
        return number.outcome, _shown(number.measured), limit, number.kind
    if number.kind == "statistical":
        u, e = number.uncertainty, number.expected_uncertainty
        measured = numbers.with_uncertainty(number.measured, u) if u else _exact(number.measured)
        expected = numbers.with_uncertainty(number.expected, e) if e else _to(number.expected, u)
        freedom = "" if number.freedom is None else f" {number.freedom:.3g}"
        return number.outcome, measured, expected, f"statistical{freedom}"
    step = number.tolerance
    return number.outcome, _to(number.measured, step), _to(number.expected, step), f"{number.kind} {_shown(step)}"


def same_text(one: Number, other: Number) -> bool:
    """Whether a baseline has the same text for the values of `one` number and the `other`."""
    return _cells(one)[1:3] == _cells(other)[1:3]


def _shown(value: float | None) -> str:
    return _NOT_FINITE if value is None else numbers.plain(value, _DIGITS)


def _exact(value: float | None) -> str:
    return _NOT_FINITE if value is None else repr(float(value))


def _to(value: float | None, scale: float | None) -> str:
    """The value to a hundredth of the scale or a little less, so that rounding is far below what is compared.

    The same for the value and the scale that are read from the text: both are rounded first.
    """
    if value is None or not scale or not math.isfinite(scale):
        return _exact(value)
    place = int(f"{scale:.1e}".partition("e")[2]) - 2
    step = float(f"1e{place}")
    steps = value / step if step else math.inf  # no step: below the smallest number
    if not abs(steps) < 10.0**_MOST_DIGITS:
        return _exact(value)
    number = round(steps)
    return numbers.plain(float(f"{number}e{place}"), len(str(abs(number))))


# -- reading ----------------------------------------------------------------------------------------------------------


class Baseline(NamedTuple):
    """A baseline as it was read.

    results: to compare runs with. lines: of each case, as they are in the file. rest: other lines, which are comments.
    """

    results: Results
    lines: Mapping[Key, list[str]]
    rest: list[str]


def is_baseline(path: Path) -> bool:
    """Whether a file begins as a baseline does. path: of a file or a directory; it need not exist."""
    return not unreadable(path) and path.open("rb").read(len(_BEGINNING)) == _BEGINNING


_BEGINNING = b"# particle-crosscheck baseline"


def read_baseline(path: Path) -> Baseline:
    """The baseline in a file.

    path: of the file. UsageError if there is none, or a line is not of its form: it names file and line.
    """
    name = shown_path(path)
    reason = unreadable(path)
    if reason:
        raise UsageError(f"{name}: no baseline ({reason}); make one from a run: crosscheck baseline accept")
    try:
        first, *rest = path.read_text(encoding="utf-8").split("\n")
    except UnicodeDecodeError as error:
        raise UsageError(f"{name}: not a baseline: not UTF-8 (byte {error.start})") from None
    head = _HEAD.fullmatch(first.rstrip("\r"))
    if head is None:
        raise UsageError(f"{name}:1: not a baseline: it begins with '{shortened(first)}'; see docs/regression.md")
    if int(head[1]) != FORM:
        raise UsageError(f"{name}:1: a baseline of form {head[1]}, this version reads {FORM}: make it anew")
    reader = _Reader()
    for number, line in enumerate(rest, 2):
        try:
            reader.take(line.rstrip("\r"), number)
        except ValueError as error:
            raise UsageError(f"{name}:{number}: not a line of a baseline: {error}; mend or remove the line") from None
    return Baseline(Results(name, reader.cases(), int(head[2]), rounded=True), reader.lines, reader.rest)


class _Reader:
    """Takes lines of a baseline, one after the other."""

    def __init__(self) -> None:
        self.lines: dict[Key, list[str]] = {}
        self.rest: list[str] = []
        self._taken: dict[tuple[str, ...], int] = {}
        self._tiers: dict[Key, str] = {}
        self._outcomes: dict[Key, str] = {}
        self._numbers: dict[Key, dict[str, Number]] = {}
        self._counters: dict[Key, dict[str, int]] = {}

    def take(self, line: str, number: int) -> None:
        """Takes a line. number: of the line in its file. ValueError if it is not of the form."""
        if line.startswith(_CONFLICT):
            raise ValueError("the mark of a merge conflict")
        if not line.strip():
            return
        if line.startswith("#"):
            self.rest.append(line)
            return
        fields = line.split("\t")
        if len(fields) < 5:
            raise ValueError(f"it has {len(fields)} fields parted by tabs, not 5 to 8")
        case, engine, tier, quantity, outcome, *cells = fields
        key = (case, engine)
        if tier not in ("quick", "full") or self._tiers.setdefault(key, tier) != tier:
            raise ValueError(f"tier '{shortened(tier)}': quick or full, the same in all lines of a case")
        name = (*key, "counted" if outcome == "counted" else "", quantity)
        if name in self._taken:
            raise ValueError(f"the same quantity is in line {self._taken[name]}")
        self._taken[name] = number
        self._store(key, quantity, outcome, cells)
        self.lines.setdefault(key, []).append(line)

    def _store(self, key: Key, quantity: str, outcome: str, cells: list[str]) -> None:
        self._numbers.setdefault(key, {})
        if outcome in ("skip", "error"):
            if cells or key in self.lines:
                raise ValueError(f"a case '{outcome}' has one line of 5 fields")
            self._outcomes[key] = outcome
        elif key in self._outcomes:
            raise ValueError(f"a case '{self._outcomes[key]}' has one line of 5 fields")
        elif outcome == "counted":
            self._counters[key] = _counters(cells)
        elif outcome in ("pass", "fail", "inconclusive"):
            if len(cells) != 3:
                raise ValueError(f"it has {len(cells) + 5} fields parted by tabs, not 8: {', '.join(_FIELDS)}")
            self._numbers[key][quantity] = _number(outcome, *cells)
        else:
            raise ValueError(f"outcome '{shortened(outcome)}': pass, fail, inconclusive, skip, error or counted")

    def cases(self) -> dict[Key, Case]:
        """The cases of all lines."""
        return {key: self._case(key, found) for key, found in self._numbers.items()}

    def _case(self, key: Key, found: Mapping[str, Number]) -> Case:
        counters = dict(self._counters.get(key, {}))
        refused = counters.pop(_REFUSED, None)
        outcome = self._outcomes.get(key) or _worst(found)
        return Case(self._tiers[key], outcome, numbers=found, counters=counters, refused=refused)


def _worst(found: Mapping[str, Number]) -> str:
    outcomes = {one.outcome for one in found.values()}
    return next((one for one in ("fail", "inconclusive") if one in outcomes), "pass")


def _counters(cells: list[str]) -> dict[str, int]:
    if len(cells) != 1:
        raise ValueError("a line of operations has 6 fields")
    found = {}
    for entry in cells[0].split(" "):
        name, _, number = entry.partition("=")
        if not name or not number.isascii() or not number.isdigit() or name in found:
            raise ValueError(f"'{shortened(entry)}': a number of operations is written name=number, each once")
        found[name] = int(number)
    return found


def _number(outcome: str, measured: str, expected: str, criterion: str) -> Number:
    kind, _, scale = criterion.partition(" ")
    if kind not in get_args(Kind):
        raise ValueError(f"criterion '{shortened(criterion)}': begins with one of {', '.join(get_args(Kind))}")
    value, u = _value(measured)
    sign, _, limit = expected.partition(" ")
    if sign in ("<=", ">="):
        if scale:
            raise ValueError(f"criterion '{shortened(criterion)}': one of a limit has no number")
        bound, _ = _value(limit)
        return Number(outcome, kind, "at_most" if sign == "<=" else "at_least", value, None, bound, None, bound, None)
    reference, e = _value(expected)
    known = _value(scale)[0] if scale else None
    if kind == "statistical":
        return Number(outcome, kind, "both", value, u or 0.0, reference, e or 0.0, None, known)
    if known is None or kind not in ("round_off", "order"):
        raise ValueError(f"criterion '{shortened(criterion)}': round_off and order have a tolerance, bounds a limit")
    return Number(outcome, kind, "both", value, None, reference, None, known, None)


def _value(text: str) -> tuple[float | None, float | None]:
    """The number in a text as 1.2345(67)e-8, and its uncertainty, or None; None for both: not finite."""
    if text == _NOT_FINITE:
        return None, None
    found = _NUMBER.fullmatch(text)
    if found is None:
        raise ValueError(f"'{shortened(text)}' is not a number")
    digits, bracket, exponent = found.groups()
    power = f"e{exponent}" if exponent else ""
    value = float(digits + power)
    if not math.isfinite(value):
        raise ValueError(f"'{shortened(text)}' is too large")
    if bracket is None:
        return value, None
    places = len(digits.partition(".")[2])
    return value, float(f"{bracket}e{int(exponent or 0) - places}")


# -- edits ------------------------------------------------------------------------------------------------------------


class Accepted(NamedTuple):
    """A baseline that was edited. text: of the file. added, removed: numbers of lines. cases: those accepted."""

    text: str
    added: int
    removed: int
    cases: Mapping[Key, Case]


def accept(before: Baseline | None, run: Results, keys: Iterable[Key]) -> Accepted:
    """A baseline in which the lines of some cases are those of a run; the others are as they were, byte by byte.

    before: the baseline; None: there is none yet. run: the run. keys: its cases that are accepted. UsageError if the
    run had another seed than the baseline.
    """
    taken = {key: run.cases[key] for key in keys}
    seed = run.seed
    if seed is None:
        raise UsageError(f"{run.name}: its lines are of several seeds; run again")
    if before is not None and before.results.seed != seed:
        raise UsageError(
            f"{before.results.name}: of seed {before.results.seed}, and the run in {run.name} of seed {seed}; run with "
            f"--seed {before.results.seed}, or remove the file to begin a new one"
        )
    old = {} if before is None else dict(before.lines)
    new = old | {key: _lines(key, case) for key, case in taken.items()}
    was, now = ({line for lines in one.values() for line in lines} for one in (old, new))
    rest = [] if before is None else before.rest
    return Accepted(text_of(seed, [*rest, *now]), len(now - was), len(was - now), taken)
