"""The auditor on a run of a right engine that shares nothing with `refimpl`, and on that run with one number wrong."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from event_scenes import scatter, thermal
from nearest_image import AllImages, Traced

from crosscheck.engines.protocol import Run, shapes
from crosscheck.references.event_audit import audit, reconstructed, with_trace
from crosscheck.scene import Box, Cylinder, Friction, GrainFriction, HardSpheres, Method, Output, Scene, explicit


@cache
def traced(interval=0.5):
    """Few unlike inelastic disks in a small periodic box, and a run with a trace."""
    rng = np.random.default_rng(5)
    sizes, lengths = (1.0, 0.8, 0.6, 0.9, 0.7), (2.6, 3.1)
    scene = Scene(
        name="disks",
        dimension=2,
        duration=3.0,
        hard_spheres=HardSpheres(diameter=sizes, restitution=0.9),
        masses=(1.0, 2.0, 0.7, 1.4, 3.0),
        species=tuple(range(5)),
        box=Box(lengths=lengths),
        initial=explicit(scatter(rng, lengths, (True, True), sizes, 5), thermal(rng, 5, 2)),
        output=Output(interval=interval, trajectory=True, trace=True),
    )
    return scene, Traced().run(scene, Method(scheme="events"))


def changed(name, change):
    scene, run = traced()
    arrays = {key: value.copy() for key, value in run.items()}
    change(arrays[name])
    return audit(scene, Run(arrays))


def test_a_right_run_is_rounding_throughout():
    scene, run = traced()
    found = audit(scene, run)
    assert found.good, found.where
    assert found.events == len(run["event_times"]) >= 15
    assert found.shares["contact"] > 0


def wrong(place, factor):
    def change(array):
        array[place] *= factor

    return change


@pytest.mark.parametrize(
    ("name", "place", "kind"),
    [
        ("event_times", 4, "free flight"),
        ("event_positions", (3, 1, 0), "free flight"),
        ("event_velocities", (6, 0, 1), "velocities after"),
        ("final_velocities", (2, 0), "final_velocities"),
        ("final_positions", (2, 1), "final_positions"),
        ("positions", (3, 1, 1), "positions"),
        ("velocities", (3, 1, 1), "velocities"),
    ],
)
def test_one_number_that_is_wrong_by_1e10_is_found(name, place, kind):
    found = changed(name, wrong(place, 1 + 1e-10))
    assert not found.good
    assert found.shares[kind] > 1


def test_a_partner_that_is_another_one_is_found():
    found = changed("event_partners", wrong((2, 0), -1.0))
    assert not found.good


@pytest.mark.parametrize("number", [0, 7, -1])
def test_an_event_that_was_missed_is_found(number):
    scene, run = traced()
    arrays = {
        key: np.delete(value, number, axis=0) if key.startswith("event_") else value for key, value in run.items()
    }
    assert not audit(scene, Run(arrays)).good


def test_the_last_flight_is_judged_too():
    """A run that stops to look for events shortly before its end."""
    scene, run = traced()
    last = float(run["event_times"][-1])
    short = scene.changed(duration=last + 1e-6, output=Output(trace=True))
    whole = Traced().run(short, Method(scheme="events"))
    state = {key: value[:-1] if key.startswith("event_") else value for key, value in whole.items()}
    found = audit(short, Run(state))
    assert found.shares["missed events"] > 1


def test_dense_samples_show_the_same_events_as_the_trace():
    scene, run = traced(0.002)
    events, unresolved = reconstructed(scene, AllImages().run(scene, Method(scheme="events")))
    assert not unresolved
    found = with_trace(run, events)
    assert found["event_times"] == pytest.approx(run["event_times"], abs=1e-11)
    assert [set(pair) for pair in found["event_partners"].tolist()] == [
        set(pair) for pair in run["event_partners"].tolist()
    ]


def test_a_trace_has_as_many_rows_as_the_run_decides():
    scene, _ = traced()
    found = shapes(scene, 7, 11)
    assert found["event_times"] == (11,)
    assert found["event_partners"] == (11, 2)
    assert found["event_velocities"] == (11, 2, 2)
    assert "event_angular_velocities" not in found


@pytest.fixture(scope="module")
def drum_until_collapse(interpreted):
    """One disk in a cylinder that takes half its normal velocity: it comes to slide along the wall in a finite time."""
    scene = Scene(
        name="drum",
        dimension=2,
        duration=20.0,
        hard_spheres=HardSpheres(diameter=1.0),
        box=Box(lengths=(4.0, 4.0), boundaries=("open", "open"), cylinder=Cylinder(radius=2.0, restitution=0.5)),
        initial=explicit(np.array([[2.6, 2.0]]), np.array([[0.3, 1.0]])),
        output=Output(observables=("collisions", "wall_collisions"), interval=1.0, trace=True),
    )
    return scene, interpreted.run(scene, Method(scheme="event_driven"))


def test_a_run_that_collapsed_is_audited_up_to_its_end(drum_until_collapse):
    scene, run = drum_until_collapse
    assert "collapse of particle 0 with a wall" in run.stopped
    found = audit(scene, run, collapsed=True)
    assert found.good, found.where
    assert found.events == len(run["event_times"]) > 20
    assert not audit(scene, run).good  # after it the disk goes through the wall


def test_a_collapse_that_is_none_is_found(drum_until_collapse):
    scene, run = drum_until_collapse
    early = {key: value[:5] if key.startswith("event_") else value for key, value in run.items()}
    assert audit(scene, Run(early), collapsed=True).shares["end of the run"] > 1


@pytest.mark.parametrize(("approach", "right"), [(0.0, True), (1e-16, True), (-1e-16, True), (1e-6, False)])
def test_what_slides_along_a_rough_wall_may_be_left_alone_where_rounding_says_whether_it_approaches(approach, right):
    """A disk on a drum's wall, sliding, and an event that changes nothing: friction would, however small the impact."""
    cylinder = Cylinder(radius=2.0, friction=Friction(tangential_restitution=0.3))
    start, velocity = np.array([[3.5, 2.0]]), np.array([[approach, 1.0]])
    scene = Scene(
        name="slides",
        dimension=2,
        duration=1e-9,
        hard_spheres=HardSpheres(diameter=1.0, friction=GrainFriction(tangential_restitution=0.3)),
        box=Box(lengths=(4.0, 4.0), boundaries=("open", "open"), cylinder=cylinder),
        initial=explicit(start, velocity),
        output=Output(trace=True),
    )
    end, still = start + velocity * scene.duration, np.zeros((1, 1))
    run = {
        "time": np.array([scene.duration]),
        "final_positions": end,
        "final_velocities": velocity,
        "final_angular_velocities": still,
    }
    nobody = np.zeros((1, 1, 2))
    event = {
        "event_times": np.zeros(1),
        "event_partners": np.array([[0.0, -5.0]]),
        "event_positions": np.concatenate([start[None], nobody], axis=1),
        "event_velocities": np.concatenate([velocity[None], nobody], axis=1),
        "event_angular_velocities": np.zeros((1, 2, 1)),
    }
    found = audit(scene, run | event)
    assert found.good == right, found.where
