"""Whether work that an event does not need is seen: some is drawn at random, and shown to the checks of work.

    python benchmarks/evidence/needless_work.py [--number K] [--seed S] [--scaling]

Drawn are a kind of needless work, and a place for it in the kernels of events: a statement that is done once more, or
a loop before a statement, over all particles, over sqrt N or log2 N of them, over a row of cells, the particle's own
cell, or the buckets of the calendar, or one that copies an array. What is drawn counts if the scenes of
`performance/written-operations` give the same results as before, to the last bit: work that is needless.

Each such copy of the sources is shown to the checks that count: `events/operations` (the kernels' own counters) and
`performance/written-operations` (all that is written). Loops that grow with the number of particles, and that neither
has seen (with --scaling: all of them), are shown to `performance/scaling-events` (the kernels' own) and
`performance/scaling-written-operations` (all) too, with the first scheduler of the tree, the lists and the calendar
that does the work. Where none is red although a scene does more, `performance/scaling-event-time` is asked, which takes
minutes.

Printed is a line for each: what, where, by how much the operations of the scene grow in which they grow most, and how
many cases of each check are red.
"""

from __future__ import annotations

import argparse
import ast
import random
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from crosscheck import runner
from crosscheck.checks.base import Check
from crosscheck.checks.performance.counted_sources import work_of
from crosscheck.checks.performance.written_operations import KNOWN
from crosscheck.errors import EngineError
from crosscheck.faults import Fault, sources
from crosscheck.mutation.judge import Judge
from crosscheck.scene import Method

FILES = (
    "events/kernels/loop.py",
    "events/kernels/schedule.py",
    "events/kernels/shells.py",
    "events/kernels/measure.py",
    "events/prediction.py",
    "events/rules.py",
)
#: Seconds that one case may take.
LIMIT = 300.0
#: Loops, by kind: the array whose length counts, as functions have it, and the text, {a} being the array.
LOOPS: dict[str, tuple[tuple[str, ...], str]] = {
    "all particles": (
        ("rows", "particles.rows"),
        "for _k in range({a}.shape[0]):\n    if {a}[_k, 6] < -1e300:\n        {a}[_k, 6] = 0.0",
    ),
    "sqrt N particles": (
        ("rows", "particles.rows"),
        "_k = 0\nwhile _k * _k < {a}.shape[0]:\n    if {a}[_k, 6] < -1e300:\n        {a}[_k, 6] = 0.0\n    _k += 1",
    ),
    "log2 N particles": (
        ("rows", "particles.rows"),
        "_k = {a}.shape[0] - 1\nwhile _k > 0:\n    if {a}[_k, 6] < -1e300:\n        {a}[_k, 6] = 0.0\n    _k >>= 1",
    ),
    "a row of cells": (
        ("particles.cells", "cells"),
        "for _k in range(grid.counts[0]):\n    if {a}[_k, 0] < -1:\n        {a}[_k, 0] = 0",
    ),
    "the slots of a cell": (
        ("particles.cells", "cells"),
        "for _k in range({a}.shape[1]):\n    if {a}[0, _k] < -1:\n        {a}[0, _k] = 0",
    ),
    "all entries of the queue": (
        ("queue.keys",),
        "for _k in range({a}.size):\n    if {a}[_k] < -1e300:\n        {a}[_k] = 0.0",
    ),
    "the buckets of the calendar": (
        ("queue.heads",),
        "for _k in range({a}.size):\n    if {a}[_k] < -1:\n        {a}[_k] = -1",
    ),
    "a copy of the rows": (
        ("rows", "particles.rows"),
        "for _k in range({a}.shape[0]):\n    {a}[_k, 6] = {a}[_k, 6] + 0.0",
    ),
}
AGAIN = "done again"
#: Kinds that are as long in any gas.
CONSTANT = (AGAIN, "the slots of a cell")
#: Checks with all of their cases in the quick tier, and those of which one case is taken.
SMALL = ("events/operations", "performance/written-operations")
LARGE = ("performance/scaling-events", "performance/scaling-written-operations")
LAST = "performance/scaling-event-time"
#: Schedulers by the names of the variants.
VARIANTS = {"event_driven": "tree", "event_driven_lists": "lists", "event_driven_calendar": "calendar"}


