"""All arrays of a run as one .npz file, and those on places (particles, cells, blocks, rows, sites) as CSV files.

Which arrays there are, and along which axes, is read off the table of observables: a new one is written without a line
here.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Run, face_names
from crosscheck.scene import AXES, Floats, Method, Scene
from crosscheck.scene.lattice_gas import gas_model
from crosscheck.scene.observables import OPERATIONS, TABLE
from crosscheck.simulate.observables import Result, labelled, meaning, method_label, outcome, places, write_csv
from crosscheck.simulate.profiles import Derived, cell_edges, on_blocks, on_cells

#: Names of the CSV files, by the axes along which their rows go; of other axes, these joined by "-".
_NAMES = {
    ("particle",): "particles",
    ("grid",): "fields",
    ("sample", "block"): "blocks",
    ("sample", "row"): "rows",
    ("row", "column"): "sites",
    ("event",): "events",
}
#: Quantities that follow from observables with these axes.
_DERIVED = {("grid",): on_cells, ("sample", "block"): on_blocks}
#: Longest CSV file, in rows; what is longer is in the .npz file alone.
MOST_ROWS = 1_000_000

#: Names -> values along one dimension of an array.
Coordinates = dict[str, Any]


def coordinates(scene: Scene, run: Run) -> dict[str, list[Coordinates]]:
    """Where and when the values of arrays are, by the axis of the table of observables; several of a grid.

    scene: what was run. run: what the engine returned.
    """
    found: dict[str, list[Coordinates]] = {"sample": [{"time": run["time"]}]}
    if scene.lattice_gas is None:
        found["particle"] = [_particles(scene)]
        found["event"] = [{"event": np.arange(len(run.get("event_times", ())))}]
    else:
        gas = scene.lattice_gas
        height = float(gas_model(scene).velocities.row_height)
        found["row"] = [{"row": np.arange(gas.rows), "y": np.arange(gas.rows) * height}]
        found["column"] = [{"column": np.arange(gas.columns)}]
    if scene.output.fields is not None or scene.lattice_gas is not None:
        cells = [
            {name: (edges[1:] + edges[:-1]) / 2, f"{name}_low": edges[:-1], f"{name}_high": edges[1:]}
            for name, edges in zip(AXES, cell_edges(scene), strict=False)
        ]
        found["grid"] = found["block"] = cells
    return found


def _particles(scene: Scene) -> Coordinates:
    found: Coordinates = {"particle": np.arange(scene.number)}
    found["mass"] = np.broadcast_to(np.asarray(scene.masses, dtype=np.float64), (scene.number,))
    if scene.species is not None:
        found["species"] = np.array(scene.species)
    diameters = scene.diameters()
    if diameters is not None:
        found["diameter"] = diameters
    return found


# -- the .npz file -------------------------------------------------------------------------------------------


def write_arrays(path: Path, scene: Scene, method: Method, result: Result) -> Path:
    """Writes all arrays of a run, and the coordinates along their axes, to the .npz file `path`; returns it.

    It is read by `numpy.load`. The entry "about" is a JSON text: what was run, and of each array its axes, unit and
    meaning. scene, method: what was run. result: of the run.
    """
    arrays = dict(result.run)
    about: dict[str, Any] = {
        "scene": json.loads(scene.to_json()),
        "engine": result.engine,
        "version": result.version,
        "method": method_label(method),
        "outcome": outcome(result.run),
        "cost": result.run.cost.known(),
        "arrays": {
            name: {"axes": TABLE[name].axes, "unit": TABLE[name].unit, "meaning": meaning(name)} for name in arrays
        },
    }
    found, used = coordinates(scene, result.run), {axis for name in arrays for axis in TABLE[name].axes}
    for axis, dimensions in found.items():
        for one in dimensions if axis in used else []:
            for name, values in one.items():
                arrays.setdefault(f"{axis}_{name}" if axis not in ("sample", name) else name, values)
    for axis, names in (("axis", AXES[: scene.dimension]), ("face", face_names(scene)), ("operation", OPERATIONS)):
        if axis in used:
            arrays[axis] = np.array(list(names))
    if "channel" in used:
        arrays["channel_velocities"] = gas_model(scene).velocities.cartesian
    np.savez_compressed(path, allow_pickle=False, about=np.array(json.dumps(about)), **arrays)
    return path


# -- CSV files -----------------------------------------------------------------------------------------------


def write_places(directory: Path, name: str, scene: Scene, method: Method, result: Result) -> tuple[list[Path], str]:
    """Writes the arrays on places as CSV files, one for each kind of place, a row for each place (and time).

    Observables in time alone and trajectories have files of their own. directory: of the files, <kind>-name.csv. scene,
    method: what was run. result: of the run. Returns the paths, and a sentence on what is too long for such a file, or
    "".
    """
    run, where = result.run, coordinates(scene, result.run)
    kinds: dict[tuple[str, ...], list[str]] = {}
    for observable in run:
        if TABLE[observable].asked != "trajectory":
            kinds.setdefault(places(observable), []).append(observable)
    paths, left_out = [], []
    for kind, names in kinds.items():
        if kind in ((), ("sample",)):
            continue
        dimensions = [one for axis in kind for one in where[axis]]
        shape = tuple(len(next(iter(one.values()))) for one in dimensions)
        file = f"{_NAMES.get(kind, '-'.join(kind))}-{name}.csv"
        if math.prod(shape) > MOST_ROWS:
            left_out.append(f"{file} would have {math.prod(shape)} rows")
            continue
        columns = _coordinate_columns(dimensions, shape)
        for observable in names:
            moved = _places_first(observable, run[observable], kind)
            columns |= {key: part.ravel() for key, part in labelled(scene, observable, moved, len(shape)).items()}
        derived = _DERIVED[kind](scene, run) if kind in _DERIVED else {}
        columns |= {key: one.values.ravel() for key, one in derived.items()}
        paths.append(write_csv(directory / file, _comments(scene, method, result, kind, names, derived), columns))
    remark = f"{result.engine}: {'; '.join(left_out)}: its numbers are in the .npz file alone" if left_out else ""
    return paths, remark


def _places_first(name: str, values: Floats, kind: tuple[str, ...]) -> Floats:
    """An observable with the axes of its places first: a grid has as many as cells have edges to count along."""
    extra = values.ndim - len(TABLE[name].axes)  # a grid or block is one axis of the table, and several of the array
    sources: list[int] = []
    position = 0
    for axis in TABLE[name].axes:
        width = 1 + extra if axis in ("grid", "block") else 1
        if axis in kind:
            sources += range(position, position + width)
        position += width
    return np.moveaxis(values, sources, range(len(sources)))


def _coordinate_columns(dimensions: list[Coordinates], shape: tuple[int, ...]) -> dict[str, Any]:
    """The coordinates of every place, as flat columns; the last dimension goes fastest."""
    columns: dict[str, Any] = {}
    for k, one in enumerate(dimensions):
        along = [1] * len(shape)
        along[k] = shape[k]
        for name, values in one.items():
            columns[name] = np.broadcast_to(np.reshape(values, along), shape).ravel()
    return columns


def _comments(
    scene: Scene,
    method: Method,
    result: Result,
    kind: tuple[str, ...],
    names: list[str],
    derived: dict[str, Derived],
) -> list[str]:
    """What the columns are, with units."""
    axes = {axis for name in names for axis in TABLE[name].axes}
    units = "time in steps, lengths in links, mass 1" if scene.lattice_gas is not None else "the scene's own units"
    texts = [
        f"scene {scene.name}: {units}",
        f"{result.engine} {result.version}, {method_label(method)}",
        *(["x_low, x_high ...: edges of the cell; x, y, z: its centre"] if {"grid", "block"} & set(kind) else []),
        *(["y: of the row; a site of an even row is at x = column"] if "row" in kind else []),
        *(meaning(name) for name in names),
    ]
    if "channel" in axes:
        velocities = gas_model(scene).velocities.cartesian.tolist()
        texts.append("velocities of the channels: " + ", ".join(f"[{i}] {c!r}" for i, c in enumerate(velocities)))
    if any(TABLE[name].axes[0] == "axis" for name in names):
        texts.append("of a flux, the first letter is the axis along which it flows")
    return texts + [f"{key} = {one.equation} (unit: {one.unit})" for key, one in derived.items()] + outcome(result.run)
