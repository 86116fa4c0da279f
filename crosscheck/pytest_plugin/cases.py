"""What the pytest plugin does once it is asked for something: cases, their verdicts, and what is said of them."""

from __future__ import annotations

import math
import os
import shlex
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypedDict, cast

import pytest

from crosscheck import runner
from crosscheck.budget.plan import Budget, left_out, measure
from crosscheck.checks.base import TIERS
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.errors import UsageError
from crosscheck.pytest_plugin.names import CASE, ENGINE, FIXTURE, MARKER, OUTCOME, ROOM
from crosscheck.record import deciding
from crosscheck.report.numbers import comparison, sensitivity
from crosscheck.runner import Case
from crosscheck.text import printable
from crosscheck.verdict import Verdict, less_certain

_ARGUMENTS = ("engine", "checks", "tier", "seed", "needed", "allow_inconclusive")


class Times(TypedDict):
    """What there is time for: JSON, for the workers of pytest-xdist.

    deadline: on the clock `time.monotonic`. limits: seconds that each chosen case may take, by name. predicted: those
    that a case will take, None: not known; of a case that is not there, a larger one is chosen.
    """

    deadline: float
    limits: dict[str, float]
    predicted: dict[str, float | None]


@dataclass(frozen=True)
class Settings:
    """What a marker, or the options, ask for.

    cases: that are judged. names: of engines, as tests are called by them. seed: the suite's. time_limit: seconds of a
    call of an engine. allow_inconclusive: such verdicts are skips. needed: the relative deviations that must be seen,
    by patterns of quantities; or one for all. times: None: as long as it takes. told: what was measured, in words.
    """

    cases: tuple[Case, ...]
    names: Mapping[str, str]
    seed: int = 0
    time_limit: float = TIME_LIMIT
    allow_inconclusive: bool = False
    needed: Mapping[str, float] | float | None = None
    times: Times | None = None
    told: tuple[str, ...] = ()

    def name(self, case: Case) -> str:
        """Of the test of a case; case: one of `cases`."""
        return f"{case.name}[{self.names[case.engine]}]"

    def identity(self, case: Case) -> str:
        """How pytest calls the test of a case that no function is marked for; case: one of `cases`."""
        return f"{ROOM}/{case.check}::{self.name(case).removeprefix(f'{case.check}/')}"

    def called(self, identities: Sequence[str]) -> Settings:
        """The same, with those cases alone; identities: of tests; none: all. UsageError if there is no such case."""
        known = {self.identity(case): case for case in self.cases}
        for identity in identities:
            if identity not in known:
                raise UsageError(f"there is no case {identity}; see --collect-only")
        return replace(self, cases=tuple(known[one] for one in identities)) if identities else self

    def within(self, seconds: float, processes: int) -> Settings:
        """The same, with what ends within so many seconds on so many processes at a time, by measured speeds."""
        if not seconds > 0:
            raise UsageError(f"budget = {seconds:g}: give a number of seconds, more than 0")
        began = time.monotonic()
        told: list[str] = []
        budget = Budget(self.cases, measure(self.cases, seconds, told.append), seconds, processes, began)
        limits = {self.name(case): budget.allowed(case) for case in budget.chosen}
        predicted = {self.name(case): budget.expected(case) for case in budget.cases}
        times = Times(deadline=began + seconds, limits=limits, predicted=predicted)
        return replace(self, times=times, told=(*told, budget.said))

    def with_times(self, times: Times | None) -> Settings:
        """The same, in a worker of pytest-xdist. times: that it was told."""
        return replace(self, times=times)

    def said(self) -> list[str]:
        """Lines on what is judged."""
        engines = ", ".join(printable(name) for name in self.names.values())
        number = f"{len(self.cases)} case{'s' if len(self.cases) > 1 else ''}"
        return [f"crosscheck: {number} of {engines}", *(f"crosscheck: {text}" for text in self.told)]


