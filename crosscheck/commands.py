"""The commands of the command line: what each does and prints. `cli` has their options."""

from __future__ import annotations

import json
import os
import shlex
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from crosscheck import runner, status
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check, Variant
from crosscheck.directory import locked
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing, UsageError
from crosscheck.faults import Fault
from crosscheck.files import naming, refuse_no_directory, refuse_unwritable
from crosscheck.record import FILE, Line, Record, case_name, deciding, finished, is_torn, provenance, read, shown
from crosscheck.text import printable
from crosscheck.verdict import Verdict

_COLOURS = {
    "pass": "green",
    "fail": "bold red",
    "error": "bold magenta",
    "inconclusive": "yellow",
    "skip": "dim",
}


def _console() -> Console:
    # at least 140 columns: in a narrow terminal, wrapped lines are easier to read than names folded within columns; a
    # pipe has no width
    console = Console()
    return Console(width=max(console.width, 140) if sys.stdout.isatty() else 200)


def _plain(text: str) -> str:
    """The text for a table, in which rich would read words in square brackets as styles."""
    return escape(printable(text))


def _variants_by_engine(check: Check) -> dict[str, tuple[Variant, ...]]:
    """The variants of a check, by name of those installed engines that it judges."""
    offers = {name: runner.judging(check, name, engine_class(name)) for name in engine_names()}
    return {name: variants for name, variants in offers.items() if variants}


def list_checks(as_json: bool) -> None:
    """Prints every check with its engines, the number of its variants in each tier, and its title.

    as_json: print all variants and faults, as JSON, instead of a table.
    """
    rows = []
    for check in all_checks():
        offers = _variants_by_engine(check)
        rows.append(
            {
                "check": check.name,
                "title": check.title,
                "engines": list(offers),
                "variants": {
                    engine: [{"name": one.name, "tier": one.tier} for one in variants]
                    for engine, variants in offers.items()
                },
                "faults": [fault.name for _, fault in check.faults],
            }
        )
    if as_json:
        print(json.dumps(rows, indent=2))
        return
    table = Table("check", "engines", "quick", "full", "measures", box=None, pad_edge=False)
    for check in all_checks():
        offers = _variants_by_engine(check)
        tiers = Counter({one.name: one.tier for variants in offers.values() for one in variants}.values())
        counts = [str(tiers[tier]) if tiers[tier] else "" for tier in ("quick", "full")]
        table.add_row(check.name, " ".join(offers), *counts, check.title)
    _console().print(table)


def show(name: str) -> None:
    """Prints equation, criterion, needs, variants and planted faults of a check.

    name: of a check, or of a case. UsageError if there is no such check.
    """
    check = runner.find(name)
    console = _console()
    console.print(f"[bold]{check.name}[/bold]", highlight=False)
    for label, text in (
        ("measures", check.title),
        ("equation", check.equation),
        ("criterion", check.criterion),
        ("citation", check.citation),
        ("needs", "; ".join(_needs_as_text(one) for one in check.all_needs)),
    ):
        console.print(f"  {label:<10} {text}", highlight=False, markup=False)
    for engine, variants in _variants_by_engine(check).items():
        for tier in ("quick", "full"):
            names = [one.name for one in variants if one.tier == tier]
            if names:
                console.print(f"  {tier:<10} {engine}: {', '.join(names)}", highlight=False, markup=False)
    for variant, fault in check.faults:
        text = f"  {'fault':<10} {fault.name} (seen by {variant}): {fault.breaks}"
        console.print(text, highlight=False, markup=False)


def _needs_as_text(needs: Needs) -> str:
    """What a check asks of an engine, as "[gravity] by stepping schemes, masses[], virial"."""
    kinds = f"[{needs.interaction}] by {' or '.join(needs.kinds)} schemes"
    return ", ".join([kinds, *needs.schemes, *sorted(needs.words), *sorted(needs.observables), *needs.promises])


