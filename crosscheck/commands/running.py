"""The command `run`: cases, record, report, and the exit status."""

from __future__ import annotations

import shlex
import sys
import time
from collections import Counter
from collections.abc import Set
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from crosscheck import runner, status
from crosscheck.budget.plan import Budget
from crosscheck.checks import all_checks
from crosscheck.checks.base import TIERS
from crosscheck.commands.budgeting import summary_of_left_out, within
from crosscheck.commands.console import COLOURS, plain, say_if_torn, that_pay, wide_console
from crosscheck.commands.regressing import Against, gone, marks, sections
from crosscheck.directory import locked
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing, UsageError
from crosscheck.files import refuse_no_directory, refuse_unwritable
from crosscheck.record import (
    FILE,
    Line,
    Record,
    case_name,
    deciding,
    finished,
    is_left_out,
    provenance,
    read,
    worst_judgement,
)
from crosscheck.regression import shown
from crosscheck.regression.difference import Difference
from crosscheck.report.markdown import append, of_run, of_server
from crosscheck.verdict import LEFT_OUT, Verdict


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
        if verdict.message.startswith(LEFT_OUT) and verdict.name not in self._running:
            return  # nothing was run; there may be hundreds
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
    baseline: Path | None = None,
    summary: Path | None = None,
    budget: float | None = None,
) -> int:
    """Runs cases, writes record and report, prints a table; returns the exit status.

    patterns: shell patterns of names of checks or cases; none: all. tier: "quick" or "full". engine_list: names, or
    path.py:Class; none: all installed. seed: the suite's seed. jobs: cases at a time; None: one per core. out:
    directory of record and report. resume: directory of an interrupted run to be completed, in place of out; None: a
    new run. junit: file for JUnit XML; None: none. required: names of engines that must be there. allow_inconclusive:
    inconclusive verdicts do not change the exit status. time_limit: seconds that one call of an engine may take.
    baseline: file of the results that are known; None: none. summary: file for a summary in Markdown; None: none,
    beside that of the CI server.
    budget: seconds that the run may take; None: as many as it needs.

    The status: see `crosscheck.status.Status`. It follows from the verdicts of this run and, where one is completed,
    those that it had; with a baseline, from what differs from it. UsageError for an unknown tier or engine, if a
    pattern matches no check, if another run is writing to the directory, if the run to be completed had another seed,
    or if the baseline cannot be read.
    """
    if tier not in TIERS:
        raise UsageError(f"--tier {tier}: unknown; take {', '.join(TIERS[:-1])} or {TIERS[-1]}")
    engines = engine_list or engine_names()
    began = time.monotonic()
    cases = runner.select(patterns, tier, engines, budget=budget is not None)
    directory = resume or out
    _refuse_unwritable_results(directory, resume, [junit, summary, of_server()])
    against = None if baseline is None else Against(baseline, patterns, tier, engine_list)
    waived = frozenset() if budget is None else runner.OF_SPEED
    told = _Telling(junit, summary, allow_inconclusive, against, waived)
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
        jobs = that_pay(jobs, len(left))
        chosen = None if budget is None else within(budget, left, jobs, began)
        own, interruption = _judged(left, seed, jobs, record, time_limit, chosen)
        lines = list((before | own).values())
        if interruption is not None:
            return told.interrupted(lines, len(left), directory, interruption)
        expected = [*engine_list, *(name for name in required if name in engines)]
        return told.finished(lines, engine_list, expected, directory, time.perf_counter() - started)


