"""Extended XYZ: ASE's reader finds every number to the last bit."""

import tempfile
from dataclasses import replace
from pathlib import Path

import ase.io
import MDAnalysis
import numpy as np
import pytest
from ase.data import chemical_symbols
from hypothesis import given, settings
from trajectory_files import bits, trajectories

from crosscheck.trajectories.trajectory import Trajectory
from crosscheck.trajectories.writers.extxyz import FORMAT


def written(directory, trajectory):
    """The frames that ASE reads. Quantities that the format does not hold are left out, as `simulate` does."""
    path = Path(directory) / "a.extxyz"
    held = {name: values for name, values in trajectory.more.items() if name in FORMAT.holds}
    FORMAT.write(path, replace(trajectory, more=held))
    return ase.io.read(path, ":")


@given(trajectories())
def test_every_number_reads_back_to_the_same_bits(trajectory):
    with tempfile.TemporaryDirectory() as directory:
        frames = written(directory, trajectory)
    assert len(frames) == len(trajectory.time)
    for k, frame in enumerate(frames):
        found = frame.arrays
        assert bits(found["positions"]) == bits(trajectory.positions[k])
        assert bits(found["masses"]) == bits(trajectory.masses)
        for name in ("velocities", "angular_velocities", "radius"):
            assert (name in found) == (name in trajectory.more)
        for name in ("velocities", "angular_velocities"):
            if name in found:
                assert bits(found[name]) == bits(trajectory.more[name][k])
        if "velocities" in found:
            with np.errstate(over="ignore"):
                momenta = trajectory.masses[:, None] * trajectory.more["velocities"][k]
            assert bits(found["momenta"]) == bits(momenta)
        if "radius" in found:
            assert bits(found["radius"]) == bits(trajectory.more["radius"])
        assert bits(frame.info["time"]) == bits(trajectory.time[k])
        assert bits(frame.cell) == bits(np.diag(trajectory.cell))
        assert frame.pbc.tolist() == trajectory.periodic.tolist()
        species = trajectory.species
        assert species_of(frame).tolist() == (len(frame) * [0] if species is None else species.tolist())


@given(trajectories())
@settings(max_examples=30)
def test_mdanalysis_finds_positions_in_single_precision(trajectory):
    """It knows plain XYZ, and leaves the other columns alone."""
    with tempfile.TemporaryDirectory() as directory, np.errstate(over="ignore", under="ignore"):
        written(directory, trajectory)
        universe = MDAnalysis.Universe(f"{directory}/a.extxyz", format="XYZ", topology_format="XYZ", to_guess=())
        assert len(universe.trajectory) == len(trajectory.time)
        for k, frame in enumerate(universe.trajectory):
            assert frame.positions.tobytes() == trajectory.positions[k].astype(np.float32).tobytes()


def test_ovito_finds_the_same_numbers_to_the_rounding_of_its_parser(tmp_path):
    ovito = pytest.importorskip("ovito.io", reason="needs the package ovito: pip install ovito")
    generator = np.random.default_rng(4)
    positions, velocities, spins = generator.normal(size=(3, 2, 5, 3))
    more = {"velocities": velocities, "angular_velocities": spins, "radius": np.full(5, 0.3)}
    trajectory = replace(atoms(5, samples=2), positions=positions, cell=np.array([3.0, 4.0, 5.0]), more=more)
    written(tmp_path, trajectory)
    frames = ovito.import_file(str(tmp_path / "a.extxyz"))
    assert frames.source.num_frames == 2
    for k in range(2):
        data = frames.compute(k)
        found = {name: np.array(values) for name, values in data.particles.items()}
        assert data.attributes["time"] == trajectory.time[k]
        expected = {"Position": positions[k], "velocities": velocities[k], "angular_velocities": spins[k]}
        expected |= {"masses": trajectory.masses}
        for name, values in expected.items():
            # measured: its parser of decimals is right to one unit in the last place
            assert found[name] == pytest.approx(values, rel=2 * 2**-52, abs=0), name
        assert bits(found["Radius"]) == bits(more["radius"].astype(np.float32))  # all that OVITO has
        assert np.diag(np.array(data.cell)[:, :3]).tolist() == [3, 4, 5]


def atoms(number, samples=1):
    """At the origin, at rest, in open space, each of its own species."""
    return Trajectory(
        time=0.25 * np.arange(samples),
        steps=np.arange(samples),
        positions=np.zeros((samples, number, 3)),
        dimension=3,
        cell=np.zeros(3),
        periodic=np.zeros(3, dtype=bool),
        walled=np.zeros((3, 2), dtype=bool),
        masses=np.arange(1.0, number + 1),
        species=np.arange(number),
        more={},
    )


def species_of(frame):
    """Species 0, 1 ... are H, He ...; X is of one species, or has a column of numbers."""
    if "species_number" in frame.arrays:
        assert set(frame.get_chemical_symbols()) == {"X"}
        return frame.arrays["species_number"]
    return np.maximum(frame.numbers - 1, 0)


def test_more_species_than_elements_have_numbers(tmp_path):
    many = atoms(len(chemical_symbols) + 1)
    assert species_of(written(tmp_path, many)[0]).tolist() == many.species.tolist()
    few = replace(many, species=many.species % (len(chemical_symbols) - 1))
    frame = written(tmp_path, few)[0]
    assert "species_number" not in frame.arrays
    assert frame.get_chemical_symbols()[:3] == ["H", "He", "Li"]
    assert species_of(frame).tolist() == few.species.tolist()
