"""Runs any scene on some engines: observables as CSV, trajectories as extended XYZ, and a picture, side by side."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.engines.base import Run
from crosscheck.engines.pool import Pool
from crosscheck.engines.registry import engine_class
from crosscheck.errors import EngineMissing, UsageError
from crosscheck.scene import Floats, Method, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Up to so many particles are drawn as trajectories, more as a configuration.
FEW = 10
_COLOURS = ("#0067a8", "#d04f00", "#00846a", "#a8327f", "#8f6c00", "#3a2a8c")


@dataclass(frozen=True)
class _Result:
    """A run with what follows from it. table: column -> (samples,)."""

    engine: str
    version: str
    run: Run
    table: dict[str, Floats]


def shipped_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    directory = files("crosscheck") / "scenes"
    return sorted(entry.name.removesuffix(".toml") for entry in directory.iterdir() if entry.name.endswith(".toml"))


def load(name: str | Path) -> Scene:
    """The scene in a file, or the shipped one of this name. UsageError if there is neither, or it is wrong."""
    path = Path(name)
    if path.is_file():
        return Scene.load(path)
    if str(name) in shipped_scenes():
        with as_file(files("crosscheck") / "scenes" / f"{name}.toml") as shipped:
            return Scene.load(shipped)
    raise UsageError(f"{name}: there is no such file, nor a shipped scene; shipped are {', '.join(shipped_scenes())}")


def simulate(scene: str | Path, engines: Sequence[str], out: Path) -> list[Path]:
    """Runs a scene on each engine with the scene's own method and writes the results to `out`.

    observables-<engine>.csv and trajectory-<engine>.extxyz where the scene records them; picture.png and picture.svg
    always. Returns their paths. UsageError without [method], and if an engine is missing or cannot run the scene.
    """
    what = load(scene)
    method = what.method
    if method is None:
        raise UsageError(
            f'scene {what.name}: add [method] with scheme and dt, as in scheme = "velocity_verlet", dt = 0.005'
        )
    if len(set(engines)) < len(engines):
        raise UsageError(f"--engine: {', '.join(engines)}: name each engine once")
    pool = Pool()
    try:
        results = [_run(what, method, engine, pool) for engine in engines]
    finally:
        pool.close()
    out.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for result in results:
        name = re.sub(r"[^A-Za-z0-9_.-]+", "-", Path(result.engine).name)
        if len(result.table) > 1:
            written.append(_write_observables(out / f"observables-{name}.csv", what, method, result))
        if result.run.positions is not None:
            written.append(_write_trajectory(out / f"trajectory-{name}.extxyz", what, result.run))
    return written + _draw(out, what, method, results)


def _run(scene: Scene, method: Method, engine: str, pool: Pool) -> _Result:
    worker = pool.worker(engine)
    schemes = engine_class(engine).schemes
    try:
        version, reason = worker.version(), worker.supports(scene, method)
    except EngineMissing as missing:
        raise UsageError(str(missing)) from None
    if reason is not None:
        raise UsageError(f"{engine} cannot run scene {scene.name}: {reason}; its schemes: {', '.join(schemes)}")
    run = worker.run(scene, method)
    return _Result(engine, version, run, observables(scene, run))


# -- observables ---------------------------------------------------------------------------------------------


def observables(scene: Scene, run: Run) -> dict[str, Floats]:
    """Time, energies, temperature and pressure, as far as the scene records what they need.

    temperature: 2K/(d(N - 1)), in units of energy, for N particles with zero total momentum; 2K/d for one. pressure:
    (2K + W)/(dV) in a box that is periodic along every axis. Tail corrections are in, if the scene has them.
    """
    table = {"time": run.time}
    kinetic, potential, virial = run.kinetic_energy, run.potential_energy, run.virial
    tail_energy, tail_pressure = _tails(scene)
    d = scene.dimension
    if kinetic is not None:
        table["kinetic_energy"] = kinetic
    if potential is not None:
        table["potential_energy"] = potential + tail_energy
    if kinetic is not None and potential is not None:
        table["total_energy"] = table["kinetic_energy"] + table["potential_energy"]
    if kinetic is not None:
        table["temperature"] = 2 * kinetic / (d * max(scene.number - 1, 1))
    if kinetic is not None and virial is not None and set(scene.boundaries) == {"periodic"}:
        table["pressure"] = (2 * kinetic + virial) / (d * scene.volume()) + tail_pressure
    return table


def _tails(scene: Scene) -> tuple[float, float]:
    """Energy and pressure of the pairs beyond the cutoff, zero unless the scene asks for them."""
    if scene.lennard_jones is None or not scene.lennard_jones.tail_corrections:
        return 0.0, 0.0
    from crosscheck.engines.refimpl import _force
    from refimpl.stepping.forces.lennard_jones import tail_corrections

    try:
        tails = tail_corrections(_force(scene, scene.initial_state()))
    except ValueError as error:
        raise UsageError(f"scene {scene.name}: lennard_jones.tail_corrections: {error}") from None
    return tails.energy, tails.pressure


_MEANINGS = {
    "temperature": "temperature = 2 kinetic_energy/(d (N - 1)), an energy: k_B T; for N = 1 it is 2 kinetic_energy/d",
    "pressure": "pressure = (2 kinetic_energy + virial)/(d V)",
}


def _write_observables(path: Path, scene: Scene, method: Method, result: _Result) -> Path:
    tails = scene.lennard_jones is not None and scene.lennard_jones.tail_corrections
    comments = [
        f"scene {scene.name}: {scene.number} particles in {scene.dimension} dimensions",
        f"{result.engine} {result.version}, {method.scheme}, dt = {method.dt!r}",
        "totals, in the scene's own units (SI, or reduced): time, energy, pressure = energy/length^d",
        *(text for name, text in _MEANINGS.items() if name in result.table),
        *(["potential_energy and pressure contain the tail corrections"] if tails else []),
        *(["the run diverged: not a number from there on"] if result.run.diverged else []),
    ]
    rows = np.column_stack(list(result.table.values()))
    header = "".join(f"# {comment}\n" for comment in comments) + ",".join(result.table)
    np.savetxt(path, rows, fmt="%.17g", delimiter=",", header=header, comments="")
    return path


# -- trajectory ----------------------------------------------------------------------------------------------


def _write_trajectory(path: Path, scene: Scene, run: Run) -> Path:
    """Extended XYZ with positions (not wrapped), velocities, masses and species; ASE reads it back.

    Species 0, 1, ... are named H, He, ...; without species the particles are called X. Eight decimals. A scene of fewer
    dimensions lies in the plane or on the axis; a diverged run is written up to its last good sample.
    """
    import ase
    import ase.io

    assert run.positions is not None
    assert run.velocities is not None
    state = scene.initial_state()
    cell, periodic = np.zeros(3), np.zeros(3, dtype=bool)
    if state.lengths is not None:
        cell[: scene.dimension] = state.lengths
        periodic[: scene.dimension] = [boundary == "periodic" for boundary in scene.boundaries]
    kinds = np.zeros(scene.number, dtype=int) if state.species is None else state.species + 1
    frames = []
    for time, r, v in zip(run.time, run.positions, run.velocities, strict=True):
        if not (np.isfinite(r).all() and np.isfinite(v).all()):
            break
        atoms = ase.Atoms(kinds, positions=_in_space(r), cell=cell, pbc=periodic, info={"time": float(time)})
        atoms.set_masses(state.masses)
        atoms.set_velocities(_in_space(v))
        atoms.new_array("velocities", _in_space(v))
        frames.append(atoms)
    ase.io.write(path, frames, format="extxyz")
    return path


def _in_space(vectors: Floats) -> Floats:
    """(N, d) as (N, 3), zeros where there is no axis."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


