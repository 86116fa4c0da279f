"""A trace from a densely sampled run, of engines that keep none: where the paths before and after an event meet.

By derivation: both paths are those of free flight, and their velocities differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.references.event_audit.matter import Matter, matter_of, wall_motion
from crosscheck.scene import Floats, Scene

#: A change of velocity, and a miss of two paths, that are rounding: in roundings of what they are computed from.
ROUNDINGS = 64.0
#: Partners are told by their distance and by the time of their events, each to this share of radius and interval: an
#: event of others is not so near. How near they are is for the audit to judge.
ALIKE = 1e-6


class SampledEvent(NamedTuple):
    """An event that samples show: its time, the partners as in the observable event_partners, and of both, (2, d), the
    positions and the velocities after it.
    """

    time: float
    partners: tuple[int, int]
    positions: Floats
    velocities: Floats


class _Change(NamedTuple):
    """An event of one particle between two samples: its time, and the position and velocity there."""

    particle: int
    time: float
    place: Floats
    velocity: Floats


def reconstructed(scene: Scene, run: Mapping[str, Floats]) -> tuple[list[SampledEvent], list[int]]:
    """The events of a run, from its samples; and those samples after which something is no single event of a particle.

    scene: of smooth hard spheres, with `output.interval` and `output.trajectory`, sampled so often that hardly a
    particle has two events from one sample to the next. run: what the engine returned.
    """
    matter = matter_of(scene)
    times, x, v = run["time"], run["positions"], run["velocities"]
    g = matter.acceleration[: matter.dimension]
    rows: list[SampledEvent] = []
    unresolved = []
    extent = float(np.abs(x).max()) + float(np.abs(v).max()) * float(times[-1])
    for k, (start, end) in enumerate(pairwise(times.tolist())):
        span = end - start
        turned = np.where(matter.fixed[:, None], 0.0, v[k + 1] - v[k] - span * g)
        rounding = ROUNDINGS * EPSILON * (np.abs(v[k : k + 2]).max() + np.abs(g).max() * span)
        changed = np.flatnonzero(np.abs(turned).max(axis=1) > rounding)
        changes, good = [], True
        for i in changed.tolist():
            # x0 + v0 t = x1 - v1 (span - t), and the fall of both, which cancels up to a constant
            meets = x[k, i] - x[k + 1, i] + span * v[k + 1, i] - 0.5 * span * span * g
            after = float(meets @ turned[i] / (turned[i] @ turned[i]))
            miss = float(np.abs(meets - after * turned[i]).max())
            good &= miss <= ROUNDINGS * EPSILON * extent and -ALIKE * span <= after <= (1 + ALIKE) * span
            place = x[k, i] + after * (v[k, i] + 0.5 * after * g)
            back = span - after
            changes.append(_Change(i, start + after, place, v[k + 1, i] - back * g))
        found = _events(matter, changes, span) if good else None
        if found is None:
            unresolved.append(k)
        else:
            rows += found
    return rows, unresolved


def with_trace(run: Mapping[str, Floats], events: list[SampledEvent]) -> dict[str, Floats]:
    """The run with the observables of `output.trace`. run: what an engine returned. events: of it, in any order."""
    ordered = sorted(events, key=lambda event: event.time)
    shape = (len(ordered), 2, run["positions"].shape[-1])
    return {
        **run,
        "event_times": np.array([event.time for event in ordered]),
        "event_partners": np.array([event.partners for event in ordered], dtype=np.float64).reshape(-1, 2),
        "event_positions": np.array([event.positions for event in ordered]).reshape(shape),
        "event_velocities": np.array([event.velocities for event in ordered]).reshape(shape),
    }


def _events(matter: Matter, changes: list[_Change], span: float) -> list[SampledEvent] | None:
    """The events that explain all changes between two samples; None if there are none that do."""
    found = []
    left = list(changes)
    while left:
        one = left.pop(0)
        nothing = np.zeros(matter.dimension)
        partner = next((other for other in left if _touch(matter, one, other, span)), None)
        if partner is not None:
            left.remove(partner)
            time, who = (one.time + partner.time) / 2, (one.particle, partner.particle)
            places, velocities = (one.place, partner.place), (one.velocity, partner.velocity)
        else:
            obstacle = _obstacle(matter, one)
            if obstacle is None:
                return None
            time, who = one.time, (one.particle, obstacle[0])
            places, velocities = (one.place, obstacle[1]), (one.velocity, nothing)
        found.append(SampledEvent(time, who, np.array(places), np.array(velocities)))
    return found


def _touch(matter: Matter, one: _Change, other: _Change, span: float) -> bool:
    """Whether two changes are those of one event of a pair."""
    return abs(one.time - other.time) <= ALIKE * span and _at_contact(
        matter, one.particle, other.particle, other.place - one.place
    )


def _at_contact(matter: Matter, i: int, j: int, gap: Floats) -> bool:
    """Whether a pair is at its core or at the edge of its well."""
    distance = float(np.linalg.norm(matter.nearest(gap)))
    contact = float(matter.radii[i] + matter.radii[j])
    return any(abs(distance - reach) <= ALIKE * contact for reach in (contact, contact * matter.well_range))


def _obstacle(matter: Matter, one: _Change) -> tuple[int, Floats] | None:
    """What a particle has met alone: -1 - face and zeros, or a fixed particle and its place; None: nothing."""
    i, nothing = one.particle, np.zeros(matter.dimension)
    for face, wall in enumerate(matter.faces):
        if wall is not None:
            axis, upper = divmod(face, 2)
            height = matter.lengths[axis] - one.place[axis] if upper else one.place[axis]
            if abs(height - matter.radii[i] - wall_motion(wall, one.time)[0]) <= ALIKE * matter.radii[i]:
                return -1 - face, nothing
    for j in np.flatnonzero(matter.fixed).tolist():
        place = matter.places[j]
        if _at_contact(matter, i, j, place - one.place):
            return j, place
    return None
