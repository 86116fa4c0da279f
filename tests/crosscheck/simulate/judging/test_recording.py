"""What a run records so that it can be judged, and durations that several time steps divide."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.scene import Box, Explicit, HardSpheres, Lattice, Method, Output, Scene, Spring
from crosscheck.simulate.judging.judge import observables_needed
from crosscheck.simulate.judging.recording import common_multiple, in_steps, recording
from crosscheck.simulate.methods import planned

SPRING = Scene(
    name="s", dimension=2, duration=3.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0, 0.0),)),
    method=Method(scheme="verlet", dt=0.125),
)  # fmt: skip


def recorded(scene, engines=("refimpl",), methods=()):
    return recording(planned(scene, engines, methods), observables_needed())


def test_a_scene_that_records_nothing_is_sampled_at_whole_steps_of_all():
    runs = recorded(SPRING, ["refimpl"], ["refimpl:scheme=verlet,dt=0.125", "refimpl:scheme=leapfrog,dt=0.1"])
    assert [run.scene.output.interval for run in runs] == [0.5, 0.5]
    assert [run.scene.output.observables for run in runs] == [("kinetic_energy", "potential_energy", "virial")] * 2
    assert all(run.scene.output.trajectory for run in runs)


def test_what_the_user_asks_for_stays():
    asked = Output(interval=0.25, observables=("virial",), forces=True)
    (one,) = recorded(SPRING.changed(output=asked))
    assert one.scene.output == asked.model_copy(
        update={"observables": ("virial", "kinetic_energy", "potential_energy"), "trajectory": True}
    )


def test_what_an_engine_does_not_measure_or_a_scene_does_not_have_is_left_out():
    gas = Scene(
        name="g", dimension=2, duration=1.0, hard_spheres=HardSpheres(), box=Box(lengths=(6.0, 6.0)),
        initial=Lattice(kind="lattice", structure="square", number=9, temperature=1.0, seed=1),
    )  # fmt: skip
    whole, naive, search = recorded(
        gas, ["refimpl", "rebound"],
        ["refimpl:scheme=event_driven", "refimpl:scheme=event_driven_naive", "rebound:scheme=collisions_direct,dt=0.1"],
    )  # fmt: skip
    assert {"dissipated_energy", "wall_impulse", "collisional_virial"} <= set(whole.scene.output.observables)
    assert not {"rotational_energy", "wall_torque"} & set(whole.scene.output.observables)
    assert set(naive.scene.output.observables) <= {"kinetic_energy", "potential_energy", "events", "collisions"}
    assert set(search.scene.output.observables) == {"kinetic_energy", "collisions"}


def test_a_trajectory_that_is_too_large_is_left_out(monkeypatch):
    monkeypatch.setattr("crosscheck.simulate.judging.recording.MOST_BYTES", 100)
    assert not recorded(SPRING)[0].scene.output.trajectory
    asked = SPRING.changed(output=Output(interval=1.0, trajectory=True))
    assert recorded(asked)[0].scene.output.trajectory


@given(st.lists(st.fractions(Fraction(1, 40), 1, max_denominator=40), min_size=1, max_size=3), st.integers(1, 60))
def test_durations_and_intervals_are_whole_numbers_of_steps(steps, most):
    """The least common multiple of fractions, against floats."""
    found = common_multiple([float(dt) for dt in steps])
    exact = steps[0]
    for dt in steps[1:]:
        quotient = exact / dt
        exact *= quotient.denominator
    if exact <= 4096 * max(steps):
        assert found == pytest.approx(float(exact), rel=1e-12)
    fits = in_steps(50.0, [float(dt) for dt in steps], most)
    assert (fits is None) == (found is None or found > 50)
    if fits is not None:
        duration, interval = fits
        assert duration <= 50.0 * (1 + 1e-9)
        for dt in steps:
            assert interval / float(dt) == pytest.approx(round(interval / float(dt)), rel=1e-9)
        assert duration / interval == pytest.approx(round(duration / interval), rel=1e-9)
        assert round(duration / interval) <= most


def test_steps_without_a_common_multiple():
    assert common_multiple([0.1, 0.1 * 2**0.5]) is None
    assert in_steps(1.0, []) == (1.0, 0.005)
