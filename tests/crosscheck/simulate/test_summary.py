"""What is said of runs: drift, momentum, endings, and how far two runs are apart."""

import numpy as np
import pytest
from hard_disks import EVENTS, disks, fall

from crosscheck.engines.protocol import Cost, Run
from crosscheck.scene import Box, Explicit, Gravity, HardSpheres, Lattice, LennardJones, Method, Output, Scene, Spring
from crosscheck.simulate.observables import Result, observables
from crosscheck.simulate.summary import compare, endings, row


def result_of(scene, run, name="refimpl"):
    return Result(name, "1", run, observables(scene, run))


def test_steps_and_their_cost():
    scene = disks()
    run = fall(scene, kinetic_energy=np.ones(3), cost=Cost(cpu=2.0, wall=3.0, steps=1000, events=500))
    one = row(scene, EVENTS, result_of(scene, run), "event_driven")
    assert (one.work, one.cpu, one.speed, one.each) == (
        "500 events", 2.0, 250.0, "4 ms/event",
    )  # fmt: skip
    one = row(scene, EVENTS, result_of(scene, run), "collision_search")
    assert (one.work, one.speed, one.each) == ("1000 steps", 500.0, "667 us/(particle step)")


def test_conserved_energy_has_a_drift_and_other_energies_a_reason():
    energy = np.array([2.0, 2.0 + 4e-6, 2.0 - 2e-6])
    scene = disks()
    assert row(scene, EVENTS, result_of(scene, fall(scene, kinetic_energy=energy)), "event_driven").energy == (
        "drift 2.0e-06"
    )
    grains = disks(hard_spheres=HardSpheres(restitution=0.5))
    run = fall(grains, kinetic_energy=np.array([2.0, 1.0, 0.5]))
    assert row(grains, EVENTS, result_of(grains, run), "event_driven").energy == "2 -> 0.5 (hard_spheres.restitution)"
    bare = disks(output=Output(interval=1.0, trajectory=True))
    assert row(bare, EVENTS, result_of(bare, fall(bare)), "event_driven").energy == "not recorded"
    # without the potential energy, that of falling disks is not known
    fallen = disks(acceleration=(0.0, -1.0))
    assert row(fallen, EVENTS, result_of(fallen, fall(fallen, kinetic_energy=energy)), "event_driven").energy == (
        "not recorded"
    )


@pytest.mark.parametrize("change", [1e-9, 0.25])
def test_momentum_relative_to_that_of_all_particles(change):
    scene = disks(box=Box(lengths=(6.0, 5.0)))
    run = fall(scene)
    run["final_velocities"] = run["final_velocities"] + np.array([[0.0, 0.0], [change, 0.0], [0.0, 0.0]])
    one = row(scene, EVENTS, result_of(scene, Run(run, kinetic_energy=np.ones(3))), "event_driven")
    assert float(one.momentum) == pytest.approx(change / 2.9, rel=0.05)
    walled = disks(box=Box(lengths=(6.0, 5.0), boundaries=("hard", "periodic")),
                   initial=Explicit(positions=((1.0, 1.0),), velocities=((1.0, 0.0),)))  # fmt: skip
    run = fall(walled, kinetic_energy=np.ones(3))
    assert row(walled, EVENTS, result_of(walled, run), "event_driven").momentum == "0.0e+00 (box.boundaries=hard)"


def test_a_run_that_stopped_says_why():
    scene = disks()
    run = Run(fall(scene, kinetic_energy=np.ones(3)), stopped="inelastic collapse of particles 1 and 2 at t = 0.5")
    result = result_of(scene, run)
    assert endings(scene, result) == [
        "refimpl: stopped: inelastic collapse of particles 1 and 2 at t = 0.5; the scene's duration is 2"
    ]
    assert row(scene, EVENTS, result, "event_driven").end == "stopped"


