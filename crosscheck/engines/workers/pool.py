"""Engines in worker processes, as the suite's process sees them: kept between runs, restarted after a crash or hang."""

from __future__ import annotations

import atexit
import json
import math
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from crosscheck.engines.protocol import Cost, Run
from crosscheck.engines.soft_spheres import resolved
from crosscheck.engines.workers import border, ending, recording
from crosscheck.engines.workers.cache import kernel_cache
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.engines.workers.states import taken_over
from crosscheck.errors import EngineError, EngineMissing, Unsupported, UsageError
from crosscheck.scene import Method, Scene

#: Number of lines of a worker's output in an error message, and of characters of each.
_LAST_LINES = 18
_LONGEST_LINE = 300
#: Bytes of a worker's output that are kept, and of its answers, whose arrays are not in them.
_LARGEST_LOG = 1 << 27
_LONGEST_ANSWER = 1 << 24
#: Seconds between two looks at whether a worker lives, while the suite waits for it.
_BETWEEN_LOOKS = 0.2
#: Seconds that a hung worker gets to write its stack to the log, and a guard to end its worker.
_SECONDS_FOR_STACK = 0.2
_SECONDS_TO_END = 1.0
# -P: the current directory must not come before a fault's overlay
_GUARD = (sys.executable, "-P", "-m", "crosscheck.engines.workers.guard")

#: What the answer to a request is read as.
Answer = TypeVar("Answer")


