"""What `simulate` says on the terminal: how each run went, and how far the runs of several engines are apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.scene import Floats, Method, Scene
from crosscheck.simulate.conserved import changes_energy, takes_momentum
from crosscheck.simulate.observables import Result, method_label

#: Differences of two runs whose first time is reported.
LEVELS = (1e-8, 1e-4, 1.0)


@dataclass(frozen=True)
class Row:
    """How one run went.

    engine, method: names. work: number of steps or events. cpu: CPU time, s. speed: steps or events per second of it.
    each: CPU time of a step of one particle or site, or of an event. energy, momentum: their change. end: how the run
    ended: "whole", "stopped" or "diverged".
    """

    engine: str
    method: str
    work: str
    cpu: float
    speed: float
    each: str
    energy: str
    momentum: str
    end: str


@dataclass(frozen=True)
class Difference:
    """How far two runs of one scene are apart.

    engines: their names. what: the quantity. unit: what the numbers are relative to. largest: the largest difference.
    passed: the first time at which it exceeded each of `LEVELS`, None if it did not. compared: until this time.
    """

    engines: tuple[str, str]
    what: str
    unit: str
    largest: float
    passed: tuple[float | None, ...]
    compared: float


def row(scene: Scene, method: Method, result: Result, kind: str) -> Row:
    """How a run went. scene, method: what was run. result: of the run. kind: of the scheme, see `protocol.Kind`."""
    run, cost = result.run, result.run.cost
    by_events = kind == "event_driven"
    number, what = (cost.events, "events") if by_events else (cost.steps, "steps")
    seconds = cost.cpu or cost.wall
    gas = scene.lattice_gas
    units, thing = (scene.number, "particle") if gas is None else (gas.rows * gas.columns, "site")
    speed = number / seconds if seconds > 0 else float("nan")
    each = "-"
    if number and seconds > 0:
        each = f"{_time(seconds / number)}/event" if by_events else f"{_time(seconds / number / units)}/({thing} step)"
    return Row(
        result.engine,
        method_label(method),
        f"{number} {what}",
        cost.cpu,
        speed,
        each,
        _energy(scene, method, result),
        _momentum(scene, run),
        "diverged" if run.diverged else "stopped" if run.stopped else "whole",
    )


def _time(seconds: float) -> str:
    """A short time in words."""
    for unit, length in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def endings(scene: Scene, result: Result) -> list[str]:
    """Sentences on a run that did not go to its end, with time and particles, and its remarks.

    scene: what was run. result: of the run.
    """
    run, found = result.run, []
    if run.diverged:
        found.append(f"{result.engine}: diverged{_where(scene, run)}")
    if run.stopped:
        found.append(f"{result.engine}: stopped: {run.stopped}; the scene's duration is {scene.duration:g}")
    return found + [f"{result.engine}: {remark}" for remark in run.remarks]


def _where(scene: Scene, run: Run) -> str:
    """When a run diverged, as far as its samples say, and which particles are lost."""
    time, positions = run["time"], run.get("positions")
    good = np.ones(time.size, dtype=bool)
    for name in ("positions", "velocities", "kinetic_energy", "potential_energy"):
        if name in run:
            good &= np.isfinite(run[name]).reshape(time.size, -1).all(axis=1)
    first = None if good.all() else int(np.argmin(good))
    if first is None:
        text = f" before its end at t = {scene.duration:g}: the state is not finite, or particles were lost"
    elif first:
        text = f" after t = {time[first - 1]:g}: not finite at t = {time[first]:g}"
    else:
        text = " at the start"
    state = run["final_positions"] if first is None or positions is None else positions[first]
    lost = np.flatnonzero(~np.isfinite(state).all(axis=1)).tolist()
    names = ", ".join(map(str, lost[:5])) + (" ..." if len(lost) > 5 else "")
    return text + (f" ({len(lost)} of {scene.number} particles: {names})" if lost else "")


def _energy(scene: Scene, method: Method, result: Result) -> str:
    """The change of the energy: its largest relative drift if it is conserved, else where it went, and why."""
    if scene.lattice_gas is not None:
        mass = result.table.get("mass")
        return "-" if mass is None else f"mass {_drift(mass):.1e}"
    table = result.table
    total = table.get("total_energy")
    if total is None and not _has_potential(scene):
        total = table.get("kinetic_energy")
    if total is None:
        return "not recorded"
    reasons = changes_energy(scene, method)
    if not reasons:
        return f"drift {_drift(total):.1e}"
    finite = total[np.isfinite(total)]
    if not finite.size:
        return "not finite"
    return f"{finite[0]:.4g} -> {finite[-1]:.4g} ({reasons[0]}{' ...' if len(reasons) > 1 else ''})"


def _has_potential(scene: Scene) -> bool:
    spheres = scene.hard_spheres
    return spheres is None or spheres.well is not None or scene.acceleration is not None


def _drift(values: Floats) -> float:
    """Largest change since the start, relative to the start; absolute if that is 0. Samples that are not finite are
    left out."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return float("nan")
    largest = float(abs(finite - finite[0]).max())
    return largest / abs(float(finite[0])) if finite[0] else largest


