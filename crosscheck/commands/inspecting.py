"""The command `inspect`: one trajectory alone."""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from rich.console import Console
from rich.table import Table

from crosscheck import status
from crosscheck.commands.console import COLOURS, plain, progress_of, wide_console
from crosscheck.errors import UsageError
from crosscheck.files import naming, refuse_unwritable, shown_path
from crosscheck.text import printable
from crosscheck.verdict import Judgement

if TYPE_CHECKING:
    from crosscheck.inspect.inspection import Inspection
    from crosscheck.inspect.setting import Options
    from crosscheck.scene import Scene
    from crosscheck.trajectories.frames import Source


class Said(NamedTuple):
    """What the user says of a trajectory, as it stands on the command line.

    scene: file or name of a scene. ensemble, temperature, hard, homogeneous, constraints, skip, arithmetic: as of
    `inspect.setting.Options`.
    masses: texts TYPE=MASS.
    """

    scene: Path | None
    ensemble: str | None
    temperature: str | None
    masses: list[str]
    hard: bool
    homogeneous: bool
    constraints: int
    skip: float
    arithmetic: str


def inspect(
    trajectory: Path, topology: Path | None, said: Said, results: Path | None, page: Path | None, allow: bool
) -> int:
    """Inspects a trajectory, prints what its properties say, and returns the exit status.

    trajectory: the file. topology: a file with masses and types, for formats that hold coordinates alone. said: what
    the user says of it. results: file for all of it as JSON; page: as HTML; None: none. allow: inconclusive verdicts
    count as passed. The status: see `crosscheck.status.Status`; 4 if nothing but the file itself could be judged.
    UsageError if the file cannot be read, holds no positions, or does not fit what is said of it.
    """
    from crosscheck.inspect.inspection import inspect_trajectory
    from crosscheck.simulate.run import load

    for path in (results, page):
        if path is not None:
            refuse_unwritable(path)
    options = _options(said)
    scene: Scene | None = None if said.scene is None else load(said.scene)
    source = _opened(trajectory, topology)
    with progress_of(trajectory.name) as progress:
        inspection = inspect_trajectory(source, scene, options, progress)
    found = [{"outcome": one.outcome} for one in inspection.judgements]
    unjudged = [] if _judges_more_than_the_file(inspection) else ["nothing but the file itself was judged"]
    result = status.of(found, unjudged, allow)
    _print(inspection, trajectory)
    if results is not None:
        with naming(results):
            results.parent.mkdir(parents=True, exist_ok=True)
            results.write_text(json.dumps(_as_json(inspection, result), indent=1) + "\n", encoding="utf-8")
    if page is not None:
        from crosscheck.inspect.page import write_page

        write_page(inspection, page)
        print(page)
    for reason in unjudged:
        print(f"crosscheck: {reason}", file=sys.stderr)
    return int(result)


def _options(said: Said) -> Options:
    from crosscheck.compare.growth import EPSILON
    from crosscheck.inspect.setting import ENSEMBLES, Ensemble, Options

    for name, value, known in (("ensemble", said.ensemble, ENSEMBLES), ("arithmetic", said.arithmetic, tuple(EPSILON))):
        if value is not None and value not in known:
            raise UsageError(f"--{name} {value}: unknown; take one of {', '.join(known)}")
    if not 0 <= said.skip < 1:
        raise UsageError(f"--skip {said.skip:g}: give a share of the frames, 0 or more and below 1")
    masses = {}
    for text in said.masses:
        name, _, mass = text.rpartition("=")
        try:
            masses[name] = float(mass)
        except ValueError:
            masses[name] = float("nan")
        if not name or not 0 < masses[name] < float("inf"):
            raise UsageError(f"--mass {text}: give TYPE=MASS with a mass above 0, as 1=39.95; all=1 of one type")
    ensemble = cast("Ensemble | None", said.ensemble)
    return Options(
        ensemble,
        said.temperature,
        masses,
        said.hard,
        said.homogeneous,
        said.constraints,
        said.skip,
        said.arithmetic,
    )


