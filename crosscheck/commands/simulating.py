"""The command `simulate`: one scene on one or more engines, and verdicts on what they did."""

from __future__ import annotations

import shlex
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rich.markup import escape
from rich.table import Table

from crosscheck import status
from crosscheck.commands.console import COLOURS, wide_console
from crosscheck.directory import locked
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.files import naming, refuse_no_directory, refuse_unwritable
from crosscheck.record import FILE, Line, Record, provenance
from crosscheck.status import Status, decisive
from crosscheck.verdict import Verdict

if TYPE_CHECKING:
    from crosscheck.simulate.judging.ladder import Ladder
    from crosscheck.simulate.run import Simulation


def simulate(
    scene: Path,
    engine_list: list[str],
    out: Path,
    time_limit: float = TIME_LIMIT,
    restart: Path | None = None,
    formats: tuple[str, ...] = (),
    methods: Sequence[str] = (),
) -> int:
    """Runs a scene, prints how the runs went and the paths of the files written; returns the exit status.

    scene: a TOML file, or the name of a shipped scene. engine_list: names, or path.py:Class. out: directory of the
    files. time_limit: seconds that one call of an engine may take. restart: a restart file to go on from; None: none.
    formats: of the trajectories; none: the default. methods: of single engines, or of all, see
    `crosscheck.simulate.methods.planned`.

    The status is FAILED if a run diverged or stopped before its end, else UNJUDGED if an engine failed, or the picture
    could not be drawn, else PASSED. UsageError: see `crosscheck.simulate.run.simulate`, and if another run is writing
    there.
    """
    from crosscheck.simulate.run import simulate as simulate_scene

    refuse_no_directory(out, "the files")
    with locked(out), naming(out):
        done = simulate_scene(scene, engine_list, out, time_limit, restart, formats, methods)
    _print_runs(done)
    return int(_of_runs(done))


def _of_runs(done: Simulation) -> Status:
    """The status that follows from how the runs went."""
    ended_early = any(row.end != "whole" for row in done.rows)
    return decisive(*([Status.FAILED] if ended_early else []), *([Status.UNJUDGED] if done.failures else []))


class Demand(NamedTuple):
    """What is asked of verdicts.

    tolerance: of the changes on halving dt, relative. allow_inconclusive: such verdicts do not change the status.
    """

    tolerance: float
    allow_inconclusive: bool


def judge(
    scene: Path,
    engine_list: list[str],
    out: Path,
    time_limit: float,
    restart: Path | None,
    formats: tuple[str, ...],
    methods: Sequence[str],
    demand: Demand,
) -> int:
    """As `simulate`, and judges all that holds for any scene; writes the record and the report.

    scene, engine_list, out, time_limit, restart, formats, methods: as of `simulate`, but a restart file is refused
    (UsageError). demand: what is asked of the verdicts. Returns a status of `crosscheck.status.Status`.
    """
    from crosscheck.report.html import FILE as REPORT
    from crosscheck.report.html import write_report
    from crosscheck.simulate.run import Judging
    from crosscheck.simulate.run import simulate as simulate_scene

    refuse_no_directory(out, "the files")
    for path in (out / FILE, out / REPORT):
        refuse_unwritable(path)
    lines: list[Line] = []
    with locked(out), naming(out):
        record = Record(out, provenance(0, shlex.join(["crosscheck", *sys.argv[1:]])))

        def begin(done: Simulation) -> None:
            _print_runs(done)
            if record.path.exists():
                record.path.replace(out / f"previous-{FILE}")

        def take(verdict: Verdict) -> None:
            lines.append(record.append(verdict))

        started = time.perf_counter()
        judging = Judging(demand.tolerance, begin, lambda text: print(text, file=sys.stderr, flush=True), take)
        done = simulate_scene(scene, engine_list, out, time_limit, restart, formats, methods, judging)
        return _told(done, lines, write_report(out), time.perf_counter() - started, demand)


def _print_runs(done: Simulation) -> None:
    """Prints how the runs went, how far they are apart, and the paths of the files."""
    from crosscheck.simulate.summary import LEVELS

    console = wide_console()
    table = Table(box=None, pad_edge=False)
    for title in ("engine", "method"):
        table.add_column(title, overflow="fold")
    for title in ("work", "CPU", "per second", "cost", "energy", "momentum"):
        table.add_column(title, justify="right", overflow="fold")
    table.add_column("end", no_wrap=True)
    for row in done.rows:
        end = row.end if row.end == "whole" else f"[{COLOURS['fail']}]{row.end}[/]"
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
        print(path, flush=True)


def _told(done: Simulation, lines: list[Line], report: Path, seconds: float, demand: Demand) -> int:
    """Prints the verdicts; the exit status."""
    from crosscheck.commands.running import print_table
    from crosscheck.simulate.judging.judge import JUDGE_NOTHING

    console = wide_console()
    for label, found in done.ladders.items():
        print()
        _print_ladder(label, found)
    print()
    print_table(console, [line for line in lines if line["outcome"] != "skip"])
    skipped: dict[str, list[str]] = {}
    for line in lines:
        if line["outcome"] == "skip":
            skipped.setdefault(str(line["message"]), []).append(line["engine"])
    several = len({row.engine for row in done.rows}) > 1
    for reason, engines in skipped.items():
        text = f"not judged: {reason}" + (f" ({', '.join(engines)})" if several else "")
        console.print(text, style="dim", highlight=False, markup=False, soft_wrap=True)
    counts = Counter(line["outcome"] for line in lines)
    summary = ", ".join(f"{counts[outcome]} {outcome}" for outcome in COLOURS if counts[outcome])
    console.print(f"{summary} in {seconds:.0f} s; report: {report}", highlight=False, soft_wrap=True)
    alarms = status.false_alarms(lines)
    if alarms:
        print(alarms)
    judged = [line for line in lines if line["variant"] not in JUDGE_NOTHING]
    reasons = status.unjudged(judged, [row.engine for row in done.rows])
    for reason in reasons:
        print(f"crosscheck: {reason}", file=sys.stderr)
    result = decisive(_of_runs(done), status.of(lines, reasons, demand.allow_inconclusive))
    if result == Status.INCONCLUSIVE:
        print(f"crosscheck: {counts['inconclusive']} inconclusive: see --allow-inconclusive", file=sys.stderr)
    return int(result)


def _print_ladder(label: str, found: Ladder) -> None:
    """Prints what halving the time step of a run has changed."""
    table = Table(box=None, pad_edge=False)
    table.add_column(f"time step of {escape(label)}", justify="right")
    for title in ("positions change by", "order", "energy changes by", "order", "CPU"):
        table.add_column(title, justify="right")
    for rung in found.rungs:
        table.add_row(
            f"{rung.step:g}",
            *(f"{rung.change:.2e}" if rung.change is not None else "", _order(rung.order)),
            *(f"{rung.energy:.2e}" if rung.energy is not None else "", _order(rung.energy_order)),
            f"{rung.cpu:.2g} s",
        )
    console = wide_console()
    console.print(table, highlight=False)
    text = f"on halving it, until t = {found.until:g}; positions relative to the {found.unit}, energies to the largest"
    console.print(text, style="dim", highlight=False, soft_wrap=True)


def _order(order: float | None) -> str:
    return "" if order is None else f"{order:.2f}"