def processes(config: pytest.Config) -> int:
    """How many processes of pytest-xdist the session has; 1 without it. config: of the session."""
    several = (specification.partition("*") for specification in getattr(config.option, "tx", None) or ())
    return max(1, sum(int(number) if star and number.isdigit() else 1 for number, star, _ in several))


def from_options(config: pytest.Config) -> Settings:
    """What the options ask for; paths are those of the directory in which pytest was called. config: of the session.

    UsageError for an engine, a pattern or a tier that there is not.
    """
    option = config.option
    # the workers of pytest-xdist get the options as they are now
    option.crosscheck_engine = [_located(name, config.invocation_params.dir) for name in option.crosscheck_engine]
    limit = option.crosscheck_time_limit
    if limit is not None and not limit > 0:
        raise UsageError(f"time limit = {limit:g}: give a number of seconds, more than 0")
    settings = Settings(
        _selected(
            option.crosscheck_engine,
            option.crosscheck_checks,
            option.crosscheck_tier,
            option.crosscheck_budget is not None,
        ),
        _names(option.crosscheck_engine, config),
        _whole(option.crosscheck_seed),
        TIME_LIMIT if limit is None else limit,
        option.crosscheck_allow_inconclusive,
    )
    return settings.called(_called(config))


def _called(config: pytest.Config) -> list[str]:
    """Cases that are named on the command line as pytest names them; pytest itself would look for their files."""
    if not hasattr(config.option, "crosscheck_called"):
        named = {one: _identity(one, config) for one in config.args}
        config.args[:] = [one for one, identity in named.items() if not identity]
        config.option.crosscheck_called = [identity for identity in named.values() if identity]
    return list(config.option.crosscheck_called)


def _identity(argument: str, config: pytest.Config) -> str:
    """The identity of a case that an argument names, by a path from where pytest was called; "" of something else."""
    path, colons, rest = argument.partition("::")
    place = os.path.relpath(config.invocation_params.dir / path, config.rootpath)
    return f"{place}{colons}{rest}" if colons and place.startswith(f"{ROOM}/") else ""


def from_marker(marker: pytest.Mark, file: Path, config: pytest.Config) -> Settings:
    """What a marker asks for; paths are those of the directory of the test's file.

    marker: with its arguments. file: of the test. config: of the session. UsageError for an argument, an engine, a
    pattern or a tier that there is not.
    """
    given = dict(marker.kwargs)
    if len(marker.args) > 1 or (marker.args and "engine" in given):
        raise UsageError("the marker takes one argument without a name, the engine")
    if marker.args:
        given["engine"] = marker.args[0]
    for name in given:
        if name not in _ARGUMENTS:
            raise UsageError(f"the marker has no argument {name}; it takes {', '.join(_ARGUMENTS)}")
    engines = [_located(name, file.parent) for name in _texts(given.get("engine"), "engine")]
    if not engines:
        raise UsageError('the marker needs an engine: engine="my_engine.py:MyEngine"')
    allowed, limit = given.get("allow_inconclusive"), config.option.crosscheck_time_limit
    return Settings(
        _selected(engines, _texts(given.get("checks"), "checks"), given.get("tier", "quick"), False),
        _names(engines, config),
        _whole(given.get("seed", 0)),
        TIME_LIMIT if limit is None else limit,
        config.option.crosscheck_allow_inconclusive if allowed is None else bool(allowed),
        _needed(given.get("needed")),
    )


def _located(engine: str, directory: Path) -> str:
    """The engine, whose path, if it is one, is no more relative to `directory`."""
    file, colon, name = engine.rpartition(":")
    return f"{(directory / file).resolve()}{colon}{name}" if file.endswith(".py") else engine


def _names(engines: Sequence[str], config: pytest.Config) -> dict[str, str]:
    """How engines are called in the names of tests: by their paths from the root of the tests, if they have any."""

    def name(engine: str) -> str:
        file, colon, cls = engine.rpartition(":")
        if not file.endswith(".py"):
            return engine
        path = Path(file)
        inside = path.is_relative_to(config.rootpath)
        return f"{path.relative_to(config.rootpath) if inside else path}{colon}{cls}"

    return {engine: name(engine) for engine in engines}


