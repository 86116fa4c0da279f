"""Engines in worker processes, as the suite's process sees them: kept between runs, restarted after a crash or hang."""

from __future__ import annotations

import atexit
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Cost, Run
from crosscheck.engines.workers.cache import kernel_cache
from crosscheck.errors import EngineError, EngineMissing, Unsupported, UsageError
from crosscheck.scene import Method, Scene

#: Seconds that one call may take before its worker counts as hung.
TIME_LIMIT = 900.0
#: Number of lines of a worker's output in an error message.
_LAST_LINES = 15
#: Seconds that a hung worker gets to write its stack to the log.
_SECONDS_FOR_STACK = 0.2
# -P: the current directory must not come before a fault's overlay
_WORKER = (sys.executable, "-P", "-m", "crosscheck.engines.workers.worker")


class Worker:
    """One engine's process, started at the first call. Not to be shared between threads.

    engine: its name, or path.py:Class. overlay: a directory put first on the path, which holds a `refimpl` with a
    planted fault. time_limit: seconds that one call may take.

    All calls raise EngineMissing if the engine cannot run on this machine, UsageError for mistakes in scene or method,
    and EngineError, with the last lines of the engine's output, if it fails, crashes or exceeds the time limit.
    """

    def __init__(self, engine: str, overlay: Path | None = None, time_limit: float = TIME_LIMIT) -> None:
        self.engine = engine
        self.overlay = overlay
        self.time_limit = time_limit
        self._process: subprocess.Popen[bytes] | None = None
        self._directory = tempfile.TemporaryDirectory(prefix="crosscheck-")
        atexit.register(self.close)

    # -- the methods of `Engine` -------------------------------------------------------------------

    def version(self) -> str:
        """See `Engine.version`."""
        return str(self._call({"call": "version"})["version"])

    def supports(self, scene: Scene, method: Method) -> str | None:
        """None, or why the engine cannot run `scene` with `method`: by its capabilities, or by `Engine.supports`."""
        reply = self._call({"call": "supports", "scene": scene.to_json(), "method": method.model_dump_json()})
        return None if reply["reason"] is None else str(reply["reason"])

    def run(self, scene: Scene, method: Method, restart: Path | None = None, keep: Path | None = None) -> Run:
        """See `Engine.run`. scene, method: what to run, and how. Unsupported if the engine cannot run it.

        restart: file with the state from which the run goes on, see `Restartable`; None: from the scene's initial one.
        keep: file for the state at its end, written if the engine can restart and the run came to its end; None: none.
        """
        texts = {"scene": scene.to_json(), "method": method.model_dump_json()}
        path = Path(self._directory.name) / "run.npz"
        reply = self._call({"call": "run", "path": str(path), "restart": _text(restart), "keep": _text(keep), **texts})
        if "unsupported" in reply:
            raise Unsupported(f"{self.engine}: {reply['unsupported']}")
        with np.load(path) as arrays:
            found = {name: arrays[name] for name in arrays}
        path.unlink()
        return Run(
            found,
            diverged=reply["diverged"],
            stopped=reply["stopped"],
            cost=Cost(**reply["cost"]),
            remarks=reply["remarks"],
        )

    def close(self) -> None:
        """Ends the process and removes its files."""
        self._stop()
        self._directory.cleanup()
        atexit.unregister(self.close)

    # -- the pipe ----------------------------------------------------------------------------------

    def _start(self) -> None:
        requests_read, requests_write = os.pipe()
        answers_read, answers_write = os.pipe()
        log = Path(self._directory.name) / "log"
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                [*_WORKER, self.engine, str(requests_read), str(answers_write)],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                pass_fds=(requests_read, answers_write),
                env=_environment(self.overlay),
            )
        os.close(requests_read)
        os.close(answers_write)
        os.set_blocking(requests_write, False)
        self._requests, self._answers, self._buffer = requests_write, answers_read, b""

    def _call(self, request: dict[str, Any]) -> dict[str, Any]:
        if self._process is None or self._process.poll() is not None:
            self._stop()
            self._start()
        assert self._process is not None
        deadline = time.monotonic() + self.time_limit
        try:
            self._write(json.dumps(request).encode() + b"\n", deadline)
            reply: dict[str, Any] = json.loads(self._read_line(deadline))
        except (BrokenPipeError, EOFError):
            ended = self._how_it_ended()
            self._stop()
            raise EngineError(f"{self.engine} {ended}\n{self._last_lines()}") from None
        except TimeoutError:
            self._process.send_signal(signal.SIGUSR1)  # the worker writes its Python stack to the log
            time.sleep(_SECONDS_FOR_STACK)
            self._stop()
            raise EngineError(
                f"{self.engine} gave no answer within {self.time_limit:g} s and was stopped\n{self._last_lines()}"
            ) from None
        if "missing" in reply:
            raise EngineMissing(f"{self.engine}: {reply['missing']}")
        if "usage" in reply:
            raise UsageError(reply["usage"])
        if "error" in reply:
            raise EngineError(f"{self.engine}: {reply['error']}\n{self._last_lines()}")
        return reply

    def _write(self, data: bytes, deadline: float) -> None:
        view = memoryview(data)
        while view:
            _wait(deadline, write=self._requests)
            view = view[os.write(self._requests, view) :]

    def _read_line(self, deadline: float) -> bytes:
        while b"\n" not in self._buffer:
            _wait(deadline, read=self._answers)
            chunk = os.read(self._answers, 1 << 16)
            if not chunk:
                raise EOFError
            self._buffer += chunk
        line, _, self._buffer = self._buffer.partition(b"\n")
        return line

    def _how_it_ended(self) -> str:
        assert self._process is not None
        try:
            code = self._process.wait(timeout=1)
        except subprocess.TimeoutExpired:
            return "closed its pipe"
        return f"was killed by signal {-code}" if code < 0 else f"ended with exit status {code}"

    def _last_lines(self) -> str:
        log = Path(self._directory.name) / "log"
        with log.open("rb") as file:
            file.seek(max(0, log.stat().st_size - (1 << 16)))
            lines = file.read().decode(errors="replace").splitlines()
        return "\n".join(lines[-_LAST_LINES:])

    def _stop(self) -> None:
        if self._process is None:
            return
        os.close(self._requests)
        os.close(self._answers)
        self._process.kill()
        self._process.wait()
        self._process = None


