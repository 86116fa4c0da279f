"""A trial: one mutant before the cases that execute what is mutated, the cheapest first, until one of them is red."""

from __future__ import annotations

import ast
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from crosscheck.engines.workers.ending import ending
from crosscheck.mutation.coverage import Executed
from crosscheck.mutation.draw import Mutant
from crosscheck.mutation.judge import Judge
from crosscheck.mutation.syntax import bound_names

#: Compiled cases that one mutant is shown to, by tier: each compiles its kernels anew.
MOST_COMPILED = {"quick": 8, "full": 30}
#: A case that takes so many times as long as usual, and so many seconds more, hangs.
_TIMES_AS_LONG, _SECONDS_MORE = 10.0, 5.0
#: What compiled cases get for their compilation, and the first one of an engine for the start of its process.
_SECONDS_TO_COMPILE, _SECONDS_TO_START = 120.0, 60.0
_PREFIX = "crosscheck-mutant-"


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant.

    caught: whether a case was red. by: the name of that case, and the engine. why: its message. judged: the number of
    cases that it was shown to. left: the number of compiled cases that execute the mutation, and that it was not shown
    to. seconds: that it took.
    """

    caught: bool
    by: str
    why: str
    judged: int
    left: int
    seconds: float


def try_mutant(mutant: Mutant, executed: Sequence[Executed], seed: int, most_compiled: int) -> Outcome | None:
    """The outcome for one mutant; None if the suite was asked to end meanwhile.

    A verdict "fail" or "error" catches it: so does a crash, and a case that takes more than ten times as long as usual
    and 5 s. Compiled ones may take 120 s more; the first one of an engine, whose process starts, 60 s more.
    "inconclusive" and "skip" catch nothing. executed: of all cases that are green for the unchanged sources. seed: of
    the suite. most_compiled: the number of compiled cases that it is shown to at most.
    """
    cases, left = to_be_judged(mutant, executed, most_compiled)
    seconds, started = 0.0, set[tuple[str, bool]]()
    with (
        overlay(mutant) as directory,
        Judge(directory, directory / "caches" if mutant.package == "refimpl" else None) as judge,
    ):
        for number, one in enumerate(cases, 1):
            limit = _TIMES_AS_LONG * one.seconds + _SECONDS_MORE + (0.0 if one.interpreted else _SECONDS_TO_COMPILE)
            process = (one.case.engine, one.interpreted)
            limit += 0.0 if process in started else _SECONDS_TO_START
            started.add(process)
            answer = judge.judge(one.case, seed, limit)
            if ending():
                return None
            seconds += answer.seconds
            if answer.red:
                return Outcome(True, f"{one.case.name} [{one.case.engine}]", answer.message, number, left, seconds)
    return Outcome(False, "", "", len(cases), left, seconds)


def to_be_judged(mutant: Mutant, executed: Sequence[Executed], most_compiled: int) -> tuple[list[Executed], int]:
    """The cases that a mutant is shown to, in this order, and the number of compiled ones that are left out.

    All interpreted ones that execute it, and some compiled ones: at first the cheapest of each check. executed: of all
    cases. most_compiled: how many compiled ones at most.
    """
    found = [one for one in executed if _executes(mutant, one)]
    interpreted = sorted((one for one in found if one.interpreted), key=lambda one: one.seconds)
    compiled = _by_turns(sorted((one for one in found if not one.interpreted), key=lambda one: one.seconds))
    return interpreted + compiled[:most_compiled], max(0, len(compiled) - most_compiled)


def _by_turns(cases: list[Executed]) -> list[Executed]:
    """One of each group of checks, then another one of each; within a group, checks take turns too."""
    return _dealt(_dealt(cases, lambda one: one.case.check), lambda one: one.case.check.partition("/")[0])


def _dealt(cases: list[Executed], key: Callable[[Executed], str]) -> list[Executed]:
    """The first case of each key, then the second of each, and so on."""
    turns: dict[str, int] = {}
    numbered = []
    for one in cases:
        turns[key(one)] = turns.get(key(one), 0) + 1
        numbered.append((turns[key(one)], one))
    return [one for _, one in sorted(numbered, key=lambda pair: pair[0])]


def _executes(mutant: Mutant, one: Executed) -> bool:
    """Whether a case executes the mutated statement; of a constant of the module, a line of the package with its name.

    Or with the name of another constant that is made from it. A statement of a class without a name, or of a module,
    counts as executed with any line of its file.
    """
    file, mutation = f"{mutant.package}/{mutant.file}", mutant.mutation
    if mutation.binds is None:
        return one.executes(file, mutation.first, mutation.last)
    default = not mutation.first <= mutation.line <= mutation.last  # a value of a function with these lines
    if default and one.executes(file, mutation.first, mutation.last):
        return True
    users = _lines_with(mutant.package, _made_from(mutant.package, mutation.binds))
    if not users:
        return file in one.lines
    return any(one.lines.get(name, frozenset()) & lines for name, lines in users.items())


@cache
def _made_from(package: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """The names, and those of constants of modules that are made from them: no case executes the lines in between."""
    found, before = set(names), set[str]()
    while found != before:
        before = set(found)
        found.update(*(bound for used, bound in _constants(package) if used & before))
    return tuple(sorted(found))


@cache
def _constants(package: str) -> tuple[tuple[frozenset[str], frozenset[str]], ...]:
    """The names that each assignment of a module of the package uses, and those that it binds."""
    found = []
    for file in _root(package).rglob("*.py"):
        for statement in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(statement, ast.Assign | ast.AnnAssign):
                bound = frozenset(bound_names(statement))
                names = {node.id for node in ast.walk(statement) if isinstance(node, ast.Name)}
                found.append((frozenset(names - bound), bound))
    return tuple(found)


def _root(package: str) -> Path:
    import importlib

    return Path(importlib.import_module(package).__path__[0])


@cache
def _lines_with(package: str, names: tuple[str, ...]) -> dict[str, frozenset[int]]:
    """The lines of a package in which one of the names occurs, by path."""
    if not names:
        return {}
    root = _root(package)
    word = re.compile(rf"\b({'|'.join(re.escape(name) for name in names)})\b")
    found = {}
    for file in root.rglob("*.py"):
        lines = file.read_text(encoding="utf-8").splitlines()
        numbers = frozenset(number for number, line in enumerate(lines, 1) if word.search(line))
        if numbers:
            found[file.relative_to(root.parent).as_posix()] = numbers
    return found


class overlay:
    """A directory with a copy of the mutant's package in which it is mutated; removed at the end.

    mutant: which. Its name holds the number of this process, see `remove_leftovers`.
    """

    def __init__(self, mutant: Mutant) -> None:
        self._mutant = mutant
        self._directory = Path()

    def __enter__(self) -> Path:
        mutant = self._mutant
        self._directory = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{os.getpid()}-"))
        root = _root(mutant.package)
        shutil.copytree(root, self._directory / mutant.package)  # with the bytecode of what is not changed
        target = self._directory / mutant.package / mutant.file
        target.write_text(mutant.after, encoding="utf-8")
        for file in (target.parent / "__pycache__").glob(f"{target.stem}.*"):
            file.unlink()
        return self._directory

    def __exit__(self, *error: object) -> None:
        shutil.rmtree(self._directory, ignore_errors=True)


def remove_leftovers() -> None:
    """Removes the directories that processes left which are gone, as after SIGKILL."""
    for directory in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        number = directory.name.removeprefix(_PREFIX).partition("-")[0]
        if number.isdigit() and not Path("/proc", number).exists():
            with suppress(OSError):
                shutil.rmtree(directory)
