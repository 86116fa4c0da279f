"""The guard of a worker: `python -P -m crosscheck.engines.workers.guard <engine> <read fd> <write fd> <directory>`.

A process between the suite and the engine. It forks the worker before anything heavy is imported, and waits. When the
worker ends, when the suite asks for it (SIGTERM), or when the suite itself is gone, it ends the worker with everything
that the engine has started, and ends in the same way as the worker did. What the suite asks of a worker by SIGUSR1, it
hands on. A guard that is killed takes its worker along.
"""

from __future__ import annotations

import ctypes
import faulthandler
import gc
import os
import resource
import select
import shutil
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

# of Linux's prctl(2): the signal that a process gets when its parent ends; whether it adopts orphans below it
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
_SIGNALS = (signal.SIGCHLD, signal.SIGUSR1, signal.SIGTERM)


def main(engine: str, read_fd: int, write_fd: int, directory: str) -> NoReturn:
    """Forks the worker, guards it, and ends.

    engine: a name, or path.py:Class. read_fd, write_fd: the worker's ends of the pipes for requests and answers.
    directory: of the worker's files, removed if the suite is gone.
    """
    alarms, alarm = os.pipe()
    os.set_blocking(alarm, False)
    signal.set_wakeup_fd(alarm)  # signals arrive as bytes in a pipe
    for number in _SIGNALS:
        signal.signal(number, lambda *_: None)
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)
    guard = os.getpid()
    worker = os.fork()
    if worker == 0:
        signal.set_wakeup_fd(-1)
        for number in _SIGNALS:
            signal.signal(number, signal.SIG_DFL)
        os.close(alarms)
        os.close(alarm)
        _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != guard:
            os._exit(1)
        os.setpgid(0, 0)
        _limit_memory()
        _work(engine, read_fd, write_fd)
    os.close(write_fd)
    status, orphaned = _watch(worker, read_fd, alarms)
    _end_descendants()
    if orphaned:
        shutil.rmtree(directory, ignore_errors=True)
    _end_like(status)


def _work(engine: str, read_fd: int, write_fd: int) -> NoReturn:
    """Serves as the worker. The process ends without waiting for threads that the engine has left."""
    # a crash, and the signal SIGUSR1, by which the suite asks a hung worker, write the Python stack to the log
    faulthandler.enable()
    faulthandler.register(signal.SIGUSR1)
    # compilers make many small objects that stay alive; collecting garbage less often saves a tenth of the compile time
    gc.set_threshold(200_000, 20, 100)
    from crosscheck.engines.workers.worker import serve

    status = 0
    try:
        serve(engine, read_fd, write_fd)
    except SystemExit as end:
        status = 0 if end.code is None else end.code if isinstance(end.code, int) else 1
        if status == 1 and not isinstance(end.code, int):
            print(end.code, file=sys.stderr)
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):
            stream.flush()
    os._exit(status & 0xFF)


def _watch(worker: int, requests: int, alarms: int) -> tuple[int, bool]:
    """Waits for an end: the status of the worker as of waitpid(2), and whether the suite is gone."""
    poll = select.poll()
    poll.register(requests, 0)  # says only that nobody can write any more
    poll.register(alarms, select.POLLIN)
    while True:
        events = dict(poll.poll())
        signals = os.read(alarms, 512) if alarms in events else b""
        if signal.SIGTERM in signals:
            return signal.SIGKILL, False
        if requests in events:
            return signal.SIGKILL, True
        if signal.SIGUSR1 in signals:
            os.kill(worker, signal.SIGUSR1)
        while signal.SIGCHLD in signals:  # of several children that end, one signal may tell
            ended, status = os.waitpid(-1, os.WNOHANG)
            if ended == worker:
                return status, False
            if ended == 0:
                break


def _end_descendants() -> None:
    """Kills all children, and the orphans that they leave, until none is left."""
    while True:
        for child in _children():
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
        try:
            os.waitpid(-1, 0)
        except ChildProcessError:
            return


def _children() -> Iterator[int]:
    """The processes whose parent is this one."""
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with suppress(OSError):
                # the name of the program, in parentheses, may hold anything
                state = (entry / "stat").read_bytes().rpartition(b")")[2].split()
                if int(state[1]) == os.getpid():
                    yield int(entry.name)


def _end_like(status: int) -> NoReturn:
    """Ends as the worker did. status: its own, of waitpid(2)."""
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # the worker's own is enough
        if number != signal.SIGKILL:
            signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
    os._exit(os.WEXITSTATUS(status))


def _limit_memory() -> None:
    """An engine that asks for more memory than there is gets a MemoryError; if memory runs out, it is killed first."""
    with suppress(OSError, ValueError):
        available = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        with suppress(OSError, ValueError):  # "max" is no number
            available = min(available, int(Path("/sys/fs/cgroup/memory.max").read_text()))
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        if hard == resource.RLIM_INFINITY or available < hard:
            resource.setrlimit(resource.RLIMIT_DATA, (available, hard))
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")


def _prctl(option: int, value: int) -> None:
    """prctl(2), where there is one: elsewhere the guard is as good as it can be without."""
    with suppress(AttributeError):
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4])