def _text(path: Path | None) -> str | None:
    return None if path is None else str(path)


def _wait(deadline: float, *, read: int | None = None, write: int | None = None) -> None:
    """Waits until the pipe can be read or written; TimeoutError after the deadline."""
    readers, writers = [[end] if end is not None else [] for end in (read, write)]
    if not any(select.select(readers, writers, [], max(0.0, deadline - time.monotonic()))):
        raise TimeoutError


def _environment(overlay: Path | None) -> dict[str, str]:
    """Environment of a worker: one thread; an overlay first on the path, with its compiled kernels beside it."""
    environment = dict(os.environ)
    environment.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", NUMBA_NUM_THREADS="1")
    environment["NUMBA_CACHE_DIR"] = str(kernel_cache(overlay / "kernels" if overlay else None))
    if overlay:
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [str(overlay), os.environ.get("PYTHONPATH", "")]))
    return environment


class Pool:
    """The workers of one thread, one per engine.

    overlay: see `Worker`; only `refimpl` gets it. time_limit: seconds that one call may take.
    """

    def __init__(self, overlay: Path | None = None, time_limit: float = TIME_LIMIT) -> None:
        self._workers: dict[str, Worker] = {}
        self._overlay = overlay
        self._time_limit = time_limit

    def worker(self, engine: str) -> Worker:
        """The worker of this engine (a name, or path.py:Class), the same one at every call."""
        if engine not in self._workers:
            overlay = self._overlay if engine == "refimpl" else None
            self._workers[engine] = Worker(engine, overlay, self._time_limit)
        return self._workers[engine]

    def close(self) -> None:
        """Ends all workers."""
        for worker in self._workers.values():
            worker.close()
        self._workers.clear()
