"""Runs any scene on one or more engines, and writes all that was recorded, trajectories, and one picture of all."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from importlib.resources import as_file
from pathlib import Path

from crosscheck.engines.protocol import Kind
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EngineError, EngineMissing, UsageError
from crosscheck.files import shown_path
from crosscheck.scene import Floats, Scene
from crosscheck.simulate.arrays import write_arrays, write_places
from crosscheck.simulate.files import results_in
from crosscheck.simulate.judging.judge import Judge, observables_needed
from crosscheck.simulate.judging.ladder import Ladder
from crosscheck.simulate.judging.recording import recording
from crosscheck.simulate.judging.trial import Tell
from crosscheck.simulate.methods import Planned, mend, planned
from crosscheck.simulate.observables import Result, observables, write_observables
from crosscheck.simulate.picture import draw_picture
from crosscheck.simulate.progress import shown
from crosscheck.simulate.restart import Restart, check_version, going_on, read_restart, write_restart
from crosscheck.simulate.summary import Difference, Row, compare, distances, endings, row
from crosscheck.trajectories.formats import DEFAULT, check_formats, write_trajectories
from crosscheck.verdict import Verdict


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
class Judging:
    """How the runs are judged.

    tolerance: of the changes on halving dt, relative. begin: gets what was simulated, before it is judged. tell: says
    something before it takes time. take: takes a verdict as soon as it is found.
    """

    tolerance: float
    begin: Callable[[Simulation], None]
    tell: Tell
    take: Callable[[Verdict], None]


@dataclass(frozen=True)
class Simulation:
    """What `simulate` did.

    paths: of the files written. rows: how each run went. endings: sentences on runs that diverged or stopped, and
    remarks of the engines. differences: of each pair of runs. failures: messages of engines that failed, whose runs are
    lost, and of a picture that could not be drawn. remarks: on the files. whole: whether all runs went to their end.
    ladders: of time steps, by the label of the run, if the runs were judged.
    """

    paths: list[Path]
    rows: list[Row]
    endings: list[str]
    differences: list[Difference]
    failures: list[str]
    remarks: list[str]
    whole: bool
    ladders: dict[str, Ladder]


def simulate(
    scene: str | Path,
    engines: Sequence[str],
    out: Path,
    time_limit: float = TIME_LIMIT,
    restart: Path | None = None,
    formats: Sequence[str] = (),
    methods: Sequence[str] = (),
    judging: Judging | None = None,
) -> Simulation:
    """Runs a scene on each engine with its own method, or else that of the scene, and writes the results.

    scene: a TOML file, or the name of a shipped scene. engines: names, or path.py:Class, each once. out: the directory
    to write to, made if it is not there. <run> in the names of files is the name of the engine, or the file and the
    class, and its method where it has several: arrays-<run>.npz with all arrays; observables-<run>.csv with what has a
    value per sample; particles-, fields-, blocks-, rows- and sites-<run>.csv with what has one per particle, cell ...;
    trajectory-<run>.<format>; each where the scene records such a thing; restart-<run>.npz of engines that can go
    on from one; picture.png and picture.svg. Files of the simulation before in this directory are removed. time_limit:
    seconds that one call of an engine may take. restart: a restart file to go on from; None: the run begins at the
    scene's initial state. methods: see `crosscheck.simulate.methods.planned`. formats: of the trajectories, names
    of `crosscheck.trajectories.formats`; none: extended XYZ, of a scene that records one. judging: how the runs are
    judged, once their files are written; they then record what that needs, beside what the scene asks for. None: they
    are not.

    UsageError if the scene is not valid or a run has no method, if an engine is missing or cannot run the scene, if
    files cannot be written, if a format is unknown, or asked for of a scene without a trajectory, if the restart file
    is damaged, or of another scene, method or engine, and if a run that goes on is to be judged. EngineError if every
    engine failed.
    """
    if judging is not None and restart is not None:
        raise UsageError("--judge and --restart: a run is judged from its start: remove one of them")
    loaded = load(scene)
    check_formats(formats, loaded)
    plan = planned(loaded, engines, methods)
    before = None if restart is None else read_restart(restart)
    if before is not None:
        plan = [_going_on(before, plan)]
    for one in {run.method.contact is None: run for run in plan}.values():
        one.scene.check_start()
    if judging is not None:
        plan = recording(plan, observables_needed())
    pool = Pool(time_limit=time_limit)
    try:
        results, done = _simulated(plan, out, pool, before, formats)
        if judging is None:
            return done
        judging.begin(done)
        judge = Judge(results, pool, judging.tolerance)
        for verdict in judge.verdicts(judging.tell):
            judging.take(verdict)
        return replace(done, ladders=judge.ladders)
    finally:
        pool.close()


def _simulated(
    plan: Sequence[Planned], out: Path, pool: Pool, before: Restart | None, formats: Sequence[str]
) -> tuple[list[tuple[Planned, Result]], Simulation]:
    """The runs, and what was written of them. pool: of the engines. Otherwise as `simulate`."""
    with results_in(out) as files:
        states = {one.label: files.scratch / f"state-{number}.npz" for number, one in enumerate(plan)}
        results, failures = _run_all(plan, states, before, pool)
        written: list[Path] = []
        remarks: list[str] = []
        for one, result in results:
            name = result.engine
            if len(result.table) > 1:
                path = files.scratch / f"observables-{name}.csv"
                written.append(write_observables(path, one.scene, one.method, result))
            written.append(write_arrays(files.scratch / f"arrays-{name}.npz", one.scene, one.method, result))
            paths, remark = write_places(files.scratch, name, one.scene, one.method, result)
            written += paths
            remarks += [remark] if remark else []
            written += write_trajectories(files.scratch, name, one.scene, result.run, one.method, formats or DEFAULT)
        written += _write_restarts(files.scratch, states, results, before)
        found = [result for _, result in results]
        compared = differences(*found) if len(found) == 2 else {}
        try:
            shown_methods = [one.method for one, _ in results]
            written += draw_picture(files.scratch, plan[0].scene, shown_methods, found, compared)
        except Exception as error:  # the numbers of a long run must not be lost with its picture
            failures.append(f"the picture cannot be drawn ({type(error).__name__}: {' '.join(str(error).split())})")
        paths = files.put(written)
    return results, Simulation(
        paths=paths,
        rows=[row(one.scene, one.method, result, kind_of(one)) for one, result in results],
        endings=[text for one, result in results for text in endings(one.scene, result)],
        differences=compare(plan[0].scene, found),
        failures=failures,
        remarks=remarks,
        whole=not failures and not any(result.run.diverged or result.run.stopped for result in found),
        ladders={},
    )


def kind_of(one: Planned) -> Kind:
    """The kind of the scheme of a run; one: the run."""
    return engine_class(one.engine).schemes[one.method.scheme].kind


def _going_on(before: Restart, plan: Sequence[Planned]) -> Planned:
    """The run that goes on from a restart file; UsageError if there are several, or it is not of that file."""
    first = plan[0]
    scene = going_on(before, first.scene, first.method, [one.engine for one in plan])
    return replace(first, scene=scene)


def _write_restarts(
    directory: Path,
    states: dict[str, Path],
    results: Sequence[tuple[Planned, Result]],
    before: Restart | None,
) -> list[Path]:
    """Writes a restart file for each run that has left its state at the end; their paths.

    states: by label, the file with it, if it is there. before: the restart file that the runs have gone on from.
    """
    written = []
    for one, result in results:
        state, scene = states[one.label], one.scene
        if not state.exists():
            continue
        span = scene.duration if scene.output.collisions is None else float(result.run["time"][-1])
        written.append(directory / f"restart-{result.engine}.npz")
        end = span if before is None else before.time + span
        write_restart(written[-1], state, scene, one.method, (one.engine, result.version), end)
    return written


def _run_all(
    plan: Sequence[Planned], states: dict[str, Path], before: Restart | None, pool: Pool
) -> tuple[list[tuple[Planned, Result]], list[str]]:
    """The runs, and the messages of engines that failed.

    All engines are asked whether they can run the scene before the first one does. states: the file for the state at
    the end, by label. before: the restart file that the runs go on from; None: none. pool: of the engines. EngineError
    if all failed.
    """
    versions: dict[str, str] = {}
    results: list[tuple[Planned, Result]] = []
    failures: list[str] = []
    restart = None if before is None else before.path.absolute()
    for one in plan:
        with shown(one.label, pool.worker(one.engine).progress):
            versions[one.engine] = _version(one, pool)
        if before is not None:
            check_version(before, versions[one.engine])
    for one in plan:
        try:
            worker = pool.worker(one.engine)
            with shown(one.label, worker.progress):
                run = worker.run(one.scene, one.method, worker.progress, restart, states[one.label])
        except EngineError as error:
            failures.append(str(error))
            continue
        results.append((one, Result(one.label, versions[one.engine], run, observables(one.scene, run))))
    if not results:
        raise EngineError("\n".join(failures))
    return results, failures


def _version(one: Planned, pool: Pool) -> str:
    """The version of an engine; UsageError if it is missing or cannot run the scene with its method."""
    engine, scene, method = one.engine, one.scene, one.method
    worker = pool.worker(engine)
    schemes = engine_class(engine).schemes
    try:
        version, reason = worker.version(), worker.supports(scene, method)
    except EngineMissing as missing:
        raise UsageError(str(missing)) from None
    if reason is not None:
        cure = mend(scene, engine, method) or f"; its schemes: {', '.join(schemes)}"
        raise UsageError(f"{engine} cannot run scene {scene.name}: {reason}{cure}")
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
