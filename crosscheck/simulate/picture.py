"""The picture of a run: one column per engine, of particles, what was measured on cells, and energies.

Below are the differences of two engines.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.figure import Frame, RoundFrame, Snapshot
from crosscheck.painter import LARGEST, Extent, bounds, colours, outlines, paint
from crosscheck.scene import Floats, Method, Scene
from crosscheck.simulate.observables import Result, method_label
from crosscheck.simulate.panels import (
    COLOURS,
    add_colour_bar,
    draw_panel,
    height,
    height_of_plane,
    limits_of_maps,
    panels,
)
from crosscheck.text import printable
from crosscheck.trajectories.trajectory import in_space

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Up to so many particles are drawn as trajectories, more as a configuration.
FEW = 10
_ENERGIES = ("kinetic_energy", "potential_energy", "total_energy", "rotational_energy")
#: Side of the picture of the particles, about, in points.
_SIDE = 250.0
#: Free space about particles and box, and the diameter of particles without a size, as shares of the picture.
_MARGIN, _POINT = 0.02, 0.01
_GREY, _OUTLINE, _WALL = "#bbbbbb", "#333333", "#222222"
#: Width of the axes of a column, about, in inches.
_WIDTH = 3.6


def draw_picture(
    out: Path, scene: Scene, methods: Sequence[Method], results: Sequence[Result], differences: dict[str, Floats]
) -> list[Path]:
    """Writes picture.png and picture.svg to the directory `out`; returns their paths.

    methods, results: of the runs of `scene`. differences: name -> (samples,), see `run.differences`; empty unless there
    are two runs.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    energies = any(_energies(result) for result in results)
    drawn = [panels(scene, result.run) for result in results]
    particles = scene.lattice_gas is None
    lengths = scene.lengths()
    flat = 4.2 if lengths is None or lengths.size == 1 else height_of_plane((lengths[0], lengths[1]), _WIDTH)
    heights = [flat] * particles + [height(panel, _WIDTH) for panel in drawn[0]]
    heights += [2.6] * energies + [2.6] * bool(differences)
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
    with matplotlib.rc_context(style), np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a name in a script that the font has not
        figure = Figure(figsize=(max(5.5, 4.6 * len(results)), sum(heights) + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        same = len(set(methods)) == 1
        parts = [*([method_label(methods[0])] if same else []), _end(scene, results)]
        title = printable(f"{scene.name}: {', '.join(parts)}")
        # a name may be long, and may hold dollar signs
        figure.suptitle("\n".join(wrap(title, 70 * len(results))), parse_math=False)
        grid = figure.add_gridspec(len(heights), len(results), height_ratios=heights)
        energy_axes: Axes | None = None
        for column, result in enumerate(results):
            state = " (diverged)" if result.run.diverged else " (stopped)" if result.run.stopped else ""
            title = printable(result.engine + state)
            if not same:
                title = "\n".join(wrap(f"{title}: {printable(method_label(methods[column]))}", 40))
            if particles:
                axes = figure.add_subplot(grid[0, column])
                axes.set_title(title, fontsize=10, parse_math=False)
                draw_configuration(axes, scene, result.run)
            for number, panel in enumerate(drawn[column]):
                limits = limits_of_maps([one[number] for one in drawn])
                on_top = number == 0 and not particles
                draw_panel(figure.add_subplot(grid[particles + number, column]), panel, limits, title * on_top)
            if energies:
                energy_axes = figure.add_subplot(grid[particles + len(drawn[column]), column], sharey=energy_axes)
                for colour, (name, values) in zip(COLOURS, _energies(result).items(), strict=False):
                    energy_axes.plot(
                        result.run["time"], values, color=colour, linewidth=1, label=name.replace("_", " ")
                    )
                energy_axes.set(xlabel="time", ylabel="energy")
                energy_axes.legend(**above)
        if differences:
            axes = figure.add_subplot(grid[-1, :])
            for colour, (name, values) in zip(COLOURS, differences.items(), strict=False):
                axes.plot(
                    results[0].run["time"], np.where(values > 0, values, np.nan), color=colour, linewidth=1, label=name
                )
            axes.set(xlabel="time", yscale="log")
            axes.set_ylabel(printable(f"|{results[0].engine} - {results[1].engine}|"), parse_math=False)
            axes.legend(**above)
        paths = [out / "picture.png", out / "picture.svg"]
        figure.savefig(paths[0], dpi=130, metadata={"Software": None})
        figure.savefig(paths[1], metadata={"Date": None, "Creator": None})
    return paths


def _end(scene: Scene, results: Sequence[Result]) -> str:
    """Until when the runs went: their last sample if they end at a number of collisions, else the duration."""
    if any(result.run.stopped or result.run.diverged for result in results):
        return f"duration {scene.duration:g}"
    if scene.output.collisions is None:
        return f"to t = {scene.duration:g}"
    return f"to t = {max(float(np.nanmax(result.run['time'])) for result in results):g}"


def _energies(result: Result) -> dict[str, Floats]:
    return {name: result.table[name] for name in _ENERGIES if name in result.table}


def draw_configuration(axes: Axes, scene: Scene, run: Run) -> None:
    """Draws the particles of a run.

    axes: matplotlib's, to draw on. scene: what was run. run: what the engine returned. Few particles without a size are
    drawn as trajectories, in one dimension against time; all others as disks at the end of the run, with the paths of
    those that move if they are few hard disks.
    """
    positions = run.get("positions")
    if scene.number <= FEW and positions is not None and not _are_disks(scene):
        _draw_trajectories(axes, scene, run["time"], positions)
    else:
        moving = ~scene.fixed()
        if _are_disks(scene) and moving.sum() <= FEW and positions is not None:
            _draw_paths(axes, positions[:, moving], scene.periods())
        _draw_snapshot(axes, scene, run)


def _are_disks(scene: Scene) -> bool:
    """Whether the particles are hard disks, whose picture shows all of them in their true size."""
    return scene.hard_spheres is not None and scene.dimension == 2


# -- particles -----------------------------------------------------------------------------------------------


def _draw_snapshot(axes: Axes, scene: Scene, run: Run) -> None:
    """Particles at the end among their walls, coloured by speed; fixed ones, and those without a finite speed, grey."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import EllipseCollection, LineCollection
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.patches import Circle

    snapshot = asdict(snapshot_of(scene, run))
    view = _view(scene, snapshot)
    left, right, bottom, top = view
    periods = scene.periods()
    painting = paint(snapshot, view, _SIDE / view.size, (periods[0], periods[1:2].sum()))
    if painting.disks:
        sizes = [2 * disk.radius for disk in painting.disks]
        disks = EllipseCollection(
            sizes,
            sizes,
            np.zeros(len(sizes)),
            units="xy",
            offsets=[(disk.x, disk.y) for disk in painting.disks],
            offset_transform=axes.transData,
            facecolors=[colours()[disk.level] if disk.level >= 0 else _GREY for disk in painting.disks],
            # a line lies half within the disk
            linewidths=[0.5 * disk.outline for disk in painting.disks],
            edgecolors=_OUTLINE,
        )
        axes.add_collection(disks)
    if painting.lost:
        axes.plot(*zip(*painting.lost, strict=True), "x", color=_WALL, clip_on=False)
    if scene.box is not None:
        lines = outlines(snapshot["container"])
        for x0, y0, x1, y1 in lines.walls:
            axes.plot([x0, x1], [y0, y1], color=_WALL, linewidth=2, solid_capstyle="projecting")
        # no line where the box is periodic: there the picture ends
        sides = [((x0, y0), (x1, y1)) for x0, y0, x1, y1 in lines.sides if not periods[0 if x0 == x1 else 1]]
        if sides:
            axes.add_collection(LineCollection(sides, colors=_WALL, linewidths=0.8, linestyles="dashed"))
        if lines.circle is not None:
            x, y, radius = lines.circle
            axes.add_patch(Circle((x, y), radius, fill=False, linewidth=2, edgecolor=_WALL))
    if painting.limits is not None:
        scale = ScalarMappable(Normalize(*painting.limits), ListedColormap(colours()))
        add_colour_bar(axes, scale, snapshot["value_label"])
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.set_xlabel("\n".join(["x", *painting.lost_remarks]))
    axes.set_ylabel("y (far particles are smaller)" if scene.dimension == 3 else "y")
    axes.grid(False)


def snapshot_of(scene: Scene, run: Run) -> Snapshot:
    """The particles at the end of a run, seen along z, those in front last; coloured by speed.

    scene: what was run. run: what the engine returned. In the plane hard disks and Lennard-Jones particles have their
    own size; all others get a size that decreases with their number, in space also with their distance. Without a box
    the container is the smallest frame around them.
    """
    positions, velocities = run["final_positions"], run["final_velocities"]
    periods = scene.periods()
    r = in_space(positions - _image(positions, periods) * periods)
    value = np.where(scene.fixed(), np.nan, np.linalg.norm(velocities, axis=1))
    container = _container(scene, r)
    radius = _radii(scene, bounds(asdict(container)).size)
    if scene.dimension == 3:
        far, near = _range(r[:, 2])
        depth = np.where(abs(r[:, 2]) < LARGEST, (r[:, 2] - far) / (near - far), 0.0)
        radius = radius * np.sqrt(0.4 + 0.6 * depth)
    order = np.argsort(r[:, 2], kind="stable")
    fastest = max((speed for speed in value.tolist() if abs(speed) < LARGEST), default=0.0)
    return Snapshot(
        r[order, 0].tolist(),
        r[order, 1].tolist(),
        radius[order].tolist(),
        container,
        value[order].tolist(),
        "speed",
        # grains may come to rest: their colours start at speed 0; those of a fluid span the speeds that occur
        (0.0, fastest or 1.0) if _are_disks(scene) else None,
    )


def _container(scene: Scene, r: Floats) -> Frame | RoundFrame:
    """What particles at r (N, 3) are in: the box, a cylinder seen along its axis, or the smallest frame around them."""
    lengths = scene.lengths()
    if scene.box is None or lengths is None:
        left, right = _range(r[:, 0])
        bottom, top = _range(r[:, 1])
        return Frame(left, right, bottom, top, ())
    if scene.box.cylinder is not None and scene.across == (0, 1):
        return RoundFrame(float(lengths[0]) / 2, float(lengths[1]) / 2, scene.box.cylinder.radius)
    sides: tuple[Literal["left", "right", "bottom", "top"], ...] = ("left", "right", "bottom", "top")
    walls = tuple(
        side
        for number, side in enumerate(sides)
        if scene.boundaries[number // 2] == "wall" or (scene.faces and scene.faces[number] is not None)
    )
    return Frame(0.0, float(lengths[0]), 0.0, float(lengths[1]), walls)


def _range(x: Floats) -> tuple[float, float]:
    """Smallest and largest of the finite coordinates in x (N,), with some room where they are all equal."""
    finite = x[abs(x) < LARGEST]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    return (low, high) if high > low else (low - 0.5 * (abs(low) or 1.0), low + 0.5 * (abs(low) or 1.0))


def _radii(scene: Scene, size: float) -> Floats:
    """Radii (N,) to draw in a container of this size: half of diameter or sigma in the plane, else by the number."""
    diameters, number = scene.diameters(), scene.number
    if scene.dimension == 2 and diameters is not None:
        return np.where(diameters > 0, diameters, _POINT * size) / 2
    if scene.dimension == 2 and scene.lennard_jones is not None:
        sigma = np.atleast_1d(scene.lennard_jones.length)
        if scene.lennard_jones.length_form == "r_m":
            sigma = sigma / 2 ** (1 / 6)
        if sigma.size == 1 or scene.species is None:
            return np.full(number, sigma[0] / 2)
        return sigma[list(scene.species)] / 2
    return np.full(number, min(0.022, 0.31 * number**-0.5) * size)


def _view(scene: Scene, snapshot: dict[str, Any]) -> Extent:
    """What is seen: the container and the particles, with a margin, but to the edge of the box where it is periodic."""
    x, y, radius = (np.array(snapshot[name]) for name in ("x", "y", "radius"))
    left, right, bottom, top = bounds(snapshot["container"])
    found = []
    for centres, low, high, period in zip((x, y), (left, bottom), (right, top), (*scene.periods(), 0.0), strict=False):
        there = abs(centres) < LARGEST
        if not period and there.any():
            low = min(low, float((centres - radius)[there].min()))
            high = max(high, float((centres + radius)[there].max()))
        found += [low, high]
    seen = Extent(*found)
    margin = _MARGIN * seen.size
    across, up = (0.0 if period else margin for period in (*scene.periods(), 0.0)[:2])
    if scene.box is None:
        # room for the labels of the shorter axis
        across += max(0.0, 0.25 * seen.size - 0.5 * (seen.right - seen.left))
        up += max(0.0, 0.25 * seen.size - 0.5 * (seen.top - seen.bottom))
    left, right, bottom, top = seen
    return Extent(left - across, right + across, bottom - up, top + up)


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
        axes.plot(path[:, 0], path[:, 1], color=COLOURS[particle % len(COLOURS)], linewidth=1)


def _draw_trajectories(axes: Axes, scene: Scene, time: Floats, positions: Floats) -> None:
    for particle in range(scene.number):
        path = positions[:, particle]
        colour = COLOURS[particle % len(COLOURS)]
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