def _opened(path: Path, topology: Path | None) -> Source:
    from crosscheck.trajectories.frames import Source
    from crosscheck.trajectories.reading import open_results

    opened = open_results(path, topology)
    if not isinstance(opened, Source):
        raise UsageError(f"{shown_path(path)}: it holds no positions ({opened.format}): give a trajectory")
    return opened


def _judges_more_than_the_file(inspection: Inspection) -> bool:
    return any(one.told.judgements for one in inspection.found if one.property.chapter != "file")


# -- output --------------------------------------------------------------------------------------------------


def _print(inspection: Inspection, trajectory: Path) -> None:
    from crosscheck.inspect.setting import TAKEN

    setting = inspection.setting
    source = setting.source
    about = f"{source.format}, {len(source)} frames of {len(setting.first.ids)} particles"
    print(f"{shown_path(trajectory)}: {about}; taken to be {TAKEN[setting.ensemble]}.")
    for remark in (*source.remarks, *setting.remarks):
        print(f"  {printable(remark)}")
    console = wide_console()
    console.print(_table(inspection))
    for one in inspection.found:
        for text in one.told.said:
            _say(console, f"{one.property.name}: {text}", "")
    for one in inspection.found:
        if one.unsaid:
            _say(console, f"{one.property.name}: cannot be said: {one.unsaid}.", "dim")
    for outcome in ("inconclusive", "fail"):
        for one in inspection.found:
            for judgement in one.told.judgements:
                if judgement.outcome == outcome:
                    _say(console, _reason(one.property.name, judgement), COLOURS[outcome])
    counts: Counter[str] = Counter(judgement.outcome for judgement in inspection.judgements)
    summary = ", ".join(f"{counts[outcome]} {outcome}" for outcome in COLOURS if counts[outcome])
    unsaid = sum(bool(one.unsaid) for one in inspection.found)
    if unsaid:
        summary += f"; {unsaid} {'property' if unsaid == 1 else 'properties'} cannot be said"
    print(summary)
    print(
        f"false alarms: a right trajectory is red with the probability {inspection.false_alarms:.1g}, of all "
        "statistical judgements together"
    )


def _say(console: Console, text: str, style: str) -> None:
    console.print(printable(text), style=style or None, highlight=False, markup=False, soft_wrap=True)


def _reason(name: str, judgement: Judgement) -> str:
    """What is red or open, where, and by which criterion."""
    few = (
        "too few independent values, or too little would have been seen" if judgement.outcome == "inconclusive" else ""
    )
    parts = (judgement.quantity, judgement.note, few, judgement.criterion.why)
    return f"{name}: {judgement.outcome}: {'; '.join(filter(None, parts))}"


def _table(inspection: Inspection) -> Table:
    from crosscheck.report import numbers

    table = Table(box=None, pad_edge=False)
    for title in ("property", "judgement"):
        table.add_column(title, overflow="fold")
    for title in ("measured", "expected", "deviation", "sensitivity"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for one in inspection.found:
        for number, judgement in enumerate(one.told.judgements):
            record = judgement.as_record()
            values = (numbers.measured, numbers.expected, numbers.deviation, numbers.sensitivity)
            table.add_row(
                plain(one.property.name) if number == 0 else "",
                plain(judgement.quantity),
                *(value(record) for value in values),
                f"[{COLOURS[judgement.outcome]}]{judgement.outcome}[/]",
            )
    return table


def _as_json(inspection: Inspection, result: status.Status) -> dict[str, Any]:
    """All that is told, as docs/inspect.md has it."""
    setting = inspection.setting
    source = setting.source
    return {
        "file": printable(str(source.path)),
        "format": source.format,
        "frames": len(source),
        "particles": len(setting.first.ids),
        "scene": None if setting.scene is None else setting.scene.name,
        "ensemble": setting.ensemble,
        "temperature": setting.temperature,
        "remarks": [*source.remarks, *setting.remarks],
        "false_alarms": inspection.false_alarms,
        "status": int(result),
        "properties": [
            {
                "name": one.property.name,
                "chapter": one.property.chapter,
                "judgements": [judgement.as_record() for judgement in one.told.judgements],
                "said": list(one.told.said),
                "unsaid": one.unsaid,
            }
            for one in inspection.found
        ],
    }
