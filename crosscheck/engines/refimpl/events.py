"""Scenes of hard spheres for the event-driven algorithms of `refimpl.events`."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numba import typeof

from crosscheck import scene as scenes
from crosscheck.engines.progress import Pace, stage
from crosscheck.engines.protocol import Run, shapes, timed
from crosscheck.engines.refimpl.continuation import Continuation, absolute_times, misfit
from crosscheck.engines.workers.cache import one_at_a_time
from crosscheck.errors import UsageError
from crosscheck.scene import AXES, Floats, Scene, State
from crosscheck.scene.observables import OPERATIONS
from refimpl.compilation import INTERPRETED
from refimpl.events import model as events
from refimpl.events.naive import CYLINDER_FACE, Naive
from refimpl.events.simulation import Simulation
from refimpl.events.state import field_energy, kinetic_energies, rotational_energies, well_energy

#: Observables that follow from the state at the sample.
_OF_STATES = ("kinetic_energy", "rotational_energy", "potential_energy")
#: Observables for which `Simulation` need not keep cumulative sums; `contact_time` is 0 for hard spheres.
_COUNTED = (*_OF_STATES, "collisions", "events", "operation_counts", "contact_time")


def run_events(scene: Scene, scheduler: Any, ends: Continuation | None = None) -> Run:
    """Runs a scene of hard spheres from event to event.

    scene: a scene of hard spheres. scheduler: name of a queue of events, a value of `engine.SCHEDULERS`. ends: from
    where the run goes on, and what it leaves; None: nothing of it. UsageError if `refimpl.events` refuses the scene.
    """
    state = scene.initial_state()
    output, times = scene.output, scene.samples()
    origin, lengths = _domain(state)
    run = Run({name: np.full(shape, np.nan) for name, shape in shapes(scene, times.size).items()})
    run["time"] = times
    tallied = any(name not in _COUNTED for name in output.observables)
    with _as_usage_error(scene):
        model = hard_spheres(scene, state, lengths)
        started = time.perf_counter()
        stage("compiling kernels")
        with one_at_a_time(f"events {scheduler} {typeof(model)}"):
            start = (model, state.positions - origin, state.velocities, state.angular_velocities)
            sim: Any
            if scheduler == "naive":
                if not INTERPRETED:
                    _Naive(*start).run(until=scene.duration, changes=1)  # compiles the collision rules
                sim = (_TracedNaive if output.trace else _Naive)(*start)
            else:
                sim = Simulation(
                    *start,
                    scheduler=scheduler,
                    tallies=tallied,
                    fields=output.fields,
                    counting="operation_counts" in output.observables,
                    trace=output.trace,
                )
            before = _record(run, 0, sim, origin, tallied)
            sim.run(until=0.0)  # compiles the loop
        run.cost.compile = time.perf_counter() - started

    resumed = ends is not None and ends.start is not None
    begin = _resume(sim, ends.start) if ends is not None and ends.start is not None else 0.0
    moments, end = absolute_times(scene, begin), begin + scene.duration
    if resumed:
        if sim.time < moments[0]:  # another look at the queue would count as operations
            sim.run(until=moments[0])
        before = _record(run, 0, sim, origin, tallied)
    reach = end if output.collisions is None else before.collisions + output.collisions[-1]
    pace = Pace(reach, begin if output.collisions is None else before.collisions)
    for sample, count in enumerate(output.collisions or (None,) * (times.size - 1), 1):
        until, collisions = (moments[sample], None) if count is None else (end, before.collisions + count)
        with timed(run.cost):
            _advance(sim, pace, until, collisions)
        if sim.stopped:
            break
        if collisions is not None and sim.collisions < collisions:
            run.stopped = f"the duration, {scene.duration:g}, is over before pair collision {count}"
            break
        if count is not None or not resumed:
            times[sample] = sim.time - begin
        _record(run, sample, sim, origin, tallied, before)
    if output.collisions is None:
        with timed(run.cost):
            _advance(sim, pace, end, None)
    run.stopped = run.stopped or sim.stopped
    run.cost.events = sim.events - before.events
    if "operation_counts" in run:
        _count_operations(run)
    run.remarks = _remarks(sim)
    if ends is not None and not run.stopped:
        ends.leave({"end": end if output.collisions is None else sim.time, "simulation": sim.snapshot()})

    final = sim.state()
    run["final_positions"], run["final_velocities"] = final.positions + origin, final.velocities
    if scene.spin_dimension:
        run["final_angular_velocities"] = final.angular_velocities
    if output.fields is not None:
        run.update(sim.fields())
    if output.trace:
        run.update(_trace(scene, sim, origin, begin))
    height = 0.0 if scene.acceleration is None else float(state.masses.sum() * (origin @ scene.acceleration))
    if "potential_energy" in run:
        run["potential_energy"] -= height
    if "potential_energy_integral" in run:
        run["potential_energy_integral"] -= height * times
    return run


def _count_operations(run: Run) -> None:
    """The operations since the start, at the last sample that there is, into the cost."""
    sampled = run["operation_counts"][~np.isnan(run["operation_counts"]).any(axis=1)]
    counts = dict(zip(OPERATIONS, (sampled[-1] - sampled[0]).astype(int).tolist(), strict=True))
    cost = run.cost
    cost.comparisons, cost.predictions = counts["tree_comparisons"], counts["predictions"]
    cost.cell_crossings, cost.stale_events = counts["cell_crossings"], counts["invalid_events"]
    cost.list_builds, cost.list_tests = counts["list_builds"], counts["list_tests"]


def _advance(sim: Any, pace: Pace, until: float, collisions: int | None) -> None:
    """`sim.run(until, collisions)`, in pieces of so many pair collisions as `pace` says: they change no bit of it."""
    while not sim.stopped:
        end = sim.collisions + pace.more(sim.time if collisions is None else sim.collisions)
        end = end if collisions is None else min(end, collisions)
        sim.run(until=until, collisions=end)
        if sim.collisions < end or sim.collisions == collisions:
            return


class _Counts(NamedTuple):
    """Numbers of pair collisions and of all events that are not this run's own: of the run that it goes on from."""

    collisions: int = 0
    events: int = 0


