"""The worker of an engine, forked by `crosscheck.engines.workers.guard`: it answers requests, one line of JSON each.

Arrays are written to an .npz file whose path is in the request. What the engine prints goes to stdout and stderr, which
the suite has redirected to a log file.
"""

from __future__ import annotations

import os
import traceback
from collections.abc import Mapping
from contextlib import suppress
from json import dumps, loads
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines import progress
from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import Claims, Engine, Restartable, Run
from crosscheck.engines.registry import load_class
from crosscheck.engines.sizes import refuse_large_run
from crosscheck.engines.soft_spheres import resolved
from crosscheck.engines.workers import border, recording
from crosscheck.engines.workers.states import hand_over, read_arrays
from crosscheck.errors import UsageError
from crosscheck.scene import Floats, Method, Scene
from crosscheck.scene.observables import TABLE


def answer(engine: Engine, request: dict[str, Any]) -> dict[str, Any]:
    """The answer to one request.

    engine: an instance. request: "call" is "version", "supports" or "run"; the latter two hold "scene" and "method" as
    JSON texts, and "run" the "path" of the file for the arrays, and perhaps that for the "progress", and "restart" and
    "keep", the files with the state from which the run goes on and for that at its end. UsageError for a mistake in
    scene or method; Misfit if the engine returns what it should not; any exception of the engine.
    """
    if request["call"] == "version":
        return {"version": border.version(engine.version())}
    scene = Scene.from_json(request["scene"])
    method = resolved(scene, Method.model_validate_json(request["method"]))
    wanted = _without_derived(scene)
    reason = refusal(engine, wanted, method)
    if reason is None:
        refuse_large_run(scene, method)
        reason = border.reason(engine.supports(wanted, method))
    if request["call"] == "supports":
        return {"reason": reason}
    if reason is not None:
        return {"unsupported": reason}
    _check_step(engine.schemes[method.scheme], method)
    progress.listen(Path(request["progress"]) if request.get("progress") else None)
    progress.stage("preparing the start")
    given, rest = border.outcome(_run(engine, wanted, method, request))
    arrays = border.arrays(given, wanted, method, diverged=rest["diverged"], stopped=rest["stopped"])
    return rest | {"shapes": hand_over(Path(request["path"]), _asked_arrays(arrays, scene, method))}


def _run(engine: Engine, scene: Scene, method: Method, request: dict[str, Any]) -> Run:
    """The run; from the state in the file `restart` of the request, and to that in `keep`, if they are given."""
    restart, keep = request.get("restart"), request.get("keep")
    if isinstance(engine, Restartable) and (keep is not None or restart is not None):
        run, state = engine.run_from(scene, method, None if restart is None else read_arrays(Path(restart)))
        if keep is not None and state is not None and not run.diverged and not run.stopped:
            np.savez(keep, allow_pickle=False, **state)
        return run
    if restart is not None:
        raise UsageError(
            f"--restart: {engine.name} does not promise the same bits after a restart: start from its trajectory "
            "(initial.kind = 'file'), which is the same to round-off"
        )
    return engine.run(scene, method)


def _without_derived(scene: Scene) -> Scene:
    """The scene with its derived observables replaced by those that they need."""
    derived = {name: row for name, row in scene.asked().items() if row.derive is not None}
    if not derived:
        return scene
    needs = {name for row in derived.values() for name in row.needs}
    output = scene.output
    return scene.changed(
        output=output.model_copy(
            update={
                "observables": tuple(
                    dict.fromkeys(
                        [name for name in output.observables if name not in derived]
                        + sorted(name for name in needs if TABLE[name].asked == "observables")
                    )
                ),
                "trajectory": output.trajectory or any(TABLE[name].asked == "trajectory" for name in needs),
            }
        )
    )


def _asked_arrays(run: Mapping[str, Floats], scene: Scene, method: Method) -> dict[str, Floats]:
    """The arrays that the scene asks for, the derived ones computed from the others."""
    asked = scene.asked()
    derived = any(row.derive is not None for row in asked.values())
    masses = scene.initial_state(method.contact).masses if derived else np.zeros(0)
    return {name: run[name] if row.derive is None else row.derive(masses, run) for name, row in asked.items()}


def _check_step(claims: Claims, method: Method) -> None:
    """UsageError unless a scheme has the time step or the tolerance that it takes, and none that it does not take."""
    how = {
        "lattice": "takes whole steps of 1",
        "event_driven": "goes from event to event",
        "adaptive": "chooses its own time steps",
    }.get(claims.kind, "takes steps of dt")
    if method.dt is not None and not claims.takes_dt:
        raise UsageError(f"method.dt = {method.dt:g}: scheme '{method.scheme}' {how}: remove dt")
    if method.tolerance is not None and not claims.takes_tolerance:
        raise UsageError(f"method.tolerance = {method.tolerance:g}: scheme '{method.scheme}' {how}: remove tolerance")
    if claims.takes_dt:
        _ = method.step
    if claims.takes_tolerance:
        _ = method.allowed


def serve(engine_name: str, read_fd: int, write_fd: int) -> None:
    """Answers requests until the pipe closes.

    engine_name: a name, or path.py:Class. read_fd, write_fd: file descriptors of the pipes for requests and answers.
    SystemExit of the engine ends it.
    """
    server = Server(engine_name)
    process = os.getpid()
    with os.fdopen(read_fd) as requests, os.fdopen(write_fd, "w") as answers:
        for line in requests:
            request = loads(line)
            reply = server.reply(request) | {"number": request["number"]}
            if os.getpid() != process:
                os._exit(1)  # a fork of the engine's that came back from it
            answers.write(dumps(reply) + "\n")
            answers.flush()


class Server:
    """One engine that answers requests: its class is loaded by the first of them.

    engine_name: a name, or path.py:Class.
    """

    def __init__(self, engine_name: str) -> None:
        self._name = engine_name
        self._class: type[Engine] | None = None
        self._declarations: dict[str, Any] | None = None
        self._engine: Engine | None = None
        self._recorder = recording.recorder()

    def reply(self, request: dict[str, Any]) -> dict[str, Any]:
        """What `answer` gives, or "usage", "missing" or "error" with a text; SystemExit passes through.

        request: as for `answer`; "call" may also be "declarations", or "lines": those executed since it was last asked.
        """
        if request["call"] == "lines":
            return {"lines": self._recorder.take() if self._recorder else {}}
        try:
            if self._declarations is None:
                self._class = load_class(self._name)
                self._declarations = self._declared(self._class)
            if request["call"] == "declarations":
                return self._declarations
            assert self._class is not None
            self._engine = self._engine or self._class()
            return answer(self._engine, request)
        except SystemExit:
            raise
        except UsageError as error:
            return {"usage": str(error)}
        except border.Misfit as error:
            return {"error": str(error)}
        except BaseException as error:
            with suppress(Exception):  # the engine may have closed stderr
                traceback.print_exc()
            return self._missing(error) or {"error": border.described(error)}

    def _declared(self, found: type[Engine]) -> dict[str, Any]:
        """What the class declares; UsageError if it is not what it should be."""
        try:
            return border.declarations(found)
        except border.Misfit as error:
            raise UsageError(f"engine '{self._name}': {error}") from None

    def _missing(self, error: BaseException) -> dict[str, str] | None:
        """The answer "missing" if the engine cannot be imported or `version` fails; None for any other error."""
        if not isinstance(error, ImportError | OSError):
            return None
        if self._engine is not None:
            try:
                self._engine.version()
            except (ImportError, OSError) as reason:
                error = reason
            except BaseException:
                return None
            else:
                return None
        return {"missing": border.described(error)}