def _texts(value: Any, name: str) -> list[str]:
    """One text, or several, as a list."""
    texts = [] if value is None else [value] if isinstance(value, str) else value
    if not isinstance(texts, list | tuple) or not all(isinstance(text, str) for text in texts):
        raise UsageError(f"{name} = {value!r}: give a text, or a list of texts")
    return list(texts)


def _whole(seed: Any) -> int:
    if not isinstance(seed, int) or seed < 0:
        raise UsageError(f"seed = {seed!r}: give a whole number, 0 or more")
    return seed


def _needed(value: Any) -> Mapping[str, float] | float | None:
    numbers = value.values() if isinstance(value, Mapping) else () if value is None else (value,)
    if not all(isinstance(number, (int, float)) and number > 0 for number in numbers):
        raise UsageError(
            f"needed = {value!r}: give a relative deviation above 0, or one for each pattern of quantities"
        )
    return value


def _selected(engines: Sequence[str], patterns: Sequence[str], tier: Any, budget: bool) -> tuple[Case, ...]:
    if tier not in TIERS:
        raise UsageError(f"tier {tier}: unknown; take {', '.join(TIERS[:-1])} or {TIERS[-1]}")
    found = runner.select(list(patterns), tier, list(engines), budget=budget)
    for engine in engines:
        if not any(case.engine == engine for case in found):
            asked = f" of {', '.join(patterns)}" if patterns else ""
            raise UsageError(f"{engine}: no case{asked} matches what it declares (docs/engines.md)")
    return tuple(found)


# -- tests -------------------------------------------------------------------------------------------------------------


class CheckNode(pytest.Collector):
    """A check, whose cases are its tests. settings: what was asked for. check: its name. more: of pytest."""

    def __init__(self, *, settings: Settings, check: str, **more: Any) -> None:
        super().__init__(**more)
        self._settings, self._check = settings, check

    def collect(self) -> list[pytest.Item | pytest.Collector]:
        """The tests, in the order of the cases."""
        found: list[pytest.Item | pytest.Collector] = []
        for case in self._settings.cases:
            if case.check == self._check:
                name = self._settings.name(case).removeprefix(f"{case.check}/")
                item = CaseItem.from_parent(self, name=name, settings=self._settings, case=case)
                item.add_marker(MARKER)
                found.append(item)
        return found


class CaseItem(pytest.Item):
    """A case as a test. settings: what was asked for. case: that is judged. more: of pytest."""

    def __init__(self, *, settings: Settings, case: Case, **more: Any) -> None:
        super().__init__(**more)
        self._settings, self._case = settings, case
        self.extra_keyword_matches.update(case.name.split("/"))

    def runtest(self) -> None:
        """Judges the case."""
        verdict = judged(self._settings, self._case, self)
        _demand(self._settings, self._case, verdict)

    def reportinfo(self) -> tuple[Path, None, str]:
        """The test has no file; it is called by its check."""
        return self.config.rootpath / ROOM / self._case.check, None, self._settings.name(self._case)


def nodes(session: pytest.Collector, settings: Settings) -> list[CheckNode]:
    """The checks, whose cases are tests. session: of pytest. settings: what was asked for."""
    checks = dict.fromkeys(case.check for case in settings.cases)
    return [
        CheckNode.from_parent(session, name=check, nodeid=f"{ROOM}/{check}", settings=settings, check=check)
        for check in checks
    ]


def judged(settings: Settings, case: Case, node: pytest.Item) -> Verdict:
    """The verdict of a case, whose numbers become properties of the test; a skip skips it.

    settings: what was asked for. case: one of its cases. node: the test.
    """
    verdict = _verdict(settings, case, beside_others=hasattr(node.config, "workerinput"))
    node.user_properties += properties(settings, case, verdict)
    if verdict.outcome == "skip":
        pytest.skip(verdict.message)
    return verdict


