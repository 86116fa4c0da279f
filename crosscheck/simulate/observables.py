"""Observables of a run: the columns that follow from what the engine recorded, and the CSV file that holds them.

What an array is, is read off its axes in the table of observables, so that a new observable needs no line here. Some
axes say where or when a value is (`PLACES`); along the others it has components, which become columns with labels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Run, face_names
from crosscheck.errors import UsageError
from crosscheck.scene import AXES, Floats, Method, Scene
from crosscheck.scene.lattice_gas import gas_model
from crosscheck.scene.observables import OPERATIONS, TABLE
from crosscheck.text import printable

#: Observables that are no columns themselves: columns of energies, temperature and pressure follow from them.
_USED = ("kinetic_energy", "potential_energy", "virial")
#: Axes of the table of observables that say where or when a value is.
PLACES = ("sample", "particle", "grid", "block", "row", "column", "event")


@dataclass(frozen=True)
class Result:
    """A run of one engine.

    engine: its name, as results are labelled with it. version: its version. run: what it returned. table: column ->
    (samples,), see `observables`.
    """

    engine: str
    version: str
    run: Run
    table: dict[str, Floats]


def observables(scene: Scene, run: Run) -> dict[str, Floats]:
    """Columns (samples,) by name: time, energies, temperature and pressure, then the other observables.

    Each is there if the run recorded what it follows from; the units are the scene's own. scene: what was run. run:
    what the engine returned.

    temperature: 2K/(d(N - 1)), in units of energy, for N particles with zero total momentum; 2K/d for one. pressure:
    (2K + W)/(dV) in a box that is periodic along every axis. Tail corrections are in, if the scene has them.

    Of hard spheres, K is of the translation: without "rotational_energy", grains that rotate have no temperature here;
    N counts those that move, and stands for N - 1 where walls, fixed particles or a field take up momentum. pressure:
    the mean since the start, with the collisional virial for W and exact time averages. An observable with several
    components becomes as many columns, as "wall_impulse[x-].y".

    Of lattice gases: total mass, total momentum, and the momentum given by the force.

    UsageError if the scene asks for tail corrections that do not apply to it.
    """
    table = {"time": run["time"]}
    kinetic, potential = run.get("kinetic_energy"), run.get("potential_energy")
    tail_energy, tail_pressure = _tails(scene)
    if kinetic is not None:
        table["kinetic_energy"] = kinetic
    if potential is not None:
        table["potential_energy"] = potential + tail_energy
    if kinetic is not None and potential is not None:
        table["total_energy"] = table["kinetic_energy"] + table["potential_energy"]
    if scene.lattice_gas is not None:
        return table | _of_lattice_gas(scene, run)
    table |= (
        _of_hard_spheres(scene, run) if scene.hard_spheres is not None else _of_smooth_forces(scene, run, tail_pressure)
    )
    return table | _recorded(scene, run)


def _recorded(scene: Scene, run: Run) -> dict[str, Floats]:
    """The observables with one value, or a few labelled ones, per sample."""
    table: dict[str, Floats] = {}
    for name in scene.output.observables:
        if name not in _USED and places(name) == ("sample",):
            table |= labelled(scene, name, run[name], 1)
    return table


def places(name: str) -> tuple[str, ...]:
    """Those axes of the observable of this name that say where or when its values are, in their order."""
    return tuple(axis for axis in TABLE[name].axes if axis in PLACES)


def _of_smooth_forces(scene: Scene, run: Run, tail_pressure: float) -> dict[str, Floats]:
    table: dict[str, Floats] = {}
    kinetic = run.get("kinetic_energy")
    d, virial = scene.dimension, run.get("virial")
    if kinetic is not None:
        table["temperature"] = 2 * kinetic / (d * max(scene.number - 1, 1))
    if kinetic is not None and virial is not None and set(scene.boundaries) == {"periodic"}:
        table["pressure"] = (2 * kinetic + virial) / (d * scene.volume()) + tail_pressure
    return table


def _of_hard_spheres(scene: Scene, run: Run) -> dict[str, Floats]:
    table: dict[str, Floats] = {}
    d, rotates = scene.dimension, scene.spin_dimension > 0
    fixed = int(scene.fixed().sum())
    free = set(scene.boundaries) == {"periodic"} and not fixed
    kinetic, rotational = run.get("kinetic_energy"), run.get("rotational_energy")
    if kinetic is not None and (rotational is not None or not rotates):
        translation = kinetic if rotational is None else kinetic - rotational
        degrees = scene.number - 1 if free and scene.acceleration is None else scene.number - fixed
        table["temperature"] = 2 * translation / (d * max(degrees, 1))
    virial, integral = run.get("collisional_virial"), run.get("kinetic_energy_integral")
    if free and not rotates and virial is not None and integral is not None:
        span = np.where(run["time"] > 0, run["time"], np.nan)
        table["pressure"] = (2 * integral + virial) / (d * scene.volume() * span)
    return table


def _of_lattice_gas(scene: Scene, run: Run) -> dict[str, Floats]:
    table: dict[str, Floats] = {}
    populations = run.get("populations")
    if populations is not None:
        whole = populations.sum(axis=(1, 2))
        momentum = whole @ gas_model(scene).velocities.cartesian
        table |= {"mass": whole.sum(axis=1), "momentum_x": momentum[:, 0], "momentum_y": momentum[:, 1]}
    impulse = run.get("force_impulse")
    if impulse is not None:
        table["force_impulse"] = impulse.sum(axis=1)
    return table | _recorded(scene, run)


def labelled(scene: Scene, name: str, values: Floats, first: int) -> dict[str, Floats]:
    """An observable as columns, named by the axes along which it has components.

    scene: what was run. name: of the observable. values: its array, the axes of its places first. first: their number;
    a column has the shape of values along them.
    """
    found = {name: values}
    for axis in (axis for axis in TABLE[name].axes if axis not in PLACES):
        found = {
            _column(axis, column, label): np.take(rows, k, axis=first)
            for column, rows in found.items()
            for k, label in enumerate(labels(scene, axis, rows.shape[first]))
            if label
        }
    return found


def _column(axis: str, column: str, label: str) -> str:
    """Name of a column of an array along an axis: "wall_impulse[x-]", and "wall_impulse[x-].y" along the next."""
    if axis == "operation":
        return label
    return f"{column}.{label}" if axis in ("axis", "spin") else f"{column}[{label}]"


def labels(scene: Scene, axis: str, number: int) -> list[str]:
    """Names of the elements along an axis of components; "" for a face that is not there.

    scene: what was run. axis: its name in the table of observables. number: of the elements.
    """
    if axis == "axis" or (axis == "spin" and number == len(AXES)):
        return list(AXES[:number])
    if axis == "spin":
        return ["z"]
    if axis == "operation":
        return list(OPERATIONS)
    if axis == "face":
        exists = [*(face is not None for face in scene.faces), True]  # the last is the cylinder
        return [face if exists[k] else "" for k, face in enumerate(face_names(scene))]
    return [str(k) for k in range(number)]


def _tails(scene: Scene) -> tuple[float, float]:
    """Energy and pressure of the pairs beyond the cutoff; 0 unless the scene asks for tail corrections."""
    if scene.lennard_jones is None or not scene.lennard_jones.tail_corrections:
        return 0.0, 0.0
    from crosscheck.references.lennard_jones import tail_corrections

    try:
        return tail_corrections(scene)
    except ValueError as error:
        raise UsageError(f"scene {scene.name}: lennard_jones.tail_corrections: {error}") from None


# -- the CSV file --------------------------------------------------------------------------------------------

_MEANINGS = {
    "temperature": "temperature = 2 kinetic_energy/(d (N - 1)), an energy: k_B T; for N = 1 it is 2 kinetic_energy/d",
    "pressure": "pressure = (2 kinetic_energy + virial)/(d V)",
}
_HARD_MEANINGS = {
    "temperature": "temperature = 2 K/(d N), K of the translation of the N that move; N - 1 if momentum is conserved",
    "pressure": "pressure = (2 kinetic_energy_integral + collisional_virial)/(d V time), the mean since the start",
}


def write_observables(path: Path, scene: Scene, method: Method, result: Result) -> Path:
    """Writes the table of a result to `path`, after comments (#) on what its columns are; returns `path`.

    scene, method: what was run. result: of the run.
    """
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
        f"{result.engine} {result.version}, {method_label(method)}",
        units,
        *(text for name, text in meanings.items() if name in result.table),
        *(meaning(name) for name in scene.output.observables if name not in _USED and places(name) == ("sample",)),
        *(["potential_energy and pressure contain the tail corrections"] if tails else []),
        *outcome(result.run),
    ]
    return write_csv(path, comments, result.table)


def outcome(run: Run) -> list[str]:
    """Sentences on how a run ended, and on what its user must know; none of a run without either."""
    return [
        *(["the run diverged: not a number from there on"] if run.diverged else []),
        *([f"the run stopped: {run.stopped}"] if run.stopped else []),
        *run.remarks,
    ]


def write_csv(path: Path, comments: Sequence[str], columns: Mapping[str, Any]) -> Path:
    """Writes columns to a CSV file, so that every number reads back to the same bits; returns `path`.

    comments: lines before the header line, each after "# ". columns: name -> (rows,).
    """
    with path.open("w", encoding="utf-8", errors="backslashreplace", newline="") as file:
        file.writelines(f"# {printable(comment)}\n" for comment in comments)
        file.write(",".join(columns) + "\n")
        values = (np.asarray(column).tolist() for column in columns.values())
        # repr gives the shortest text that reads back to the same number
        file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*values, strict=True))
    return path


def meaning(name: str) -> str:
    """A comment on the observable of this name, from the table of observables."""
    row = TABLE[name]
    return f"{name}: {row.meaning}{', since the start' if row.cumulative else ''} (unit: {row.unit})"


def method_label(method: Method) -> str:
    """`method` as text: scheme, time step or tolerance, stiffness or duration of contacts: "verlet, dt = 0.01"."""
    contact, dt = method.contact, None if method.dt is None else f"{method.dt!r}"
    softness = ""
    if contact is not None:
        names = {"stiffness": "k", "duration": "t_c", "k_n": "k_n", "E": "E"}
        name = next(name for name in names if getattr(contact, name) is not None)
        softness = f", {names[name]} = {getattr(contact, name)!r}"
        dt = dt or f"{contact.resolution!r} t_c"
    tolerance = "" if method.tolerance is None else f", tolerance = {method.tolerance!r}"
    return method.scheme + (f", dt = {dt}" if dt else "") + tolerance + softness
