"""The picture of a run: a column an engine, with particles or field above the energies; below, how far two differ."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.scene import Floats, Method, Scene
from crosscheck.scene.lattice_gas import gas_model
from crosscheck.simulate.observables import Result, method_label, recorded
from crosscheck.simulate.trajectory import in_space

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Up to so many particles are drawn as trajectories, more as a configuration.
FEW = 10
_ENERGIES = ("kinetic_energy", "potential_energy", "total_energy", "rotational_energy")
_COLOURS = ("#0067a8", "#d04f00", "#00846a", "#a8327f", "#8f6c00", "#3a2a8c")


def draw_picture(
    out: Path, scene: Scene, method: Method, results: list[Result], differences: dict[str, Floats]
) -> list[Path]:
    """Writes picture.png and picture.svg to the directory `out`; returns their paths.

    results: runs of `scene` with `method`, one an engine. differences: name -> (samples,), see `run.differences`;
    empty unless there are two.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    energies = any(_energies(result) for result in results)
    heights = [4.2] + [2.6] * energies + [2.6] * bool(differences)
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
        figure.suptitle(f"{scene.name}: {method_label(method)}, to t = {_end(scene, results):g}")
        grid = figure.add_gridspec(len(heights), len(results), height_ratios=heights)
        energy_axes: Axes | None = None
        for column, result in enumerate(results):
            axes = figure.add_subplot(grid[0, column])
            state = " (diverged)" if result.run.diverged else " (stopped)" if result.run.stopped else ""
            axes.set_title(result.engine + state, fontsize=10)
            draw_configuration(axes, scene, result.run)
            if energies:
                energy_axes = figure.add_subplot(grid[1, column], sharey=energy_axes)
                for colour, (name, values) in zip(_COLOURS, _energies(result).items(), strict=False):
                    energy_axes.plot(result.run.time, values, color=colour, linewidth=1, label=name.replace("_", " "))
                energy_axes.set(xlabel="time", ylabel="energy")
                energy_axes.legend(**above)
        if differences:
            axes = figure.add_subplot(grid[-1, :])
            for colour, (name, values) in zip(_COLOURS, differences.items(), strict=False):
                axes.plot(
                    results[0].run.time, np.where(values > 0, values, np.nan), color=colour, linewidth=1, label=name
                )
            axes.set(xlabel="time", ylabel=f"|{results[0].engine} - {results[1].engine}|", yscale="log")
            axes.legend(**above)
        paths = [out / "picture.png", out / "picture.svg"]
        figure.savefig(paths[0], dpi=130, metadata={"Software": None})
        figure.savefig(paths[1], metadata={"Date": None, "Creator": None})
    return paths


def _end(scene: Scene, results: list[Result]) -> float:
    """Time of the last sample of a run that ends at a number of collisions; the duration of any other."""
    if scene.output.collisions is None:
        return scene.duration
    return max(float(np.nanmax(result.run.time)) for result in results)


def _energies(result: Result) -> dict[str, Floats]:
    return {name: result.table[name] for name in _ENERGIES if name in result.table}


def draw_configuration(axes: Axes, scene: Scene, run: Run) -> None:
    """Few particles as trajectories, on a line against time; many as points at the end, coloured by speed.

    Hard disks as circles of their size, among their walls, with the paths of those that move if they are few.
    """
    if scene.lattice_gas is not None:
        _draw_lattice_gas(axes, scene, run)
        return
    if scene.hard_spheres is not None and scene.dimension == 2:
        _draw_disks(axes, scene, run)
        return
    positions = recorded(run, "positions")
    if scene.number <= FEW and positions is not None:
        _draw_trajectories(axes, scene, run.time, positions)
        return
    r, lengths = run.final_positions.copy(), scene.lengths()
    if lengths is not None:
        wraps = np.array(scene.boundaries) == "periodic"
        r[:, wraps] %= lengths[wraps]
        axes.set_xlim(0, lengths[0])
        if scene.dimension > 1:
            axes.set_ylim(0, lengths[1])
    flat = in_space(r)
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


def _draw_lattice_gas(axes: Axes, scene: Scene, run: Run) -> None:
    """Speed of the blocks at the last sample, with arrows, and the walls."""
    gas = scene.lattice_gas
    assert gas is not None
    velocities = gas_model(scene).velocities
    height = gas.rows * velocities.row_height
    axes.set(xlim=(0, gas.columns), ylim=(0, height), xlabel="x", ylabel="y", aspect="equal")
    axes.grid(False)
    populations = recorded(run, "populations")
    if populations is not None:
        counts = populations[-1]
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
    r = run.final_positions - _image(run.final_positions, periods) * periods
    positions = recorded(run, "positions")
    if scene.number - fixed.sum() <= FEW and positions is not None:
        _draw_paths(axes, positions[:, ~fixed], periods)
    size = float(np.ptp(r, axis=0).max()) if lengths is None else float(lengths.max())
    seen = np.where(diameters > 0, diameters, 0.01 * (size or 1.0))
    # a disk that reaches over a periodic edge is seen again on the other side
    shifts = np.array([(i, k) for i in (-1, 0, 1) for k in (-1, 0, 1) if (periodic | (np.array([i, k]) == 0)).all()])
    centres = (r + (shifts * periods)[:, None]).reshape(-1, 2)
    which = np.tile(np.arange(scene.number), len(shifts))
    over = (np.abs(centres - periods / 2) > (periods + seen[which, None]) / 2)[:, periodic].any(axis=1)
    centres, which = centres[~over], which[~over]
    speed = np.linalg.norm(run.final_velocities, axis=1)
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