def _resume(sim: Any, start: Mapping[str, Any]) -> float:
    """Brings the simulation to the start of the run; the time that it is then, since the very first start."""
    prefix = "simulation."
    try:
        sim.resume({name.removeprefix(prefix): array for name, array in start.items() if name.startswith(prefix)})
        return float(start["end"])
    except (KeyError, TypeError) as error:
        raise misfit(ValueError(f"array {error} is missing or damaged")) from None
    except ValueError as error:
        raise misfit(error) from None


def hard_spheres(scene: Scene, state: State, lengths: Floats) -> Any:
    """The model of `refimpl.events` for `scene`.

    state: its initial state. lengths: sides of the domain that is divided into cells, (d,), length. ValueError from
    `refimpl.events` if it refuses the scene.
    """
    spheres = scene.hard_spheres
    assert spheres is not None
    assert state.diameters is not None
    fixed = scene.fixed()
    seed = scene.seed
    if seed is None:
        seed = scene.initial.seed if isinstance(scene.initial, scenes.Lattice) else 0
    friction, well = spheres.friction, spheres.well
    return events.hard_spheres(
        lengths=lengths.tolist(),
        periodic=[boundary == "periodic" for boundary in scene.boundaries],
        diameters=state.diameters,
        masses=np.where(fixed, np.inf, state.masses),
        restitution=spheres.restitution,
        friction=None if friction is None else _friction(friction, friction.inertia),
        acceleration=scene.acceleration,
        well=None if well is None else events.Well(well.depth, well.range),
        faces=[None if face is None else _face(face) for face in scene.faces],
        cylinder=_cylinder(scene),
        contact_duration=spheres.contact_duration,
        seed=seed,
    )


def _friction(friction: scenes.Friction | None, inertia: float | None = None) -> Any:
    """The friction record of `refimpl.events`; None without friction. inertia: q in I = q m R^2; None: the default."""
    if friction is None:
        return None
    static = math.inf if friction.static is None else friction.static
    sliding = math.inf if friction.sliding is None else friction.sliding
    return events.Friction(friction.tangential_restitution, static, sliding, inertia)


def _face(face: scenes.Face) -> Any:
    phase, oscillation = face.random_phase, face.oscillation
    return events.Face(
        restitution=face.restitution,
        velocity=face.velocity or 0.0,
        random_phase=None if phase is None else events.RandomPhase(phase.speed, phase.law),
        oscillation=None
        if oscillation is None
        else events.Oscillation(oscillation.amplitude, oscillation.frequency, oscillation.phase),
        temperature=face.temperature,
        friction=_friction(face.friction),
    )


def _cylinder(scene: Scene) -> Any:
    if scene.box is None or scene.box.cylinder is None:
        return None
    cylinder = scene.box.cylinder
    axis = AXES.index(cylinder.axis) if cylinder.axis is not None else 2
    return events.Cylinder(
        cylinder.radius, axis, cylinder.angular_velocity, cylinder.restitution, _friction(cylinder.friction)
    )


