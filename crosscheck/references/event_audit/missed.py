"""Events that a trace should have and has not: all pairs and all walls, between the events that it has.

By derivation: two that come nearer than their contact between two events have met before.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.references.event_audit.deviations import Audit
from crosscheck.references.event_audit.history import History
from crosscheck.scene import Floats
from crosscheck.scene.overlaps import wrapped

#: An oscillating wall turns by less than this between two times that are looked at, rad.
LARGEST_TURN = 0.5
#: Relative paths between two times, in units of the shortest room of a periodic axis beyond the contact range; and at
#: least so many box sides, for boxes that leave hardly any room: there more images are looked at.
OF_ROOM, OF_SIDE = 0.9, 0.2
#: Places at which the height above a wall is looked at between two times, and steps of Newton's from the lowest.
PLACES, STEPS = 9, 5

#: Up to so many particles, all pairs are looked at in each interval; of more, those that can come into contact in it.
ALL_PAIRS = 64
#: Positions that are held at a time, of more than so many particles.
_AT_A_TIME = 200_000

#: tau -> value and first two derivatives, all (intervals, N).
Height = Callable[[Floats], tuple[Floats, Floats, Floats]]


def audit_missed(history: History, rounding: float, found: Audit) -> None:
    """Notes the deepest overlaps of pairs and walls between events, and passages of wells without one.

    history: of the run, after its last event. rounding: error of a distance that is rounding. found: where they are
    noted.
    """
    times = _moments(history)
    if times.size < 2:
        return
    few = history.matter.number <= ALL_PAIRS
    pairs, count = (_pairs, times.size) if few else (_near_pairs, max(1, _AT_A_TIME // history.matter.number))
    for first in range(0, times.size - 1, count):
        part = times[first : first + count + 1]
        x, v, _ = history.at(part[:-1])
        pairs(history, part, np.diff(part), x, v, rounding, found)
        _walls(history, part, np.diff(part), x, v, rounding, found)


def _moments(history: History) -> Floats:
    """The times of all events, start and end, and so many between that nobody goes far from one to the next."""
    matter = history.matter
    times = np.unique(np.clip([0.0, *history.times, history.end], 0.0, history.end))
    if times.size < 2:
        return times
    _, v, _ = history.at(times[:-1])
    # two at a time: relative to the mean, since a common fall does not bring two together
    relative = 2 * np.sqrt(((v - v[:, :1]) ** 2).sum(axis=2)).max(axis=1)
    most = np.diff(times)
    wraps = matter.periods > 0
    if wraps.any():
        reach = 2 * float(matter.radii.max()) * matter.well_range
        room = np.maximum(OF_ROOM * (matter.periods[wraps] / 2 - reach), OF_SIDE * matter.periods[wraps]).min()
        most = np.minimum(most, room / np.maximum(relative, 1e-300))
    for face in matter.faces:
        if face is not None and face.oscillation is not None:
            most = np.minimum(most, LARGEST_TURN / face.oscillation.frequency)
    pieces = np.ceil(np.diff(times) / most * (1 - 1e-12)).astype(int).clip(1)
    parts = [a + (b - a) * np.arange(n) / n for a, b, n in zip(times[:-1], times[1:], pieces, strict=True)]
    return np.append(np.concatenate(parts), times[-1])


def _pairs(history: History, times: Floats, spans: Floats, x: Floats, v: Floats, rounding: float, found: Audit) -> None:
    matter, d = history.matter, history.matter.dimension
    i, j = np.triu_indices(matter.number, 1)
    contact = matter.radii[i] + matter.radii[j]
    real = (contact > 0) & ~(matter.fixed[i] & matter.fixed[j])
    i, j, contact = i[real], j[real], contact[real]
    if not i.size:
        return
    nearest = matter.nearest((x[:, j] - x[:, i])[..., :d])
    w = (v[:, j] - v[:, i])[..., :d]
    edge = contact * matter.well_range
    inside = _inside(history, times, i, j)
    for shift in np.ndindex(*(3 if wraps else 1 for wraps in matter.periods > 0)):
        r = nearest + np.where(matter.periods > 0, (np.array(shift) - 1) * matter.periods, 0.0)
        start, rw, ww = (r * r).sum(axis=2), (r * w).sum(axis=2), (w * w).sum(axis=2)
        closest = np.clip(-rw / np.where(ww > 0, ww, 1.0), 0.0, spans[:, None])
        lowest = np.sqrt(np.maximum(start + closest * (2 * rw + closest * ww), 0.0))
        end = np.sqrt(start + spans[:, None] * (2 * rw + spans[:, None] * ww))
        _deepest(found, contact - lowest, rounding, times, i, j, "overlap")
        if matter.spheres.well is not None:
            centre = all(turn == 1 or not wraps for turn, wraps in zip(shift, matter.periods > 0, strict=True))
            within = inside if centre else np.zeros_like(inside)
            _deepest(found, np.where(within, 0.0, edge - lowest), rounding, times, i, j, "are in their well unseen")
            beyond = np.maximum(np.sqrt(start), end) - edge
            _deepest(found, np.where(within, beyond, 0.0), rounding, times, i, j, "left their well unseen")


def _near_pairs(
    history: History, times: Floats, spans: Floats, x: Floats, v: Floats, rounding: float, found: Audit
) -> None:
    """As `_pairs`, for those pairs alone that are near enough at the beginning of an interval to meet in it.

    Two that are in their well are near; only the nearest image is, unless the box leaves little room: then all pairs.
    """
    from scipy.spatial import cKDTree

    matter, d = history.matter, history.matter.dimension
    boxed = matter.periods > 0
    fastest = 2 * np.sqrt(((v - v[:, :1]) ** 2).sum(axis=2)).max(axis=1)
    reach = 2 * float(matter.radii.max()) * matter.well_range + fastest * spans + rounding
    room = float(matter.periods[boxed].min()) / 2 if boxed.any() else np.inf
    parts = []
    for k, distance in enumerate(reach.tolist()):
        if distance >= room:
            _pairs(history, times[k : k + 2], spans[k : k + 1], x[k : k + 1], v[k : k + 1], rounding, found)
            continue
        tree = cKDTree(wrapped(x[k, :, :d], matter.periods), boxsize=matter.periods)
        near = tree.query_pairs(distance, output_type="ndarray")
        parts.append(np.column_stack([np.full(len(near), k), near]))
    if not parts:
        return
    k, i, j = np.concatenate(parts).T
    contact = matter.radii[i] + matter.radii[j]
    real = (contact > 0) & ~(matter.fixed[i] & matter.fixed[j])
    k, i, j, contact = k[real], i[real], j[real], contact[real]
    if not k.size:
        return
    r, w, span = matter.nearest((x[k, j] - x[k, i])[:, :d]), (v[k, j] - v[k, i])[:, :d], spans[k]
    start, rw, ww = (r * r).sum(axis=1), (r * w).sum(axis=1), (w * w).sum(axis=1)
    closest = np.clip(-rw / np.where(ww > 0, ww, 1.0), 0.0, span)
    lowest = np.sqrt(np.maximum(start + closest * (2 * rw + closest * ww), 0.0))

    def deepest(depth: Floats, what: str) -> None:
        worst = int(np.argmax(depth))
        when = f"t = {times[k[worst]]:.6g} to {times[k[worst] + 1]:.6g}"
        where = f"{when}: particles {i[worst]} and {j[worst]} {what}"
        found.note("missed events", max(float(depth[worst]), 0.0), rounding, where)

    deepest(contact - lowest, "overlap")
    if matter.spheres.well is None:
        return
    within = _bonded(history, times[:-1], k, i, j)
    edge, end = contact * matter.well_range, np.sqrt(start + span * (2 * rw + span * ww))
    deepest(np.where(within, 0.0, edge - lowest), "are in their well unseen")
    deepest(np.where(within, np.maximum(np.sqrt(start), end) - edge, 0.0), "left their well unseen")


def _bonded(history: History, times: Floats, k: Floats, i: Floats, j: Floats) -> Floats:
    """Whether the pairs i < j are in their wells in the intervals k that begin at `times`, all (pairs,)."""
    known = history.bonds()
    of_interval = np.searchsorted(history.times, times, side="right")
    found = np.zeros(k.size, dtype=bool)
    low, high = np.minimum(i, j), np.maximum(i, j)
    for interval in np.unique(k).tolist():
        here = np.flatnonzero(k == interval)
        bonds = known[int(of_interval[interval])]
        found[here] = [(a, b) in bonds for a, b in zip(low[here].tolist(), high[here].tolist(), strict=True)]
    return found


def _inside(history: History, times: Floats, i: Floats, j: Floats) -> Floats:
    """Whether each pair is in its well in each interval, (intervals, pairs)."""
    place = {pair: k for k, pair in enumerate(zip(i.tolist(), j.tolist(), strict=True))}
    known = np.zeros((len(history.events) + 1, i.size), dtype=bool)
    for number, bonds in enumerate(history.bonds()):
        for pair in bonds & place.keys():
            known[number, place[pair]] = True
    return np.asarray(known[np.searchsorted(history.times, times[:-1], side="right")])


def _deepest(found: Audit, depth: Floats, rounding: float, times: Floats, i: Floats, j: Floats, what: str) -> None:
    interval, pair = np.unravel_index(int(np.argmax(depth)), depth.shape)
    where = f"t = {times[interval]:.6g} to {times[interval + 1]:.6g}: particles {i[pair]} and {j[pair]} {what}"
    found.note("missed events", max(float(depth[interval, pair]), 0.0), rounding, where)


def _walls(history: History, times: Floats, spans: Floats, x: Floats, v: Floats, rounding: float, found: Audit) -> None:
    matter, g = history.matter, history.matter.acceleration
    mobile = np.flatnonzero(~matter.fixed)

    def note(height: Height, name: str) -> None:
        lowest = _lowest(height, spans, mobile.size)
        interval, k = np.unravel_index(int(np.argmin(lowest)), lowest.shape)
        when = f"t = {times[interval]:.6g} to {times[interval + 1]:.6g}"
        depth = max(-float(lowest[interval, k]), 0.0)
        found.note("missed events", depth, rounding, f"{when}: particle {mobile[k]} is beyond {name}")

    for face, wall in enumerate(matter.faces):
        if wall is None:
            continue
        axis, upper = divmod(face, 2)
        sign = -1.0 if upper else 1.0
        origin = matter.lengths[axis] if upper else 0.0
        start = sign * (x[:, mobile, axis] - origin) - matter.radii[mobile]
        speed, a = sign * v[:, mobile, axis], sign * g[axis]
        swing = wall.oscillation

        def height(tau: Floats, start=start, speed=speed, a=a, swing=swing) -> tuple[Floats, Floats, Floats]:  # type: ignore[no-untyped-def]
            h, dh, ddh = start + tau * (speed + 0.5 * a * tau), speed + a * tau, a + 0.0 * tau
            if swing is None:
                return h, dh, ddh
            angle = swing.frequency * (times[:-1, None] + tau) + swing.phase
            wave = swing.amplitude * np.cos(angle)
            return (
                h - wave,
                dh + swing.amplitude * swing.frequency * np.sin(angle),
                ddh + swing.frequency**2 * wave,
            )

        note(height, f"face {face}")
    if matter.cylinder is not None:
        across = list(matter.across)
        middle, pull = matter.lengths[across] / 2, g[across]
        room = matter.cylinder.radius - matter.radii[mobile]
        r, u = x[:, mobile][..., across] - middle, v[:, mobile][..., across]

        def inside(tau: Floats) -> tuple[Floats, Floats, Floats]:
            t = tau[..., None]
            place, speed = r + t * (u + 0.5 * t * pull), u + t * pull
            grows = (place * speed).sum(axis=2)
            bends = (speed * speed).sum(axis=2) + (place * pull).sum(axis=2)
            return (room - (place * place).sum(axis=2) / room) / 2, -grows / room, -bends / room

        note(inside, "the cylinder")


def _lowest(height: Height, spans: Floats, number: int) -> Floats:
    """The lowest value of a height in each interval, (intervals, N): of places in it, then by Newton's steps."""
    span = np.broadcast_to(spans[:, None], (spans.size, number))
    taus = [span * k / (PLACES - 1) for k in range(PLACES)]
    values = np.stack([height(tau)[0] for tau in taus])
    tau = np.take_along_axis(np.stack(taus), values.argmin(axis=0)[None], axis=0)[0]
    lowest = values.min(axis=0)
    for _ in range(STEPS):
        _, slope, bend = height(tau)
        curved = bend > 0
        tau = np.where(curved, np.clip(tau - slope / np.where(curved, bend, 1.0), 0.0, span), tau)
        lowest = np.minimum(lowest, height(tau)[0])
    return lowest
