"""Runs one scene several times on one engine, each time in a new process, and keeps what each recorded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing, UsageError
from crosscheck.scene import Scene
from crosscheck.simulate.arrays import write_arrays
from crosscheck.simulate.files import file_labels
from crosscheck.simulate.observables import Result, observables
from crosscheck.simulate.progress import shown
from crosscheck.simulate.run import load


def repeat(
    scene: str | Path, engine: str, times: int, threads: Sequence[int], out: Path, time_limit: float
) -> list[Path]:
    """Runs a scene several times with the scene's own method; returns the .npz files, one a run.

    scene: a TOML file, or the name of a shipped scene. engine: its name, or path.py:Class. times: number of runs for
    each number of threads. threads: that libraries of the engine may use, as OMP_NUM_THREADS says; each in turn. out:
    directory of the files, run-<number>-threads-<number>.npz. time_limit: seconds that one run may take.

    UsageError if the scene is not valid, records no trajectory, or the engine is missing or cannot run it. EngineError
    if a run fails, diverges or stops.
    """
    loaded = load(scene)
    method = loaded.method
    if method is None:
        raise UsageError(f"scene {loaded.name}: add [method]: repeat runs it")
    if not loaded.output.trajectory and loaded.lattice_gas is None:
        loaded = _with_trajectory(loaded)
    loaded.check_start()
    (label,) = file_labels((engine,)).values()
    paths = []
    for count in threads:
        for number in range(1, times + 1):
            worker = Worker(engine, time_limit=time_limit, threads=count)
            try:
                with shown(f"{label}, run {number} of {times}", worker.progress):
                    try:
                        version, reason = worker.version(), worker.supports(loaded, method)
                    except EngineMissing as missing:
                        raise UsageError(str(missing)) from None
                    if reason is not None:
                        raise UsageError(f"{engine} cannot run scene {loaded.name}: {reason}")
                    run = worker.run(loaded, method, worker.progress)
            finally:
                worker.close()
            if run.diverged:
                raise EngineError(f"{engine}: run {number} diverged")
            paths.append(out / f"run-{number:02d}-threads-{count}.npz")
            result = Result(label, version, run, observables(loaded, run))
            write_arrays(paths[-1], loaded, method, result)
    return paths


def _with_trajectory(scene: Scene) -> Scene:
    output = scene.output
    if output.interval is None and output.collisions is None:
        raise UsageError(f"scene {scene.name}: add output.interval: without samples nothing can be compared")
    return scene.changed(output=output.model_copy(update={"trajectory": True}))