def engines() -> None:
    """Prints each installed engine with its version, or the reason why it cannot run on this machine."""
    table = Table("engine", "state", "version or reason", "schemes", box=None, pad_edge=False)
    for name in engine_names():
        worker = Worker(name, time_limit=120)
        try:
            state, text = "found", worker.version()
        except (EngineMissing, EngineError) as error:
            state, text = "missing", str(error).splitlines()[0]
        finally:
            worker.close()
        table.add_row(name, state, _plain(text), " ".join(engine_class(name).schemes))
    _console().print(table)


# -- run -------------------------------------------------------------------------------------------


class _Display:
    """A progress bar on a terminal, plain lines on a pipe."""

    def __init__(self, total: int) -> None:
        self._total, self._done, self._started = total, 0, time.perf_counter()
        self._running: list[str] = []
        self._bar: Progress | None = None
        if sys.stdout.isatty():
            self._bar = Progress(
                TextColumn("{task.description}", markup=False),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
                transient=True,
            )
            self._task = self._bar.add_task("starting", total=total)
            self._bar.start()

    def started(self, case: runner.Case) -> None:
        self._running.append(case.name)
        self._describe()

    def finished(self, verdict: Verdict) -> None:
        self._done += 1
        if verdict.name in self._running:
            self._running.remove(verdict.name)
        if self._bar:
            self._bar.advance(self._task)
            self._describe()
            return
        passed = time.perf_counter() - self._started
        left = passed / self._done * (self._total - self._done)
        print(
            f"[{self._done}/{self._total}] {verdict.outcome:<12} {verdict.name} [{verdict.engine}]"
            f"  {verdict.cost['seconds']:.2f} s, about {left:.0f} s left",
            flush=True,
        )

    def _describe(self) -> None:
        if self._bar:
            self._bar.update(self._task, description=", ".join(self._running[:2]) or "finishing")

    def close(self) -> None:
        if self._bar:
            self._bar.stop()


def run(
    patterns: list[str],
    tier: str,
    engine_list: list[str],
    seed: int,
    jobs: int | None,
    out: Path,
    resume: Path | None,
    junit: Path | None,
    required: list[str],
    allow_inconclusive: bool,
    time_limit: float = TIME_LIMIT,
) -> int:
    """Runs cases, writes record and report, prints a table; returns the exit status.

    patterns: shell patterns of names of checks or cases; none: all. tier: "quick" or "full". engine_list: names, or
    path.py:Class; none: all installed. seed: the suite's seed. jobs: cases at a time; None: one per core. out:
    directory of record and report. resume: directory of an interrupted run to be completed, in place of out; None: a
    new run. junit: file for JUnit XML; None: none. required: names of engines that must be there. allow_inconclusive:
    inconclusive verdicts do not change the exit status. time_limit: seconds that one call of an engine may take.

    The status: see `crosscheck.status.Status`. It follows from the verdicts of this run and, where one is completed,
    those that it had. UsageError for an unknown tier or engine, if a pattern matches no check, if another run is
    writing to the directory, or if the run to be completed had another seed.
    """
    if tier not in ("quick", "full"):
        raise UsageError(f"--tier {tier}: unknown; take quick or full")
    engines = engine_list or engine_names()
    cases = runner.select(patterns, tier, engines)
    directory = resume or out
    _refuse_unwritable_results(directory, resume, junit)
    told = _Telling(junit, allow_inconclusive)
    absent = _absent(required)
    if absent:
        return told.unjudged([], absent)
    with locked(directory):
        before = _lines_before(directory, resume is not None, seed)
        left = [case for case in cases if (case.name, case.engine) not in finished(before.values())]
        if not left and not before:
            return told.unjudged([], status.unjudged([], []))
        record = Record(directory, provenance(seed, shlex.join(["crosscheck", *sys.argv[1:]])))
        started = time.perf_counter()
        own, interruption = _judged(left, seed, _that_pay(jobs, len(left)), record, time_limit)
        lines = list((before | own).values())
        if interruption is not None:
            return told.interrupted(lines, len(left), directory, interruption)
        expected = [*engine_list, *(name for name in required if name in engines)]
        return told.finished(lines, engine_list, expected, directory, time.perf_counter() - started)


