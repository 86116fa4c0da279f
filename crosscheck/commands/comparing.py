"""The commands `compare` and `repeat`: two results or many, and one scene several times."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crosscheck.commands.console import progress_of
from crosscheck.commands.regressing import diff
from crosscheck.compare.differences import VECTORS
from crosscheck.compare.growth import EPSILON, Rate
from crosscheck.compare.outcome import MODES, Mode, status
from crosscheck.compare.replicas import Replicas, replicas
from crosscheck.compare.tables import TableComparison, compare_tables
from crosscheck.compare.trajectories import Comparison, compare_trajectories
from crosscheck.compare.written import document, table_document
from crosscheck.directory import locked
from crosscheck.errors import UsageError
from crosscheck.files import naming, refuse_no_directory, shown_path
from crosscheck.record import FILE
from crosscheck.status import Status, decisive
from crosscheck.text import printable
from crosscheck.trajectories.frames import Series, Source
from crosscheck.trajectories.reading import open_results, results_in

#: The files that a comparison writes.
PAGE, DOCUMENT = "compare.html", "compare.json"


@dataclass(frozen=True)
class Standard:
    """How results are compared.

    mode: "exact", "tolerance", "chaos" or "statistics"; None: the usual one, "chaos" of trajectories. tolerance: with
    mode "tolerance", a distance that counts as the same. arithmetic: "double" or "single", of the runs. topology: file
    with types and masses. scene, engine: a scene whose rate of growth an engine measures; None: the data tell it.
    time_limit: seconds that one run of it may take.
    """

    mode: str | None
    tolerance: float | None
    arithmetic: str
    topology: Path | None
    scene: Path | None
    engine: str
    time_limit: float


def compare(files: Sequence[Path], asked: Standard, out: Path) -> int:
    """Compares results, prints what they are to each other, writes page and JSON; returns the exit status.

    files: two or more files of results, or directories with one each; two records are compared as by `diff`. asked: the
    standard. out: directory of page and JSON. The status is 0 if they are the same by the standard, 1 if not, 3 if that
    cannot be told. UsageError for files that cannot be read or compared, and for unknown words.
    """
    if len(files) < 2:
        raise UsageError("compare: give two or more files of results, or directories with one each")
    if all(_is_record(file) for file in files):
        if len(files) > 2:
            raise UsageError("compare: of records, give two")
        return diff(files[0], files[1], "refimpl", as_json=False, summary=None)
    refuse_no_directory(out, "the comparison")
    paths = [results_in(file) for file in files]
    opened = [open_results(path, asked.topology) for path in paths]
    mode = _checked(asked, "statistics" if all(isinstance(one, Series) for one in opened) else "chaos")
    rate = _rate(asked)
    with locked(out), naming(out):
        return int(_compared(opened, mode, asked, rate, out))


def _is_record(path: Path) -> bool:
    return (path / FILE).is_file() or path.suffix == ".jsonl"


def _checked(asked: Standard, usual: Mode) -> Mode:
    """The standard that is asked for; `usual` if none is. UsageError for words that are none."""
    if asked.mode is not None and asked.mode not in MODES:
        raise UsageError(f"--mode {printable(asked.mode)}: give one of {', '.join(MODES)}")
    if asked.arithmetic not in EPSILON:
        raise UsageError(f"--arithmetic {printable(asked.arithmetic)}: give one of {', '.join(EPSILON)}")
    if asked.tolerance is not None and asked.mode != "tolerance":
        raise UsageError("--tolerance: goes with --mode tolerance")
    return asked.mode or usual


def _rate(asked: Standard) -> Rate | None:
    if asked.scene is None:
        return None
    from crosscheck.compare.twin import twin_rate
    from crosscheck.simulate.run import load

    return twin_rate(load(asked.scene), asked.engine, asked.time_limit)


def _compared(opened: Sequence[Source | Series], mode: Mode, asked: Standard, rate: Rate | None, out: Path) -> Status:
    tables = [one for one in opened if isinstance(one, Series)]
    sources = [one for one in opened if isinstance(one, Source)]
    if tables and sources:
        raise UsageError(
            f"{shown_path(tables[0].path)} is a table in time, {shown_path(sources[0].path)} a trajectory: compare "
            "files of one kind"
        )
    if len(tables) > 2:
        raise UsageError("compare: of tables in time, give two")
    if tables:
        found = compare_tables(*tables)
        _print_table(found)
        _write(out / DOCUMENT, table_document(found, mode))
        return status(found.classed, mode)
    if len(sources) == 2:
        with progress_of("frames") as progress:
            pair = _of_two(sources[0], sources[1], mode, asked, rate, progress)
        _print(pair)
        _write_all(pair, mode, out)
        return status(pair.classed, mode)
    with progress_of("files") as progress:
        several = replicas(sources, progress)
    return _print_replicas(several, sources, mode, asked, rate, out)


def _of_two(one: Source, other: Source, mode: Mode, asked: Standard, rate: Rate | None, progress: Any) -> Comparison:
    return compare_trajectories(
        one, other, mode, arithmetic=asked.arithmetic, rate=rate, tolerance=asked.tolerance, progress=progress
    )


def _print_replicas(
    found: Replicas,
    sources: Sequence[Source],
    mode: Mode,
    asked: Standard,
    rate: Rate | None,
    out: Path,
) -> Status:
    """Says which runs left the others, and compares each of them with one that did not."""
    names = [shown_path(source.path) for source in sources]
    stayed = len(sources) - len(found.left)
    print(f"{len(sources)} runs, {found.frames} common frames; {stayed} are the same to the last bit")
    for text in found.remarks:
        print(f"remark: {text}")
    if not found.left:
        return Status.PASSED
    statuses = []
    first = True
    for member, place in sorted(found.left.items(), key=lambda pair: (pair[1], pair[0])):
        pair = _of_two(sources[found.reference], sources[member], mode, asked, rate, lambda done, total: None)
        print(f"\n{names[member]} left the others at {found.when(place)}:")
        _print_findings(pair)
        statuses.append(status(pair.classed, mode))
        if first:
            _write_all(pair, mode, out)
            first = False
    return decisive(*statuses)


def repeat(scene: Path, engine: str, times: int, threads: Sequence[int], asked: Standard, out: Path) -> int:
    """Runs a scene several times on one engine, says whether the runs are the same; returns the exit status.

    scene: a TOML file, or the name of a shipped scene. engine: its name, or path.py:Class. times: runs for each number
    of threads. threads: numbers of threads. asked: how runs are compared that are not the same to the last bit. out:
    directory of the runs and the comparison. The status is that of `compare`.
    UsageError, EngineError: see `crosscheck.simulate.repeating.repeat`.
    """
    from crosscheck.simulate.repeating import repeat as run_again

    mode = _checked(asked, "exact")
    refuse_no_directory(out, "the runs")
    with locked(out), naming(out):
        paths = run_again(scene, engine, times, threads, out, asked.time_limit)
        sources = [one for one in map(open_results, paths) if isinstance(one, Source)]
        if len(sources) < 2:
            raise UsageError("repeat: the scene records no positions of particles: nothing can be compared")
        several = replicas(sources)
        found = _print_replicas(several, sources, mode, asked, None, out)
    if several.left:
        print(f"{engine} is not deterministic here: {len(several.groups)} different results in {len(sources)} runs")
    else:
        print(f"{engine} is deterministic in this scene: one result in {len(sources)} runs")
    return int(found)


# -- what is printed and written -----------------------------------------------------------------------------


def _print(found: Comparison) -> None:
    _print_head(found, f"{found.particles} particles, {len(found.gaps)} common frames, matched by {found.clock}")
    _print_findings(found)


def _print_findings(found: Comparison) -> None:
    for title, one in (("first bits that differ", found.bits), ("first beyond the files' rounding", found.beyond)):
        if one is not None:
            print(
                f"{title}: {found.when(one.pair)}, {VECTORS[one.quantity]} {'xyz'[one.axis]} of particle "
                f"{one.particle}: {one.first!r} against {one.second!r} (rounding {one.rounding:.1e})"
            )
    print(found.sentence)


def _print_table(found: TableComparison) -> None:
    _print_head(found, f"{found.rows} common rows of {', '.join(found.columns)}")
    print(found.sentence)


def _print_head(found: Comparison | TableComparison, compared: str) -> None:
    print(f"first: {found.first} ({found.formats[0]})\nsecond: {found.second} ({found.formats[1]})")
    print(f"compared: {compared}")
    for text in found.remarks:
        print(f"remark: {text}")


def _write_all(found: Comparison, mode: Mode, out: Path) -> None:
    from crosscheck.report.comparison import write_page

    _write(out / DOCUMENT, document(found, mode))
    print(write_page(found, mode, out / PAGE))


def _write(path: Path, content: dict[str, Any]) -> None:
    with naming(path):
        path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    print(path)