def _momentum(scene: Scene, run: Run) -> str:
    """The change of the total momentum from start to end, relative to the sum of m |v| at the start."""
    if scene.lattice_gas is not None or "final_velocities" not in run:
        return "-"
    state = scene.own_start()
    free = ~scene.fixed()
    start = run["velocities"][0] if "velocities" in run else state.velocities
    masses, before, after = state.masses[free], start[free], run["final_velocities"][free]
    scale = float((masses * np.linalg.norm(before, axis=1)).sum())
    scale = scale or float((masses * np.linalg.norm(after, axis=1)).sum()) or 1.0
    change = float(np.linalg.norm(masses @ (after - before))) / scale
    reasons = takes_momentum(scene)
    return f"{change:.1e}" + (f" ({reasons[0]})" if reasons else "")


# -- several engines -----------------------------------------------------------------------------------------


def compare(scene: Scene, results: Sequence[Result]) -> list[Difference]:
    """Differences of positions and energies of each pair of runs of `scene`, at the samples that both have.

    results: of the runs. Positions: of the particle that is farthest from itself in the other run, in diameters, in
    sigma, or relative to the largest distance of particles at the start. Energies: relative to the largest absolute
    energy of the first.
    """
    found = []
    for one, other in combinations(results, 2):
        names, time = (one.engine, other.engine), one.run["time"]
        apart = distances(one.run, other.run)
        if apart is not None:
            length, unit = length_unit(scene)
            found.append(_difference(names, "position", unit, time, apart / length))
        elif "final_positions" in one.run and "final_positions" in other.run:
            length, unit = length_unit(scene)
            final = np.linalg.norm(one.run["final_positions"] - other.run["final_positions"], axis=1).max(keepdims=True)
            found.append(_difference(names, "position at the end", unit, np.array([scene.duration]), final / length))
        energy = next((e for e in ("total_energy", "kinetic_energy") if e in one.table and e in other.table), None)
        if energy is not None:
            finite = abs(one.table[energy][np.isfinite(one.table[energy])])
            scale = float(finite.max(initial=0.0)) or 1.0
            what = energy.replace("_", " ")
            differing = abs(one.table[energy] - other.table[energy]) / scale
            found.append(_difference(names, what, f"largest |{what}|", time, differing))
    return found


def distances(one: Run, other: Run) -> Floats | None:
    """Largest distance of a particle from itself in another run, (samples,), length; None without trajectories.

    one, other: the runs.
    """
    here, there = one.get("positions"), other.get("positions")
    if here is None or there is None or here.shape != there.shape:
        return None
    return np.asarray(np.linalg.norm(here - there, axis=2).max(axis=1))


def _difference(names: tuple[str, str], what: str, unit: str, time: Floats, values: Floats) -> Difference:
    finite = np.isfinite(values)
    first = [np.flatnonzero(finite & (values > level)) for level in LEVELS]
    passed = tuple(float(time[found[0]]) if found.size else None for found in first)
    largest = float(values[finite].max()) if finite.any() else float("nan")
    return Difference(names, what, unit, largest, passed, float(time[finite].max()) if finite.any() else float("nan"))


def length_unit(scene: Scene) -> tuple[float, str]:
    """The length to which differences of positions of a `scene` are relative, and its name."""
    diameters = scene.diameters()
    if diameters is not None and diameters.max() > 0:
        return float(diameters.max()), "largest diameter"
    if scene.lennard_jones is not None:
        length: Any = scene.lennard_jones.length
        return float(np.max(length)), f"largest {scene.lennard_jones.length_form}"
    positions = scene.own_start().positions
    extent = float(np.linalg.norm(np.ptp(positions, axis=0))) if len(positions) > 1 else 0.0
    if extent > 0:
        return extent, "extent at the start"
    distance = float(np.linalg.norm(positions, axis=1).max(initial=0.0))
    return (distance, "distance from the origin at the start") if distance > 0 else (1.0, "unit of length")