def _domain(state: State) -> tuple[Floats, Floats]:
    """Origin and sides of the domain that is divided into cells: the box, or a box around the particles without one."""
    if state.lengths is not None:
        return np.zeros_like(state.lengths), state.lengths
    assert state.diameters is not None
    extent = np.ptp(state.positions, axis=0)
    least = float(state.diameters.max()) or float(extent.max()) or 1.0
    return state.positions.min(axis=0), np.maximum(extent, least)


@contextmanager
def _as_usage_error(scene: Scene) -> Iterator[None]:
    """Turns a ValueError of `refimpl.events`, which is about the scene, into a UsageError."""
    try:
        yield
    except ValueError as error:
        raise UsageError(f"scene {scene.name}: {error}") from None


def _remarks(sim: Any) -> tuple[str, ...]:
    """What the user of a run must know of it. sim: a simulation of either algorithm, after the run."""
    number, first = sim.simultaneous
    if not number:
        return ()
    return (
        f"{number} {'event' if number == 1 else 'events'} took place at the same time, within rounding, as another one "
        f"of the same particle, the first at t = {first:.12g}: which of them comes first depends on the order in which "
        "the particles are given, and so may all that follows.",
    )


class _Naive(Naive):
    """The naive algorithm, with those observables of `Simulation` that follow from the state alone."""

    @property
    def events(self) -> int:
        """Number of events: the changes of state, since this algorithm has no other events."""
        return len(self.trace)

    def kinetic_energy(self) -> float:
        return float(kinetic_energies(self.model, self.state()).sum())

    def rotational_energy(self) -> float:
        return float(rotational_energies(self.model, self.state().angular_velocities, self.number).sum())

    def potential_energy(self) -> float:
        return field_energy(self.model, self.state().positions) + well_energy(self.model, self._bonds)


class _TracedNaive(_Naive):
    """The naive algorithm, event by event, with the states of the partners after each."""

    def __init__(self, *start: Any) -> None:
        super().__init__(*start)
        self._after = [np.zeros((0, 2, 9))]

    def run(self, until: float = math.inf, collisions: int | None = None, changes: int | None = None) -> None:
        """As `Naive.run`."""
        while changes is None or len(self.trace) < changes:
            before = len(self.trace)
            super().run(until, collisions, before + 1)
            if len(self.trace) == before:
                return
            _, x, v, spins = self.state()
            after = np.zeros((1, 2, 9))
            for place, i in enumerate(self.trace[-1][1:]):
                if i >= 0:
                    after[0, place, : self.dimension] = x[i]
                    after[0, place, 3 : 3 + self.dimension] = v[i]
                    if spins is not None:
                        after[0, place, 6 if self.dimension == 3 else 8 :] = spins[i]
            self._after.append(after)

    def traced_states(self) -> Floats:
        """As `Simulation.traced_states`."""
        return np.concatenate(self._after)


def _trace(scene: Scene, sim: Any, origin: Floats, begin: float) -> dict[str, Floats]:
    """The observables of `output.trace`. origin: of the domain. begin: time of the start of the run."""
    d, rows = scene.dimension, sim.trace if isinstance(sim, Naive) else sim.trace()
    traced, states = np.array(rows, dtype=np.float64).reshape(-1, 3), sim.traced_states()
    partners = traced[:, 1:]
    # faces are numbered as if in space, the cylinder is the last one that there is
    partners[partners == -1 - CYLINDER_FACE] = -1 - 2 * d
    shift = np.where(partners[..., None] >= 0, origin, 0.0)
    found = {
        "event_times": traced[:, 0] - begin,
        "event_partners": partners,
        "event_positions": states[..., :d] + shift,
        "event_velocities": states[..., 3 : 3 + d],
    }
    if scene.spin_dimension:
        found["event_angular_velocities"] = states[..., 8:] if d == 2 else states[..., 6:]
    return found


def _record(run: Run, sample: int, sim: Any, origin: Floats, tallied: bool, before: _Counts | None = None) -> _Counts:
    """Writes the observables at a sample; returns the counts at it.

    tallied: the simulation keeps cumulative sums, and they are written too. before: the counts at the start; None: it
    is the start.
    """
    now = _Counts(sim.collisions, sim.events)
    first = before or now
    values: dict[str, Any] = {"contact_time": 0.0}
    if "positions" in run:
        state = sim.state()
        values |= {"positions": state.positions + origin, "velocities": state.velocities}
        values["angular_velocities"] = state.angular_velocities
    for name in (*_OF_STATES, "operation_counts"):
        if name in run:
            values[name] = getattr(sim, name)()
    if tallied:
        values |= sim.tallies()
    values |= {"collisions": now.collisions - first.collisions, "events": now.events - first.events}
    for name in values.keys() & run.keys():
        run[name][sample] = values[name]
    return now
