"""Runs any scene on one or more engines, and writes observables as CSV, trajectories, and one picture of all."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np

from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EngineMissing, UsageError
from crosscheck.scene import Floats, Method, Scene
from crosscheck.simulate.observables import Result, observables, write_observables
from crosscheck.simulate.picture import draw_picture
from crosscheck.simulate.restart import Restart, check_version, going_on, read_restart, write_restart
from crosscheck.simulate.trajectory import write_trajectories


def shipped_scenes() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    directory = files("crosscheck") / "scenes"
    return sorted(entry.name.removesuffix(".toml") for entry in directory.iterdir() if entry.name.endswith(".toml"))


def load(name: str | Path) -> Scene:
    """A scene from a file, or a shipped one.

    name: path of a TOML file, or name of a shipped scene. UsageError if there is neither, or if the scene is not valid.
    """
    path = Path(name)
    if path.is_file():
        return Scene.load(path)
    if str(name) in shipped_scenes():
        with as_file(files("crosscheck") / "scenes" / f"{name}.toml") as shipped:
            return Scene.load(shipped)
    raise UsageError(f"{name}: there is no such file, nor a shipped scene; shipped are {', '.join(shipped_scenes())}")


def simulate(scene: str | Path, engines: Sequence[str], out: Path, restart: Path | None = None) -> list[Path]:
    """Runs a scene on each engine with the scene's own method and writes the results; returns the paths of all files.

    scene: a TOML file, or the name of a shipped scene. engines: names, or path.py:Class, each once. out: the directory
    to write to, made if it is not there: observables-<engine>.csv and trajectory-<engine>.<format> where the scene
    records them, restart-<engine>.npz of engines that can go on from one, picture.png and picture.svg always. restart:
    a file of the last kind to go on from; None: the run begins at the scene's initial state.

    UsageError if the scene is not valid or has no [method], if an engine is missing or cannot run the scene, and if the
    restart file is damaged, or of another scene, method or engine.
    """
    loaded = load(scene)
    method = _method(loaded)
    if len(set(engines)) < len(engines):
        raise UsageError(f"--engine: {', '.join(engines)}: name each engine once")
    before = None if restart is None else read_restart(restart)
    if before is not None:
        loaded = going_on(before, loaded, method, engines)
    pool, scratch = Pool(), tempfile.TemporaryDirectory(prefix="crosscheck-")
    states = {engine: Path(scratch.name) / f"{number}.npz" for number, engine in enumerate(engines)}
    try:
        results = [_run(loaded, method, engine, pool, before, states[engine]) for engine in engines]
    except BaseException:
        scratch.cleanup()
        raise
    finally:
        pool.close()
    out.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for result in results:
        name = re.sub(r"[^A-Za-z0-9_.-]+", "-", Path(result.engine).name)
        if len(result.table) > 1:
            written.append(write_observables(out / f"observables-{name}.csv", loaded, method, result))
        written += write_trajectories(out, name, loaded, result.run)
        state = states[result.engine]
        if state.exists():
            written.append(out / f"restart-{name}.npz")
            span = loaded.duration if loaded.output.collisions is None else float(result.run["time"][-1])
            end = span if before is None else before.time + span
            write_restart(written[-1], state, loaded, method, (result.engine, result.version), end)
    scratch.cleanup()
    compared = differences(*results) if len(results) == 2 else {}
    return written + draw_picture(out, loaded, method, results, compared)


def _method(scene: Scene) -> Method:
    """The scene's own method; UsageError, with an example of one, if it has none."""
    if scene.method is not None:
        return scene.method
    example = 'scheme and dt, as in scheme = "velocity_verlet", dt = 0.005'
    if scene.hard_spheres is not None:
        example = 'scheme = "event_driven"'
    elif scene.lattice_gas is not None:
        example = 'scheme = "lattice_planes"'
    raise UsageError(f"scene {scene.name}: add [method] with {example}")


def _run(scene: Scene, method: Method, engine: str, pool: Pool, restart: Restart | None, keep: Path) -> Result:
    """The run of one engine in its worker process; UsageError if the engine is missing or cannot run the scene."""
    worker = pool.worker(engine)
    schemes = engine_class(engine).schemes
    try:
        version, reason = worker.version(), worker.supports(scene, method)
    except EngineMissing as missing:
        raise UsageError(str(missing)) from None
    if reason is not None:
        raise UsageError(f"{engine} cannot run scene {scene.name}: {reason}; its schemes: {', '.join(schemes)}")
    if restart is not None:
        check_version(restart, version)
    run = worker.run(scene, method, None if restart is None else restart.path.absolute(), keep)
    return Result(engine, version, run, observables(scene, run))


def differences(one: Result, other: Result) -> dict[str, Floats]:
    """Absolute differences between runs of one scene on two engines, `one` and `other`, (samples,) by name.

    Of energies and pressure, as far as both have them. "position of the farthest particle": the largest distance of a
    particle from itself in the other run, if both have trajectories.
    """
    found: dict[str, Floats] = {}
    for name in ("total_energy", "kinetic_energy", "potential_energy", "pressure"):
        if name in one.table and name in other.table:
            found[name.replace("_", " ")] = abs(one.table[name] - other.table[name])
    here, there = one.run.get("positions"), other.run.get("positions")
    if here is not None and there is not None:
        found["position of the farthest particle"] = np.linalg.norm(here - there, axis=2).max(axis=1)
    return found
