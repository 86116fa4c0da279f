"""The history of a run as its trace tells it: the states of all particles between their events.

By derivation from the motion between events: flights of constant acceleration, spins that stay as they are.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from crosscheck.references.event_audit.matter import Matter
from crosscheck.references.event_audit.rules import Motion
from crosscheck.scene import Floats, Scene


@dataclass
class Event:
    """One event of the trace.

    number: its place. time. i, j: partners, j = -1 - face for a wall. n: unit vector from i to j, or to the wall, (3,).
    distance: of the centres, 0 for a wall. kind: "core", "edge" of a well, or "wall". before: position (3,) and motion
    of each partner, after: their motions. inside: whether the pair is in its well then.
    """

    number: int
    time: float
    i: int
    j: int
    n: Floats
    distance: float
    kind: str
    before: list[tuple[Floats, Motion]]
    after: list[Motion]
    inside: bool = False

    @property
    def partners(self) -> list[int]:
        """The particles that take part."""
        return [self.i] if self.j < 0 else [self.i, self.j]


class States:
    """States of all particles: times (N,), positions and velocities (N, d), spins (N, 3)."""

    def __init__(self, positions: Floats, velocities: Floats, spins: Floats) -> None:
        self.positions, self.velocities, self.spins = positions, velocities, spins


class History:
    """What the trace of a run says of each particle.

    scene, run, collapsed: as in `audit`. Attributes: matter; run; end: of the run, time; times: of the events; events:
    those that were audited; drawn: what random walls have drawn.
    """

    def __init__(self, scene: Scene, matter: Matter, run: Mapping[str, Floats], collapsed: bool = False) -> None:
        state = scene.initial_state()
        self.matter, self.run = matter, run
        # a run that counts collisions ends at the last of them, if its duration is not over before
        self.end = scene.duration
        if scene.output.collisions is not None and np.isfinite(run["time"][-1]):
            self.end = float(run["time"][-1])
        self.times = run["event_times"].tolist()
        if collapsed and self.times:
            self.end = self.times[-1]
        self.events: list[Event] = []
        self.drawn: list[float] = []
        self.start = States(
            _three(state.positions),
            _three(state.velocities),
            np.zeros((matter.number, 3)) if state.angular_velocities is None else spins3(state.angular_velocities),
        )
        #: Of each particle: times of its states, and the states: position, velocity, spin.
        self._times: list[list[float]] = [[0.0] for _ in range(matter.number)]
        self._states = [
            [(self.start.positions[i], self.start.velocities[i], self.start.spins[i])] for i in range(matter.number)
        ]
        self._collided = np.full(matter.number, -np.inf)
        self._bonds = self.bonds_at_start()
        self._positions = _three(run["event_positions"])
        self._velocities = _three(run["event_velocities"])
        spins = run.get("event_angular_velocities")
        self._spins = np.zeros_like(self._velocities) if spins is None else spins3(spins)

    def bonds_at_start(self) -> set[tuple[int, int]]:
        """The pairs (i < j) inside their wells at the start."""
        matter = self.matter
        if matter.spheres.well is None:
            return set()
        found = set()
        for i in range(matter.number):
            for j in range(i + 1, matter.number):
                gap = self.start.positions[j] - self.start.positions[i]
                gap = matter.nearest(gap[: matter.dimension])
                if gap @ gap < (matter.well_range * (matter.radii[i] + matter.radii[j])) ** 2:
                    found.add((i, j))
        return found

    def seen(self, number: int, place: int) -> tuple[Floats, Motion]:
        """Position, and motion after the event, of a partner as the trace has it. number, place: event and partner."""
        motion = Motion(self._velocities[number, place], self._spins[number, place])
        return self._positions[number, place], motion

    def flown(self, i: int, time: float) -> tuple[Floats, Motion]:
        """Position and motion of particle i at `time`, from its last state."""
        x, v, w = self._states[i][-1]
        span, g = time - self._times[i][-1], self._pull(i)
        return x + span * (v + 0.5 * span * g), Motion(v + span * g, w)

    def _pull(self, i: int) -> Floats:
        return np.zeros(3) if self.matter.fixed[i] else self.matter.acceleration

    def collided_lately(self, i: int, time: float) -> bool:
        """Whether particle i has collided less than the contact duration of the TC model before `time`."""
        duration = self.matter.spheres.contact_duration
        return duration is not None and time - self._collided[i] < duration

    def inside(self, i: int, j: int) -> bool:
        """Whether the pair of particles i and j is in its well."""
        return (min(i, j), max(i, j)) in self._bonds

    def append(self, event: Event) -> None:
        """Takes up an event that was audited."""
        self.events.append(event)
        for i, (x, _), after in zip(event.partners, event.before, event.after, strict=True):
            self._times[i].append(event.time)
            self._states[i].append((x, after.velocity, after.spin))
            if event.kind != "edge" and not self.matter.fixed[i]:
                self._collided[i] = event.time
        if event.kind == "edge":
            pair = (min(event.i, event.j), max(event.i, event.j))
            (self._bonds.add if event.inside else self._bonds.discard)(pair)

    def close(self) -> None:
        """After the last event: states by particle as arrays."""
        self._arrays = [tuple(np.array([state[k] for state in states]) for k in range(3)) for states in self._states]

    def times_of(self, i: int) -> list[float]:
        """Times of the states of particle i, that of the start first."""
        return self._times[i]

    def states_of(self, i: int) -> tuple[Floats, Floats, Floats]:
        """Positions, velocities and spins, (states, 3), of particle i at `times_of`, right after each event."""
        x, v, w = self._arrays[i]
        return x, v, w

    def at(self, times: Floats) -> tuple[Floats, Floats, Floats]:
        """Positions, velocities and spins of all at `times`, right after events of that time, (times, N, 3)."""
        n = self.matter.number
        x, v, w = (np.empty((times.size, n, 3)) for _ in range(3))
        for i in range(n):
            known, states = np.array(self._times[i]), self._arrays[i]
            last = np.searchsorted(known, times, side="right") - 1
            span, g = (times - known[last])[:, None], self._pull(i)
            x[:, i] = states[0][last] + span * (states[1][last] + 0.5 * span * g)
            v[:, i] = states[1][last] + span * g
            w[:, i] = states[2][last]
        return x, v, w

    def sampled(self, times: Floats) -> tuple[Floats, Floats, Floats]:
        """As `at`, but at the time 0 before its events: sample 0 of a run is the start."""
        x, v, w = self.at(times)
        for i, states in enumerate(self._arrays):
            for found, of_start in zip((x, v, w), states, strict=True):
                found[times == 0.0, i] = of_start[0]
        return x, v, w

    def number_until(self, time: float) -> int:
        """How many events are not later than `time`."""
        return bisect_right(self.times, time)

    def bonds(self) -> list[set[tuple[int, int]]]:
        """The pairs in their wells before the first event, and after each, (events + 1,)."""
        found = [self.bonds_at_start()]
        for event in self.events:
            now = found[-1]
            if event.kind == "edge":
                pair = (min(event.i, event.j), max(event.i, event.j))
                now = now | {pair} if event.inside else now - {pair}
            found.append(now)
        return found


def _three(vectors: Floats) -> Floats:
    """(..., d) vectors with three components."""
    missing = 3 - vectors.shape[-1]
    return np.asarray(np.concatenate([vectors, np.zeros((*vectors.shape[:-1], missing))], axis=-1))


def spins3(spins: Floats) -> Floats:
    """The angular velocities `spins`, (..., 1) about the third axis of the plane or (..., 3), as (..., 3)."""
    if spins.shape[-1] == 3:
        return np.asarray(spins)
    return np.asarray(np.concatenate([np.zeros((*spins.shape[:-1], 2)), spins], axis=-1))
