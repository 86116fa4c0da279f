"""A judge: a process of its own that runs cases on a mutant, and answers with their outcomes."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import TracebackType
from typing import IO

import crosscheck
import refimpl
from crosscheck.engines.workers import ending, recording
from crosscheck.runner import Case

#: Seconds that a case may take in the judge's own process, beside two calls of an engine at their limit.
_OWN_SECONDS = 60.0
_ROOTS = tuple(Path(package.__path__[0]) for package in (crosscheck, refimpl))


@dataclass(frozen=True)
class Answer:
    """What became of a case.

    outcome: of its verdict; "error" too if the judge's process ended or gave no answer. message: why, in a line.
    seconds: that it took. lines: that were executed, if they are recorded, see `recording.Executed`.
    """

    outcome: str
    message: str
    seconds: float
    lines: recording.Executed = field(default_factory=dict)

    @property
    def red(self) -> bool:
        """Whether a run of the suite with this verdict ends with status 1, or 4 after an error: it is not green."""
        return self.outcome in ("fail", "error")


class Judge:
    """One process, started by the first case. Not to be shared between threads.

    overlay: a directory with the mutated package, which comes first on the path; None: the installed sources. caches:
    directory for compiled kernels; None: the user's own. records: whether the answers hold the executed lines.
    """

    def __init__(self, overlay: Path | None = None, caches: Path | None = None, *, records: bool = False) -> None:
        self._overlay, self._caches, self._records = overlay, caches, records
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Judge:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def judge(self, case: Case, seed: int, limit: float) -> Answer:
        """The answer for one case. seed: of the suite. limit: seconds that one call of an engine may take."""
        started = time.monotonic()
        if self._process is None:
            self._process = self._started()
        request = {"case": asdict(case), "seed": seed, "limit": limit}
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
            line = _line(self._process.stdout, started + 2 * limit + _OWN_SECONDS)
        except (BrokenPipeError, EOFError):
            self.close()
            return Answer("error", "the suite's own process ended", time.monotonic() - started)
        except TimeoutError:
            self.close()
            return Answer("error", "the suite's own process gave no answer in time", time.monotonic() - started)
        return Answer(**json.loads(line))

    def close(self) -> None:
        """Ends the process; its workers end with it."""
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with suppress(BrokenPipeError):
                    pipe.close()
        process.wait()
        ending.forget(process)

    def _started(self) -> subprocess.Popen[bytes]:
        environment = dict(os.environ)
        path = [*([str(self._overlay)] if self._overlay else []), *(str(root.parent) for root in _ROOTS)]
        environment["PYTHONPATH"] = os.pathsep.join(
            [*dict.fromkeys(path), *filter(None, [os.environ.get("PYTHONPATH")])]
        )
        if self._caches is not None:
            environment["XDG_CACHE_HOME"] = str(self._caches)
        if self._records:
            environment[recording.VARIABLE] = os.pathsep.join(str(root) for root in recorded_roots())
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "crosscheck.mutation.judging"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,  # Ctrl-C is for the process that asks, which ends this one
        )
        ending.enlist(process, str(self._overlay or ""))
        return process


def recorded_roots() -> tuple[Path, Path]:
    """The directories whose lines are recorded: `refimpl`, and the engines of `crosscheck`."""
    return _ROOTS[1], _ROOTS[0] / "engines"


def _line(pipe: IO[bytes], deadline: float) -> bytes:
    """One line of an answer; TimeoutError after the deadline, EOFError if there is none."""
    found = b""
    while not found.endswith(b"\n"):
        ready, _, _ = select.select([pipe], [], [], max(0.0, deadline - time.monotonic()))
        if not ready:
            raise TimeoutError
        chunk = os.read(pipe.fileno(), 1 << 16)
        if not chunk:
            raise EOFError
        found += chunk
    return found
