"""The naive event-driven algorithm: predict all events, take the earliest, advance all particles, apply its rule.

O(N^2) an event and as short as can be: the executable specification that the fast algorithm must match event by event.
The closed forms of the prediction and the rules at the contact are the same.

Arguments that are the same throughout: model: `HardSpheres`. rows: (N, 7), a particle's position 0-2, wrapped into the
box, velocity 3-5, and the time of its last collision 6. turns: (N, 3) how often each position was wrapped. spins:
(N, 3) angular velocities, or None. bonds: see `refimpl.events.state`, or None. now: the time. Units: any
consistent set.

Literature: B. J. Alder and T. E. Wainwright, J. Chem. Phys. 31, 459 (1959).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from refimpl.events.kernels.compiled import inline, kernel
from refimpl.events.kernels.loop import COLLAPSE
from refimpl.events.model import Floats, HardSpheres, Vector, Well
from refimpl.events.prediction import (
    NEVER,
    contact_distance,
    cylinder_time,
    drift,
    nearest,
    pair_time,
    radius_of,
    resting_flight,
    rests,
    speed_after,
    squared_moment,
    wall_time,
)
from refimpl.events.rules import (
    apply_impulse,
    at_cylinder,
    at_edge,
    at_plane,
    is_fixed,
    normal_restitution,
    pair_impulse,
    pass_edge,
    still_in_contact,
)
from refimpl.events.state import (
    SIMULTANEOUS,
    Simultaneous,
    State,
    bonds_of,
    check_state,
    collapse,
    nearness,
    shortest_time,
    spins_of,
    time_to_cross,
    two_sum,
)
from refimpl.snapshot import Arrays, restore, snapshot

#: Column of `rows`: the time of the particle's last collision.
_LAST = 6
#: Number of the cylinder among the faces.
CYLINDER_FACE = 8


class Naive:
    """Hard particles of `model` from the given state.

    positions, velocities: (N, d). angular_velocities: (N, 1) in two dimensions, (N, 3) in three; zero by default; only
    with friction. last: (N,) times of earlier collisions, for the TC model; -inf: none. hits: (N,) numbers of earlier
    collisions with walls, for random ones. Raises ValueError for a state that is not finite or outside the walls.

    Attributes: model, dimension, number; time; collisions, of pairs; trace: (time, i, j) of every change of state, with
    j = -1 - face for a plane wall and -1 - CYLINDER_FACE for the cylinder; simultaneous: see `state.Simultaneous`;
    stopped: "", or which inelastic collapse ended the run for good.
    """

    def __init__(
        self,
        model: HardSpheres,
        positions: ArrayLike,
        velocities: ArrayLike,
        angular_velocities: ArrayLike | None = None,
        *,
        last: ArrayLike = -math.inf,
        hits: ArrayLike = 0,
    ) -> None:
        x, v = np.array(positions, dtype=np.float64), np.array(velocities, dtype=np.float64)
        self.model, self.dimension = model, x.shape[1]
        self.number = check_state(model, x, v)
        self._clock, self.collisions = (0.0, 0.0), 0
        self.simultaneous = Simultaneous(0, math.nan)
        self.trace: list[tuple[float, int, int]] = []
        self._rows = np.zeros((self.number, 7))
        self._rows[:, : self.dimension] = x
        self._rows[:, 3 : 3 + self.dimension] = v
        self._rows[:, _LAST] = last
        self._turns = np.zeros((self.number, 3), np.int64)
        self._hits = np.zeros(self.number, np.int64)
        self._hits[:] = hits
        self._latest = np.full(self.number, -math.inf), np.full(self.number, -1, np.int64)
        self._streaks = np.zeros(self.number, np.int64)
        self.stopped = ""
        self._spins = None if model.rough is None else spins_of(angular_velocities, self.number, self.dimension)
        self._bonds = None if model.well is None else bonds_of(model, model.well, x)

    @property
    def time(self) -> float:
        """The time of the last event, or the one that the run was told to reach."""
        return self._clock[0]

    def run(self, until: float = math.inf, collisions: int | None = None, changes: int | None = None) -> None:
        """Runs until the time `until`, or the given number of pair collisions or changes of state since the start.

        until: time; collisions, changes: numbers, None for no such limit. The first limit that is reached ends the run;
        so does an inelastic collapse, see `stopped`.
        """
        while (collisions is None or self.collisions < collisions) and (changes is None or len(self.trace) < changes):
            if self.stopped:
                return
            span, i, j = next_event(self.model, self._rows, self._bonds, self.time, nearness(self.model))
            limit = longest_flight(self.model, self._rows)
            left = math.fsum((until, -self._clock[0], -self._clock[1]))
            if min(span, limit) > left:
                advance_all(self.model, self._rows, self._turns, left)
                self._clock = (until, 0.0)
                return
            advance_all(self.model, self._rows, self._turns, min(span, limit))
            self._clock = two_sum(*self._clock, min(span, limit))
            if span <= limit:
                self.trace.append((self.time, i, j))
                crossing = time_to_cross(self.model, self._rows[:, 3:6])
                self._note_streak(i, j, crossing)
                self._note_simultaneous(i, j, crossing)
                self.collisions += apply_event(
                    self.model, self._rows, self._spins, self._bonds, i, j, self._hits, self.time
                )

    def _note_streak(self, i: int, j: int, crossing: float) -> None:
        """Counts the events of a particle in a row at one instant; too many of all partners are a collapse."""
        instant = shortest_time(self.model, self._rows[:, 3:6], crossing)
        if -1 - CYLINDER_FACE < j < 0:
            instant = max(instant, resting_flight(self.model.walls, self.model, -1 - j))
        mobile = [one for one in (i, j) if one >= 0 and not is_fixed(self.model.inverse_masses, one)]
        at_once = all(self.time - self._latest[0][one] < instant for one in mobile)
        self._streaks[mobile] = self._streaks[mobile] + 1 if at_once else 0
        if self._streaks[mobile].min() > COLLAPSE:
            self.stopped = collapse(i, j, self.time)

    def _note_simultaneous(self, i: int, j: int, crossing: float) -> None:
        """Counts the event if one of its particles has had another one, with another partner, at the same time."""
        times, partners = self._latest
        tick = SIMULTANEOUS * crossing
        seen = [(i, j)] if j < 0 else [(i, j), (j, i)]
        for one, other in seen:
            same = (partners[one] < 0 and other < 0) or partners[one] == other
            if self.time - times[one] < tick and not same:
                number, first = self.simultaneous
                self.simultaneous = Simultaneous(number + 1, first if number else self.time)
                break
        for one, other in seen:
            if not is_fixed(self.model.inverse_masses, one):
                times[one], partners[one] = self.time, other

    def snapshot(self) -> Arrays:
        """The complete state as arrays by name, without the trace: `resume` goes on from it with the same bits."""
        return snapshot(self._state())

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Goes on from where another run of the same model was; the trace begins anew.

        arrays: of its `snapshot`. Raises ValueError that names an array which does not fit.
        """
        state = restore(self._state(), arrays)
        self._clock, self.collisions = state["clock"], state["collisions"]
        self.simultaneous = state["simultaneous"]

    def _state(self) -> dict[str, Any]:
        return {
            "clock": self._clock, "collisions": self.collisions, "rows": self._rows, "turns": self._turns,
            "hits": self._hits, "spins": self._spins, "bonds": self._bonds, "latest": self._latest,
            "streaks": self._streaks, "simultaneous": self.simultaneous,
        }  # fmt: skip

    def state(self) -> State:
        """The state of all particles now."""
        d = self.dimension
        x = self._rows[:, :d] + self._turns[:, :d] * np.array(self.model.lengths)
        spins = self._spins
        return State(
            self.time, x, self._rows[:, 3 : 3 + d].copy(), None if spins is None else spins[:, 2 if d == 2 else 0 :]
        )


