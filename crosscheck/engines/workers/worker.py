"""The worker process of an engine: `python -P -m crosscheck.engines.workers.worker <engine> <read fd> <write fd>`.

A request is one line of JSON, and so is its answer. Arrays are written to an .npz file whose path is in the request.
What the engine prints goes to stdout and stderr, which the parent process has redirected to a log file.
"""

from __future__ import annotations

import dataclasses
import faulthandler
import gc
import json
import os
import signal
import sys
import traceback
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import Claims, Engine, Restartable, Run, sample_times, shapes
from crosscheck.engines.registry import load_engine
from crosscheck.engines.soft_spheres import resolved
from crosscheck.engines.workers.states import read_arrays
from crosscheck.errors import UsageError
from crosscheck.scene import Floats, Method, Scene
from crosscheck.scene.observables import TABLE


def answer(engine: Engine, request: dict[str, Any]) -> dict[str, Any]:
    """The answer to one request.

    engine: an instance. request: "call" is "version", "supports" or "run"; the latter two hold "scene" and "method" as
    JSON texts, and "run" the "path" of the file for the arrays, and perhaps "restart" and "keep", the files with the
    state from which the run goes on and for that at its end. UsageError for a mistake in scene or method; ValueError
    if a run holds arrays of other shapes than the scene asks for; any exception of the engine.
    """
    if request["call"] == "version":
        return {"version": engine.version()}
    scene = Scene.from_json(request["scene"])
    method = resolved(scene, Method.model_validate_json(request["method"]))
    wanted = _without_derived(scene)
    reason = refusal(engine, wanted, method) or engine.supports(wanted, method)
    if request["call"] == "supports":
        return {"reason": reason}
    if reason is not None:
        return {"unsupported": reason}
    _check_step(engine.schemes[method.scheme], method)
    run = _run(engine, wanted, method, request)
    _check_arrays(run, wanted, method)
    np.savez(request["path"], allow_pickle=False, **_asked_arrays(run, scene))
    return {
        "diverged": bool(run.diverged),
        "stopped": str(run.stopped),
        "cost": dataclasses.asdict(run.cost),
        "remarks": list(run.remarks),
    }


def _run(engine: Engine, scene: Scene, method: Method, request: dict[str, Any]) -> Run:
    """The run; from the state in the file `restart` of the request, and to that in `keep`, if they are given."""
    restart, keep = request.get("restart"), request.get("keep")
    if isinstance(engine, Restartable) and keep is not None:
        run, state = engine.run_from(scene, method, None if restart is None else read_arrays(Path(restart)))
        if state is not None and not run.diverged and not run.stopped:
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


def _asked_arrays(run: Run, scene: Scene) -> dict[str, Floats]:
    """The arrays that the scene asks for, the derived ones computed from the others."""
    asked = scene.asked()
    masses = scene.initial_state().masses if any(row.derive is not None for row in asked.values()) else np.zeros(0)
    return {name: run[name] if row.derive is None else row.derive(masses, run) for name, row in asked.items()}


def _check_step(claims: Claims, method: Method) -> None:
    """UsageError if a scheme that takes time steps has none, or one that does not take them has one."""
    if claims.takes_dt:
        _ = method.step
    elif method.dt is not None:
        how = "takes whole steps of 1" if claims.kind == "lattice" else "goes from event to event"
        raise UsageError(f"method.dt = {method.dt:g}: scheme '{method.scheme}' {how}: remove dt")


def _check_arrays(run: Run, scene: Scene, method: Method) -> None:
    """ValueError if arrays are missing or have wrong shapes: here it names the engine; a check would fail obscurely."""
    samples, expected = len(run["time"]), len(sample_times(scene, method))
    if samples != expected:
        raise ValueError(f"run['time'] has {samples} samples, the scene asks for {expected}")
    for name, shape in shapes(scene, samples).items():
        returned = run[name].shape if name in run else None
        if returned != shape:
            found = "nothing" if returned is None else f"shape {returned}"
            raise ValueError(f"run['{name}'] must have shape {shape}, found {found}")


def serve(engine_name: str, read_fd: int, write_fd: int) -> None:
    """Answers requests until the pipe closes.

    engine_name: a name, or path.py:Class. read_fd, write_fd: file descriptors of the pipes for requests and answers.
    """
    engine: Engine | None = None
    with os.fdopen(read_fd) as requests, os.fdopen(write_fd, "w") as answers:
        for line in requests:
            try:
                engine = engine or load_engine(engine_name)
                reply = json.dumps(answer(engine, json.loads(line)))
            except UsageError as error:
                reply = json.dumps({"usage": str(error)})
            except Exception as error:
                traceback.print_exc()
                reason = _missing(engine, error)
                reply = json.dumps(reason or {"error": f"{type(error).__name__}: {error}"})
            answers.write(reply + "\n")
            answers.flush()


def _missing(engine: Engine | None, error: Exception) -> dict[str, str] | None:
    """The answer "missing" if the engine cannot be imported or `version` fails; None for any other error."""
    if not isinstance(error, ImportError | OSError):
        return None
    if engine is not None:
        try:
            engine.version()
        except (ImportError, OSError) as reason:
            error = reason
        else:
            return None
    return {"missing": f"{type(error).__name__}: {error}"}


if __name__ == "__main__":
    # a crash, and the signal SIGUSR1, by which the parent asks a hung worker, write the Python stack to the log
    faulthandler.enable()
    faulthandler.register(signal.SIGUSR1)
    # compilers make many small objects that stay alive; collecting garbage less often saves a tenth of the compile time
    gc.set_threshold(200_000, 20, 100)
    serve(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
