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

from crosscheck import runner
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check, Variant
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.registry import engine_class, engine_names
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
) -> int:
    """Runs cases, writes record and report, prints a table; returns the exit status.

    patterns: shell patterns of names of checks or cases; none: all. tier: "quick" or "full". engine_list: names, or
    path.py:Class; none: all installed. seed: the suite's seed. jobs: cases at a time; None: one per core. out:
    directory of record and report. resume: directory of an interrupted run to be completed, in place of out; None: a
    new run. junit: file for JUnit XML; None: none.

    The status is 1 if a case failed or ended in error, 130 after an interrupt by the user, else 0. UsageError for an
    unknown tier or engine, if no check matches, or if the run to be completed had another seed.
    """
    from crosscheck.report.html import FILE as REPORT
    from crosscheck.report.html import write_report
    from crosscheck.report.junit import write_junit

    if tier not in ("quick", "full"):
        raise UsageError(f"--tier {tier}: unknown; take quick or full")
    cases = runner.select(patterns, tier, engine_list or engine_names())
    directory = resume or out
    before = [] if resume is None else read(resume)
    refuse_no_directory(directory, "the record")
    for path in (directory / FILE, directory / REPORT, *([] if junit is None else [junit])):
        refuse_unwritable(path)
    if resume is not None:
        _say_if_torn(resume)
        if any(line["provenance"]["seed"] != seed for line in before):
            raise UsageError(f"{resume}: was run with another seed; resume it with that --seed, or start a new run")
        done = finished(before)
        cases = [case for case in cases if (case.name, case.engine) not in done]
    elif (directory / FILE).exists():
        # the last record in this directory is kept, in case it is of an interrupted run that was to be resumed
        (directory / FILE).replace(directory / f"previous-{FILE}")
    record = Record(directory, provenance(seed, shlex.join(["crosscheck", *sys.argv[1:]])))
    display = _Display(len(cases))
    started = time.perf_counter()
    try:
        for verdict in runner.run(cases, seed, jobs or len(os.sched_getaffinity(0)), display.started):
            record.append(verdict)
            display.finished(verdict)
    except KeyboardInterrupt:
        print(f"crosscheck: interrupted; the record has what was finished: --resume {directory}", file=sys.stderr)
        return 130
    finally:
        display.close()
    lines = read(directory)
    console = _console()
    _print_table(console, lines)
    for name in engine_list:
        print(_share_of_checks(name))
    report_path = write_report(directory)
    if junit is not None:
        write_junit(lines, junit)
    counts = Counter(line["outcome"] for line in lines)
    summary = ", ".join(f"{counts[outcome]} {outcome}" for outcome in _COLOURS if counts[outcome])
    console.print(
        f"{summary} in {time.perf_counter() - started:.0f} s; report: {report_path}", highlight=False, soft_wrap=True
    )
    return 1 if counts["fail"] or counts["error"] else 0


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


def simulate(scene: Path, engine_list: list[str], out: Path) -> None:
    """Runs a scene and prints the paths of the files written.

    scene: a TOML file, or the name of a shipped scene. engine_list: names, or path.py:Class. out: directory of the
    files. UsageError: see `crosscheck.simulate.run.simulate`.
    """
    from crosscheck.simulate.run import simulate as simulate_scene

    refuse_no_directory(out, "the files")
    with naming(out):
        written = simulate_scene(scene, engine_list, out)
    for path in written:
        print(path)


# -- prove -----------------------------------------------------------------------------------------


def prove(patterns: list[str], jobs: int | None, seed: int) -> int:
    """Runs checks with their planted faults, and prints a line for each; returns the exit status.

    patterns: shell patterns of names of checks or of `check/variant`; none: all. jobs: faults at a time; None: one per
    core. seed: the suite's seed. The status is 0 if every fault turns its check red, else 1. UsageError if no check
    with a fault matches, or the text that a fault replaces is not there.
    """
    planted = [
        (check, variant, fault)
        for check in all_checks()
        for variant, fault in check.faults
        if not patterns
        or any(fnmatchcase(check.name, p) or fnmatchcase(f"{check.name}/{variant}", p) for p in patterns)
    ]
    if not planted:
        raise UsageError(f"no check matches {' '.join(patterns)}; see `crosscheck list`")
    undetected = 0
    with ThreadPoolExecutor(jobs or len(os.sched_getaffinity(0))) as pool:
        results = pool.map(lambda item: _prove_one(*item, seed=seed), planted)
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


def _prove_one(check: Check, variant: str, fault: Fault, *, seed: int) -> Verdict:
    with tempfile.TemporaryDirectory(prefix="crosscheck-fault-") as directory:
        overlay = Path(directory)
        fault.apply(overlay)
        case = runner.Case(check.name, variant, "refimpl", check.timing)
        verdict = runner.judge(case, seed, overlay)
    return replace(verdict, cost={})