class Worker:
    """One engine's process, started at the first call. Not to be shared between threads.

    engine: its name, or path.py:Class. overlay: a directory put first on the path, which holds a `refimpl` with a
    planted fault. time_limit: seconds that one call may take. interpreted: numba compiles nothing. threads: that its
    libraries may use.

    All calls raise EngineMissing if the engine cannot run on this machine, UsageError for mistakes in scene or method,
    and EngineError, with the last lines of the engine's output, if it fails, crashes or exceeds the time limit.
    """

    def __init__(
        self,
        engine: str,
        overlay: Path | None = None,
        time_limit: float = TIME_LIMIT,
        *,
        interpreted: bool = False,
        threads: int = 1,
    ) -> None:
        self.engine = engine
        self.overlay = overlay
        self.interpreted = interpreted
        self.threads = threads
        self.time_limit = time_limit
        self._process: subprocess.Popen[bytes] | None = None
        self._number = 0
        self._directory = tempfile.TemporaryDirectory(prefix="crosscheck-")
        atexit.register(self.close)

    # -- the methods of `Engine` -------------------------------------------------------------------

    def declarations(self) -> dict[str, Any]:
        """What the class of the engine declares, see `border.declared`; UsageError if it is not what it should be."""
        return self._call({"call": "declarations"})

    def version(self) -> str:
        """See `Engine.version`."""
        return self._checked(lambda reply: border.version(reply["version"]), {"call": "version"})

    def supports(self, scene: Scene, method: Method) -> str | None:
        """None, or why the engine cannot run `scene` with `method`: by its capabilities, or by `Engine.supports`."""
        texts = {"scene": scene.to_json(), "method": method.model_dump_json()}
        return self._checked(lambda reply: border.reason(reply["reason"]), {"call": "supports", **texts})

    def lines(self) -> recording.Executed:
        """The lines executed since the last call, of a worker that records, see `workers.recording`."""
        alive = self._process is not None and self._process.poll() is None
        return self._checked(lambda reply: dict(reply["lines"]), {"call": "lines"}) if alive else {}

    def run(
        self,
        scene: Scene,
        method: Method,
        progress: Path | None = None,
        restart: Path | None = None,
        keep: Path | None = None,
    ) -> Run:
        """See `Engine.run`. scene, method: what to run, and how. Unsupported if the engine cannot run it.

        progress: the file to which the engine reports how far it is, see `crosscheck.engines.progress`; None: none.
        restart: file with the state from which the run goes on, see `Restartable`; None: from the scene's initial one.
        keep: file for the state at its end, written if the engine can restart and the run came to its end; None: none.
        """
        texts = {"scene": scene.to_json(), "method": method.model_dump_json()}
        path = Path(self._directory.name) / "run"
        files = {"progress": progress, "restart": restart, "keep": keep}
        given = {name: str(file) for name, file in files.items() if file is not None}
        request = {"call": "run", "path": str(path), **given, **texts}
        try:
            return self._checked(lambda reply: self._arrived(reply, path, scene, method), request)
        finally:
            path.unlink(missing_ok=True)

    def _arrived(self, reply: dict[str, Any], path: Path, scene: Scene, method: Method) -> Run:
        """The run that an answer and its file hold, checked again in the suite's own process."""
        if "unsupported" in reply:
            raise Unsupported(f"{self.engine}: {border.reason(reply['unsupported'])}")
        found = taken_over(path, reply["shapes"])
        rest = {name: reply[name] for name in ("diverged", "stopped", "remarks")}
        _, rest = border.outcome(Run(cost=Cost(**reply["cost"]), **rest))
        ended = {"diverged": rest["diverged"], "stopped": rest["stopped"]}
        arrays = border.arrays(found, scene, resolved(scene, method), **ended)
        return Run(arrays, cost=Cost(**rest["cost"]), remarks=rest["remarks"], **ended)

    def _checked(self, read: Callable[[dict[str, Any]], Answer], request: dict[str, Any]) -> Answer:
        """What `read` makes of the answer to a request; EngineError if the answer is not what it should be."""
        reply = self._call(request)
        try:
            return read(reply)
        except (Unsupported, UsageError):
            raise
        except Exception as error:
            self._stop()  # nothing that this process says is to be believed
            what = str(error) if isinstance(error, border.Misfit) else border.described(error)
            raise EngineError(f"{self.engine}: its answer cannot be read: {what}\n{self._last_lines()}") from None

    def close(self) -> None:
        """Ends the process and removes its files."""
        self._stop()
        self._directory.cleanup()
        atexit.unregister(self.close)

    # -- the pipe ----------------------------------------------------------------------------------

    def _start(self) -> None:
        if ending.ending():
            raise EngineError(f"{self.engine}: the suite is ending, no engine is started")
        requests_read, requests_write = os.pipe()
        answers_read, answers_write = os.pipe()
        directory = self._directory.name
        with self._log.open("wb"):
            pass
        with self._log.open("ab") as output:  # to be cut while it is written
            self._process = subprocess.Popen(
                [*_GUARD, self.engine, str(requests_read), str(answers_write), directory],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                pass_fds=(requests_read, answers_write),
                env=_environment(self.overlay, self.interpreted, self.threads),
                start_new_session=True,  # Ctrl-C is the suite's, which ends the worker
            )
        ending.enlist(self._process, directory)
        os.close(requests_read)
        os.close(answers_write)
        os.set_blocking(requests_write, False)
        self._requests, self._answers, self._buffer = requests_write, answers_read, b""

    def _call(self, request: dict[str, Any]) -> dict[str, Any]:
        if self._process is None or self._process.poll() is not None:
            self._stop()
            self._start()
        self._number += 1
        deadline = time.monotonic() + self.time_limit
        try:
            self._write(json.dumps(request | {"number": self._number}).encode() + b"\n", deadline)
            reply = self._read_answer(deadline)
        except (BrokenPipeError, EOFError):
            ended = self._how_it_ended()
            self._stop()
            raise EngineError(f"{self.engine} {ended}\n{self._last_lines()}") from None
        except TimeoutError:
            assert self._process is not None
            self._process.send_signal(signal.SIGUSR1)  # the worker writes its Python stack to the log
            time.sleep(_SECONDS_FOR_STACK)
            self._stop()
            raise EngineError(
                f"{self.engine} gave no answer within {self.time_limit:g} s and was stopped\n{self._last_lines()}"
            ) from None
        except ValueError as error:
            self._stop()
            raise EngineError(f"{self.engine}: its answer cannot be read: {error}\n{self._last_lines()}") from None
        except BaseException:
            self._stop()  # what it answers later would be taken for the answer to another request
            raise
        return self._granted(reply)

    def _granted(self, reply: dict[str, Any]) -> dict[str, Any]:
        """The answer, if it is none of those that say why there is no other."""
        if "missing" in reply:
            raise EngineMissing(f"{self.engine}: {reply['missing']}")
        if "usage" in reply:
            raise UsageError(str(reply["usage"]))
        if "error" in reply:
            raise EngineError(f"{self.engine}: {reply['error']}\n{self._last_lines()}")
        return reply

    def _write(self, data: bytes, deadline: float) -> None:
        view = memoryview(data)
        while view:
            self._wait(deadline, write=self._requests)
            view = view[os.write(self._requests, view) :]

    def _read_answer(self, deadline: float) -> dict[str, Any]:
        """The answer to the last request; ValueError for anything else."""
        while b"\n" not in self._buffer:
            self._wait(deadline, read=self._answers)
            chunk = os.read(self._answers, 1 << 16)
            if not chunk:
                raise EOFError
            self._buffer += chunk
            if len(self._buffer) > _LONGEST_ANSWER:
                raise ValueError(f"it is longer than {_LONGEST_ANSWER} bytes")
        line, _, self._buffer = self._buffer.partition(b"\n")
        try:
            reply = json.loads(line)
        except (ValueError, RecursionError):
            raise ValueError(f"{border.shown(line)} is not JSON") from None
        if not isinstance(reply, dict) or reply.pop("number", None) != self._number:
            raise ValueError(f"{border.shown(line)} is not the answer to this request")
        return reply

    def _wait(self, deadline: float, *, read: int | None = None, write: int | None = None) -> None:
        """Waits until the pipe can be read or written; TimeoutError after the deadline, EOFError if nobody is there."""
        readers, writers = [[end] if end is not None else [] for end in (read, write)]
        assert self._process is not None
        while True:
            ended = self._process.poll() is not None
            left = deadline - time.monotonic()
            if any(select.select(readers, writers, [], max(0.0, min(left, 0.0 if ended else _BETWEEN_LOOKS)))):
                return
            if ended:
                raise EOFError
            if left <= 0:
                raise TimeoutError
            if self._log.stat().st_size > _LARGEST_LOG:
                os.truncate(self._log, 0)

    def _how_it_ended(self) -> str:
        assert self._process is not None
        try:
            code = self._process.wait(timeout=1)
        except subprocess.TimeoutExpired:
            return "closed its pipe"
        if code == -signal.SIGKILL:
            return "was killed by signal 9, as when memory runs out"
        return f"was killed by signal {-code}" if code < 0 else f"ended with exit status {code}"

    @property
    def progress(self) -> Path:
        """A file for the progress of a run, beside the other files of this worker, with which it is removed."""
        return Path(self._directory.name) / "progress"

    @property
    def _log(self) -> Path:
        return Path(self._directory.name) / "log"

    def _last_lines(self) -> str:
        if not self._log.exists():
            return ""
        with self._log.open("rb") as file:
            file.seek(max(0, self._log.stat().st_size - (1 << 16)))
            lines = file.read().decode(errors="replace").splitlines()
        return "\n".join(border.capped(line, _LONGEST_LINE) for line in lines[-_LAST_LINES:])

    def _stop(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        process.terminate()  # the guard ends the worker, and all that the engine has started
        try:
            process.wait(_SECONDS_TO_END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        ending.forget(process)
        os.close(self._requests)  # not before: a pipe without a writer tells the guard that the suite is gone
        os.close(self._answers)


#: Memory that a step frees is kept for the next one (GNU C library): given back and asked for again, page by page, the
#: arrays of 32000 Lennard-Jones particles cost 17 of 92 ns a particle step.
_KEPT_MEMORY = dict.fromkeys(("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_"), str(1 << 30))


def _environment(overlay: Path | None, interpreted: bool, threads: int) -> dict[str, str]:
    """Environment of a worker: number of threads; an overlay first on the path, with its kernels beside it, if any."""
    environment = dict(os.environ)
    environment.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), str(threads)))
    environment = {**_KEPT_MEMORY, **environment}
    if interpreted:  # with no cache there is nothing that workers wait for each other with
        environment["NUMBA_DISABLE_JIT"] = "1"
        environment.pop("NUMBA_CACHE_DIR", None)
    else:
        environment["NUMBA_CACHE_DIR"] = str(kernel_cache(overlay / "kernels" if overlay else None))
    if overlay:
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [str(overlay), os.environ.get("PYTHONPATH", "")]))
    return environment


