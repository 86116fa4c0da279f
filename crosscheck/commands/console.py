"""What several commands print, and how."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from crosscheck.files import shown_path
from crosscheck.record import FILE, is_torn
from crosscheck.text import printable

#: Of outcomes in tables.
COLOURS = {
    "pass": "green",
    "fail": "bold red",
    "error": "bold magenta",
    "inconclusive": "yellow",
    "skip": "dim",
}


def wide_console() -> Console:
    """The console, wide enough for tables."""
    # at least 140 columns: in a narrow terminal, wrapped lines are easier to read than names folded within columns; a
    # pipe has no width
    console = Console()
    return Console(width=max(console.width, 140) if sys.stdout.isatty() else 200)


def plain(text: str) -> str:
    """The text for a table, in which rich would read words in square brackets as styles."""
    return escape(printable(text))


def that_pay(jobs: int | None, things: int) -> int:
    """How many of so many things to do at a time: no more than there are, nor than cores; says so if it was asked more.

    jobs: as asked; None: one per core.
    """
    cores = len(os.sched_getaffinity(0))
    most = max(1, min(cores, things))
    if jobs is not None and jobs > most:
        print(f"crosscheck: --jobs {jobs}: {most} at a time, for there are {things} to do on {cores} cores", flush=True)
    return min(jobs or most, most)


@contextmanager
def progress_of(what: str) -> Iterator[Callable[[int, int], None]]:
    """Shows on stderr how much is done: as a bar on a terminal, else as lines at ever longer intervals.

    what: that is being done. Gives a function that is told how many are done, and of how many.
    """
    if not sys.stderr.isatty():
        from crosscheck.simulate.progress import Lines

        lines, begun = Lines(printable(what)), time.monotonic()

        def say(done: int, total: int) -> None:
            text = lines.line(time.monotonic() - begun, "reading", done / total)
            if text is not None and done < total:
                print(text, file=sys.stderr, flush=True)

        yield say
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(plain(what), total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def say_if_torn(path: Path) -> None:
    """Says on stderr if a record ends in the middle of a line. path: of the record, or of its directory."""
    if is_torn(path):
        file = path / FILE if path.is_dir() else path
        print(f"crosscheck: {shown_path(file)}: its last line is incomplete, and does not count", file=sys.stderr)