def _refuse_unwritable_results(directory: Path, resumed: Path | None, files: list[Path | None]) -> None:
    """UsageError if there is nothing to complete, or the results cannot be written, before anything is made.

    files: to be written outside of the directory.
    """
    from crosscheck.report.html import FILE as REPORT

    if resumed is not None:
        read(resumed)
        say_if_torn(resumed)
    refuse_no_directory(directory, "the record")
    for path in (directory / FILE, directory / REPORT, *(file for file in files if file is not None)):
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
    cases: list[runner.Case], seed: int, jobs: int, record: Record, time_limit: float, budget: Budget | None
) -> tuple[dict[tuple[str, str], Line], int | None]:
    """Runs the cases; their lines as they are in the record, by case and engine; the status if it was interrupted."""
    cases = cases if budget is None else budget.cases
    display = _Display(len(cases))
    lines = {}
    try:
        for verdict in runner.run(cases, seed, jobs, display.started, None, time_limit, budget):
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
    """Tells the user, and in files for other tools, how a run ended.

    junit, summary: these files, or None. against: the baseline that the run is compared with, or None. waived: promises
    that were not asked for.
    """

    def __init__(
        self,
        junit: Path | None,
        summary: Path | None,
        allow_inconclusive: bool,
        against: Against | None,
        waived: Set[str] = frozenset(),
    ) -> None:
        self._junit, self._summary = junit, summary
        self._allow_inconclusive, self._against, self._waived = allow_inconclusive, against, waived

    def unjudged(self, lines: list[Line], reasons: list[str], difference: Difference | None = None) -> int:
        """The status of a run that judged nothing, or nothing of an engine that was named."""
        for reason in reasons:
            print(f"crosscheck: {reason}", file=sys.stderr)
        self._write(lines, reasons, difference)
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

        console = wide_console()
        print_table(console, lines)
        for name in named:
            print(_share_of_checks(name, self._waived))
        report_path = write_report(directory)
        counts = Counter(line["outcome"] for line in lines)
        summary = ", ".join(f"{counts[outcome]} {outcome}" for outcome in COLOURS if counts[outcome])
        console.print(f"{summary} in {seconds:.0f} s; report: {report_path}", highlight=False, soft_wrap=True)
        alarms = status.false_alarms(lines)
        if alarms:
            print(alarms)
        reasons = status.unjudged(lines, expected)
        result = status.of(lines, reasons, self._allow_inconclusive)
        difference = None
        if self._against is not None:
            difference = self._against.difference(lines, directory)
            self._against.say(difference, directory)
            unjudged = [status.Status.UNJUDGED] if reasons else []
            result = status.decisive(difference.status(self._allow_inconclusive), *unjudged)
        if reasons:
            self.unjudged(lines, reasons, difference)
            return int(result)
        if result == status.Status.INCONCLUSIVE:
            number = counts["inconclusive"]
            print(f"crosscheck: {number} inconclusive: see --allow-inconclusive", file=sys.stderr)
        self._write(lines, [], difference)
        return int(result)

    def _write(self, lines: list[Line], reasons: list[str], difference: Difference | None = None) -> None:
        """Writes the files for other tools. difference: between the baseline and the run; None: there is none."""
        from crosscheck.report.junit import write_junit

        compared = "" if difference is None else shown.summary(difference)
        command = shlex.join(["crosscheck", *sys.argv[1:]])
        append(of_run(lines, reasons, command, compared, sections(difference)), self._summary)
        if self._junit is not None:
            problems = reasons if difference is None else [*reasons, *gone(difference, lines)]
            known = {} if difference is None else marks(difference)
            write_junit(lines, self._junit, problems, self._allow_inconclusive, known)


def _share_of_checks(name: str, waived: Set[str]) -> str:
    """How many checks judge the engine of this name: what the others measured of it is nothing, and not green."""
    checks = all_checks()
    matched = sum(bool(runner.judging(check, name, engine_class(name), waived)) for check in checks)
    rest = len(checks) - matched
    return f"{name}: {matched} checks match what it declares, {rest} need more and say nothing of it (docs/engines.md)"


def print_table(console: Console, lines: list[Line]) -> None:
    """Prints a row for each case, worst last, and what is to be said of those that were left out, skipped or red.

    console: where to. lines: of the record.
    """
    from crosscheck.report import numbers

    table = Table(box=None, pad_edge=False)
    for title in ("check", "engine"):
        table.add_column(title, overflow="fold")
    for title in ("measured", "expected", "deviation", "sensitivity", "cost"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    order = {outcome: rank for rank, outcome in enumerate(("pass", "skip", "inconclusive", "error", "fail"))}
    shown_lines = [line for line in lines if not is_left_out(line)]
    for line in sorted(shown_lines, key=lambda item: (order[item["outcome"]], case_name(item), item["engine"])):
        found = worst_judgement(line)
        values = (numbers.measured, numbers.expected, numbers.deviation, numbers.sensitivity)
        outcome = line["outcome"]
        table.add_row(
            plain(case_name(line)),
            plain(line["engine"]),
            *("" if found is None else value(found) for value in values),
            numbers.seconds(line["cost"].get("seconds")),
            f"[{COLOURS[outcome]}]{outcome}[/]",
        )
    console.print(table)
    told = summary_of_left_out(lines)
    if told:
        console.print(told, style="dim", highlight=False, markup=False, soft_wrap=True)
    reasons = Counter(line["message"] for line in lines if line["outcome"] == "skip" and not is_left_out(line))
    for reason, count in reasons.items():
        console.print(f"skipped {count}: {reason}", style="dim", highlight=False, markup=False, soft_wrap=True)
    for line in lines:
        if line["outcome"] in ("fail", "error"):
            parts = [*(one["quantity"] for one in deciding(line)), line["note"], line["message"]]
            text = f"{case_name(line)} [{line['engine']}]: {'; '.join(filter(None, parts))}"
            console.print(text, style=COLOURS[line["outcome"]], highlight=False, markup=False, soft_wrap=True)
