"""How workers end: the time limit of a call, and Ctrl-C or a signal to the suite, which ends all of them.

It imports nothing heavy: the command line reads it before it knows what to do.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

#: Seconds that one call of an engine may take before its worker counts as hung.
TIME_LIMIT = 900.0

#: The processes of this suite, with the directory of their files.
_alive: dict[subprocess.Popen[bytes], str] = {}
_ending = False


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, or a signal that asks the suite to end. status: its exit status, 128 and the number of the signal."""

    def __init__(self, status: int) -> None:
        super().__init__()
        self.status = status


def enlist(process: subprocess.Popen[bytes], directory: str) -> None:
    """Takes note of a worker's process, to be ended when the suite is; one that comes too late is ended at once.

    directory: of its files.
    """
    _alive[process] = directory
    if _ending:
        process.terminate()


def forget(process: subprocess.Popen[bytes]) -> None:
    """A worker's process has ended, and is no longer to be ended."""
    _alive.pop(process, None)


def ending() -> bool:
    """Whether the suite has been asked to end: no worker is started any more."""
    return _ending


def interruptible(work: Callable[[], int | None]) -> int:
    """What `work` returns, the exit status of a command; Ctrl-C, SIGTERM and SIGHUP end all workers and the command.

    The exit status is then 130, 143 or 129. work: gets an `Interrupted` in the main thread; None: 0. A second signal
    ends the process without waiting for its threads. A signal that was ignored before remains so, as under nohup.
    """
    global _ending

    def end(number: int, frame: FrameType | None) -> None:
        global _ending
        again, _ending = _ending, True
        for process in list(_alive):
            process.terminate()
        if again:
            for directory in list(_alive.values()):
                shutil.rmtree(directory, ignore_errors=True)
            os._exit(128 + number)
        raise Interrupted(128 + number)

    before: dict[int, Any] = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    before[signal.SIGHUP] = signal.getsignal(signal.SIGHUP)
    _ending = False
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, end)
    try:
        return work() or 0
    except Interrupted as interrupted:
        print("crosscheck: interrupted", file=sys.stderr)
        return interrupted.status
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _ending = False
