"""The engine's side of the pipe: `python -P -m crosscheck.engines.workers.worker <engine> <read fd> <write fd>`.

One request a line, JSON in, JSON out; arrays leave as an .npz file whose path is in the answer. The engine's own output
goes to stdout and stderr, which the parent has pointed at a log.
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
from typing import Any

import numpy as np

from crosscheck.engines.protocol import TALLY, Claims, Engine, Run, sample_times, tally_shapes
from crosscheck.engines.registry import load_engine
from crosscheck.engines.soft_spheres import resolved
from crosscheck.errors import UsageError
from crosscheck.scene import GAS_TALLIES, TALLIES, Method, Scene


def answer(engine: Engine, request: dict[str, Any]) -> dict[str, Any]:
    """The answer to one request: `version`, `supports` or `run`."""
    if request["call"] == "version":
        return {"version": engine.version()}
    scene = Scene.from_json(request["scene"])
    method = resolved(scene, Method.model_validate_json(request["method"]))
    reason = engine.supports(scene, method)
    if request["call"] == "supports":
        return {"reason": reason}
    if reason is not None:
        return {"unsupported": reason}
    _check_step(engine.schemes.get(method.scheme), method)
    run = engine.run(scene, method)
    _check(run, scene, method)
    apart = ("diverged", "stopped", "cost", "tallies")
    arrays = {f.name: getattr(run, f.name) for f in dataclasses.fields(run) if f.name not in apart}
    arrays |= {f"{TALLY}{name}": array for name, array in run.tallies.items()}
    np.savez(request["path"], **{name: array for name, array in arrays.items() if array is not None})
    return {"diverged": bool(run.diverged), "stopped": str(run.stopped), "cost": dataclasses.asdict(run.cost)}


def _check_step(claims: Claims | None, method: Method) -> None:
    """UsageError if a scheme that takes time steps has none, or one that does not take them has one."""
    if claims is None or claims.stepping or claims.collisions:
        _ = method.step
    elif method.dt is not None:
        how = "takes whole steps of 1" if claims.lattice else "goes from event to event"
        raise UsageError(f"method.dt = {method.dt:g}: scheme '{method.scheme}' {how}: remove dt")


def _check(run: Run, scene: Scene, method: Method) -> None:
    """Refuses a malformed answer here, where the engine's name is known, not in the analysis later."""
    shape, spin = (scene.number, scene.dimension), (scene.number, scene.spin_dimension)
    samples, expected = len(run.time), len(sample_times(scene, method))
    if samples != expected:
        raise ValueError(f"run.time has {samples} samples, the scene asks for {expected}")
    wanted: dict[str, tuple[int, ...]] = {"final_positions": shape, "final_velocities": shape}
    if scene.output.trajectory:
        wanted |= {"positions": (samples, *shape), "velocities": (samples, *shape)}
    if scene.spin_dimension:
        wanted["final_angular_velocities"] = spin
        if scene.output.trajectory:
            wanted["angular_velocities"] = (samples, *spin)
    if scene.output.forces:
        wanted["forces"] = shape
    wanted |= {name: (samples,) for name in scene.output.observables if name not in (*TALLIES, *GAS_TALLIES)}
    found = {name: getattr(run, name) for name in wanted}
    tallies = tally_shapes(scene, samples)
    for name, expected_shape in (wanted | tallies).items():
        array = run.tallies.get(name) if name in tallies else found[name]
        if array is None or array.shape != expected_shape:
            what = f"run.tallies['{name}']" if name in tallies else f"run.{name}"
            met = "None" if array is None else f"shape {array.shape}"
            raise ValueError(f"{what} must have shape {expected_shape}, found {met}")


def serve(engine_name: str, read_fd: int, write_fd: int) -> None:
    """Answers requests until the pipe closes."""
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
    """An engine is missing if it cannot be imported or cannot tell its version; any other failure is an error."""
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
    # a crash, and SIGUSR1 before a hung worker is ended, leave the place in the log
    faulthandler.enable()
    faulthandler.register(signal.SIGUSR1)
    # compilers make hosts of small objects that stay: to look through them each time costs a tenth of the compilation
    gc.set_threshold(200_000, 20, 100)
    serve(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