def _verdict(settings: Settings, case: Case, *, beside_others: bool) -> Verdict:
    """beside_others: other processes run cases at the same time."""
    if case.timing and beside_others:
        return _skipped(case, "it measures computing times, which nothing may disturb: run it without pytest-xdist")
    deadline, times = math.inf, settings.times
    if times is not None:
        now, name = time.monotonic(), settings.name(case)
        if name not in times["predicted"]:
            return _skipped(case, f"{case.check}/{case.instead} is run in its place")
        allowed = times["limits"].get(name)
        if allowed is None or now >= times["deadline"]:
            return left_out(case, times["predicted"][name])
        deadline = min(times["deadline"], now + allowed)
    verdict = runner.judge(case, settings.seed, time_limit=settings.time_limit, deadline=deadline)
    if settings.needed is None or verdict.findings is None:
        return verdict
    try:
        found = less_certain(verdict.findings, settings.needed)
    except UsageError as error:
        return replace(verdict, outcome="error", findings=None, message=str(error))
    return replace(verdict, findings=found, outcome=found.outcome)


def _skipped(case: Case, reason: str) -> Verdict:
    return Verdict(case.check, case.variant, case.engine, "skip", None, reason)


def demand_green(item: pytest.Function) -> None:
    """Fails a marked test whose verdict is red; judges its case, if the test has not asked for that. item: the test."""
    settings, case = cast(tuple[Settings, Case], item.callspec.params[FIXTURE])
    verdict = item.funcargs.get(FIXTURE) or judged(settings, case, item)
    _demand(settings, case, cast(Verdict, verdict))


def _demand(settings: Settings, case: Case, verdict: Verdict) -> None:
    if verdict.outcome == "pass":
        return
    text = told(settings, case, verdict)
    if verdict.outcome == "inconclusive" and settings.allow_inconclusive:
        pytest.skip(text)
    pytest.fail(text, pytrace=False)


# -- what is said ------------------------------------------------------------------------------------------------------


def told(settings: Settings, case: Case, verdict: Verdict) -> str:
    """What a verdict that is not green says: each number that is not, and why; and how to run it again.

    settings: what was asked for. case: one of its cases. verdict: of that.
    """
    line = verdict.as_record()
    red = [one for one in line["judgements"] if one["outcome"] != "pass"]
    red.sort(key=lambda one: one not in deciding(line))
    lines = [f"{verdict.outcome}: {settings.name(case)}"]
    for one in red:
        lines.append(f"  {one['outcome']}: {comparison(one)}")
        lines += [f"    {text}" for text in (one["criterion"]["why"], one["note"]) if text]
    green = len(line["judgements"]) - len(red)
    lines += [f"  {green} more pass"] if red and green else []
    lines += [f"  {text}" for text in (line["note"], line["message"]) if text]
    command = ["crosscheck", "run", case.name, "--engine", case.engine, "--seed", str(settings.seed)]
    command += ["--tier", verdict.tier] if verdict.tier != "quick" else []
    return printable("\n".join([*lines, f"  again: {shlex.join(command)}"]), keep="\n")


def properties(settings: Settings, case: Case, verdict: Verdict) -> list[tuple[str, object]]:
    """All numbers of a verdict, as properties of the test: in JUnit XML, and in every report.

    settings: what was asked for. case: one of its cases. verdict: of that.
    """
    found: list[tuple[str, object]] = [
        (OUTCOME, verdict.outcome),
        (CASE, case.name),
        (ENGINE, printable(settings.names[case.engine])),
    ]
    for one in verdict.as_record()["judgements"]:
        value = f"{one['outcome']}: {comparison(one).removeprefix(one['quantity'] + ': ')}"
        found.append((printable(one["quantity"]), printable(f"{value}, sensitivity {sensitivity(one)}")))
    return found
