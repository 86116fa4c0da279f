"""Scenes of hard spheres on `refimpl.events`: what is handed over, and runs whose outcome is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from refusals import refused

from crosscheck.checks.base import schemes_with
from crosscheck.engines.refimpl import events as refimpl_events
from crosscheck.engines.refimpl.engine import RefimplEngine
from crosscheck.engines.refimpl.events import hard_spheres, run_events
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import UsageError
from crosscheck.references.event_audit import audit
from crosscheck.scene import (
    Box,
    Cylinder,
    Explicit,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Method,
    Oscillation,
    Output,
    RandomPhase,
    Scene,
    Spring,
    Well,
)
from refimpl.events import model as events
from refimpl.events.state import Simultaneous, State

EVENTS = Method(scheme="event_driven")
NAIVE = Method(scheme="event_driven_naive")


def disks(**changes: Any) -> Scene:
    entries: dict[str, Any] = {
        "name": "disks",
        "dimension": 2,
        "duration": 4.0,
        "hard_spheres": HardSpheres(),
        "initial": Explicit(positions=((0.0, 0.0), (3.0, 0.0)), velocities=((1.0, 0.0), (0.0, 0.0))),
    }
    return Scene(**(entries | changes))


# -- what is handed over ----------------------------------------------------------------------------------


def model_of(scene: Scene) -> Any:
    state = scene.initial_state()
    return hard_spheres(scene, state, np.full(scene.dimension, 10.0) if state.lengths is None else state.lengths)


def assert_same(one: Any, other: Any) -> None:
    assert type(one) is type(other)
    if isinstance(one, tuple):
        for this, that in zip(one, other, strict=True):
            assert_same(this, that)
    else:
        np.testing.assert_array_equal(one, other)


def test_absent_means_not_there() -> None:
    assert_same(model_of(disks()), events.hard_spheres(lengths=(10.0, 10.0), periodic=(False, False)))


def test_particles_and_laws() -> None:
    grains = GrainFriction(tangential_restitution=-0.5, static=0.5, sliding=0.4, inertia=0.3)
    scene = disks(
        species=(0, 1),
        masses=(2.0, 3.0),
        acceleration=(0.5, -1.0),
        hard_spheres=HardSpheres(
            diameter=(1.0, 2.0),
            restitution=0.9,
            contact_duration=1e-3,
            friction=grains,
            well=Well(depth=2.0, range=1.5),
        ),
        box=Box(lengths=(9.0, 9.0), boundaries=("periodic", "open")),
    )
    expected = events.hard_spheres(
        lengths=(9.0, 9.0),
        periodic=(True, False),
        diameters=[1.0, 2.0],
        masses=[2.0, 3.0],
        restitution=0.9,
        friction=events.Friction(-0.5, 0.5, 0.4, 0.3),
        acceleration=(0.5, -1.0),
        well=events.Well(2.0, 1.5),
        contact_duration=1e-3,
    )
    assert_same(model_of(scene), expected)


def test_fixed_particles_have_infinite_mass() -> None:
    scene = disks(species=(0, 1), masses=2.0, hard_spheres=HardSpheres(fixed=(1,)))
    expected = events.hard_spheres(lengths=(10.0, 10.0), periodic=(False, False), masses=[2.0, math.inf])
    assert_same(model_of(scene), expected)


def test_faces() -> None:
    faces = {
        "x-": Face(oscillation=Oscillation(amplitude=0.1, frequency=10.0, phase=2.0)),
        "x+": Face(open=True),
        "y-": Face(random_phase=RandomPhase(speed=2.0, law="uniform"), restitution=0.8),
        "z-": Face(velocity=1.0, friction=Friction(tangential_restitution=0.0)),
        "z+": Face(temperature=2.0),
    }
    scene = disks(
        dimension=3,
        seed=7,
        hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0, static=0.2, sliding=0.2)),
        box=Box(lengths=(9.0,) * 3, boundaries=("hard",) * 3, faces=faces),
        initial=Explicit(positions=((4.0, 4.0, 4.0),)),
    )
    expected = events.hard_spheres(
        lengths=(9.0,) * 3,
        periodic=(False,) * 3,
        friction=events.Friction(0.0, 0.2, 0.2),
        faces=(
            events.Face(oscillation=events.Oscillation(0.1, 10.0, 2.0)),
            None,
            events.Face(0.8, random_phase=events.RandomPhase(2.0, "uniform")),
            events.Face(),
            events.Face(velocity=1.0, friction=events.Friction(0.0)),
            events.Face(temperature=2.0),
        ),
        seed=7,
    )
    assert_same(model_of(scene), expected)


@pytest.mark.parametrize(("axis", "number"), [("x", 0), ("z", 2)])
def test_cylinder(axis: Any, number: int) -> None:
    grains = GrainFriction(tangential_restitution=0.0)
    rough = Friction(tangential_restitution=0.5, static=0.3, sliding=0.2)
    scene = disks(
        dimension=3,
        hard_spheres=HardSpheres(friction=grains),
        box=Box(
            lengths=(9.0,) * 3,
            boundaries=("open",) * 3,
            cylinder=Cylinder(radius=4.0, axis=axis, angular_velocity=0.3, restitution=0.7, friction=rough),
        ),
        initial=Explicit(positions=((4.0, 4.0, 4.0),)),
    )
    expected = events.hard_spheres(
        lengths=(9.0,) * 3,
        periodic=(False,) * 3,
        friction=events.Friction(0.0),
        cylinder=events.Cylinder(4.0, number, 0.3, 0.7, events.Friction(0.5, 0.3, 0.2)),
    )
    assert_same(model_of(scene), expected)


def test_the_seed_is_the_scene_s_or_the_lattice_s() -> None:
    lattice = Lattice(kind="lattice", structure="square", number=4, speed=1.0, seed=5)
    box = Box(lengths=(9.0, 9.0), boundaries=("hard", "hard"), faces={"x-": Face(temperature=1.0)})
    assert model_of(disks(box=box, initial=lattice)).seed == 5
    assert model_of(disks(box=box, initial=lattice, seed=6)).seed == 6


def test_what_the_engine_runs() -> None:
    engine = RefimplEngine()
    spring = Scene(name="a", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))
    assert refused(engine, disks(), EVENTS) is None
    assert "is for [hard_spheres], not for [spring]" in (refused(engine, spring, EVENTS) or "")
    assert "hard spheres need an event-driven scheme" in (
        refused(engine, disks(), Method(scheme="verlet", dt=0.1)) or ""
    )
    measured = disks(output=Output(interval=1.0, observables=("wall_energy",)))
    assert "declares no wall_energy" in (refused(engine, measured, NAIVE) or "")
    assert not any(one.name.startswith("event_driven") for one in schemes_with()(engine.schemes))


# -- runs ---------------------------------------------------------------------------------------------------

LOW = HardSpheres(restitution=0.05)


def test_two_disks_that_meet(interpreted: Worker) -> None:
    output = Output(interval=1.0, observables=("kinetic_energy", "potential_energy", "collisions"), trajectory=True)
    run = interpreted.run(disks(hard_spheres=LOW, output=output), EVENTS)
    # contact at t = 2; then v_1 = (1 - alpha)/2, v_2 = (1 + alpha)/2
    np.testing.assert_array_equal(run["time"], [0, 1, 2, 3, 4])
    x = run["positions"][:, :, 0]
    np.testing.assert_allclose(x[:, 0], [0, 1, 2, 2.475, 2.95], rtol=1e-15)
    np.testing.assert_allclose(x[:, 1], [3, 3, 3, 3.525, 4.05], rtol=1e-15)
    np.testing.assert_allclose(run["kinetic_energy"][[0, 4]], [0.5, 0.25 * (1 + 0.05**2)], rtol=1e-15)
    np.testing.assert_array_equal(run["potential_energy"], np.zeros(5))
    np.testing.assert_array_equal(run["collisions"][[0, 4]], [0, 1])
    np.testing.assert_allclose(run["final_velocities"], [[0.475, 0], [0.525, 0]], rtol=1e-15)
    assert (run.stopped, run.cost.steps) == ("", 0)
    assert run.cost.events > 0


def test_samples_at_collisions(interpreted: Worker) -> None:
    scene = disks(hard_spheres=LOW, output=Output(collisions=(1, 2), trajectory=True))
    run = interpreted.run(scene, EVENTS)
    np.testing.assert_allclose(run["time"], [0, 2, np.nan], rtol=1e-15)
    np.testing.assert_allclose(run["velocities"][1, :, 0], [0.475, 0.525], rtol=1e-15)
    assert np.isnan(run["positions"][2]).all()
    assert run.stopped == "the duration, 4, is over before pair collision 2"
    np.testing.assert_allclose(run["final_positions"][:, 0], [2.95, 4.05], rtol=1e-15)
    reached = interpreted.run(scene.changed(output=Output(collisions=(1,))), EVENTS)
    assert reached.stopped == ""
    np.testing.assert_allclose(reached["final_positions"][:, 0], [2, 3], rtol=1e-15)


class Collapsing:
    """A simulation at rest that stops at t = 1.5."""

    def __init__(self, model: Any, positions: Any, velocities: Any, spins: Any, **more: Any) -> None:
        self.time, self.collisions, self.events, self.stopped = 0.0, 0, 0, ""
        self.simultaneous = Simultaneous(0, math.nan)
        self._state = (positions, velocities, spins)

    def run(self, until: float, collisions: int | None = None) -> None:
        self.time = min(until, 1.5)
        self.collisions, self.events = int(self.time), 7
        if until > 1.5:
            self.stopped = "inelastic collapse of particles 0 and 1 at t = 1.5"

    def state(self) -> State:
        return State(self.time, *self._state)

    def kinetic_energy(self) -> float:
        return self.time


@pytest.mark.parametrize(
    ("output", "times", "energies"),
    [
        ({"interval": 1.0}, [0, 1, 2, 3, 4], [0, 1, np.nan, np.nan, np.nan]),
        ({"collisions": (5, 6)}, [0, np.nan, np.nan], [0, np.nan, np.nan]),
    ],
)
def test_an_inelastic_collapse_is_told(
    monkeypatch: pytest.MonkeyPatch, output: dict[str, Any], times: list[float], energies: list[float]
) -> None:
    monkeypatch.setattr(refimpl_events, "Simulation", Collapsing)
    run = run_events(disks(output=Output(observables=("kinetic_energy",), **output)), "tree")
    assert run.stopped == "inelastic collapse of particles 0 and 1 at t = 1.5"
    np.testing.assert_array_equal(run["time"], times)
    np.testing.assert_array_equal(run["kinetic_energy"], energies)
    np.testing.assert_array_equal(run["final_positions"], [[0, 0], [3, 0]])
    assert run.cost.events == 7


def test_the_naive_algorithm_agrees_with_the_fast_one(interpreted: Worker) -> None:
    scene = disks(
        duration=3.0,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(restitution=0.9, friction=GrainFriction(tangential_restitution=0.5)),
        box=Box(lengths=(8.0, 12.0), boundaries=("periodic", "hard"), faces={"y-": Face(velocity=1.0)}),
        initial=Lattice(kind="lattice", structure="square", number=20, speed=1.0, seed=2),
        output=Output(
            interval=1.0,
            observables=("kinetic_energy", "potential_energy", "rotational_energy", "collisions"),
            trajectory=True,
        ),
    )
    fast, naive = (interpreted.run(scene, method) for method in (EVENTS, NAIVE))
    # some tens of collisions, each of which multiplies a rounding by about the mean free path in diameters
    for name in ("positions", "velocities", "angular_velocities", "kinetic_energy", "potential_energy"):
        np.testing.assert_allclose(naive[name], fast[name], atol=1e-6)
    np.testing.assert_array_equal(naive["collisions"], fast["collisions"])
    assert fast["collisions"][-1] > 20
    spins = fast["angular_velocities"][..., 0]
    np.testing.assert_allclose(fast["rotational_energy"], 0.5 * 0.5 * 0.25 * (spins**2).sum(axis=1), rtol=1e-13)
    translation = 0.5 * (fast["velocities"] ** 2).sum(axis=(1, 2))
    np.testing.assert_allclose(fast["kinetic_energy"], translation + fast["rotational_energy"], rtol=1e-13)
    np.testing.assert_allclose(fast["potential_energy"], fast["positions"][:, :, 1].sum(axis=1), rtol=1e-13)


def test_wells_count_in_the_energy_of_the_naive_algorithm(interpreted: Worker) -> None:
    scene = disks(
        duration=2.0,
        hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.5)),
        box=Box(lengths=(8.0, 8.0), boundaries=("periodic", "periodic")),
        initial=Lattice(kind="lattice", structure="square", number=20, temperature=1.0, seed=2),
        output=Output(interval=0.25, observables=("kinetic_energy", "potential_energy")),
    )
    run = interpreted.run(scene, NAIVE)
    assert len(set(run["potential_energy"])) > 2
    np.testing.assert_allclose(
        run["kinetic_energy"] + run["potential_energy"],
        run["kinetic_energy"][0] + run["potential_energy"][0],
        rtol=1e-13,
    )


def test_tallies_and_fields_balance(interpreted: Worker) -> None:
    names = ("wall_impulse", "wall_energy", "wall_collisions", "kinetic_energy_integral", "operation_counts", "events")
    scene = disks(
        duration=10.0,
        box=Box(
            lengths=(12.0, 9.0),
            boundaries=("hard", "periodic"),
            faces={"x-": Face(temperature=2.0), "x+": Face(temperature=1.0)},
        ),
        initial=Lattice(kind="lattice", structure="square", number=30, temperature=1.0, seed=3),
        output=Output(interval=2.0, observables=("kinetic_energy", *names), trajectory=True, fields=(4, 3)),
    )
    run = interpreted.run(scene, EVENTS)
    tallies = run
    momentum = run["velocities"].sum(axis=1)
    scale = np.abs(run["velocities"]).sum()
    np.testing.assert_allclose(tallies["wall_impulse"].sum(axis=1), momentum[0] - momentum, atol=1e-15 * scale)
    gained = run["kinetic_energy"] - run["kinetic_energy"][0]
    np.testing.assert_allclose(tallies["wall_energy"].sum(axis=1), gained, atol=1e-14 * run["kinetic_energy"].max())
    assert (tallies["wall_collisions"][-1, :2] > 0).all()
    assert not tallies["wall_collisions"][:, 2:].any()
    assert (np.diff(tallies["operation_counts"], axis=0) >= 0).all()
    # the mean of the exact integral lies within the range of the energy
    mean = tallies["kinetic_energy_integral"][-1] / 10
    assert 0.5 * run["kinetic_energy"].min() < mean < 2 * run["kinetic_energy"].max()
    assert tallies["field_mass"].shape == (4, 3)
    assert tallies["field_mass"].sum() == pytest.approx(30 * 10, rel=1e-12)
    assert tallies["field_kinetic"].sum() == pytest.approx(tallies["kinetic_energy_integral"][-1], rel=1e-12)
    np.testing.assert_allclose(tallies["field_final_momentum"].sum(axis=(0, 1)), momentum[-1], atol=1e-14 * scale)


def test_what_only_the_algorithm_can_tell_is_about_the_scene(interpreted: Worker) -> None:
    # cells for fields must not be smaller than a disk
    box = Box(lengths=(12.0, 9.0), boundaries=("hard", "hard"))
    lattice = Lattice(kind="lattice", structure="square", number=30, temperature=1.0, seed=3)
    scene = disks(box=box, initial=lattice, output=Output(fields=(13, 3)))
    with pytest.raises(UsageError, match=r"scene disks: fields: cells of side 0.923077 along axis 0 are smaller"):
        interpreted.run(scene, EVENTS)


# -- what a user must know --------------------------------------------------------------------------------


def ring(order: int) -> Scene:
    """24 beads at a distance of 3 that fly at a disk in their middle, one way round or the other."""
    angles = order * 2 * np.pi * np.arange(24) / 24
    way = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    start = Explicit(
        positions=((0.0, 0.0), *map(tuple, (3 * way).tolist())), velocities=((0.0, 0.0), *map(tuple, (-way).tolist()))
    )
    return disks(
        duration=10.0,
        masses=(10.0, *[1.0] * 24),
        species=(0, *[1] * 24),
        hard_spheres=HardSpheres(diameter=(4.0, 0.2)),
        initial=start,
        output=Output(interval=0.5, observables=("kinetic_energy", "collisions"), trajectory=True),
    )


@pytest.mark.parametrize("method", [EVENTS, NAIVE], ids=lambda method: method.scheme)
def test_simultaneous_events_of_one_particle_are_told(interpreted: Worker, method: Method) -> None:
    """The same ring in another order of the beads: another outcome, of which the run warns."""
    runs = [interpreted.run(ring(order), method) for order in (1, -1)]
    for run in runs:
        (remark,) = run.remarks
        assert "at the same time, within rounding, as another one of the same particle, the first at t = 0.9:" in remark
        assert int(remark.split()[0]) >= 23
        assert "depends on the order in which the particles are given, and so may all that follows." in remark
        assert run["kinetic_energy"][-1] == pytest.approx(12.0, rel=1e-12)
        assert not run.stopped
    assert np.abs(runs[0]["final_velocities"][0] - runs[1]["final_velocities"][0]).max() > 0.01


def test_an_ordinary_run_has_no_remarks(interpreted: Worker) -> None:
    assert not interpreted.run(disks(), EVENTS).remarks


def test_fields_of_one_cell_along_a_periodic_axis_have_what_collisions_carry_to_the_next_image(interpreted):
    scene = disks(
        duration=4.0,
        box=Box(lengths=(6.0, 4.0)),
        initial=Explicit(
            positions=((1.0, 0.6), (1.2, 3.2), (4.0, 3.3), (4.1, 0.7)),
            velocities=((0.0, -0.5), (0.0, 0.7), (0.1, 0.6), (0.0, -0.4)),
        ),
        output=Output(interval=1.0, trajectory=True, trace=True, observables=("collisions",), fields=(2, 1)),
    )
    run = interpreted.run(scene, EVENTS)
    assert run["collisions"][-1] >= 2
    found = audit(scene, run)
    assert found.good, found.where
    assert np.abs(run["field_flux_momentum"][1]).max() > 0.1
