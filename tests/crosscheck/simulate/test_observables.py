"""Columns that follow from a run, by their definitions, and the file that holds them."""

import math

import numpy as np
import pytest
from hard_disks import EVENTS, disks, fall

from crosscheck.engines.protocol import OPERATIONS, Run
from crosscheck.scene import Box, Explicit, Face, GrainFriction, HardSpheres, Lattice, LennardJones, Output, Scene
from crosscheck.simulate.observables import Result, observables, write_observables


def small_fluid(**lennard_jones):
    return Scene(
        name="fluid",
        dimension=3,
        duration=0.05,
        box=Box(lengths=(6.0, 6.0, 6.0)),
        lennard_jones=LennardJones(cutoff=2.5, **lennard_jones),
        initial=Lattice(kind="lattice", structure="fcc", number=108, temperature=1.0, seed=3),
        output=Output(interval=0.05, observables=("kinetic_energy", "potential_energy", "virial")),
    )


def run_of(scene, **arrays):
    zeros = np.zeros((scene.number, scene.dimension))
    return Run(
        {name: np.array([value]) for name, value in arrays.items()},
        time=np.zeros(1),
        final_positions=zeros,
        final_velocities=zeros,
    )


def test_observables_follow_their_definitions():
    scene = small_fluid()
    table = observables(scene, run_of(scene, kinetic_energy=160.5, potential_energy=-500.0, virial=-30.0))
    assert table["temperature"] == pytest.approx(2 * 160.5 / (3 * 107))
    assert table["pressure"] == pytest.approx((2 * 160.5 - 30) / (3 * 216))
    assert table["total_energy"] == pytest.approx(-339.5)


def test_tail_corrections_are_added():
    scene, plain = small_fluid(tail_corrections=True), small_fluid()
    values = {"kinetic_energy": 160.5, "potential_energy": -500.0, "virial": -30.0}
    with_tails, without = observables(scene, run_of(scene, **values)), observables(plain, run_of(plain, **values))
    rho, x = 108 / 216, 2.5**-3
    energy = 8 / 3 * math.pi * 108 * rho * (x**3 / 3 - x)
    pressure = 16 / 3 * math.pi * rho**2 * (2 * x**3 / 3 - x)
    assert with_tails["potential_energy"] - without["potential_energy"] == pytest.approx(energy)
    assert with_tails["pressure"] - without["pressure"] == pytest.approx(pressure)


def test_only_what_the_scene_records_is_there():
    scene = small_fluid().changed(output=Output(interval=0.05, observables=("kinetic_energy",)))
    assert list(observables(scene, run_of(scene, kinetic_energy=1.0))) == ["time", "kinetic_energy", "temperature"]


def test_observables_of_hard_spheres():
    scene = disks(initial=Lattice(kind="lattice", structure="square", number=12, temperature=1.0, seed=1))
    ones = np.ones(3)
    tallies = {"collisional_virial": 6 * ones, "kinetic_energy_integral": np.array([0.0, 5.0, 10.0])}
    asked = Output(interval=1.0, observables=("kinetic_energy", *tallies))
    table = observables(scene.changed(output=asked), fall(scene, kinetic_energy=5 * ones, **tallies))
    assert list(table) == ["time", "kinetic_energy", "temperature", "pressure", *tallies]
    assert table["temperature"] == pytest.approx(2 * 5 / (2 * 11))
    assert table["pressure"][1:] == pytest.approx([(2 * 5 + 6) / (2 * 30), (2 * 10 + 6) / (2 * 30 * 2)])
    assert np.isnan(table["pressure"][0])
    fallen = scene.changed(acceleration=(0.0, -1.0))
    assert observables(fallen, fall(fallen, kinetic_energy=5 * ones))["temperature"] == pytest.approx(2 * 5 / (2 * 12))


def test_the_temperature_of_grains_is_that_of_their_translation():
    scene = disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)))
    ones = np.ones(3)
    assert "temperature" not in observables(scene, fall(scene, kinetic_energy=ones))
    run = fall(scene, kinetic_energy=ones, rotational_energy=0.25 * ones)
    assert observables(scene, run)["temperature"] == pytest.approx(2 * 0.75 / (2 * 2))


def test_columns_of_tallies():
    names = ("wall_impulse", "wall_energy", "operation_counts")
    scene = disks(
        box=Box(lengths=(6.0, 5.0), boundaries=("periodic", "hard"), faces={"y+": Face(open=True)}),
        initial=Explicit(positions=((1.0, 1.0),)),
        output=Output(interval=1.0, observables=names),
    )
    numbers = np.arange(8.0).reshape(4, 2)
    tallies = {
        "wall_impulse": np.stack([numbers] * 3),
        "wall_energy": np.stack([numbers[:, 0]] * 3),
        "operation_counts": np.ones((3, 9)),
    }
    table = observables(scene, fall(scene, **tallies))
    assert list(table) == ["time", "wall_impulse[y-].x", "wall_impulse[y-].y", "wall_energy[y-]", *OPERATIONS]
    assert (table["wall_impulse[y-].y"] == 5).all()
    assert (table["wall_energy[y-]"] == 4).all()


def test_why_a_run_stopped_is_in_the_table(tmp_path):
    scene = disks()
    run = fall(scene, kinetic_energy=np.ones(3), stopped="inelastic collapse of particles 0 and 1 at t = 0.5")
    result = Result("refimpl", "1", run, observables(scene, run))
    text = write_observables(tmp_path / "o.csv", scene, EVENTS, result).read_text()
    assert "# the run stopped: inelastic collapse of particles 0 and 1 at t = 0.5\n" in text


def test_the_table_of_observables_names_columns_and_says_what_they_are(tmp_path):
    scene = disks(output=Output(interval=1.0, observables=("momentum", "collisions")))
    run = fall(scene, momentum=np.arange(6.0).reshape(3, 2), collisions=np.arange(3.0))
    result = Result("refimpl", "1", run, observables(scene, run))
    assert list(result.table) == ["time", "momentum.x", "momentum.y", "collisions"]
    text = write_observables(tmp_path / "o.csv", scene, EVENTS, result).read_text()
    assert "# momentum: sum of m v (unit: momentum)\n" in text
    assert "# collisions: number of collisions of pairs, since the start (unit: none)\n" in text


def test_a_name_that_is_not_utf8_is_kept_in_the_comments(tmp_path):
    """An engine in a file whose name holds a byte that is not UTF-8, or a line end."""
    scene = disks(name="\u03c3")
    run = fall(scene)
    result = Result("e\udcff\n.py:Class", "1", run, observables(scene, run))
    path = write_observables(tmp_path / "table.csv", scene, EVENTS, result)
    comments = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#")]
    assert comments[1].startswith("# e\\udcff\\n.py:Class 1, event_driven")
    assert np.loadtxt(path, delimiter=",", skiprows=len(comments) + 1).shape[0] == run["time"].size
