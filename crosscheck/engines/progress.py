"""How far a run is: an engine reports it from its worker process, through a small file that the suite's process reads.

Without a listener, as in the checks, reports cost nothing, and a run is not cut into pieces.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

#: Least time, s, between two reports of the share done.
_INTERVAL = 0.1
#: A piece of work that takes between these times, s, is long enough to cost nothing, and short enough to be watched.
_SHORT, _LONG = 0.1, 0.4
#: More steps or events than any run has; fits into 64 bits with another such number.
_ALL = 1 << 62


@dataclass
class _Listener:
    """Where reports go: the file (None: nowhere), and when the last one was written."""

    file: Path | None = None
    last: float = -1.0


_listener = _Listener()


def listen(file: Path | None) -> None:
    """Sends the reports of this process to `file` from now on. file: None: nobody listens."""
    _listener.file, _listener.last = file, -1.0


def stage(what: str) -> None:
    """Reports what a run does now, before its first step. what: as "compiling kernels"."""
    if _listener.file is not None:
        _write(_listener.file, f"{what}\n")


def report(share: float) -> None:
    """Reports how much of the run is done, at most some times a second. share: 0 to 1."""
    now = time.monotonic()
    if _listener.file is not None and now - _listener.last >= _INTERVAL:
        _listener.last = now
        _write(_listener.file, f"running\n{share!r}\n")


def _write(file: Path, text: str) -> None:
    """Replaces the file as a whole, so that no half of it is read."""
    new = file.with_name(f"{file.name}.new")
    new.write_text(text, encoding="utf-8")
    new.replace(file)


def read(file: Path) -> tuple[str, float | None]:
    """The last report in a file: the stage, "" before the first one, and the share done, None before the first step."""
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
        return lines[0], float(lines[1]) if len(lines) > 1 else None
    except (OSError, ValueError, IndexError):  # not there yet
        return "", None


class Pace:
    """Cuts a run into pieces, after each of which it reports how much is done.

    end, begin: of the run, in the unit in which `more` is told how far it is.
    """

    def __init__(self, end: float, begin: float = 0.0) -> None:
        self._begin, self._whole = begin, end - begin
        self._size = 1
        self._since = time.monotonic()

    def more(self, done: float) -> int:
        """Number of steps or events until it wants to be asked again; all of them if nobody listens.

        done: how far the run is; it is reported.
        """
        if _listener.file is None:
            return _ALL
        now = time.monotonic()
        took, self._since = now - self._since, now
        if took < _SHORT:
            self._size = min(2 * self._size, _ALL)
        elif took > _LONG:
            self._size = max(1, self._size // 2)
        report(min(1.0, (done - self._begin) / self._whole) if self._whole > 0 else 1.0)
        return self._size
