"""Runs any scene on some engines: observables as CSV, trajectories as extended XYZ, and a picture, side by side."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.engines.protocol import Run, face_names
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EngineMissing, UsageError
from crosscheck.scene import AXES, Floats, Method, Scene
from crosscheck.scene.lattice_gas import gas_model
from crosscheck.scene.observables import OPERATIONS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Up to so many particles are drawn as trajectories, more as a configuration.
FEW = 10
_ENERGIES = ("kinetic_energy", "potential_energy", "total_energy", "rotational_energy")
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
        example = 'scheme and dt, as in scheme = "velocity_verlet", dt = 0.005'
        if what.hard_spheres is not None:
            example = 'scheme = "event_driven"'
        elif what.lattice_gas is not None:
            example = 'scheme = "lattice_planes"'
        raise UsageError(f"scene {what.name}: add [method] with {example}")
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
        if "positions" in result.run:
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
    """Time, energies, temperature and pressure, as far as the scene records what they need; then the tallies.

    temperature: 2K/(d(N - 1)), in units of energy, for N particles with zero total momentum; 2K/d for one. pressure:
    (2K + W)/(dV) in a box that is periodic along every axis. Tail corrections are in, if the scene has them.

    Of hard spheres, K is of the translation: without "rotational_energy", grains that rotate have no temperature here;
    N counts those that move, and stands for N - 1 where walls, fixed particles or a field take up momentum. pressure:
    the mean since the start, with the collisional virial for W and exact time averages. A tally with several columns
    becomes as many, "wall_impulse[x-].y" and the like.

    Of lattice gases: totals of mass, momentum and what the force gave.
    """
    table = {"time": run["time"]}
    kinetic, potential, virial = run["kinetic_energy"], run["potential_energy"], run["virial"]
    tail_energy, tail_pressure = _tails(scene)
    d = scene.dimension
    if kinetic is not None:
        table["kinetic_energy"] = kinetic
    if potential is not None:
        table["potential_energy"] = potential + tail_energy
    if kinetic is not None and potential is not None:
        table["total_energy"] = table["kinetic_energy"] + table["potential_energy"]
    if scene.hard_spheres is not None:
        return table | _of_hard_spheres(scene, run)
    if scene.lattice_gas is not None:
        return table | _of_lattice_gas(scene, run)
    if kinetic is not None:
        table["temperature"] = 2 * kinetic / (d * max(scene.number - 1, 1))
    if kinetic is not None and virial is not None and set(scene.boundaries) == {"periodic"}:
        table["pressure"] = (2 * kinetic + virial) / (d * scene.volume()) + tail_pressure
    return table


def _of_hard_spheres(scene: Scene, run: Run) -> dict[str, Floats]:
    table: dict[str, Floats] = {}
    d, tallies, rotates = scene.dimension, run, scene.spin_dimension > 0
    fixed = int(scene.fixed().sum())
    free = set(scene.boundaries) == {"periodic"} and not fixed
    rotational = tallies.get("rotational_energy")
    if "kinetic_energy" in run and (rotational is not None or not rotates):
        translation = run["kinetic_energy"] if rotational is None else run["kinetic_energy"] - rotational
        freedoms = scene.number - 1 if free and scene.acceleration is None else scene.number - fixed
        table["temperature"] = 2 * translation / (d * max(freedoms, 1))
    virial, integral = tallies.get("collisional_virial"), tallies.get("kinetic_energy_integral")
    if free and not rotates and virial is not None and integral is not None:
        span = np.where(run["time"] > 0, run["time"], np.nan)
        table["pressure"] = (2 * integral + virial) / (d * scene.volume() * span)
    for name in scene.output.observables:
        if name in tallies:
            table |= _columns(scene, name, tallies[name])
    return table


def _of_lattice_gas(scene: Scene, run: Run) -> dict[str, Floats]:
    table: dict[str, Floats] = {}
    tallies = run
    if "populations" in tallies:
        whole = tallies["populations"].sum(axis=(1, 2))
        momentum = whole @ gas_model(scene).velocities.cartesian
        table |= {"mass": whole.sum(axis=1), "momentum_x": momentum[:, 0], "momentum_y": momentum[:, 1]}
    if "force_impulse" in tallies:
        table["force_impulse"] = tallies["force_impulse"].sum(axis=1)
    if "h_function" in tallies:
        table["h_function"] = tallies["h_function"]
    return table


def _columns(scene: Scene, name: str, values: Floats) -> dict[str, Floats]:
    """A tally as columns: by face, by face and axis, or by kind of operation."""
    if values.ndim == 1:
        return {name: values}
    if name == "operation_counts":
        return dict(zip(OPERATIONS, values.T, strict=True))
    there = [*(face is not None for face in scene.faces), True]  # the last is the cylinder
    found = {}
    for face, name_of_face in enumerate(face_names(scene)):
        if there[face]:
            column = values[:, face]
            if values.ndim == 2:
                found[f"{name}[{name_of_face}]"] = column
            else:
                found |= {
                    f"{name}[{name_of_face}].{axis}": column[:, k] for k, axis in enumerate(AXES[: column.shape[1]])
                }
    return found


def _tails(scene: Scene) -> tuple[float, float]:
    """Energy and pressure of the pairs beyond the cutoff, zero unless the scene asks for them."""
    if scene.lennard_jones is None or not scene.lennard_jones.tail_corrections:
        return 0.0, 0.0
    from crosscheck.engines.refimpl.stepping import force_record
    from refimpl.stepping.forces.lennard_jones import tail_corrections

    try:
        tails = tail_corrections(force_record(scene, scene.initial_state()))
    except ValueError as error:
        raise UsageError(f"scene {scene.name}: lennard_jones.tail_corrections: {error}") from None
    return tails.energy, tails.pressure


_MEANINGS = {
    "temperature": "temperature = 2 kinetic_energy/(d (N - 1)), an energy: k_B T; for N = 1 it is 2 kinetic_energy/d",
    "pressure": "pressure = (2 kinetic_energy + virial)/(d V)",
}
_HARD_MEANINGS = {
    "temperature": "temperature = 2 K/(d N), K of the translation of the N that move; N - 1 if momentum is conserved",
    "pressure": "pressure = (2 kinetic_energy_integral + collisional_virial)/(d V time), the mean since the start",
    "collisions": "collisions, and all columns after it except rotational_energy, add up from the start",
}


def _write_observables(path: Path, scene: Scene, method: Method, result: _Result) -> Path:
    tails = scene.lennard_jones is not None and scene.lennard_jones.tail_corrections
    meanings = _MEANINGS if scene.hard_spheres is None else _HARD_MEANINGS
    what, units = (
        f"{scene.number} particles in {scene.dimension} dimensions",
        "totals, in the scene's own units (SI, or reduced): time, energy, pressure = energy/length^d",
    )
    if scene.lattice_gas is not None:
        gas = scene.lattice_gas
        what, units = (
            f"{gas.model}, {gas.columns} x {gas.rows} sites",
            "totals: time in steps, lengths in links, mass 1",
        )
    comments = [
        f"scene {scene.name}: {what}",
        f"{result.engine} {result.version}, {_named(method)}",
        units,
        *(text for name, text in meanings.items() if name in result.table),
        *(["potential_energy and pressure contain the tail corrections"] if tails else []),
        *(["the run diverged: not a number from there on"] if result.run.diverged else []),
        *([f"the run stopped: {result.run.stopped}"] if result.run.stopped else []),
    ]
    rows = np.column_stack(list(result.table.values()))
    header = "".join(f"# {comment}\n" for comment in comments) + ",".join(result.table)
    np.savetxt(path, rows, fmt="%.17g", delimiter=",", header=header, comments="")
    return path


def _named(method: Method) -> str:
    contact, dt = method.contact, None if method.dt is None else f"{method.dt!r}"
    softness = ""
    if contact is not None:
        softness = f", k = {contact.stiffness!r}" if contact.duration is None else f", t_c = {contact.duration!r}"
        dt = dt or f"{contact.resolution!r} t_c"
    return method.scheme + (f", dt = {dt}" if dt else "") + softness


# -- trajectory ----------------------------------------------------------------------------------------------


def _write_trajectory(path: Path, scene: Scene, run: Run) -> Path:
    """Extended XYZ with positions (not wrapped), velocities, masses and species; ASE reads it back.

    Of hard spheres also radius, and angular_velocities where they rotate. Species 0, 1, ... are named H, He, ...;
    without species the particles are called X. Eight decimals. A scene of fewer dimensions lies in the plane or on the
    axis (and turns about z); a diverged or stopped run is written up to its last good sample.
    """
    import ase
    import ase.io

    state = scene.initial_state()
    cell, periodic = np.zeros(3), np.zeros(3, dtype=bool)
    if state.lengths is not None:
        cell[: scene.dimension] = state.lengths
        periodic[: scene.dimension] = [boundary == "periodic" for boundary in scene.boundaries]
    kinds = np.zeros(scene.number, dtype=int) if state.species is None else state.species + 1
    frames = []
    for sample, (time, r, v) in enumerate(zip(run["time"], run["positions"], run["velocities"], strict=True)):
        if not (np.isfinite(r).all() and np.isfinite(v).all()):
            break
        atoms = ase.Atoms(kinds, positions=_in_space(r), cell=cell, pbc=periodic, info={"time": float(time)})
        atoms.set_masses(state.masses)
        atoms.set_velocities(_in_space(v))
        atoms.new_array("velocities", _in_space(v))
        if state.diameters is not None:
            atoms.new_array("radius", state.diameters / 2)
        if "angular_velocities" in run:
            spins = run["angular_velocities"][sample]
            atoms.new_array("angular_velocities", np.pad(spins, ((0, 0), (3 - spins.shape[1], 0))))
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
        figure.suptitle(f"{scene.name}: {_named(method)}, to t = {_end(scene, results):g}")
        grid = figure.add_gridspec(len(heights), len(results), height_ratios=heights)
        energy_axes: Axes | None = None
        for column, result in enumerate(results):
            axes = figure.add_subplot(grid[0, column])
            state = " (diverged)" if result.run.diverged else " (stopped)" if result.run.stopped else ""
            axes.set_title(result.engine + state, fontsize=10)
            _draw_configuration(axes, scene, result.run)
            if energies:
                energy_axes = figure.add_subplot(grid[1, column], sharey=energy_axes)
                for colour, (name, values) in zip(_COLOURS, _energies(result).items(), strict=False):
                    energy_axes.plot(
                        result.run["time"], values, color=colour, linewidth=1, label=name.replace("_", " ")
                    )
                energy_axes.set(xlabel="time", ylabel="energy")
                energy_axes.legend(**above)
        if compared:
            axes = figure.add_subplot(grid[-1, :])
            for colour, (name, values) in zip(_COLOURS, compared.items(), strict=False):
                axes.plot(
                    results[0].run["time"], np.where(values > 0, values, np.nan), color=colour, linewidth=1, label=name
                )
            axes.set(xlabel="time", ylabel=f"|{results[0].engine} - {results[1].engine}|", yscale="log")
            axes.legend(**above)
        paths = [out / "picture.png", out / "picture.svg"]
        figure.savefig(paths[0], dpi=130, metadata={"Software": None})
        figure.savefig(paths[1], metadata={"Date": None, "Creator": None})
    return paths


def _end(scene: Scene, results: list[_Result]) -> float:
    """Time of the last sample of a run that ends at a number of collisions; the duration of any other."""
    if scene.output.collisions is None:
        return scene.duration
    return max(float(np.nanmax(result.run["time"])) for result in results)


def _energies(result: _Result) -> dict[str, Floats]:
    return {name: result.table[name] for name in _ENERGIES if name in result.table}


def _differences(results: list[_Result]) -> dict[str, Floats]:
    """Absolute differences between two engines: of every observable, and of the farthest particle."""
    one, other = results
    found: dict[str, Any] = {}
    for name in ("total_energy", "kinetic_energy", "potential_energy", "pressure"):
        if name in one.table and name in other.table:
            found[name.replace("_", " ")] = abs(one.table[name] - other.table[name])
    if "positions" in one.run and "positions" in other.run:
        distances = np.linalg.norm(one.run["positions"] - other.run["positions"], axis=2)
        found["position of the farthest particle"] = distances.max(axis=1)
    return found


def _draw_configuration(axes: Axes, scene: Scene, run: Run) -> None:
    """Few particles as trajectories, on a line against time; many as points at the end, coloured by speed.

    Hard disks as circles of their size, among their walls, with the paths of those that move if they are few.
    """
    if scene.lattice_gas is not None:
        _draw_lattice_gas(axes, scene, run)
        return
    if scene.hard_spheres is not None and scene.dimension == 2:
        _draw_disks(axes, scene, run)
        return
    if scene.number <= FEW and "positions" in run:
        _draw_trajectories(axes, scene, run["time"], run["positions"])
        return
    r, lengths = run["final_positions"].copy(), scene.lengths()
    if lengths is not None:
        wraps = np.array(scene.boundaries) == "periodic"
        r[:, wraps] %= lengths[wraps]
        axes.set_xlim(0, lengths[0])
        if scene.dimension > 1:
            axes.set_ylim(0, lengths[1])
    flat = _in_space(r)
    speed = np.linalg.norm(run["final_velocities"], axis=1)
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


def _draw_lattice_gas(axes: Axes, scene: Scene, run: Run) -> None:
    """Speed of the blocks at the last sample, with arrows, and the walls."""
    gas = scene.lattice_gas
    assert gas is not None
    velocities = gas_model(scene).velocities
    height = gas.rows * velocities.row_height
    axes.set(xlim=(0, gas.columns), ylim=(0, height), xlabel="x", ylabel="y", aspect="equal")
    axes.grid(False)
    if "populations" in run:
        counts = run["populations"][-1]
        mass = counts.sum(axis=-1)
        u = counts @ velocities.cartesian / np.where(mass > 0, mass, np.nan)[..., None]
        speed = np.linalg.norm(u, axis=-1)
        image = axes.imshow(speed.T, origin="lower", extent=(0, gas.columns, 0, height), aspect="equal")
        assert axes.figure is not None
        axes.figure.colorbar(image, ax=axes, label="speed", shrink=0.8)
        each = max(1, max(speed.shape) // 24)
        x = (np.arange(speed.shape[0]) + 0.5) * gas.columns / speed.shape[0]
        y = (np.arange(speed.shape[1]) + 0.5) * height / speed.shape[1]
        axes.quiver(
            *np.meshgrid(x[::each], y[::each]),
            u[::each, ::each, 0].T,
            u[::each, ::each, 1].T,
            color="white",
            width=0.003,
        )
    walls = scene.wall_rules()
    if walls is not None:
        rows, columns = np.nonzero(walls)
        axes.plot(columns, rows * velocities.row_height, ",", color="#d04f00")


def _draw_disks(axes: Axes, scene: Scene, run: Run) -> None:
    """Disks at the end, coloured by speed, fixed ones grey; points have a size of their own."""
    from matplotlib.collections import EllipseCollection

    diameters, fixed, lengths = scene.diameters(), scene.fixed(), scene.lengths()
    assert diameters is not None
    periodic = np.array(scene.boundaries) == "periodic"
    periods = scene.periods()
    r = run["final_positions"] - _image(run["final_positions"], periods) * periods
    if scene.number - fixed.sum() <= FEW and "positions" in run:
        _draw_paths(axes, run["positions"][:, ~fixed], periods)
    size = float(np.ptp(r, axis=0).max()) if lengths is None else float(lengths.max())
    seen = np.where(diameters > 0, diameters, 0.01 * (size or 1.0))
    # a disk that reaches over a periodic edge is seen again on the other side
    shifts = np.array([(i, k) for i in (-1, 0, 1) for k in (-1, 0, 1) if (periodic | (np.array([i, k]) == 0)).all()])
    centres = (r + (shifts * periods)[:, None]).reshape(-1, 2)
    which = np.tile(np.arange(scene.number), len(shifts))
    over = (np.abs(centres - periods / 2) > (periods + seen[which, None]) / 2)[:, periodic].any(axis=1)
    centres, which = centres[~over], which[~over]
    speed = np.linalg.norm(run["final_velocities"], axis=1)
    for still in (True, False):
        group = fixed[which] == still
        if not group.any():
            continue
        size_of = seen[which[group]]
        disks = EllipseCollection(
            size_of, size_of, np.zeros(size_of.size), units="xy", offsets=centres[group],
            offset_transform=axes.transData, linewidths=0.3, edgecolors="#333333",
        )  # fmt: skip
        if still:
            disks.set_facecolor("#bbbbbb")
        else:
            disks.set_array(speed[which[group]])
            disks.set_clim(0.0, float(np.nanmax(speed)) or 1.0)
            assert axes.figure is not None
            axes.figure.colorbar(disks, ax=axes, label="speed", shrink=0.8)
        axes.add_collection(disks)
    low, high = np.nanmin(r - seen[:, None] / 2, axis=0), np.nanmax(r + seen[:, None] / 2, axis=0)
    if lengths is not None:
        low = np.where(periodic, 0.0, np.minimum(low, 0.0))
        high = np.where(periodic, lengths, np.maximum(high, lengths))
    margin = np.where(periodic, 0.0, 0.02 * float((high - low).max()))
    (left, bottom), (right, top) = low - margin, high + margin
    axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="x", ylabel="y", aspect="equal")
    axes.grid(False)
    _draw_walls(axes, scene)


def _image(positions: Floats, periods: Floats) -> Floats:
    """Which copy of the periodic box the positions are in, per axis; 0 where it is not periodic."""
    return np.where(periods > 0, np.floor(positions / np.where(periods > 0, periods, 1.0)), 0.0)


def _draw_paths(axes: Axes, positions: Floats, periods: Floats) -> None:
    """Paths from sample to sample, brought back into the periodic box and broken where they leave it."""
    for particle in range(positions.shape[1]):
        path = positions[:, particle]
        image = _image(path, periods)
        breaks = np.flatnonzero((np.diff(image, axis=0) != 0).any(axis=1)) + 1
        path = np.insert(path - image * periods, breaks, np.nan, axis=0)
        axes.plot(path[:, 0], path[:, 1], color=_COLOURS[particle % len(_COLOURS)], linewidth=1)


def _draw_walls(axes: Axes, scene: Scene) -> None:
    """Hard faces and the cylinder, thick."""
    from matplotlib.patches import Circle

    lengths = scene.lengths()
    if lengths is None:
        return
    for index, face in enumerate(scene.faces):
        if face is not None:
            axis, upper = divmod(index, 2)
            draw = axes.axvline if axis == 0 else axes.axhline
            draw(float(lengths[axis]) * upper, color="#222222", linewidth=2)
    if scene.box is not None and scene.box.cylinder is not None:
        middle = (float(lengths[0]) / 2, float(lengths[1]) / 2)
        axes.add_patch(Circle(middle, scene.box.cylinder.radius, fill=False, linewidth=2, edgecolor="#222222"))


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