def _refuse_unwritable_results(directory: Path, resumed: Path | None, junit: Path | None) -> None:
    """UsageError if there is nothing to complete, or the results cannot be written, before anything is made."""
    from crosscheck.report.html import FILE as REPORT

    if resumed is not None:
        read(resumed)
        _say_if_torn(resumed)
    refuse_no_directory(directory, "the record")
    for path in (directory / FILE, directory / REPORT, *([] if junit is None else [junit])):
        refuse_unwritable(path)


def _lines_before(directory: Path, resumed: bool, seed: int) -> dict[tuple[str, str], Line]:
    """The lines that the record in `directory` has of the run to be completed, by case and engine.

    A new run has none: the last record in its directory is put aside, in case it is of an interrupted run that was to
    be resumed. UsageError if the run to be completed had another seed.
    """
    if not resumed:
        if (directory / FILE).exists():
            (directory / FILE).replace(directory / f"previous-{FILE}")
        return {}
    before = read(directory)
    if any(line["provenance"]["seed"] != seed for line in before):
        raise UsageError(f"{directory}: was run with another seed; resume it with that --seed, or start a new run")
    return {(case_name(line), line["engine"]): line for line in before}


def _judged(
    cases: list[runner.Case], seed: int, jobs: int, record: Record, time_limit: float
) -> tuple[dict[tuple[str, str], Line], int | None]:
    """Runs the cases; their lines as they are in the record, by case and engine; the status if it was interrupted."""
    display = _Display(len(cases))
    lines = {}
    try:
        for verdict in runner.run(cases, seed, jobs, display.started, None, time_limit):
            lines[verdict.name, verdict.engine] = record.append(verdict)
            display.finished(verdict)
    except KeyboardInterrupt as interrupt:
        return lines, getattr(interrupt, "status", int(status.Status.INTERRUPTED))
    finally:
        display.close()
    return lines, None


def _absent(required: list[str]) -> list[str]:
    """A sentence on each required engine that cannot run on this machine. UsageError if there is no such engine."""
    found = []
    for name in required:
        engine_class(name)
        worker = Worker(name, time_limit=120)
        try:
            worker.version()
        except (EngineMissing, EngineError) as error:
            found.append(f"nothing was judged: --require {name}: {str(error).splitlines()[0]}")
        finally:
            worker.close()
    return found


class _Telling:
    """Tells the user, and in a file for other tools, how a run ended. junit: that file, or None."""

    def __init__(self, junit: Path | None, allow_inconclusive: bool) -> None:
        self._junit, self._allow_inconclusive = junit, allow_inconclusive

    def unjudged(self, lines: list[Line], reasons: list[str]) -> int:
        """The status of a run that judged nothing, or nothing of an engine that was named."""
        for reason in reasons:
            print(f"crosscheck: {reason}", file=sys.stderr)
        self._write(lines, reasons)
        return int(status.Status.UNJUDGED)

    def interrupted(self, lines: list[Line], cases: int, directory: Path, result: int) -> int:
        """The status, `result`, of a run of `cases` that was interrupted; lines: of what was finished."""
        print(f"crosscheck: interrupted; the record has what was finished: --resume {directory}", file=sys.stderr)
        self._write(lines, [f"interrupted: not all of {cases} cases were judged"])
        return result

    def finished(
        self, lines: list[Line], named: list[str], expected: list[str], directory: Path, seconds: float
    ) -> int:
        """Prints the table and writes the report; the status.

        named: engines by --engine. expected: these, and others of which something must be judged. directory: of the
        report.
        """
        from crosscheck.report.html import write_report

        console = _console()
        _print_table(console, lines)
        for name in named:
            print(_share_of_checks(name))
        report_path = write_report(directory)
        counts = Counter(line["outcome"] for line in lines)
        summary = ", ".join(f"{counts[outcome]} {outcome}" for outcome in _COLOURS if counts[outcome])
        console.print(f"{summary} in {seconds:.0f} s; report: {report_path}", highlight=False, soft_wrap=True)
        reasons = status.unjudged(lines, expected)
        result = status.of(lines, reasons, self._allow_inconclusive)
        if reasons:
            self.unjudged(lines, reasons)
            return int(result)
        if result == status.Status.INCONCLUSIVE:
            number = counts["inconclusive"]
            print(f"crosscheck: {number} inconclusive: see --allow-inconclusive", file=sys.stderr)
        self._write(lines, [])
        return int(result)

    def _write(self, lines: list[Line], reasons: list[str]) -> None:
        from crosscheck.report.junit import write_junit

        if self._junit is not None:
            write_junit(lines, self._junit, reasons, self._allow_inconclusive)