# -- picture -------------------------------------------------------------------------------------------------


def _draw(out: Path, scene: Scene, method: Method, results: list[_Result]) -> list[Path]:
    """A column per engine: configuration or trajectories above the energies; below, how far two engines differ."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    energies = any(_energies(result) for result in results)
    compared = _differences(results) if len(results) == 2 else {}
    heights = [4.2] + [2.6] * energies + [2.6] * bool(compared)
    style: Any = {
        "svg.hashsalt": "crosscheck",
        "svg.fonttype": "none",
        "font.size": 10,
        "axes.grid": True,
        "grid.alpha": 0.3,
    }
    above: dict[str, Any] = {
        "fontsize": 8, "ncols": 3, "loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "frameon": False,
        "columnspacing": 1.2, "handlelength": 1.5,
    }  # fmt: skip
    with matplotlib.rc_context(style), np.errstate(all="ignore"):
        figure = Figure(figsize=(max(5.5, 4.6 * len(results)), sum(heights) + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(f"{scene.name}: {method.scheme}, dt = {method.dt:g}, to t = {scene.duration:g}")
        grid = figure.add_gridspec(len(heights), len(results), height_ratios=heights)
        energy_axes: Axes | None = None
        for column, result in enumerate(results):
            axes = figure.add_subplot(grid[0, column])
            axes.set_title(result.engine + (" (diverged)" if result.run.diverged else ""), fontsize=10)
            _draw_configuration(axes, scene, result.run)
            if energies:
                energy_axes = figure.add_subplot(grid[1, column], sharey=energy_axes)
                for colour, (name, values) in zip(_COLOURS, _energies(result).items(), strict=False):
                    energy_axes.plot(result.run.time, values, color=colour, linewidth=1, label=name.replace("_", " "))
                energy_axes.set(xlabel="time", ylabel="energy")
                energy_axes.legend(**above)
        if compared:
            axes = figure.add_subplot(grid[-1, :])
            for colour, (name, values) in zip(_COLOURS, compared.items(), strict=False):
                axes.plot(
                    results[0].run.time, np.where(values > 0, values, np.nan), color=colour, linewidth=1, label=name
                )
            axes.set(xlabel="time", ylabel=f"|{results[0].engine} - {results[1].engine}|", yscale="log")
            axes.legend(**above)
        paths = [out / "picture.png", out / "picture.svg"]
        figure.savefig(paths[0], dpi=130, metadata={"Software": None})
        figure.savefig(paths[1], metadata={"Date": None, "Creator": None})
    return paths


def _energies(result: _Result) -> dict[str, Floats]:
    return {name: values for name, values in result.table.items() if name.endswith("_energy")}


def _differences(results: list[_Result]) -> dict[str, Floats]:
    """Absolute differences between two engines: of every observable, and of the farthest particle."""
    one, other = results
    found: dict[str, Any] = {}
    for name in ("total_energy", "kinetic_energy", "potential_energy", "pressure"):
        if name in one.table and name in other.table:
            found[name.replace("_", " ")] = abs(one.table[name] - other.table[name])
    if one.run.positions is not None and other.run.positions is not None:
        distances = np.linalg.norm(one.run.positions - other.run.positions, axis=2)
        found["position of the farthest particle"] = distances.max(axis=1)
    return found


def _draw_configuration(axes: Axes, scene: Scene, run: Run) -> None:
    """Few particles as trajectories, on a line against time; many as points at the end, coloured by speed."""
    if scene.number <= FEW and run.positions is not None:
        _draw_trajectories(axes, scene, run.time, run.positions)
        return
    r, lengths = run.final_positions.copy(), scene.lengths()
    if lengths is not None:
        wraps = np.array(scene.boundaries) == "periodic"
        r[:, wraps] %= lengths[wraps]
        axes.set_xlim(0, lengths[0])
        if scene.dimension > 1:
            axes.set_ylim(0, lengths[1])
    flat = _in_space(r)
    speed = np.linalg.norm(run.final_velocities, axis=1)
    order = np.argsort(flat[:, 2], kind="stable")
    depth = (
        np.zeros(scene.number) if scene.dimension < 3 else (flat[:, 2] - flat[:, 2].min()) / (np.ptp(flat[:, 2]) or 1.0)
    )
    area = min(120.0, 2.4e4 / scene.number) * (0.4 + 0.6 * depth if scene.dimension == 3 else 1.0 + depth)
    points = axes.scatter(
        flat[order, 0],
        flat[order, 1],
        s=area[order],
        c=speed[order],
        cmap="viridis",
        linewidths=0.3,
        edgecolors="#333333",
    )
    assert axes.figure is not None
    axes.figure.colorbar(points, ax=axes, label="speed", shrink=0.8)
    axes.set(xlabel="x", ylabel="y (far particles are smaller)" if scene.dimension == 3 else "y", aspect="equal")


def _draw_trajectories(axes: Axes, scene: Scene, time: Floats, positions: Floats) -> None:
    for particle in range(scene.number):
        path = positions[:, particle]
        colour = _COLOURS[particle % len(_COLOURS)]
        across, up = (time, path[:, 0]) if scene.dimension == 1 else (path[:, 0], path[:, 1])
        axes.plot(across, up, color=colour, linewidth=1)
        good = np.flatnonzero(np.isfinite(across) & np.isfinite(up))
        if good.size:
            axes.plot(across[good[-1]], up[good[-1]], "o", color=colour, markersize=5)
    if scene.dimension == 1:
        axes.set(xlabel="time", ylabel="x")
    else:
        axes.set(xlabel="x", ylabel="y")
        axes.set_aspect("equal", adjustable="datalim")
