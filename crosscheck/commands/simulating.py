"""The command `simulate`: one scene on one or more engines."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from crosscheck.commands.console import COLOURS, wide_console
from crosscheck.directory import locked
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.files import naming, refuse_no_directory
from crosscheck.status import Status, decisive


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
    from crosscheck.simulate.summary import LEVELS

    refuse_no_directory(out, "the files")
    with locked(out), naming(out):
        done = simulate_scene(scene, engine_list, out, time_limit, restart, formats, methods)
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
        print(path)
    ended_early = any(row.end != "whole" for row in done.rows)
    return int(decisive(*([Status.FAILED] if ended_early else []), *([Status.UNJUDGED] if done.failures else [])))
