"""Runs any scene on one or more engines, and writes all that was recorded, trajectories, and one picture of all."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from importlib.resources import as_file
from pathlib import Path

from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EngineError, EngineMissing, UsageError
from crosscheck.files import shown_path
from crosscheck.scene import Floats, Method, Scene
from crosscheck.simulate.arrays import write_arrays, write_places
from crosscheck.simulate.files import file_labels, results_in
from crosscheck.simulate.observables import Result, observables, write_observables
from crosscheck.simulate.picture import draw_picture
from crosscheck.simulate.progress import shown
from crosscheck.simulate.restart import Restart, check_version, going_on, read_restart, write_restart
from crosscheck.simulate.summary import Difference, Row, compare, distances, endings, row
from crosscheck.trajectories.formats import DEFAULT, check_formats, write_trajectories


def shipped_scenes() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    directory = resources.files("crosscheck") / "scenes"
    return sorted(entry.name.removesuffix(".toml") for entry in directory.iterdir() if entry.name.endswith(".toml"))


def load(name: str | Path) -> Scene:
    """A scene from a file, or a shipped one.

    name: path of a TOML file, or name of a shipped scene. UsageError if there is neither, or if the scene is not valid.
    """
    if not os.path.isfile(name) and str(name) in shipped_scenes():
        with as_file(resources.files("crosscheck") / "scenes" / f"{name}.toml") as shipped:
            return Scene.load(shipped)
    if os.path.lexists(name):
        return Scene.load(name)
    raise UsageError(
        f"{shown_path(name)}: there is no such file, nor a shipped scene; shipped are {', '.join(shipped_scenes())}"
    )


@dataclass(frozen=True)
class Simulation:
    """What `simulate` did.

    paths: of the files written. rows: how each run went. endings: sentences on runs that diverged or stopped, and
    remarks of the engines. differences: of each pair of runs. failures: messages of engines that failed, whose runs are
    lost, and of a picture that could not be drawn. remarks: on the files. whole: whether all runs went to their end.
    """

    paths: list[Path]
    rows: list[Row]
    endings: list[str]
    differences: list[Difference]
    failures: list[str]
    remarks: list[str]
    whole: bool


def simulate(
    scene: str | Path,
    engines: Sequence[str],
    out: Path,
    time_limit: float = TIME_LIMIT,
    restart: Path | None = None,
    formats: Sequence[str] = (),
) -> Simulation:
    """Runs a scene on each engine with the scene's own method, and writes the results.

    scene: a TOML file, or the name of a shipped scene. engines: names, or path.py:Class, each once. out: the directory
    to write to, made if it is not there. <engine> in the names of files is the name, or the file and the class:
    arrays-<engine>.npz with all arrays; observables-<engine>.csv with what has a value per sample;
    particles-, fields-, blocks-, rows- and sites-<engine>.csv with what has one per particle, cell ...;
    trajectory-<engine>.<suffix>; each where the scene records such a thing; restart-<engine>.npz of engines that can go
    on from one; picture.png and picture.svg. Files of the simulation before in this directory are removed. time_limit:
    seconds that one call of an engine may take. restart: a restart file to go on from; None: the run begins at the
    scene's initial state. formats: of the trajectories, names of `crosscheck.trajectories.formats`; none: extended XYZ,
    of a scene that records one.

    UsageError if the scene is not valid or has no [method], if an engine is missing or cannot run the scene, if files
    cannot be written, if a format is unknown, or asked for of a scene without a trajectory, and if the restart file is
    damaged, or of another scene, method or engine. EngineError if every engine failed.
    """
    loaded = load(scene)
    check_formats(formats, loaded)
    method = _method(loaded)
    if len(set(map(_identity, engines))) < len(engines):
        raise UsageError(f"--engine: {', '.join(engines)}: name each engine once")
    before = None if restart is None else read_restart(restart)
    if before is not None:
        loaded = going_on(before, loaded, method, engines)
    loaded.check_start()
    with results_in(out) as files:
        states = {engine: files.scratch / f"state-{number}.npz" for number, engine in enumerate(engines)}
        results, kinds, failures = _run_all(loaded, method, states, before, time_limit)
        written: list[Path] = []
        remarks: list[str] = []
        for result in results:
            name = result.engine
            if len(result.table) > 1:
                path = files.scratch / f"observables-{name}.csv"
                written.append(write_observables(path, loaded, method, result))
            written.append(write_arrays(files.scratch / f"arrays-{name}.npz", loaded, method, result))
            paths, remark = write_places(files.scratch, name, loaded, method, result)
            written += paths
            remarks += [remark] if remark else []
            written += write_trajectories(files.scratch, name, loaded, result.run, method, formats or DEFAULT)
        written += _write_restarts(files.scratch, loaded, method, states, results, before)
        compared = differences(*results) if len(results) == 2 else {}
        try:
            written += draw_picture(files.scratch, loaded, method, results, compared)
        except Exception as error:  # the numbers of a long run must not be lost with its picture
            failures.append(f"the picture cannot be drawn ({type(error).__name__}: {' '.join(str(error).split())})")
        paths = files.put(written)
    return Simulation(
        paths=paths,
        rows=[row(loaded, method, result, kinds[result.engine]) for result in results],
        endings=[text for result in results for text in endings(loaded, result)],
        differences=compare(loaded, results),
        failures=failures,
        remarks=remarks,
        whole=not failures and not any(result.run.diverged or result.run.stopped for result in results),
    )


def _write_restarts(
    directory: Path,
    scene: Scene,
    method: Method,
    states: dict[str, Path],
    results: Sequence[Result],
    before: Restart | None,
) -> list[Path]:
    """Writes a restart file for each engine that has left its state at the end; their paths.

    states: by engine, the file with it, if it is there. before: the restart file that the runs have gone on from.
    """
    written = []
    labels = file_labels(tuple(states))
    of_label = {result.engine: result for result in results}
    for engine, state in states.items():
        result = of_label.get(labels[engine])
        if result is None or not state.exists():
            continue
        span = scene.duration if scene.output.collisions is None else float(result.run["time"][-1])
        written.append(directory / f"restart-{result.engine}.npz")
        end = span if before is None else before.time + span
        write_restart(written[-1], state, scene, method, (engine, result.version), end)
    return written


def _identity(engine: str) -> str:
    """The same text for two spellings of one engine."""
    return str(Path(engine).resolve()) if ".py:" in engine else engine


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


def _run_all(
    scene: Scene, method: Method, states: dict[str, Path], before: Restart | None, time_limit: float
) -> tuple[list[Result], dict[str, str], list[str]]:
    """The runs, the kind of scheme of each by its label, and the messages of engines that failed.

    All engines are asked whether they can run the scene before the first one does. states: the file for the state at
    the end, by engine. before: the restart file that the runs go on from; None: none. EngineError if all failed.
    """
    engines = tuple(states)
    labels = file_labels(engines)
    versions: dict[str, str] = {}
    results: list[Result] = []
    failures: list[str] = []
    restart = None if before is None else before.path.absolute()
    pool = Pool(time_limit=time_limit)
    try:
        for engine in engines:
            with shown(labels[engine], pool.worker(engine).progress):
                versions[engine] = _version(scene, method, engine, pool)
            if before is not None:
                check_version(before, versions[engine])
        for engine in engines:
            try:
                worker = pool.worker(engine)
                with shown(labels[engine], worker.progress):
                    run = worker.run(scene, method, worker.progress, restart, states[engine])
            except EngineError as error:
                failures.append(str(error))
                continue
            results.append(Result(labels[engine], versions[engine], run, observables(scene, run)))
    finally:
        pool.close()
    if not results:
        raise EngineError("\n".join(failures))
    kinds: dict[str, str] = {labels[engine]: engine_class(engine).schemes[method.scheme].kind for engine in engines}
    return results, kinds, failures


def _version(scene: Scene, method: Method, engine: str, pool: Pool) -> str:
    """The version of an engine; UsageError if it is missing or cannot run the scene."""
    worker = pool.worker(engine)
    schemes = engine_class(engine).schemes
    try:
        version, reason = worker.version(), worker.supports(scene, method)
    except EngineMissing as missing:
        raise UsageError(str(missing)) from None
    if reason is not None:
        raise UsageError(f"{engine} cannot run scene {scene.name}: {reason}; its schemes: {', '.join(schemes)}")
    return version


def differences(one: Result, other: Result) -> dict[str, Floats]:
    """Absolute differences between runs of one scene on two engines, `one` and `other`, (samples,) by name.

    Of energies and pressure, as far as both have them. "position of the farthest particle": the largest distance of a
    particle from itself in the other run, if both have trajectories.
    """
    found: dict[str, Floats] = {}
    for name in ("total_energy", "kinetic_energy", "potential_energy", "pressure"):
        if name in one.table and name in other.table:
            found[name.replace("_", " ")] = abs(one.table[name] - other.table[name])
    apart = distances(one.run, other.run)
    if apart is not None:
        found["position of the farthest particle"] = apart
    return found
