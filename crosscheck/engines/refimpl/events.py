"""Scenes of hard spheres for the event-driven algorithms of `refimpl.events`."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numba import typeof

from crosscheck import scene as scenes
from crosscheck.engines.protocol import Run, tally_shapes, timed
from crosscheck.engines.workers.cache import one_at_a_time
from crosscheck.errors import UsageError
from crosscheck.scene import AXES, TALLIES, Floats, Scene, State
from refimpl.events import model as events
from refimpl.events.naive import Naive
from refimpl.events.simulation import Simulation
from refimpl.events.state import field_energy, kinetic_energies, rotational_energies, well_energy

#: Tallies that `Simulation` counts anyway, without being asked.
_COUNTED = ("collisions", "events", "rotational_energy", "operation_counts", "contact_time")


def run_events(scene: Scene, scheduler: Any) -> Run:
    """Runs a scene of hard spheres from event to event, with one of the schedulers of `refimpl.events`."""
    state = scene.initial_state()
    output, times = scene.output, scene.samples()
    origin, lengths = _domain(state)
    run = Run(times, state.positions, state.velocities)
    _allocate(run, scene)
    with _in_words(scene):
        model = hard_spheres(scene, state, lengths)
        started = time.perf_counter()
        with one_at_a_time(f"events {scheduler} {typeof(model)}"):
            start = (model, state.positions - origin, state.velocities, state.angular_velocities)
            sim: Any
            if scheduler == "naive":
                _Naive(*start).run(until=scene.duration, changes=1)  # compiles the rules of collisions
                sim = _Naive(*start)
            else:
                sim = Simulation(
                    *start,
                    scheduler=scheduler,
                    tallies=any(name in TALLIES and name not in _COUNTED for name in output.observables),
                    fields=output.fields,
                    counting="operation_counts" in output.observables,
                )
            _record(run, 0, sim, origin)
            sim.run(until=0.0)  # compiles the loop
        run.cost.compile = time.perf_counter() - started

    for sample, count in enumerate(output.collisions or (None,) * (times.size - 1), 1):
        with timed(run.cost):
            sim.run(until=times[sample] if count is None else scene.duration, collisions=count)
        if sim.stopped:
            break
        if count is not None and sim.collisions < count:
            run.stopped = f"the duration, {scene.duration:g}, is over before pair collision {count}"
            break
        times[sample] = sim.time
        _record(run, sample, sim, origin)
    if output.collisions is None:
        with timed(run.cost):
            sim.run(until=scene.duration)
    run.stopped = run.stopped or sim.stopped
    run.cost.events = sim.events

    final = sim.state()
    run.final_positions, run.final_velocities = final.positions + origin, final.velocities
    run.final_angular_velocities = final.angular_velocities
    if output.fields is not None:
        run.tallies |= sim.fields()
    height = 0.0 if scene.acceleration is None else float(state.masses.sum() * (origin @ scene.acceleration))
    if run.potential_energy is not None:
        run.potential_energy -= height
    if "potential_energy_integral" in run.tallies:
        run.tallies["potential_energy_integral"] -= height * times
    return run


def hard_spheres(scene: Scene, state: State, lengths: Floats) -> Any:
    """The model of `refimpl.events` for a scene."""
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
    """The law of a contact; without friction, None."""
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
    """Origin and lengths of the cells: those of the box; in open space, about the particles."""
    if state.lengths is not None:
        return np.zeros_like(state.lengths), state.lengths
    assert state.diameters is not None
    extent = np.ptp(state.positions, axis=0)
    least = float(state.diameters.max()) or float(extent.max()) or 1.0
    return state.positions.min(axis=0), np.maximum(extent, least)


@contextmanager
def _in_words(scene: Scene) -> Iterator[None]:
    """A ValueError of `refimpl.events` is about the scene."""
    try:
        yield
    except ValueError as error:
        raise UsageError(f"scene {scene.name}: {error}") from None


class _Naive(Naive):
    """Algorithm v1.0 with the measurements of `Simulation` that need no more than the state."""

    stopped = ""

    @property
    def events(self) -> int:
        """Changes of state: it has no others."""
        return len(self.trace)

    def kinetic_energy(self) -> float:
        return float(kinetic_energies(self.model, self.state()).sum())

    def rotational_energy(self) -> float:
        return float(rotational_energies(self.model, self.state().angular_velocities, self.number).sum())

    def potential_energy(self) -> float:
        return field_energy(self.model, self.state().positions) + well_energy(self.model, self._bonds)


def _allocate(run: Run, scene: Scene) -> None:
    """Arrays of NaN for all that the scene records."""
    output, samples = scene.output, run.time.size
    if output.trajectory:
        shape = (samples, scene.number, scene.dimension)
        run.positions, run.velocities = np.full(shape, np.nan), np.full(shape, np.nan)
        if scene.spin_dimension:
            run.angular_velocities = np.full((samples, scene.number, scene.spin_dimension), np.nan)
    for name in ("kinetic_energy", "potential_energy"):
        if name in output.observables:
            setattr(run, name, np.full(samples, np.nan))
    shapes = tally_shapes(scene, samples)
    run.tallies = {name: np.full(shape, np.nan) for name, shape in shapes.items() if name in TALLIES}


def _record(run: Run, sample: int, sim: Any, origin: Floats) -> None:
    if run.positions is not None and run.velocities is not None:
        state = sim.state()
        run.positions[sample], run.velocities[sample] = state.positions + origin, state.velocities
        if run.angular_velocities is not None:
            run.angular_velocities[sample] = state.angular_velocities
    if run.kinetic_energy is not None:
        run.kinetic_energy[sample] = sim.kinetic_energy()
    if run.potential_energy is not None:
        run.potential_energy[sample] = sim.potential_energy()
    asked = set(run.tallies)
    measured = sim.tallies() if asked - set(_COUNTED) else {}
    if "operation_counts" in asked:
        measured["operation_counts"] = sim.operation_counts()
    if "rotational_energy" in asked:
        measured["rotational_energy"] = sim.rotational_energy()
    measured |= {"collisions": sim.collisions, "events": sim.events, "contact_time": 0.0}
    for name, values in run.tallies.items():
        values[sample] = measured[name]