class Place(NamedTuple):
    """A statement of a function. file: below `refimpl`. function: its name. arguments: of it. statement: itself."""

    file: str
    function: str
    arguments: frozenset[str]
    statement: ast.stmt


class Drawn(NamedTuple):
    """Needless work. kind: of it. place: where. fault: the sources with it."""

    kind: str
    place: Place
    fault: Fault

    @property
    def words(self) -> str:
        """What is done, in the words of the table."""
        line = ast.unparse(self.place.statement).splitlines()[0]
        return f"`{line if len(line) < 60 else line[:57] + '...'}` once more" if self.kind == AGAIN else self.kind


def places() -> list[Place]:
    """All statements of the functions of the kernels."""
    found = []
    for file in FILES:
        tree = ast.parse((sources() / file).read_text(encoding="utf-8"))
        for function in (node for node in tree.body if isinstance(node, ast.FunctionDef)):
            arguments = frozenset(one.arg for one in function.args.args)
            for node in ast.walk(function):
                if isinstance(node, ast.stmt) and node is not function and not _is_text(node):
                    found.append(Place(file, function.name, arguments, node))
    return found


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def repeatable(place: Place) -> bool:
    """Whether a statement does so much that it may be worth repeating: a loop, or a call."""
    match place.statement:
        case ast.Expr(value=ast.Call(func=ast.Name(id="tick"))):
            return False  # counts, and does nothing
        case ast.For() | ast.While() | ast.Expr():
            return place.function != "advance" or not isinstance(place.statement, ast.While)
        case ast.Assign(value=ast.Call()):
            return True
    return False


def array_of(kind: str, place: Place) -> str | None:
    """The array that a loop can be over at a place; None: there is none."""
    names, text = LOOPS[kind]
    if "grid" in text and "grid" not in place.arguments:
        return None
    return next((name for name in names if name.partition(".")[0] in place.arguments), None)


def candidates(statements: list[Place], kind: str) -> Iterator[tuple[Place, str]]:
    """Where work of a kind can be, and the array that it is over."""
    for place in statements:
        array = array_of(kind, place) if kind != AGAIN else "" if repeatable(place) else None
        if array is not None:
            yield place, array


def with_more(place: Place, kind: str, array: str) -> Fault:
    """The sources with the work before the statement."""
    before = (sources() / place.file).read_text(encoding="utf-8")
    lines = before.splitlines(keepends=True)
    first, last = place.statement.lineno - 1, place.statement.end_lineno
    if kind == AGAIN:
        more = lines[first:last]
    else:
        indent = " " * place.statement.col_offset
        more = [f"{indent}{line}\n" for line in LOOPS[kind][1].format(a=array).splitlines()]
    after = "".join([*lines[:first], *more, *lines[first:]])
    return Fault(f"{kind}-{place.statement.lineno}", place.file, before, after, "needless work")


def drawn(chance: random.Random, usual: dict[str, list[tuple[str, int]]]) -> Iterator[tuple[Drawn, dict[str, float]]]:
    """Needless work, and by how much the operations of each scheduler's scenes grow by it, relative.

    usual: digest and operations of each run with the sources as they are, by the name of the variant.
    """
    statements, seen = places(), set[str]()
    kinds = (AGAIN, AGAIN, *LOOPS)
    while True:
        kind = chance.choice(kinds)
        place, array = chance.choice(list(candidates(statements, kind)))
        fault = with_more(place, kind, array)
        if fault.new in seen or not _compiles(fault.new):
            continue
        seen.add(fault.new)
        with tempfile.TemporaryDirectory() as name:
            fault.apply(Path(name))
            try:
                found = {}
                for variant, before in usual.items():
                    found[variant] = runs_of(Path(name) / "refimpl", variant)
                    if any(a[0] != b[0] for a, b in zip(before, found[variant], strict=True)):
                        break
                else:
                    yield Drawn(kind, place, fault), growth(usual, found)
            except EngineError:
                continue  # it does something else, and fails