def test_a_run_that_diverged_says_when_and_which_particles():
    scene = disks()
    run = fall(scene, kinetic_energy=np.ones(3))
    run["positions"] = run["positions"].copy()
    run["positions"][2, [0, 2]] = np.nan
    assert endings(scene, result_of(scene, Run(run, diverged=True))) == [
        "refimpl: diverged after t = 1: not finite at t = 2 (2 of 3 particles: 0, 2)"
    ]
    alone = {"time": run["time"], "kinetic_energy": np.ones(3)}
    lost = Run(alone, final_positions=np.full((3, 2), np.inf), final_velocities=np.zeros((3, 2)), diverged=True)
    text = endings(scene.changed(output=Output(interval=1.0)), Result("e", "1", lost, {}))[0]
    assert text.startswith("e: diverged before its end at t = 2")
    assert text.endswith("(3 of 3 particles: 0, 1, 2)")


def test_remarks_of_an_engine_are_repeated():
    scene = disks()
    run = Run(fall(scene, kinetic_energy=np.ones(3)), remarks=["24 events at one time."])
    assert endings(scene, result_of(scene, run, "other")) == ["other: 24 events at one time."]


def test_differences_of_each_pair_and_when_they_passed():
    scene = disks(hard_spheres=HardSpheres(diameter=0.5))
    ones = fall(scene, kinetic_energy=np.array([2.0, 2.0, 2.0]))
    others = fall(scene, kinetic_energy=np.array([2.0, 2.0 + 1e-6, 2.0 + 1e-3]))
    others["positions"] = others["positions"] + np.array([0.0, 1e-6, 1.0])[:, None, None] * np.array([0.6, 0.8])
    results = [result_of(scene, ones, "a"), result_of(scene, others, "b"), result_of(scene, ones, "c")]
    found = compare(scene, results)
    assert [(one.engines, one.what) for one in found] == [
        (("a", "b"), "position"), (("a", "b"), "kinetic energy"), (("a", "c"), "position"),
        (("a", "c"), "kinetic energy"), (("b", "c"), "position"), (("b", "c"), "kinetic energy"),
    ]  # fmt: skip
    position, energy = found[:2]
    assert position.unit == "largest diameter"
    assert position.largest == pytest.approx(2.0)
    assert position.passed == (1.0, 2.0, 2.0)
    assert energy.largest == pytest.approx(5e-4)
    assert energy.passed == (1.0, 2.0, None)
    assert found[2].passed == (None, None, None)


def test_without_trajectories_the_ends_are_compared():
    scene = Scene(
        name="two",
        dimension=1,
        duration=3.0,
        gravity=Gravity(),
        initial=Explicit(positions=((0.0,), (4.0,))),
        output=Output(),
    )
    ends = [np.array([[0.0], [4.0]]), np.array([[0.0], [4.4]])]
    runs = [Run(time=np.array([0.0]), final_positions=end, final_velocities=0 * end) for end in ends]
    (one,) = compare(
        scene, [Result(name, "1", run, {"time": run["time"]}) for name, run in zip("ab", runs, strict=True)]
    )
    assert (one.what, one.unit) == ("position at the end", "extent at the start")
    assert one.largest == pytest.approx(0.1)
    assert one.passed == (3.0, 3.0, None)


@pytest.mark.parametrize(
    ("scene", "unit"),
    [
        (
            Scene(
                name="fluid",
                dimension=2,
                duration=1.0,
                box=Box(lengths=(6.0, 6.0)),
                lennard_jones=LennardJones(cutoff=2.0, length=(1.0, 2.0)),
                species=(0, 1),
                initial=Lattice(kind="lattice", structure="square", number=2, temperature=1.0, seed=1),
            ),
            "largest sigma",
        ),
        (
            Scene(name="s", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=((3.0,),))),
            "distance from the origin at the start",
        ),
    ],
)
def test_the_length_is_named(scene, unit):
    state = scene.initial_state()
    run = Run(time=np.zeros(1), final_positions=state.positions, final_velocities=state.velocities)
    (one,) = compare(scene, [Result(name, "1", run, {"time": run["time"]}) for name in "ab"])
    assert one.unit == unit
    assert row(scene, Method(scheme="x", dt=0.1), Result("a", "1", run, {}), "stepping").energy == "not recorded"