def _that_pay(jobs: int | None, things: int) -> int:
    """How many of so many things to do at a time: no more than there are, nor than cores; says so if it was asked more.

    jobs: as asked; None: one per core.
    """
    cores = len(os.sched_getaffinity(0))
    most = max(1, min(cores, things))
    if jobs is not None and jobs > most:
        print(f"crosscheck: --jobs {jobs}: {most} at a time, for there are {things} to do on {cores} cores", flush=True)
    return min(jobs or most, most)


def _share_of_checks(name: str) -> str:
    """How many checks judge the engine of this name: what the others measured of it is nothing, and not green."""
    checks = all_checks()
    matched = sum(bool(runner.judging(check, name, engine_class(name))) for check in checks)
    rest = len(checks) - matched
    return f"{name}: {matched} checks match what it declares, {rest} need more and say nothing of it (docs/engines.md)"


def _print_table(console: Console, lines: list[Line]) -> None:
    from crosscheck.report import numbers

    table = Table(box=None, pad_edge=False)
    for title in ("check", "engine"):
        table.add_column(title, overflow="fold")
    for title in ("measured", "expected", "deviation", "sensitivity", "cost"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    order = {outcome: rank for rank, outcome in enumerate(("pass", "skip", "inconclusive", "error", "fail"))}
    for line in sorted(lines, key=lambda item: (order[item["outcome"]], case_name(item), item["engine"])):
        found = shown(line)
        values = (numbers.measured, numbers.expected, numbers.deviation, numbers.sensitivity)
        outcome = line["outcome"]
        table.add_row(
            _plain(case_name(line)),
            _plain(line["engine"]),
            *("" if found is None else value(found) for value in values),
            numbers.seconds(line["cost"].get("seconds")),
            f"[{_COLOURS[outcome]}]{outcome}[/]",
        )
    console.print(table)
    reasons = Counter(line["message"] for line in lines if line["outcome"] == "skip")
    for reason, count in reasons.items():
        console.print(f"skipped {count}: {reason}", style="dim", highlight=False, markup=False, soft_wrap=True)
    for line in lines:
        if line["outcome"] in ("fail", "error"):
            parts = [*(one["quantity"] for one in deciding(line)), line["note"], line["message"]]
            text = f"{case_name(line)} [{line['engine']}]: {'; '.join(filter(None, parts))}"
            console.print(text, style=_COLOURS[line["outcome"]], highlight=False, markup=False, soft_wrap=True)


def report(directory: Path) -> None:
    """Writes the report of a finished or interrupted run. directory: of the run. UsageError if it has no record."""
    from crosscheck.report.html import write_report

    _say_if_torn(directory)
    print(write_report(directory))


def _say_if_torn(directory: Path) -> None:
    if is_torn(directory):
        print(f"crosscheck: {directory / FILE}: its last line is incomplete, and does not count", file=sys.stderr)


def simulate(
    scene: Path, engine_list: list[str], out: Path, time_limit: float = TIME_LIMIT, restart: Path | None = None
) -> int:
    """Runs a scene, prints how the runs went and the paths of the files written; returns the exit status.

    scene: a TOML file, or the name of a shipped scene. engine_list: names, or path.py:Class. out: directory of the
    files. time_limit: seconds that one call of an engine may take. restart: a restart file to go on from; None: none.
    The status is 1 if a run diverged, stopped before its end, or failed, else 0. UsageError: see
    `crosscheck.simulate.run.simulate`, and if another run is writing there.
    """
    from crosscheck.simulate.run import simulate as simulate_scene
    from crosscheck.simulate.summary import LEVELS

    refuse_no_directory(out, "the files")
    with locked(out), naming(out):
        done = simulate_scene(scene, engine_list, out, time_limit, restart)
    console = _console()
    table = Table(box=None, pad_edge=False)
    for title in ("engine", "method"):
        table.add_column(title, overflow="fold")
    for title in ("work", "CPU", "per second", "cost", "energy", "momentum"):
        table.add_column(title, justify="right", overflow="fold")
    table.add_column("end", no_wrap=True)
    for row in done.rows:
        end = row.end if row.end == "whole" else f"[{_COLOURS['fail']}]{row.end}[/]"
        table.add_row(
            *map(escape, (row.engine, row.method, row.work, f"{row.cpu:.3g} s", f"{row.speed:.3g}", row.each)),
            *map(escape, (row.energy, row.momentum)),
            end,
        )
    console.print(table, highlight=False)
    if done.differences:
        table = Table(box=None, pad_edge=False)
        for title in ("difference of", "quantity", "largest", "relative to"):
            table.add_column(title, overflow="fold")
        for level in LEVELS:
            table.add_column(f"passed {level:g}", justify="right")
        for one in done.differences:
            times = ("never" if time is None else f"t = {time:g}" for time in one.passed)
            table.add_row(*map(escape, (" - ".join(one.engines), one.what, f"{one.largest:.2e}", one.unit)), *times)
        console.print(table, highlight=False)
    for text in (*done.endings, *done.remarks, *done.failures):
        print(text, file=sys.stdout if done.whole else sys.stderr)
    for path in done.paths:
        print(path)
    return 0 if done.whole else 1


# -- prove -----------------------------------------------------------------------------------------


def prove(patterns: list[str], jobs: int | None, seed: int, time_limit: float = TIME_LIMIT) -> int:
    """Runs checks with their planted faults, and prints a line for each; returns the exit status.

    patterns: shell patterns of names of checks or of `check/variant`; none: all. jobs: faults at a time; None: one per
    core. seed: the suite's seed. time_limit: seconds that one call of an engine may take. The status is 0 if every
    fault turns its check red, else 1. UsageError if a pattern matches no check with a fault, or the text that a fault
    replaces is not there.
    """

    def matches(pattern: str, check: Check, variant: str) -> bool:
        return fnmatchcase(check.name, pattern) or fnmatchcase(f"{check.name}/{variant}", pattern)

    planted = [
        (check, variant, fault)
        for check in all_checks()
        for variant, fault in check.faults
        if not patterns or any(matches(pattern, check, variant) for pattern in patterns)
    ]
    for pattern in patterns:
        if not any(matches(pattern, check, variant) for check, variant, _ in planted):
            raise UsageError(f"no check matches {pattern}; see `crosscheck list`")
    undetected = 0
    with ThreadPoolExecutor(_that_pay(jobs, len(planted))) as pool:
        results = pool.map(lambda item: _prove_one(*item, seed=seed, time_limit=time_limit), planted)
        for (check, variant, fault), verdict in zip(planted, results, strict=True):
            red = verdict.outcome == "fail"
            undetected += not red
            state = "red" if red else f"NOT RED ({verdict.outcome})"
            print(f"{state:<16} {check.name}/{variant}  {fault.name}: {fault.breaks}", flush=True)
            if verdict.message:
                print(f"    {verdict.message}")
    runner.close_pools()
    print(f"{len(planted) - undetected} of {len(planted)} planted faults turned their check red")
    return 1 if undetected else 0


def _prove_one(check: Check, variant: str, fault: Fault, *, seed: int, time_limit: float) -> Verdict:
    with tempfile.TemporaryDirectory(prefix="crosscheck-fault-") as directory:
        overlay = Path(directory)
        fault.apply(overlay)
        case = runner.Case(check.name, variant, "refimpl", check.timing)
        verdict = runner.judge(case, seed, overlay, time_limit)
    return replace(verdict, cost={})
