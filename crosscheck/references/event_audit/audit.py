"""The audit of a run: each event of its trace, the flights between events, what was missed, and all sums.

By derivation from the definitions of the scene language.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.references.event_audit.deviations import Audit
from crosscheck.references.event_audit.fields import audit_fields
from crosscheck.references.event_audit.history import Event, History
from crosscheck.references.event_audit.matter import matter_of, wall_motion
from crosscheck.references.event_audit.missed import audit_missed
from crosscheck.references.event_audit.rules import Motion, Outcome, pair_collision, size, wall_collision, well_edge
from crosscheck.references.event_audit.tallies import audit_tallies
from crosscheck.scene import Floats, Scene
from crosscheck.scene.parts import Face

#: Rounding of positions and times between two events: those of a grid, of the time of the event, of the sums.
ROUNDINGS = 32.0
#: Velocities drawn by a thermal wall, in thermal velocities: beyond it is the probability 1e-22 a draw.
LARGEST_DRAW = 10.0
#: A collapse shows as so many flights of one particle, its last ones, each shorter than this share of the time in which
#: the fastest one moves by a diameter.
LAST_FLIGHTS, OF_A_DIAMETER = 2, 1e-8


#: Kinds of deviation of the events themselves, in the order of the report, and what their tolerance is.
KINDS = {
    "order of events": "times do not go backwards, and the partners exist",
    "free flight": "rounding of positions, and of the times of events",
    "contact": "rounding of positions, and of the times of events",
    "approach": "rounding of velocities",
    "velocities after": "rounding of the normal, that of positions over the radius, times the largest velocity",
    "spins after": "as of velocities, over the radius",
    "drawn velocities": "what the law of a random wall makes possible; no draw repeats",
    "missed events": "rounding of positions: no overlap of any pair, image or wall between events",
    "end of the run": "its time is over, or the last flights of a particle take no time",
}


def audit(scene: Scene, run: Mapping[str, Floats], *, collapsed: bool = False) -> Audit:
    """Audits a run with a trace.

    scene: of hard spheres, with `output.trace`; whatever else it asks for is audited too. run: what the engine
    returned. collapsed: the engine says that an inelastic collapse has ended the run: it is audited up to its last
    event, and must look like one there.
    """
    matter, found = matter_of(scene), Audit()
    for kind in KINDS:
        found.note(kind, 0.0, 1.0, "")
    history = History(scene, matter, run, collapsed)
    judge = _Judge(history, found)
    found.events = len(history.times)
    for number in range(len(history.times)):
        event = judge.event(number)
        if event is None:
            return found  # all that follows would be judged by what did not happen
        history.append(event)
    history.close()
    if collapsed:
        _audit_collapse(history, judge.speed, found)
    audit_missed(history, judge.length, found)
    audit_tallies(scene, history, run, (judge.length, judge.velocity, judge.spin), found)
    if scene.output.fields is not None:
        audit_fields(scene, history, run, found)
    return found


def _audit_collapse(history: History, speed: float, found: Audit) -> None:
    """Notes the last flights of the particle whose collapse ended the run, where they take time. speed: the largest."""
    last = history.events[-1] if history.events else None
    flights = math.inf
    for i in [] if last is None else last.partners:
        times = history.times_of(i)
        if len(times) > LAST_FLIGHTS + 1:  # the first is that of the start
            flights = min(flights, float(np.diff(times[-LAST_FLIGHTS - 1 :]).max()))
    where = f"t = {history.end:.6g}: a collapse that is none"
    found.note("end of the run", flights, OF_A_DIAMETER * 2 * float(history.matter.radii.max()) / speed, where)


class _Judge:
    """Judges one event after the other.

    Attributes: length, velocity, spin: errors that rounding explains. speed: the largest one of the run.
    """

    def __init__(self, history: History, found: Audit) -> None:
        self.history, self.matter, self.found = history, history.matter, found
        self.drawn: list[float] = []
        matter, run = history.matter, history.run
        extent = float(matter.lengths[np.isfinite(matter.lengths)].max(initial=0.0))
        for positions in (history.start.positions, run["final_positions"], run["event_positions"]):
            extent = max(extent, float(np.abs(positions).max(initial=0.0)))
        velocities = (history.start.velocities, run["final_velocities"], run["event_velocities"])
        speed = max(float(np.abs(v).max(initial=0.0)) for v in velocities)
        self.speed = speed + size(matter.acceleration) * history.end
        smallest = float(matter.radii[matter.radii > 0].min(initial=extent))
        spin = self.speed / smallest / min(matter.shape, 1.0)
        if "event_angular_velocities" in run:
            spin = max(spin, float(np.abs(run["event_angular_velocities"]).max(initial=0.0)))
        self.length = ROUNDINGS * EPSILON * (extent + self.speed * history.end)
        relative = self.length / min(smallest, extent)
        self.velocity, self.spin = relative * self.speed, relative * spin

    def event(self, number: int) -> Event | None:
        """One event, judged; None if it is none at all, and nothing after it can be judged. number: its place."""
        history, matter = self.history, self.matter
        i, j = (int(one) for one in history.run["event_partners"][number])
        time = history.times[number]
        who = f"particles {i} and {j}" if j >= 0 else f"particle {i}, face {-1 - j}"
        where = f"event {number}, t = {time:.6g}, {who}"
        if not self._possible(number, time, i, j, where):
            return None
        before, after = [], []
        for place, one in enumerate([i] if j < 0 else [i, j]):
            x, motion = history.flown(one, time)
            seen, seen_after = history.seen(number, place)
            self.found.note("free flight", float(np.abs(x - seen).max()), self.length, f"{where}: position of {one}")
            before.append((seen, motion))
            after.append(seen_after)
        event = Event(number, time, i, j, np.zeros(3), 0.0, "wall", before, after)
        if j < 0:
            outcomes = self._at_wall(event, -1 - j, where)
        else:
            gap = matter.nearest((before[1][0] - before[0][0])[: matter.dimension])
            event.distance = float(np.sqrt(gap @ gap))
            event.n[: matter.dimension] = gap / event.distance
            outcomes = self._at_pair(event, where)
        if not outcomes:
            return None
        self._outcome(outcomes, event, where)
        return event

    def _possible(self, number: int, time: float, i: int, j: int, where: str) -> bool:
        """Whether there are such partners, which may have an event; notes times that go backwards."""
        history, matter = self.history, self.matter
        latest = history.times[number - 1] if number else 0.0
        backwards = max(latest - time, time - history.end, 0.0)
        self.found.note("order of events", backwards, EPSILON * 4 * max(history.end, 1e-300), where)
        faces = 2 * matter.dimension + (matter.cylinder is not None)
        if not (0 <= i < matter.number and -faces <= j < matter.number and i != j):
            self.found.note("order of events", math.inf, 1.0, f"{where}: there are no such partners")
            return False
        if matter.fixed[i] and (j < 0 or matter.fixed[j]):
            self.found.note("order of events", math.inf, 1.0, f"{where}: a fixed particle has no event of its own")
            return False
        return True

    def _outcome(self, outcomes: list[Outcome], event: Event, where: str) -> None:
        """Velocities and spins after the event, against the nearest of the outcomes that the rule allows."""

        def errors(outcome: Outcome) -> tuple[float, float]:
            expected = [outcome.first] + ([] if outcome.second is None else [outcome.second])
            pairs = list(zip(expected, event.after, strict=True))
            velocity = max(float(np.abs(a.velocity - b.velocity).max()) for a, b in pairs)
            spin = max(float(np.abs(a.spin - b.spin).max()) for a, b in pairs)
            return velocity / (outcome.amplified * self.velocity), spin / (outcome.amplified * self.spin)

        (velocity, spin), best = min(((errors(one), one) for one in outcomes), key=lambda found: max(found[0]))
        event.inside = best.inside
        what = {"core": "collision", "edge": "edge of the well", "wall": "wall"}[event.kind]
        self.found.note("velocities after", velocity, 1.0, f"{where}: {what}")
        self.found.note("spins after", spin, 1.0, f"{where}: {what}")

    def _at_pair(self, event: Event, where: str) -> list[Outcome]:
        """The outcomes that the rule allows, at the core or at the edge of the well: what is nearer."""
        matter, i, j, n = self.matter, event.i, event.j, event.n
        one, other = event.before[0][1], event.before[1][1]
        contact = matter.radii[i] + matter.radii[j]
        edge = contact * matter.well_range
        core = matter.spheres.well is None or event.distance - contact < edge - event.distance
        event.kind = "core" if core else "edge"
        self.found.note("contact", abs(event.distance - (contact if core else edge)), self.length, where)
        if contact == 0:
            self.found.note("contact", math.inf, 1.0, f"{where}: points never hit each other")
        apart = float((other.velocity - one.velocity) @ n)
        if core:
            self.found.note("approach", max(apart, 0.0), self.velocity, where)
            elastic = any(self.history.collided_lately(k, event.time) for k in (i, j))
            outcomes = pair_collision(matter, i, j, n, one, other, elastic, self.speed)
            return self._or_untouched(event, apart, outcomes)
        inside = self.history.inside(i, j)
        wrong_way = max(-apart if inside else apart, 0.0)
        self.found.note("approach", wrong_way, self.velocity, f"{where}: edge of the well")
        return well_edge(matter, i, j, n, one, other, inside)

    def _at_wall(self, event: Event, face: int, where: str) -> list[Outcome]:
        """The outcomes that the rule of the wall allows; sets the unit vector towards it."""
        matter, (x, motion), n = self.matter, event.before[0], event.n
        elastic = self.history.collided_lately(event.i, event.time)
        if face == 2 * matter.dimension:
            return self._at_cylinder(event, elastic, where)
        axis, upper = divmod(face, 2)
        wall = matter.faces[face]
        n[axis] = 1.0 if upper else -1.0
        if wall is None:
            self.found.note("contact", math.inf, 1.0, f"{where}: there is no wall")
            return []
        place, own = wall_motion(wall, event.time)
        height = matter.lengths[axis] - x[axis] if upper else x[axis]
        self.found.note("contact", abs(height - matter.radii[event.i] - place), self.length, where)
        arriving = -float(motion.velocity @ n)
        if wall.temperature is not None:
            self.found.note("approach", max(arriving, 0.0), self.velocity, where)
            return [self._thermal(event, wall.temperature, where)]
        law = (1.0, None) if elastic else (wall.restitution, wall.friction)
        if wall.random_phase is not None:
            own = self._drawn_phase(event, wall, law[0], arriving, where)
        self.found.note("approach", max(arriving - own, 0.0), self.velocity, where)
        outcomes = wall_collision(matter, event.i, n, motion, law, -own * n, self.speed)
        # the velocity of a random wall is what the outcome says: nothing else is known of the approach
        return outcomes if wall.random_phase is not None else self._or_untouched(event, arriving - own, outcomes)

    def _or_untouched(self, event: Event, apart: float, outcomes: list[Outcome]) -> list[Outcome]:
        """The outcomes, and that nothing happens where rounding decides whether the partners approach at all.

        Friction without a limit shows the difference: its impulse does not vanish with the normal one. apart: velocity
        with which they go apart.
        """
        if abs(apart) > self.velocity:
            return outcomes
        first, *second = [motion for _, motion in event.before]
        return [*outcomes, Outcome(first, second[0] if second else None, 1.0)]

    def _drawn_phase(self, event: Event, wall: Face, restitution: float, arriving: float, where: str) -> float:
        """The velocity of a random wall that explains what came out: v'_n = (1 + a) V - a v_n; it must be possible."""
        assert wall.random_phase is not None
        own = (-float(event.after[0].velocity @ event.n) + restitution * arriving) / (1 + restitution)
        beyond = max(abs(own) - wall.random_phase.speed, 0.0)
        self.found.note("drawn velocities", beyond, self.velocity, f"{where}: faster than the wall can be")
        self._new_draw(own, where)
        return own

    def _thermal(self, event: Event, temperature: float, where: str) -> Outcome:
        """A thermal wall: any velocity away from it that its temperature makes possible; it does not touch the spin."""
        after = event.after[0]
        width = math.sqrt(temperature / self.matter.masses[event.i])
        inwards = max(float(after.velocity @ event.n), 0.0)
        self.found.note("drawn velocities", inwards, EPSILON * width, f"{where}: into the thermal wall")
        share = size(after.velocity) / width
        self.found.note("drawn velocities", share, LARGEST_DRAW, f"{where}: too fast for the temperature")
        for axis in range(self.matter.dimension):
            self._new_draw(float(after.velocity[axis]), f"{where}, along {'xyz'[axis]}")
        return Outcome(Motion(after.velocity, event.before[0][1].spin), None, 1.0)

    def _new_draw(self, drawn: float, where: str) -> None:
        """Random numbers of the continuum do not repeat."""
        repeated = any(abs(drawn - other) <= 1e-12 * abs(drawn) for other in self.drawn)
        self.drawn.append(drawn)
        self.found.note("drawn velocities", float(repeated), 0.5, f"{where}: drawn before")

    def _at_cylinder(self, event: Event, elastic: bool, where: str) -> list[Outcome]:
        matter, (x, motion), n = self.matter, event.before[0], event.n
        cylinder, (first, second) = matter.cylinder, matter.across
        assert cylinder is not None
        across = np.array([first, second])
        away = x[across] - matter.lengths[across] / 2
        distance = math.sqrt(away @ away)
        contact = cylinder.radius - matter.radii[event.i]
        self.found.note("contact", abs(contact - distance), self.length, where)
        n[across] = away / distance
        along = np.zeros(3)
        along[first], along[second] = -n[second], n[first]
        apart = -float(motion.velocity @ n)
        self.found.note("approach", max(apart, 0.0), self.velocity, where)
        law = (1.0, None) if elastic else (cylinder.restitution, cylinder.friction)
        surface = cylinder.angular_velocity * cylinder.radius * along
        outcomes = wall_collision(matter, event.i, n, motion, law, surface, self.speed)
        return self._or_untouched(event, apart, outcomes)
