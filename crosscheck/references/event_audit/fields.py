"""Hydrodynamic fields on cells, computed again from the trace of a run.

By derivation from the definition of the fields: sums over particles, integrated along their flights.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from crosscheck.references.event_audit.deviations import Audit
from crosscheck.references.event_audit.history import Event, History
from crosscheck.references.event_audit.tallies import OF_SUMS, energies, gained, impulse_on
from crosscheck.scene import Floats, Scene


class _Cells:
    """All fields of a run, as `scene.observables` describes them, summed flight by flight and event by event."""

    def __init__(self, scene: Scene, history: History) -> None:
        assert scene.output.fields is not None
        self.history, self.matter, d = history, history.matter, scene.dimension
        self.shape, self.d = scene.output.fields, d
        self.sides = self.matter.lengths / np.array(self.shape)
        self.wraps = self.matter.periods > 0
        self.sums: dict[str, Floats] = {}
        vector, fluxes = (*self.shape, d), (d, *self.shape)
        for name, shape in (
            ("mass", self.shape), ("momentum", vector), ("kinetic", self.shape), ("rotational", self.shape),
            ("flux_mass", fluxes), ("flux_momentum", (*fluxes, d)), ("flux_energy", fluxes),
            ("dissipation", self.shape), ("collisions", self.shape), ("wall_momentum", vector),
            ("wall_energy", self.shape), ("initial_mass", self.shape), ("initial_momentum", vector),
            ("initial_energy", self.shape), ("final_mass", self.shape), ("final_momentum", vector),
            ("final_energy", self.shape),
        ):  # fmt: skip
            self.sums[name] = np.zeros(shape)

    def place(self, x: Floats) -> tuple[int, ...]:
        """The cell of a position, unwrapped; beyond an axis that is not periodic, the last one."""
        cell = np.floor(x[: self.d] / self.sides).astype(int)
        shape = np.array(self.shape)
        return tuple(np.where(self.wraps, cell % shape, np.clip(cell, 0, shape - 1)).tolist())

    def add(self, name: str, place: Any, value: Any) -> None:
        """Adds to a sum in a cell."""
        self.sums[name][place] += value

    def flight(self, i: int, x: Floats, v: Floats, w: Floats, span: float) -> list[tuple[int, int, float]]:
        """One flight of a particle: residence in cells. Returns the faces it passed: axis, sign, time."""
        mass, g, d = self.matter.masses[i], self.matter.acceleration, self.d
        passages: list[tuple[float, int, int]] = []
        for axis in range(d):
            for plane in self._planes(axis, x[axis], v[axis], g[axis], span):
                passages += [(tau, axis, sign) for tau, sign in _crossings(x[axis] - plane, v[axis], g[axis], span)]
        passages.sort()
        rotation = float(energies(self.history, i, 0 * v, w))
        cuts = [0.0, *(tau for tau, _, _ in passages), span]
        for a, b in pairwise(cuts):
            middle = (a + b) / 2
            place = self.place(x + middle * (v + 0.5 * middle * g))
            self.add("mass", place, mass * (b - a))
            moved = v * (b - a) + g * (b * b - a * a) / 2
            self.add("momentum", place, mass * moved[:d])
            square = (v @ v) * (b - a) + (v @ g) * (b * b - a * a) + (g @ g) * (b**3 - a**3) / 3
            self.add("kinetic", place, 0.5 * mass * square)
            self.add("rotational", place, rotation * (b - a))
        return [(axis, sign, tau) for tau, axis, sign in passages]

    def _planes(self, axis: int, x: float, v: float, a: float, span: float) -> list[float]:
        """Faces of cells that a flight may pass along an axis; on an axis that is not periodic, inner ones alone."""
        ends = [x, x + span * (v + 0.5 * a * span)]
        if a != 0 and 0 < -v / a < span:
            ends.append(x - v * v / (2 * a))
        side = float(self.sides[axis])
        low, high = int(np.floor(min(ends) / side)), int(np.ceil(max(ends) / side))
        if not self.wraps[axis]:
            low, high = max(low, 1), min(high, self.shape[axis] - 1)
        return [k * side for k in range(low, high + 1)]

    def passage(self, i: int, x: Floats, v: Floats, w: Floats, axis: int, sign: int, half_bonds: float) -> None:
        """What a particle carries through a face. x, v: there. half_bonds: its half of the energy of its wells."""
        beyond = x.copy()
        beyond[axis] += 1e-6 * self.sides[axis]  # the face is the lower one of the cell above it
        face = (axis, *self.place(beyond))
        mass = self.matter.masses[i]
        self.add("flux_mass", face, sign * mass)
        self.add("flux_momentum", face, sign * mass * v[: self.d])
        self.add("flux_energy", face, sign * (float(energies(self.history, i, v, w)) + half_bonds))

    def pair(self, event: Event) -> None:
        """A collision or passage of a well: momentum and energy go from i to j along the line of centres.

        J. H. Irving and J. G. Kirkwood, J. Chem. Phys. 18, 817 (1950).
        """
        history = self.history
        one, other = gained(history, event)
        x = event.before[0][0]
        here, there = self.place(x), self.place(event.before[1][0])
        held = 0.0
        if event.kind == "core":
            for place in (here, there):
                self.add("dissipation", place, -0.5 * (one + other))
                self.add("collisions", place, 0.5)
        else:
            was = _was_inside(event)
            held = -0.5 * self.matter.depth * (float(event.inside) - float(was))
        # half of what both lost, and of what the second gained: what went over
        energy = 0.5 * ((other + held) - (one + held))
        impulse = impulse_on(history, event)[: self.d]
        line = event.distance * event.n
        for axis in range(self.d):
            a, b = x[axis] / self.sides[axis], (x[axis] + line[axis]) / self.sides[axis]
            if np.floor(a) == np.floor(b):
                continue
            sign = 1 if b > a else -1
            plane = max(np.floor(a), np.floor(b))
            if not self.wraps[axis] and not 1 <= plane <= self.shape[axis] - 1:
                continue
            share = (plane - a) / (b - a)
            at = x + share * line
            at[axis] = (plane + 0.5) * self.sides[axis]
            face = (axis, *self.place(at))
            self.add("flux_momentum", face, sign * impulse)
            self.add("flux_energy", face, sign * energy)


def _was_inside(event: Event) -> bool:
    """Whether the pair of `event`, at the edge of a well, was inside: it moved outwards."""
    (_, one), (_, other) = event.before
    return bool((other.velocity - one.velocity) @ event.n > 0)


def _crossings(gap: float, v: float, a: float, span: float) -> list[tuple[float, int]]:
    """Times within a flight at which gap + v t + a t^2/2 changes its sign, and the direction, +1 upwards."""
    if a == 0.0:
        if v == 0.0:
            return []
        roots = [-gap / v]
    else:
        square = v * v - 2 * a * gap
        if square <= 0:
            return []
        q = -(v + np.copysign(np.sqrt(square), v))
        roots = [q / a, 2 * gap / q]
    return [(float(tau), 1 if v + a * tau > 0 else -1) for tau in sorted(roots) if 0 < tau < span]


def audit_fields(scene: Scene, history: History, run: Mapping[str, Floats], found: Audit) -> None:
    """Notes how far the fields of a run are from those of its trace.

    scene, run: as in `audit`. history: of the run, after its last event. found: where deviations are noted.
    """
    cells = _Cells(scene, history)
    matter, times = history.matter, np.array(history.times)
    bonds = history.bonds()

    def half_bonds(i: int, time: float) -> float:
        return -0.5 * matter.depth * sum(i in pair for pair in bonds[int(np.searchsorted(times, time, side="right"))])

    for i in np.flatnonzero(~matter.fixed).tolist():
        known = [*history.times_of(i), history.end]
        for k, (x, v, w) in enumerate(zip(*history.states_of(i), strict=True)):
            for axis, sign, tau in cells.flight(i, x, v, w, known[k + 1] - known[k]):
                g = matter.acceleration
                held = half_bonds(i, known[k] + tau) if matter.depth else 0.0
                cells.passage(i, x + tau * (v + 0.5 * tau * g), v + tau * g, w, axis, sign, held)
    for event in history.events:
        if event.kind != "wall":
            cells.pair(event)
            continue
        place = cells.place(event.before[0][0])
        change = event.after[0].velocity - event.before[0][1].velocity
        cells.add("wall_momentum", place, matter.masses[event.i] * change[: cells.d])
        cells.add("wall_energy", place, gained(history, event)[0])
    for when, time in (("initial", 0.0), ("final", history.end)):
        _contents(cells, history, when, time, half_bonds)
    for name, values in cells.sums.items():
        seen = run[f"field_{name}"]
        size = float(np.abs(values).max())
        found.note(f"field_{name}", float(np.abs(seen - values).max()), OF_SUMS * max(size, _least(cells, name)), "")


def _least(cells: _Cells, name: str) -> float:
    """A size of a field below which a difference of two terms is rounding: what all particles have of it."""
    matter, history = cells.matter, cells.history
    _, v, w = history.at(np.array([0.0]))
    energy = sum(float(energies(history, i, v[0, i], w[0, i])) for i in range(matter.number)) + abs(matter.depth)
    mass = float(matter.weights.sum())
    momentum = float(np.sqrt(mass * energy))
    kind = "energy" if any(word in name for word in ("energy", "kinetic", "rotational", "dissipation")) else name
    return {"energy": energy}.get(kind, momentum if "momentum" in name else mass) * max(history.end, 1.0)


def _contents(cells: _Cells, history: History, when: str, time: float, half_bonds: Any) -> None:
    matter = history.matter
    x, v, w = (one[0] for one in history.at(np.array([time])))
    for i in range(matter.number):
        place = cells.place(x[i])
        if matter.depth:  # a fixed particle holds its half of a well too
            cells.add(f"{when}_energy", place, half_bonds(i, time))
        if matter.fixed[i]:
            continue
        cells.add(f"{when}_mass", place, matter.masses[i])
        cells.add(f"{when}_momentum", place, matter.masses[i] * v[i, : cells.d])
        cells.add(f"{when}_energy", place, float(energies(history, i, v[i], w[i])))
