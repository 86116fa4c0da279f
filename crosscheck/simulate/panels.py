"""Pictures of what was measured on cells: profiles, maps with the flow as arrows, and waves in space and time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.scene import AXES, Floats, Scene
from crosscheck.scene.lattice_gas import gas_model
from crosscheck.simulate.profiles import cell_edges, on_blocks, on_cells

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Sites are drawn as means over squares, at most so many along an axis.
_MOST_SQUARES = 256
#: Arrows along the longer side of a map, about.
_ARROWS = 24
_WALL = "#d04f00"
COLOURS = ("#0067a8", "#d04f00", "#00846a", "#a8327f", "#8f6c00", "#3a2a8c")


@dataclass(frozen=True)
class Profile:
    """Quantities along one axis.

    label: of them all. along: name of the axis. ends: of the axis. x: places, (n,). lines: name -> (n,).
    """

    label: str
    along: str
    ends: tuple[float, float]
    x: Floats
    lines: dict[str, Floats]


@dataclass(frozen=True)
class Map:
    """A quantity on a plane: of space, or of space and time.

    label: of the quantity. axes: names of the axes across and up. edges: of the cells, (m + 1,) and (n + 1,). values:
    (m, n). arrows: components of the flow, (m, n) each; None: none. signed: whether 0 is the middle of the colours.
    spatial: whether both axes are lengths. walls: places of wall sites across and up, (2, walls); None: none.
    """

    label: str
    axes: tuple[str, str]
    edges: tuple[Floats, Floats]
    values: Floats
    arrows: tuple[Floats, Floats] | None = None
    signed: bool = False
    spatial: bool = True
    walls: Floats | None = None


Panel = Profile | Map


def panels(scene: Scene, run: Run) -> list[Panel]:
    """What a run measured on cells, blocks, rows and sites, as pictures; none if it measured nothing there.

    scene: what was run. run: what the engine returned.
    """
    if scene.lattice_gas is None:
        return _of_cells(scene, run)
    return [*_of_blocks(scene, run), *_of_rows(scene, run), *_of_sites(scene, run)] or [_empty_lattice(scene)]


def _of_cells(scene: Scene, run: Run) -> list[Panel]:
    """Means over the run on the cells of hard spheres: profiles, or maps; of three axes, the mean over one of them."""
    if "field_mass" not in run:
        return []
    while sum(n > 1 for n in scene.output.fields or ()) > 2:
        scene, run = _summed(scene, run)
    counts = scene.output.fields
    assert counts is not None
    long = [axis for axis, n in enumerate(counts) if n > 1] or [0]
    found = {name: np.squeeze(one.values, tuple(k for k in range(len(counts)) if k not in long))
             for name, one in on_cells(scene, run).items()}  # fmt: skip
    thermal = "temperature" if "temperature" in found else "thermal_energy"
    edges = [cell_edges(scene)[axis] for axis in long]
    velocity = {name: found[f"velocity.{name}"] for name in AXES[: scene.dimension]}
    if len(long) == 1:
        x, along = (edges[0][1:] + edges[0][:-1]) / 2, AXES[long[0]]
        # what a wall gives is not counted as a flux between cells
        inside = slice(0 if scene.boundaries[long[0]] == "periodic" else 1, None)
        flux = found[f"energy_flux.{along}"]
        ends = (float(edges[0][0]), float(edges[0][-1]))
        return [
            Profile(thermal.replace("_", " "), along, ends, x, {"": found[thermal]}),
            Profile("density", along, ends, x, {"": found["density"]}),
            Profile("velocity", along, ends, x, {f"v_{name}": values for name, values in velocity.items()}),
            Profile("energy flux", along, ends, edges[0][:-1][inside], {"": flux[inside]}),
        ]
    one, other = (AXES[axis] for axis in long)
    flow = (velocity[one], velocity[other])
    return [
        Map(f"{thermal.replace('_', ' ')}, mean of the run", (one, other), (edges[0], edges[1]), found[thermal]),
        Map("density, mean of the run", (one, other), (edges[0], edges[1]), found["density"], flow),
    ]


def _summed(scene: Scene, run: Run) -> tuple[Scene, Run]:
    """The scene and the run with the fields summed along the axis that has the fewest cells."""
    counts = scene.output.fields
    assert counts is not None
    axis = int(np.argmin(counts))
    fewer = tuple(1 if k == axis else n for k, n in enumerate(counts))
    output = scene.output.model_copy(update={"fields": fewer})
    names = ("field_mass", "field_momentum", "field_kinetic", "field_flux_energy")
    first = {name: axis + (name == "field_flux_energy") for name in names}
    summed = {name: run[name].sum(axis=first[name], keepdims=True) for name in names}
    return scene.changed(output=output), Run({**run, **summed}, stopped=run.stopped)


# -- lattice gases -------------------------------------------------------------------------------------------


def _of_blocks(scene: Scene, run: Run) -> list[Panel]:
    """The flow in the blocks: at the end, or in space and time if there are blocks along one axis alone."""
    flow = {name: one.values for name, one in on_blocks(scene, run).items()}
    if not flow or flow["density"][0].size == 1:
        return []
    x, y = cell_edges(scene)
    mean = "particles per site"
    if 1 not in flow["density"].shape[1:]:
        u, v = flow["velocity.x"][-1], flow["velocity.y"][-1]
        curl = np.gradient(v, x[1] - x[0], axis=0) - np.gradient(u, y[1] - y[0], axis=1)
        walls, axes, edges = _walls(scene), ("x", "y"), (x, y)
        return [
            Map("speed at the end", axes, edges, np.hypot(u, v), (u, v), walls=walls),
            Map("vorticity at the end", axes, edges, curl, signed=True, walls=walls),
            Map(mean, axes, edges, flow["density"][-1], walls=walls),
        ]
    axis = 0 if flow["density"].shape[1] > 1 else 1
    time = run["time"]
    between = (time[1:] + time[:-1]) / 2
    time_edges = np.concatenate([time[:1], between, time[-1:]])
    found: list[Panel] = []
    for name, values in flow.items():
        plane = values.squeeze(2 - axis)  # (samples, blocks)
        label = mean if name == "density" else name.replace("velocity.", "v_")
        found.append(
            Map(label, ("time", AXES[axis]), (time_edges, (x, y)[axis]), plane, signed=name != "density", spatial=False)
        )
    return found


def _of_rows(scene: Scene, run: Run) -> list[Panel]:
    impulse = run.get("force_impulse")
    if impulse is None or not scene.duration:
        return []
    y = np.arange(impulse.shape[1]) * float(gas_model(scene).velocities.row_height)
    return [Profile("force on a row", "y", (0.0, float(y[-1])), y, {"": impulse[-1] / scene.duration})]


def _of_sites(scene: Scene, run: Run) -> list[Panel]:
    """Particles per site at the end, as means over squares."""
    sites = run.get("sites")
    if sites is None:
        return []
    counts = sum((np.asarray(sites).astype(np.int64) >> i) & 1 for i in range(gas_model(scene).channels))
    rows, columns = np.shape(counts)
    side = max(1, -(-max(rows, columns) // _MOST_SQUARES))
    starts = np.arange(0, rows, side), np.arange(0, columns, side)
    total = np.add.reduceat(np.add.reduceat(counts, starts[0], axis=0), starts[1], axis=1)
    ends = [np.append(start, n) for start, n in zip(starts, (rows, columns), strict=True)]
    mean = total / np.outer(*(np.diff(end) for end in ends))
    height = float(gas_model(scene).velocities.row_height)
    edges = (ends[1].astype(float), ends[0] * height)
    return [Map("particles per site at the end", ("x", "y"), edges, mean.T, walls=_walls(scene))]


def _walls(scene: Scene) -> Floats | None:
    rules = scene.wall_rules()
    if rules is None:
        return None
    rows, columns = np.nonzero(rules)
    return np.array([columns, rows * float(gas_model(scene).velocities.row_height)])


def _empty_lattice(scene: Scene) -> Panel:
    x, y = cell_edges(scene.changed(output=scene.output.model_copy(update={"fields": None})))
    return Map("nothing was recorded in space", ("x", "y"), (x, y), np.full((1, 1), np.nan), walls=_walls(scene))


# -- drawing -------------------------------------------------------------------------------------------------


def height(panel: Panel, width: float) -> float:
    """Height of a panel, in inches. width: of its axes, in inches."""
    if isinstance(panel, Profile):
        return 1.5
    if not panel.spatial:
        return 2.4
    across, up = panel.edges
    return height_of_plane((across[-1] - across[0], up[-1] - up[0]), width)


def height_of_plane(sides: tuple[float, float], width: float) -> float:
    """Height of a picture of the plane, in inches. sides: of what is seen, length. width: of the picture, in inches."""
    return min(max(width * float(sides[1]) / float(sides[0]), 1.0), 4.0) + 0.8


def limits_of_maps(same: Sequence[Panel]) -> tuple[float, float] | None:
    """Ends of one colour scale for the same map of several runs; None for profiles, or if no value is finite."""
    values = np.concatenate([np.ravel(one.values) for one in same if isinstance(one, Map)] or [np.zeros(0)])
    values = values[np.isfinite(values)]
    if not values.size:
        return None
    low, high = float(values.min()), float(values.max())
    if any(isinstance(one, Map) and one.signed for one in same):
        low, high = -max(-low, high), max(-low, high)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def draw_panel(axes: Axes, panel: Panel, limits: tuple[float, float] | None, title: str) -> None:
    """Draws a panel on `axes`, matplotlib's. limits: ends of the colour scale of a map. title: above it, or ""."""
    if isinstance(panel, Profile):
        axes.set_title(title, fontsize=10, parse_math=False)
        marker = "o" if panel.x.size <= _ARROWS else ""
        for colour, (name, values) in zip(COLOURS, panel.lines.items(), strict=False):
            axes.plot(panel.x, values, marker=marker, color=colour, linewidth=1, markersize=3, label=name or None)
        axes.set(xlabel=panel.along, ylabel=panel.label, xlim=panel.ends)
        if any(panel.lines):
            axes.legend(fontsize=8, frameon=False, ncols=3)
        return
    axes.grid(False)
    axes.set(xlabel=panel.axes[0], ylabel=panel.axes[1], aspect="equal" if panel.spatial else "auto")
    axes.set(xlim=tuple(panel.edges[0][[0, -1]]), ylim=tuple(panel.edges[1][[0, -1]]))
    words = [panel.label]
    if limits is not None:
        colour_map = "RdBu_r" if panel.signed else "viridis"
        low, high = limits
        mesh = axes.pcolormesh(*panel.edges, panel.values.T, vmin=low, vmax=high, cmap=colour_map, rasterized=True)
        add_colour_bar(axes, mesh, "")
    if panel.arrows is not None and np.isfinite(panel.arrows[0]).any():
        words.append(f"arrows: flow, up to {_draw_arrows(axes, panel.edges, panel.arrows):.2g}")
    if panel.walls is not None:
        axes.plot(*panel.walls, ",", color=_WALL)
    axes.set_title(f"{title}: {'; '.join(words)}" if title else "; ".join(words), fontsize=10, parse_math=False)


def add_colour_bar(axes: Axes, mappable: Any, label: str) -> None:
    """A colour bar at the right of `axes`, as high as they are. mappable: matplotlib's. label: beside it."""
    assert axes.figure is not None
    axes.figure.colorbar(mappable, cax=axes.inset_axes((1.03, 0.0, 0.035, 1.0)), label=label)


def _draw_arrows(axes: Axes, edges: tuple[Floats, Floats], arrows: tuple[Floats, Floats]) -> float:
    """Arrows of the flow in so many cells as can be told apart; returns the speed of the longest."""
    each = max(1, max(arrows[0].shape) // _ARROWS)
    centres = [(one[1:] + one[:-1]) / 2 for one in edges]
    x, y = np.meshgrid(centres[0][each // 2 :: each], centres[1][each // 2 :: each])
    u, v = (one[each // 2 :: each, each // 2 :: each].T for one in arrows)
    axes.quiver(x, y, u, v, color="white", width=0.003, pivot="middle")
    return float(np.nanmax(np.hypot(u, v)))