class Pool:
    """The workers of one thread, one per engine; two for an engine that may be interpreted.

    overlay: see `Worker`; only `refimpl` gets it. time_limit: seconds that one call may take. deadline: on the clock
    `time.monotonic`, when all calls end. Both may change, for the next calls of `worker`.
    """

    def __init__(self, overlay: Path | None = None, time_limit: float = TIME_LIMIT, deadline: float = math.inf) -> None:
        self._workers: dict[tuple[str, bool], Worker] = {}
        self.overlay = overlay
        self.time_limit = time_limit
        self.deadline = deadline

    def worker(self, engine: str, interpreted: bool = False) -> Worker:
        """The worker of this engine (a name, or path.py:Class), the same one at every call.

        interpreted: one in which numba compiles nothing. EngineError after the deadline.
        """
        left = self.deadline - time.monotonic()
        if left <= 0:
            raise EngineError(f"{engine}: the time is over")
        key = (engine, interpreted)
        if key not in self._workers:
            overlay = self.overlay if engine == "refimpl" else None
            self._workers[key] = Worker(engine, overlay, self.time_limit, interpreted=interpreted)
        self._workers[key].time_limit = min(self.time_limit, left)
        return self._workers[key]

    def lines(self) -> recording.Executed:
        """The lines that all workers executed since the last call, see `Worker.lines`."""
        return recording.merged(worker.lines() for worker in self._workers.values())

    def close(self) -> None:
        """Ends all workers."""
        for worker in self._workers.values():
            worker.close()
        self._workers.clear()