def _compiles(text: str) -> bool:
    try:
        compile(text, "", "exec")
    except SyntaxError:
        return False
    return True


def runs_of(directory: Path, variant: str) -> list[tuple[str, int]]:
    """Digest and number of operations of each run of a variant of `performance/written-operations`."""
    runs = work_of(directory, [(one.scene, Method(scheme=one.scheme)) for one in KNOWN[variant]], interpreted=True)
    return [(run.digest, run.work[-1] + run.ahead[-1]) for run in runs]


def growth(usual: dict[str, list[tuple[str, int]]], found: dict[str, list[tuple[str, int]]]) -> dict[str, float]:
    """By how much the operations grow, relative, at most, by scheduler; a run is of the scheduler of its record."""
    most: dict[str, float] = {}
    for variant, known in KNOWN.items():
        for one, (_, before), (_, after) in zip(known, usual[variant], found[variant], strict=True):
            most[one.scheme] = max(most.get(one.scheme, 0.0), after / before - 1)
    return most


def scheme_of(place: Place, more: dict[str, float]) -> str:
    """The first scheme whose scenes do more; if none does, the one that the function is named after, or the tree."""
    named = [name for name, variant in VARIANTS.items() if place.function.startswith(f"_{variant}")]
    return next((name for name in VARIANTS if more.get(name, 0.0) > 0), next(iter(named), "event_driven"))


def case(check: Check, variant: str) -> runner.Case:
    """A case of a check on `refimpl`."""
    return runner.Case(check.name, variant, "refimpl", check.timing)


def red(fault: Fault, scheme: str, *, grows: bool, done: bool, scaling: bool) -> dict[str, tuple[int, int]]:
    """By check: the number of its cases that are red, and of those that were judged.

    scheme: that does the work. grows: it may be more in larger gases. done: a scene does it. scaling: larger gases are
    judged although small ones were red.
    """
    variant = VARIANTS[scheme]
    cases = [case(runner.find(name), one.name) for name in SMALL for one in runner.find(name).offered({})]
    found: dict[str, tuple[int, int]] = {}

    def judge(one: runner.Case) -> None:
        answer = judging.judge(one, 0, LIMIT)
        before = found.get(one.check, (0, 0))
        found[one.check] = before[0] + answer.red, before[1] + 1

    with ExitStack() as stack:
        directory = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="crosscheck-needless-")))
        fault.apply(directory)
        judging = stack.enter_context(Judge(directory, directory / "caches"))
        for one in cases:
            judge(one)
        if grows and (scaling or not any(number for number, _ in found.values())):
            for name in LARGE:
                judge(case(runner.find(name), variant))
        if not any(number for number, _ in found.values()) and done and variant != "lists":
            judge(case(runner.find(LAST), variant))
    return found


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--number", type=int, default=24)
    parser.add_argument("--seed", type=int, default=15)
    parser.add_argument("--scaling", action="store_true")
    options = parser.parse_args()
    usual = {variant: runs_of(sources(), variant) for variant in KNOWN}
    columns = (*SMALL, *LARGE, LAST)
    print(f"| work | where | more operations | {' | '.join(columns)} |")
    print(f"|{'---|' * (3 + len(columns))}")
    draws = drawn(random.Random(options.seed), usual)
    missed = 0
    for _ in range(options.number):
        one, more = next(draws)
        scheme, most = scheme_of(one.place, more), max(more.values())
        answers = red(one.fault, scheme, grows=one.kind not in CONSTANT, done=most > 0, scaling=options.scaling)
        missed += not any(number for number, _ in answers.values())
        cells = [f"{answers[name][0]} of {answers[name][1]}" if name in answers else "" for name in columns]
        where = f"{one.place.file}:{one.place.statement.lineno} {one.place.function}"
        print(f"| {one.words} | {where} | {most:.2%} | {' | '.join(cells)} |", flush=True)
    print(f"\n{options.number - missed} of {options.number} are seen.")


if __name__ == "__main__":
    main()
