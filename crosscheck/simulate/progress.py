"""Shows how far a run is: as a bar on a terminal, else as lines at ever longer intervals; all on stderr."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from crosscheck.engines.progress import read

#: Times, s: between two looks at the progress; before a stage is worth a line; before the first line on the share done.
_LOOK, _PATIENCE, _FIRST = 0.1, 2.0, 10.0


class Lines:
    """Decides when there is something to say about one run.

    engine: its label.
    """

    def __init__(self, engine: str) -> None:
        self._engine = engine
        self._said: set[str] = set()
        self._stage = ""
        self._since = self._started = 0.0
        self._next = _FIRST

    def line(self, now: float, stage: str, share: float | None) -> str | None:
        """A line to print now, or None. now: time since the start, s. stage, share: as `engines.progress.read`.

        None until the engine says what it does: whether it can run the scene is being asked, and where it cannot, one
        line says so, with none before it.
        """
        if stage != self._stage:
            self._stage, self._since = stage, now
            if share is not None:
                self._started = now
        if share is not None:
            if now - self._started < self._next:
                return None
            self._next *= 2
            return f"{self._engine}: {share:.3%} done, {left(share, now - self._started)}"
        if not stage or now - self._since < _PATIENCE or stage in self._said:
            return None
        self._said.add(stage)
        return f"{self._engine}: {stage} ..."


def left(share: float, elapsed: float) -> str:
    """The time left in words. share: of the run, done in the time `elapsed`, s."""
    if share <= 0:
        return "time left unknown"
    seconds = elapsed * (1 - share) / share
    for unit, length in (("years", 3.156e7), ("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2 * length:
            return f"about {seconds / length:.3g} {unit} left"
    return f"about {seconds:.0f} seconds left"


@contextmanager
def shown(engine: str, file: Path) -> Iterator[None]:
    """Shows the progress of a run on stderr during the `with` block.

    engine: its label. file: that to which the progress is reported; it need not be there yet.
    """
    over = threading.Event()
    on_terminal = sys.stderr is not None and sys.stderr.isatty()
    watch = threading.Thread(target=_bar if on_terminal else _lines, args=(engine, file, over), daemon=True)
    watch.start()
    try:
        yield
    finally:
        over.set()
        watch.join()


def _lines(engine: str, file: Path, over: threading.Event) -> None:
    lines, start = Lines(engine), time.monotonic()
    while not over.wait(_LOOK):
        text = lines.line(time.monotonic() - start, *read(file))
        if text is not None and sys.stderr is not None:
            print(text, file=sys.stderr, flush=True)


def _bar(engine: str, file: Path, over: threading.Event) -> None:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TextColumn("{task.fields[left]}"))
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(engine, total=None, left="")
        started: float | None = None
        while not over.wait(_LOOK):
            stage, share = read(file)
            if share is None:
                bar.update(task, description=f"{engine}: {stage or 'starting'} ...")
                continue
            started = started or time.monotonic()
            remaining = left(share, time.monotonic() - started)
            bar.update(task, description=engine, total=1.0, completed=share, left=remaining)