def longest_flight(model: HardSpheres, rows: Floats) -> float:
    """The time before which no image of a pair but the nearest one can come into contact."""
    reach = model.diameter * (1.0 if model.well is None else model.well.range)
    room = [length / 2 - reach for length, wraps in zip(model.lengths, model.periodic, strict=True) if wraps]
    # velocities relative to one particle: a common fall does not bring two together
    fastest = float(np.sqrt(((rows[:, 3:6] - rows[0, 3:6]) ** 2).sum(axis=1).max()))
    return min(room) / (2 * fastest) if room and fastest > 0 else math.inf


@kernel
def next_event(model: HardSpheres, rows: Floats, bonds: Any, now: float, near: float) -> tuple[float, int, int]:
    """Time to the earliest event of all pairs and walls, and whose it is: i and j, or i and -1 - face.

    near: see `refimpl.events.prediction`.
    """
    best, one, other = NEVER, -1, -1
    d = len(model.lengths)
    for i in range(rows.shape[0]):
        for j in range(i + 1, rows.shape[0]):
            x, y, z = nearest(model, rows, i, j)
            u, v, w = rows[j, 3] - rows[i, 3], rows[j, 4] - rows[i, 4], rows[j, 5] - rows[i, 5]
            b, w2 = x * u + y * v + z * w, u * u + v * v + w * w
            s = contact_distance(model.diameter, model.radii, i, j)
            c = x * x + y * y + z * z - s * s
            if s > 0.0 and not (c <= near * s * s and b < 0.0 and rests(rows, i, j, b, s * s)):
                moment2 = squared_moment(x, y, z, u, v, w)
                span = pair_time(model.well, bonds, i, j, b, c, w2, s * s, moment2, near)
                if span < best:
                    best, one, other = span, i, j
        if not is_fixed(model.inverse_masses, i):
            radius = radius_of(model.diameter, model.radii, i)
            for face in range(2 * d):
                k = face >> 1
                span = wall_time(model, model.walls, face, rows[i, k], rows[i, 3 + k], radius, now, best)
                if span < best:
                    best, one, other = span, i, -1 - face
            span = cylinder_time(model, model.cylinder, rows, i, 0.0, radius)
            if span < best:
                best, one, other = span, i, -1 - CYLINDER_FACE
    return best, one, other


