"""Error against run time: which method reaches an error at the least cost, from the ladders of a record.

A cost between two runs of a ladder is interpolated on the straight line between them, in the logarithms of error, cost
and step. Nothing is extrapolated: an error below all of a ladder's is not reached.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

from crosscheck.engines.registry import engine_order
from crosscheck.record import Line, case_name
from crosscheck.report.numbers import count, plain, seconds

#: Errors that methods are compared at; of cases that span few decades, those between them too.
TARGETS = tuple(10.0**-k for k in range(2, 13, 2))
_EACH = tuple(10.0**-k for k in range(1, 13))
#: Decades between the largest and the smallest error of a case below which every decade is a target.
_FEW = 4.0


def power(target: float) -> str:
    """A power of ten, as it is written in code; target: the number."""
    return f"1e{round(math.log10(target))}"


def times(factor: float) -> str:
    """A factor to two digits: 1.2, 12, 120; factor: 1 or more."""
    return f"{factor:.1f}" if factor < 9.95 else f"{float(f'{factor:.1e}'):.0f}"


@dataclass(frozen=True)
class Point:
    """One run of a ladder. control: step or tolerance. error, uncertainty: in the unit of the case. cpu, low, high: CPU
    time, s, median and ends of the repeats. count: what was counted, or NaN. failure: why it says nothing, or "".
    """

    control: float
    error: float
    uncertainty: float
    cpu: float
    low: float
    high: float
    count: float
    failure: str

    @property
    def good(self) -> bool:
        """Whether it can be compared with others."""
        return not self.failure and 0 < self.error < math.inf and self.cpu > 0


@dataclass(frozen=True)
class Climb:
    """The ladder of one method in a case.

    engine, label: of the method. family: of methods that are drawn alike. control: name of what is varied. points: the
    runs, in the order of the ladder. count_label: what was counted. case, options: of the command that runs it again:
    `crosscheck run CASE OPTIONS`.
    """

    engine: str
    label: str
    family: str
    control: str
    points: tuple[Point, ...]
    count_label: str
    case: str
    options: str

    @property
    def name(self) -> str:
        """The method with its engine."""
        return f"{self.label}, {self.engine}"

    @property
    def good(self) -> list[Point]:
        """The runs that can be compared."""
        return [point for point in self.points if point.good]


@dataclass(frozen=True)
class Reached:
    """How a method reaches an error.

    climb: the method. control, cpu, count: its step, CPU time and count there, interpolated. between: whether the error
    is between two runs; else the coarsest run that can be compared is already as good. spread: relative uncertainty of
    the CPU time, from half the range of the repeats of the nearest run, and from that of its error.
    """

    climb: Climb
    control: float
    cpu: float
    count: float
    between: bool
    spread: float

    @property
    def shown(self) -> str:
        """The step, in words."""
        return f"{self.climb.control} = {plain(self.control, 2)}"

    @property
    def time(self) -> str:
        """The CPU time, in words that stay together in one line."""
        return f"{'' if self.between else '≤ '}{seconds(self.cpu)}".replace(" ", "\u00a0")

    @property
    def timed(self) -> str:
        """The CPU time with its uncertainty, in words."""
        percent = 100 * self.spread
        return f"{self.time} ±\u00a0{percent:.0f}\u00a0%" if percent >= 0.5 else self.time

    @property
    def counted(self) -> str:
        """The count, in words; "" if nothing was counted."""
        return f"{count(self.count)} {self.climb.count_label}" if math.isfinite(self.count) else ""


class Cell(NamedTuple):
    """The cheapest method of an engine at a target. reached: how; factor: its CPU time over the least of all."""

    reached: Reached
    factor: float

    @property
    def times(self) -> str:
        """The factor, in words."""
        return "best" if self.factor == 1.0 else f"{times(self.factor)}\u00a0×"


class Row(NamedTuple):
    """What it takes to reach an error. target: the error. cells: by engine. best: the cheapest of all."""

    target: float
    cells: dict[str, Cell]
    best: Reached


@dataclass(frozen=True)
class Case:
    """A case with the ladders of all methods.

    title: what is simulated. unit: what the error is. check: name of its check. anchor: its id in the page. climbs: the
    ladders, those of the engines in the order of the report.
    """

    title: str
    unit: str
    check: str
    anchor: str
    climbs: list[Climb] = field(default_factory=list)

    @property
    def engines(self) -> list[str]:
        """The engines that take part, in the order of the report."""
        return sorted({climb.engine for climb in self.climbs}, key=engine_order)

    @property
    def families(self) -> list[str]:
        """The families of methods, in the order of their names."""
        return sorted({climb.family for climb in self.climbs})

    @property
    def commands(self) -> list[tuple[str, list[str]]]:
        """Commands that run the methods again, each with the names that METHOD stands for in it; one: as it is."""
        found: dict[tuple[str, str], list[str]] = {}
        for climb in self.climbs:
            check, _, method = climb.case.rpartition("/")
            found.setdefault((check, climb.options), []).append(method)
        return [
            (f"crosscheck run {check}/{methods[0] if len(methods) == 1 else 'METHOD'} {options}", methods)
            for (check, options), methods in found.items()
        ]

    @property
    def failed(self) -> int:
        """Number of runs that say nothing."""
        return sum(not point.good for climb in self.climbs for point in climb.points)

    @property
    def runs(self) -> int:
        """Number of runs, repeats apart."""
        return sum(len(climb.points) for climb in self.climbs)

    @property
    def targets(self) -> tuple[float, ...]:
        """The errors that methods are compared at."""
        errors = [point.error for climb in self.climbs for point in climb.good]
        few = bool(errors) and math.log10(max(errors) / min(errors)) < _FEW
        return _EACH if few else TARGETS

    @property
    def rows(self) -> list[Row]:
        """For each target that a method reaches: the cheapest method of each engine."""
        return [row for row in map(self._row, self.targets) if row is not None]

    def _row(self, target: float) -> Row | None:
        found = [one for one in (reached(climb, target) for climb in self.climbs) if one is not None]
        if not found:
            return None
        best = min(found, key=lambda one: one.cpu)
        cells = {}
        for engine in self.engines:
            of_engine = [one for one in found if one.climb.engine == engine]
            if of_engine:
                cheapest = min(of_engine, key=lambda one: one.cpu)
                cells[engine] = Cell(cheapest, cheapest.cpu / best.cpu)
        return Row(target, cells, best)

    @property
    def front(self) -> list[tuple[Climb, Point]]:
        """The runs that no other run beats in both error and CPU time, the cheapest first."""
        every = sorted(
            ((point.cpu, point.error, climb, point) for climb in self.climbs for point in climb.good),
            key=lambda one: one[:2],
        )
        found: list[tuple[Climb, Point]] = []
        for _, error, climb, point in every:
            if not found or error < found[-1][1].error:
                found.append((climb, point))
        return found

    @property
    def answer(self) -> list[str]:
        """Which method to take, a sentence for each stretch of errors with the same one."""
        sentences = []
        for best, rows in _stretches(self.rows):
            first, last = rows[0].target, rows[-1].target
            where = f"For an error of {power(first)}" + (f" to {power(last)}" if first != last else "")
            cost = " to ".join(dict.fromkeys((rows[0].best.time, rows[-1].best.time)))
            peers = sorted({cell.reached.climb.engine for row in rows for cell in row.cells.values()} - {best.engine})
            others = []
            for peer in peers:
                factors = [row.cells[peer].factor for row in rows if peer in row.cells]
                low, high = times(min(factors)), times(max(factors))
                others.append(f"{peer} takes {low if low == high else f'{low} to {high}'} times as long")
            sentences.append(f"{where}: {best.name}, in {cost}{'; ' if others else ''}{', '.join(others)}.")
        lowest = min((point.error for climb in self.climbs for point in climb.good), default=math.nan)
        if math.isfinite(lowest):
            sentences.append(f"The smallest error of all is {plain(lowest, 2)}.")
        return sentences


def _stretches(rows: Iterable[Row]) -> Iterator[tuple[Climb, list[Row]]]:
    """Neighbouring rows with the same best method."""
    together: list[Row] = []
    for row in rows:
        if together and row.best.climb != together[-1].best.climb:
            yield together[0].best.climb, together
            together = []
        together.append(row)
    if together:
        yield together[0].best.climb, together


def reached(climb: Climb, target: float) -> Reached | None:
    """How a method reaches an error at the least cost; None if no run of its ladder is as good.

    climb: its ladder. target: the error.
    """
    found = []
    good = climb.good
    for point in good:
        if point.error <= target:
            found.append(Reached(climb, point.control, point.cpu, point.count, point is not good[0], _spread(point)))
    for one, other in pairwise(climb.points):
        if not (one.good and other.good):
            continue
        coarse, fine = (one, other) if one.error > other.error else (other, one)
        if coarse.error > target > fine.error:
            share = math.log(coarse.error / target) / math.log(coarse.error / fine.error)
            nearer = fine if share > 0.5 else coarse
            fall = math.log(coarse.error / fine.error) / abs(math.log(fine.cpu / coarse.cpu) or math.inf)
            found.append(
                Reached(
                    climb,
                    _between(coarse.control, fine.control, share),
                    _between(coarse.cpu, fine.cpu, share),
                    _between(coarse.count, fine.count, share),
                    True,
                    _spread(nearer, fall),
                )
            )
    return min(found, key=lambda one: one.cpu, default=None)


def _between(first: float, second: float, share: float) -> float:
    """From the first to the second number, by their logarithms."""
    return first * (second / first) ** share


def _spread(point: Point, fall: float = math.inf) -> float:
    """Relative uncertainty of a cost; fall: the power of the cost by which the error falls."""
    unknown = point.uncertainty / point.error / fall if fall > 0 else 0.0
    return math.hypot((point.high - point.low) / point.cpu / 2, unknown)


# -- from the record -----------------------------------------------------------------------------------------


def cases(check: str, anchor: str, lines: Iterable[Line]) -> list[Case]:
    """The cases of a check that have ladders, in the order of their titles.

    check: its name. anchor: of its section, from which those of the cases are made. lines: its verdicts.
    """
    found: dict[str, Case] = {}
    for line in sorted(lines, key=lambda line: (engine_order(line["engine"]), case_name(line))):
        for figure in line.get("figures") or ():
            if not figure.get("ladder"):
                continue
            place = f"{anchor}-ladder{len(found)}"
            case = found.setdefault(figure["title"], Case(figure["title"], figure["y_label"], check, place))
            case.climbs.append(_climb(line, figure["ladder"]))
    return [found[title] for title in sorted(found)]


def _climb(line: Line, ladder: dict[str, Any]) -> Climb:
    def numbers(name: str) -> list[float]:
        return [math.nan if value is None else float(value) for value in ladder[name]]

    size = len(ladder["controls"])
    columns: Sequence[list[float]] = [
        numbers(name) if ladder[name] else [math.nan] * size
        for name in ("controls", "error", "uncertainty", "cpu", "cpu_low", "cpu_high", "count")
    ]
    points = [
        Point(control, error, uncertainty, cpu, low, high, count, failure)
        for (control, error, uncertainty, cpu, low, high, count), failure in zip(
            zip(*columns, strict=True), ladder["failures"], strict=True
        )
    ]
    options = ["--tier", line["tier"]] if line["tier"] != "quick" else []
    options += ["--engine", line["engine"], "--seed", str(line["provenance"].get("seed", 0))]
    return Climb(
        line["engine"],
        ladder["label"],
        ladder["family"],
        ladder["control"],
        tuple(points),
        ladder["count_label"],
        case_name(line),
        shlex.join(options),
    )


def overview(found: Sequence[Case], targets: Sequence[float] = TARGETS) -> list[tuple[Case, list[Reached | None]]]:
    """For each case, the cheapest method at each target; None where no method reaches it.

    found: the cases. targets: the errors.
    """
    pick: Callable[[Case, float], Row | None] = Case._row
    return [(case, [None if (row := pick(case, target)) is None else row.best for target in targets]) for case in found]
