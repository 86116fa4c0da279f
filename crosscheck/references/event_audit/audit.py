"""The audit of a run: each event of its trace, the flights between events, what was missed, and all sums."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.references.event_audit.history import Event, History
from crosscheck.references.event_audit.matter import Matter, matter_of
from crosscheck.references.event_audit.rules import (
    Motion,
    Outcome,
    pair_collision,
    size,
    wall_collision,
    well_edge,
)
from crosscheck.scene import Floats, Scene
from crosscheck.scene.parts import Face

#: Rounding of positions and times between two events: those of a grid, of the time of the event, of the sums.
ROUNDINGS = 32.0
#: Velocities drawn by a thermal wall, in thermal velocities: beyond it is the probability 1e-22 a draw.
LARGEST_DRAW = 10.0


@dataclass
class Audit:
    """The largest deviation of each kind, as a share of its tolerance, and where it was found.

    shares: by kind, in a fixed order. where: in words, by kind. events: number of those audited.
    """

    shares: dict[str, float] = field(default_factory=dict)
    where: dict[str, str] = field(default_factory=dict)
    events: int = 0

    def note(self, kind: str, error: float, tolerance: float, where: str) -> None:
        """Takes up a deviation. kind: of it. error, tolerance: in one unit; NaN fails. where: in words."""
        share = float(error / tolerance) if error == error else math.inf
        if share > self.shares.setdefault(kind, 0.0):
            self.shares[kind], self.where[kind] = share, where

    @property
    def good(self) -> bool:
        """Whether all deviations are within their tolerances."""
        return all(share <= 1 for share in self.shares.values())


@dataclass(frozen=True)
class Scales:
    """Sizes of rounding in one run. length, velocity, spin: errors that rounding explains; speed: the largest one."""

    length: float
    velocity: float
    spin: float
    speed: float


#: Kinds of deviation, in the order of the report.
KINDS = (
    "order of events",
    "free flight",
    "contact",
    "approach",
    "velocities after",
    "spins after",
    "drawn velocities",
    "missed events",
)


def audit(scene: Scene, run: Mapping[str, Floats]) -> Audit:
    """Audits a run with a trace.

    scene: of hard spheres, with `output.trace`; whatever else it asks for is audited too. run: what the engine
    returned.
    """
    from crosscheck.references.event_audit.fields import audit_fields
    from crosscheck.references.event_audit.missed import audit_missed
    from crosscheck.references.event_audit.tallies import audit_tallies

    matter, found = matter_of(scene), Audit()
    for kind in KINDS:
        found.note(kind, 0.0, 1.0, "")
    history = History(scene, matter, run)
    scales = _scales(matter, history, run)
    found.events = len(history.times)
    for number in range(len(history.times)):
        event = _event(history, scales, found, number)
        if event is None:
            return found  # all that follows would be judged by what did not happen
        history.append(event)
    history.close()
    audit_missed(history, scales.length, found)
    audit_tallies(scene, history, run, (scales.length, scales.velocity, scales.spin), found)
    if scene.output.fields is not None:
        audit_fields(scene, history, run, found)
    return found


def _scales(matter: Matter, history: History, run: Mapping[str, Floats]) -> Scales:
    finite = matter.lengths[np.isfinite(matter.lengths)]
    extent = max(
        float(np.abs(history.start.positions).max()),
        float(np.abs(run["final_positions"]).max()),
        float(np.abs(run["event_positions"]).max(initial=0.0)),
        float(finite.max(initial=0.0)),
    )
    velocities = (history.start.velocities, run["final_velocities"], run["event_velocities"])
    speed = max(float(np.abs(v).max(initial=0.0)) for v in velocities)
    speed += size(matter.acceleration) * history.end
    smallest = float(matter.radii.min()) or extent
    spin = speed / smallest / min(matter.shape, 1.0)
    if "final_angular_velocities" in run:
        spin = max(spin, float(np.abs(run["event_angular_velocities"]).max(initial=0.0)))
    length = ROUNDINGS * EPSILON * (extent + speed * history.end)
    relative = length / min(smallest, extent)
    return Scales(length, relative * speed, relative * spin, speed)


def _event(history: History, scales: Scales, found: Audit, number: int) -> Event | None:
    """One event, judged; None if it is none at all, and nothing after it can be judged."""
    matter, time, run = history.matter, history.times[number], history.run
    i, j = (int(one) for one in run["event_partners"][number])
    where = f"event {number}, t = {time:.6g}, {f'particles {i} and {j}' if j >= 0 else f'particle {i}, face {-1 - j}'}"
    latest = history.times[number - 1] if number else 0.0
    backwards = max(latest - time, time - history.end, 0.0)
    found.note("order of events", backwards, EPSILON * max(history.end, 1e-300) * 4, where)
    faces = 2 * matter.dimension + (matter.cylinder is not None)
    if not (0 <= i < matter.number and -1 - faces < 0 and -faces <= j < matter.number and i != j):
        found.note("order of events", math.inf, 1.0, f"{where}: there are no such partners")
        return None
    if matter.fixed[i] and (j < 0 or matter.fixed[j]):
        found.note("order of events", math.inf, 1.0, f"{where}: a fixed particle has no events of its own")
        return None
    who = [i] if j < 0 else [i, j]
    before, after = [], []
    for place, one in enumerate(who):
        x, motion = history.flown(one, time)
        seen = history.seen(number, place)
        found.note("free flight", float(np.abs(x - seen[0]).max()), scales.length, f"{where}: position of {one}")
        before.append((seen[0], motion))
        after.append(seen[1])
    if j < 0:
        face = -1 - j
        outcomes, n = _at_wall(history, scales, found, i, face, time, before[0], after[0], where)
        event = Event(number, time, i, j, n, 0.0, "wall", before, after)
    else:
        gap = matter.nearest((before[1][0] - before[0][0])[: matter.dimension])
        distance = float(np.sqrt(gap @ gap))
        n = np.zeros(3)
        n[: matter.dimension] = gap / distance
        outcomes, kind = _at_pair(history, scales, found, (i, j), n, distance, time, before, where)
        event = Event(number, time, i, j, n, distance, kind, before, after)
    if not outcomes:
        return None
    _judge_outcome(found, scales, outcomes, event, where)
    return event


def _judge_outcome(found: Audit, scales: Scales, outcomes: list[Outcome], event: Event, where: str) -> None:
    """Velocities and spins after the event, against the nearest of the outcomes that the rule allows."""

    def errors(outcome: Outcome) -> tuple[float, float]:
        expected = [outcome.first] + ([] if outcome.second is None else [outcome.second])
        pairs = list(zip(expected, event.after, strict=True))
        velocity = max(float(np.abs(a.velocity - b.velocity).max()) for a, b in pairs)
        spin = max(float(np.abs(a.spin - b.spin).max()) for a, b in pairs)
        return velocity / (outcome.amplified * scales.velocity), spin / (outcome.amplified * scales.spin)

    best = min(outcomes, key=lambda outcome: max(errors(outcome)))
    velocity, spin = errors(best)
    event.inside = best.inside
    what = {"core": "collision", "edge": "edge of the well", "wall": "wall"}[event.kind]
    found.note("velocities after", velocity, 1.0, f"{where}: {what}")
    found.note("spins after", spin, 1.0, f"{where}: {what}")


def _at_pair(
    history: History,
    scales: Scales,
    found: Audit,
    pair: tuple[int, int],
    n: Floats,
    distance: float,
    time: float,
    before: list[tuple[Floats, Motion]],
    where: str,
) -> tuple[list[Outcome], str]:
    """The outcomes that the rule allows, and whether the pair is at its "core" or at the "edge" of its well."""
    matter, (i, j) = history.matter, pair
    one, other = before[0][1], before[1][1]
    contact = matter.radii[i] + matter.radii[j]
    edge = contact * matter.well_range
    core = matter.spheres.well is None or distance - contact < edge - distance
    found.note("contact", abs(distance - (contact if core else edge)), scales.length, where)
    apart = float((other.velocity - one.velocity) @ n)
    if core:
        if contact == 0:
            found.note("contact", math.inf, 1.0, f"{where}: points never hit each other")
        found.note("approach", max(apart, 0.0), scales.velocity, where)
        elastic = history.collided_lately(i, time) or history.collided_lately(j, time)
        return pair_collision(matter, i, j, n, one, other, elastic, scales.speed), "core"
    inside = history.inside(i, j)
    found.note("approach", max(-apart if inside else apart, 0.0), scales.velocity, f"{where}: edge of the well")
    return well_edge(matter, i, j, n, one, other, inside), "edge"


def _at_wall(
    history: History,
    scales: Scales,
    found: Audit,
    i: int,
    face: int,
    time: float,
    before: tuple[Floats, Motion],
    after: Motion,
    where: str,
) -> tuple[list[Outcome], Floats]:
    """The outcomes that the rule allows, and the unit vector towards the wall."""
    matter, (x, motion) = history.matter, before
    elastic = history.collided_lately(i, time)
    if face == 2 * matter.dimension:
        return _at_cylinder(history, scales, found, i, x, motion, elastic, where)
    axis, upper = divmod(face, 2)
    wall = matter.faces[face]
    n = np.zeros(3)
    n[axis] = 1.0 if upper else -1.0
    if wall is None:
        found.note("contact", math.inf, 1.0, f"{where}: there is no wall")
        return [], n
    place, own = wall_motion(wall, time)
    height = matter.lengths[axis] - x[axis] if upper else x[axis]
    found.note("contact", abs(height - matter.radii[i] - place), scales.length, where)
    inwards = -n
    arriving = float(motion.velocity @ inwards)
    if wall.temperature is not None:
        found.note("approach", max(arriving, 0.0), scales.velocity, where)
        return [_thermal(matter, found, scales, history, i, wall, inwards, motion, after, where)], n
    law = (1.0, None) if elastic else (wall.restitution, wall.friction)
    if wall.random_phase is not None:
        # any velocity that the wall can have and that lets the two meet, but only this one fits what came out
        own = (float(after.velocity @ inwards) + law[0] * arriving) / (1 + law[0])
        beyond = abs(own) - wall.random_phase.speed
        found.note("drawn velocities", max(beyond, 0.0), scales.velocity, f"{where}: faster than the wall can be")
        _no_repetition(history, found, own, where)
    found.note("approach", max(arriving - own, 0.0), scales.velocity, where)
    return wall_collision(matter, i, n, motion, law, own * inwards, scales.speed), n


def wall_motion(wall: Face, time: float) -> tuple[float, float]:
    """Displacement (length) and velocity (length/time) of a plane wall, both into the box. time: since t = 0."""
    if wall.oscillation is not None:
        amplitude, frequency, phase = wall.oscillation.amplitude, wall.oscillation.frequency, wall.oscillation.phase
        angle = frequency * time + phase
        return amplitude * math.cos(angle), -amplitude * frequency * math.sin(angle)
    return 0.0, wall.velocity or 0.0


def _thermal(
    matter: Matter,
    found: Audit,
    scales: Scales,
    history: History,
    i: int,
    wall: Face,
    inwards: Floats,
    motion: Motion,
    after: Motion,
    where: str,
) -> Outcome:
    """A thermal wall: any velocity away from it that its temperature makes possible; it does not touch the spin."""
    assert wall.temperature is not None
    width = math.sqrt(wall.temperature / matter.masses[i])
    leaving = float(after.velocity @ inwards)
    found.note("drawn velocities", max(-leaving, 0.0), EPSILON * width, f"{where}: into the thermal wall")
    found.note("drawn velocities", size(after.velocity) / width, LARGEST_DRAW, f"{where}: too fast for its temperature")
    for axis in range(matter.dimension):
        _no_repetition(history, found, float(after.velocity[axis]), f"{where}, along {'xyz'[axis]}")
    return Outcome(Motion(after.velocity, motion.spin), None, 1.0)


def _no_repetition(history: History, found: Audit, drawn: float, where: str) -> None:
    """Random numbers of the continuum do not repeat."""
    repeated = any(abs(drawn - other) <= 1e-12 * abs(drawn) for other in history.drawn)
    history.drawn.append(drawn)
    found.note("drawn velocities", float(repeated), 0.5, f"{where}: drawn before")


def _at_cylinder(
    history: History,
    scales: Scales,
    found: Audit,
    i: int,
    x: Floats,
    motion: Motion,
    elastic: bool,
    where: str,
) -> tuple[list[Outcome], Floats]:
    matter = history.matter
    cylinder, (first, second) = matter.cylinder, matter.across
    assert cylinder is not None
    across = np.array([first, second])
    away = x[across] - matter.lengths[across] / 2
    distance = math.sqrt(away @ away)
    found.note("contact", abs(cylinder.radius - matter.radii[i] - distance), scales.length, where)
    n, along = np.zeros(3), np.zeros(3)
    n[across] = away / distance
    along[first], along[second] = -n[second], n[first]
    found.note("approach", max(-float(motion.velocity @ n), 0.0), scales.velocity, where)
    law = (1.0, None) if elastic else (cylinder.restitution, cylinder.friction)
    surface = cylinder.angular_velocity * cylinder.radius * along
    return wall_collision(matter, i, n, motion, law, surface, scales.speed), n