@kernel
def advance_all(model: HardSpheres, rows: Floats, turns: NDArray[np.int64], span: float) -> None:
    """Advances all particles by the time `span`, and wraps their positions into the box."""
    for i in range(rows.shape[0]):
        for k in range(len(model.lengths)):
            if not is_fixed(model.inverse_masses, i):
                rows[i, k] = drift(rows[i, k], rows[i, 3 + k], model.acceleration, k, span)
                rows[i, 3 + k] = speed_after(rows[i, 3 + k], model.acceleration, k, span)
            if model.periodic[k]:
                turn = np.floor(rows[i, k] / model.lengths[k])
                rows[i, k] -= turn * model.lengths[k]
                turns[i, k] += np.int64(turn)


@inline
def _at_well_edge(
    well: Well | None, model: HardSpheres, rows: Floats, bonds: Any, i: int, j: int, n: Vector, distance: float,
    gn: float,
) -> bool:  # fmt: skip
    """Applies the event at the edge of a well, if the pair is there; whether it was."""
    if well is None:
        return False
    if not at_edge(well, model, i, j, distance * distance):
        return False
    pass_edge(well, model, rows, bonds, i, j, n, gn)
    return True


@kernel
def apply_event(
    model: HardSpheres, rows: Floats, spins: Any, bonds: Any, i: int, j: int, hits: NDArray[np.int64], now: float
) -> bool:
    """Applies the rule of the event of i with j (or the wall -1 - j); whether it was a collision of a pair.

    hits: (N,) collisions with walls so far, which number the draws of random ones.
    """
    if j < 0:
        recent = still_in_contact(model.contact_duration, now - rows[i, _LAST])
        if j == -1 - CYLINDER_FACE:
            at_cylinder(model, model.cylinder, rows, spins, i, recent)
        else:
            at_plane(model, model.walls, rows, spins, i, hits[i], -1 - j, now, recent)
        rows[i, _LAST] = now
        hits[i] += 1
        return False
    x, y, z = nearest(model, rows, i, j)
    distance = np.sqrt(x * x + y * y + z * z)
    x, y, z = x / distance, y / distance, z / distance
    gn = (rows[j, 3] - rows[i, 3]) * x + (rows[j, 4] - rows[i, 4]) * y + (rows[j, 5] - rows[i, 5]) * z
    collided = not _at_well_edge(model.well, model, rows, bonds, i, j, (x, y, z), distance, gn)
    if collided:
        recent = still_in_contact(model.contact_duration, now - max(rows[i, _LAST], rows[j, _LAST]))
        alpha = normal_restitution(model.restitution, recent)
        impulse = pair_impulse(model.rough, spins, model, rows, i, j, (x, y, z), gn, alpha, recent)
        apply_impulse(model, rows, i, j, impulse)
        for one in (i, j):
            if not is_fixed(model.inverse_masses, one):
                rows[one, _LAST] = now
    return collided
