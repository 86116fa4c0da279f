"""GSD: HOOMD's chunks in single precision, and the log, which loses nothing."""

import tempfile
from dataclasses import replace
from pathlib import Path

import gsd.fl
import gsd.hoomd
import MDAnalysis
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from trajectory_files import SINGLE, bits, trajectories

from crosscheck.trajectories.trajectory import Trajectory, box_around
from crosscheck.trajectories.writers.gsd import FORMAT, wrapped


def written(directory, trajectory):
    """The path of the file."""
    path = Path(directory) / f"a.{FORMAT.suffix}"
    FORMAT.write(path, trajectory)
    return path


@given(trajectories())
def test_the_log_has_every_number_to_the_last_bit(trajectory):
    with tempfile.TemporaryDirectory() as directory, gsd.hoomd.open(str(written(directory, trajectory))) as frames:
        found = list(frames)
    assert [frame.configuration.step for frame in found] == trajectory.steps.tolist()
    box = box_around(trajectory)
    for k, frame in enumerate(found):
        log = frame.log
        assert all(values.dtype == np.float64 for values in log.values())
        assert bits(log["time"]) == bits(trajectory.time[k])
        assert bits(log["particles/positions"]) == bits(trajectory.positions[k])
        assert bits(log["particles/masses"]) == bits(trajectory.masses)
        assert bits(log["cell"]) == bits(trajectory.cell)
        assert bits(log["box_lower"]) == bits(box[:, 0])
        for name in ("velocities", "angular_velocities", "radius", "moment_of_inertia"):
            assert (f"particles/{name}" in log) == (name in trajectory.more)
            if name in trajectory.more:
                values = trajectory.more[name]
                assert bits(log[f"particles/{name}"]) == bits(values if values.ndim == 1 else values[k])


@given(trajectories())
def test_the_chunks_of_hoomd_are_the_numbers_in_single_precision(trajectory):
    with tempfile.TemporaryDirectory() as directory, gsd.hoomd.open(str(written(directory, trajectory))) as frames:
        assert frames.file.schema_version == (1, 4)
        found = list(frames)
    n = len(trajectory.masses)
    box = box_around(trajectory)
    species = np.zeros(n, dtype=np.int64) if trajectory.species is None else trajectory.species
    with np.errstate(over="ignore", under="ignore"):
        sides = (box[:, 1] - box[:, 0]).astype(np.float32)
        for k, frame in enumerate(found):
            particles = frame.particles
            assert frame.configuration.dimensions == max(2, trajectory.dimension)
            assert frame.configuration.box.tolist() == [*sides.tolist(), 0, 0, 0]
            assert particles.position.dtype == np.float32
            assert [int(particles.types[kind]) for kind in particles.typeid] == species.tolist()
            assert particles.mass.tobytes() == trajectory.masses.astype(np.float32).tobytes()
            diameter = 2 * trajectory.more.get("radius", np.full(n, 0.5))
            assert particles.diameter.tobytes() == diameter.astype(np.float32).tobytes()
            velocities = trajectory.more.get("velocities", np.zeros((len(found), n, 3)))[k]
            assert particles.velocity.astype(np.float32).tolist() == velocities.astype(np.float32).tolist()
            assert particles.orientation.tolist() == [[1, 0, 0, 0]] * n


def points(**more):
    """Three disks in a plane, periodic along x, which rotate."""
    generator = np.random.default_rng(2)
    positions, velocities, spins = generator.normal(size=(3, 3, 3, 3))
    positions[..., 2] = velocities[..., 2] = 0
    spins[..., :2] = 0
    entries = {
        "time": 0.1 * np.arange(3),
        "steps": 7 * np.arange(3),
        "positions": positions * [40.0, 1.0, 1.0],
        "dimension": 2,
        "cell": np.array([7.0, 5.0, 0.0]),
        "periodic": np.array([True, False, False]),
        "walled": np.zeros((3, 2), dtype=bool),
        "masses": np.array([1.0, 2.0, 3.0]),
        "species": np.array([5, 0, 5]),
        "more": {
            "velocities": velocities,
            "angular_velocities": spins,
            "radius": np.array([0.5, 0.5, 0.5]),
            "moment_of_inertia": np.array([0.1, 0.2, 0.3]),
        },
    }
    return Trajectory(**(entries | more))


def product(a, b):
    """Of quaternions (..., 4), the scalar first (Hamilton)."""
    scalar = a[..., 0] * b[..., 0] - (a[..., 1:] * b[..., 1:]).sum(axis=-1)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar[..., None], vector], axis=-1)


@pytest.mark.parametrize("dimension", [2, 3])
def test_angular_momenta_are_those_of_hoomd(tmp_path, dimension):
    """Its angular momentum in the frame of the particle is S = conj(q) p/2, and that is I omega."""
    disks = points(dimension=dimension)
    with gsd.hoomd.open(str(written(tmp_path, disks))) as frames:
        for k, frame in enumerate(frames):
            q, momentum = frame.particles.orientation, frame.particles.angmom
            momentum_of_body = product(q * [1, -1, -1, -1], momentum) / 2
            moments = frame.particles.moment_inertia
            used = [False, False, True] if dimension == 2 else [True] * 3
            assert moments.tolist() == [[np.float32(i) * one for one in used] for i in (0.1, 0.2, 0.3)]
            assert momentum_of_body[:, 0].tolist() == [0, 0, 0]
            expected = moments * disks.more["angular_velocities"][k]
            assert momentum_of_body[:, 1:] == pytest.approx(expected, rel=4 * 2**-23, abs=0)


ONCE = {
    "configuration/box", "configuration/dimensions", "particles/N", "particles/types", "particles/typeid",
    "particles/mass", "particles/diameter", "particles/moment_inertia", "log/particles/masses", "log/particles/radius",
    "log/particles/moment_of_inertia", "log/box_lower", "log/box_sides", "log/cell",
}  # fmt: skip
ALWAYS = {
    "configuration/step", "particles/position", "particles/image", "particles/velocity", "particles/angmom",
    "log/particles/positions", "log/particles/velocities", "log/particles/angular_velocities", "log/time",
}  # fmt: skip


@pytest.mark.parametrize("value", [0.3, 1.0, 0.0])
def test_what_does_not_change_is_written_once_and_what_is_a_default_of_hoomd_too(tmp_path, value):
    """HOOMD's default of diameters and masses is 1, that of all else 0; other readers have other ones, or none."""
    disks = points()
    more = {name: np.full_like(values, value / 2) for name, values in disks.more.items()}
    disks = replace(disks, masses=np.full(3, value), positions=np.full((3, 3, 3), value), more=more, species=None)
    with gsd.fl.open(str(written(tmp_path, disks)), "r") as file:
        names = [set(filter(lambda name, k=k: file.chunk_exists(k, name), ONCE | ALWAYS)) for k in range(3)]
        assert set(file.find_matching_chunk_names("")) == ONCE | ALWAYS
        assert names == [ONCE | ALWAYS, ALWAYS, ALWAYS]
        assert file.read_chunk(0, "particles/diameter").tolist() == [np.float32(value)] * 3


@given(
    positions=arrays(np.float64, (4, 3), elements=st.floats(-1e6, 1e6) | st.floats(-1e-9, 1e-9)),
    lower=arrays(np.float64, 3, elements=st.floats(-100, 100)),
    sides=arrays(np.float64, 3, elements=st.floats(0.5, 100)),
    periodic=arrays(np.bool_, 3),
)
@settings(max_examples=200)
def test_wrapped_positions_and_their_images_are_the_positions(positions, lower, sides, periodic):
    found, images = wrapped(positions, lower, sides, periodic)
    half = (sides / 2).astype(np.float32)
    assert ((-half <= found) & (found < half))[:, periodic].all()
    assert not images[:, ~periodic].any()
    again = found.astype(np.float64) + images * sides + lower + sides / 2
    # single precision of what is in the file, and double precision of what was wrapped
    rounding = 2**-24 * np.where(periodic, sides, np.abs(positions - lower) + sides) + 2**-51 * np.abs(positions)
    assert (np.abs(again - positions) <= rounding).all()


def test_an_image_beyond_32_bits_is_the_largest():
    far = np.array([[1e300, -1e300, 3e9]])
    _, images = wrapped(far, np.zeros(3), np.ones(3), np.ones(3, dtype=bool))
    assert images.tolist() == [[2**31 - 1, 1 - 2**31, 2**31 - 1]]


@given(trajectories(sizes=SINGLE))
@settings(max_examples=30)
def test_mdanalysis_finds_the_chunks_of_hoomd(trajectory):
    with tempfile.TemporaryDirectory() as directory, np.errstate(all="ignore"):
        universe = MDAnalysis.Universe(str(written(directory, trajectory)))
        box = box_around(trajectory)
        sides = box[:, 1] - box[:, 0]
        species = [0] * len(trajectory.masses) if trajectory.species is None else trajectory.species.tolist()
        assert universe.atoms.types.tolist() == [str(one) for one in species]
        assert bits(universe.atoms.masses) == bits(trajectory.masses.astype(np.float32))
        assert len(universe.trajectory) == len(trajectory.time)
        for k, frame in enumerate(universe.trajectory):
            expected, _ = wrapped(trajectory.positions[k], box[:, 0], sides, trajectory.periodic)
            assert frame.positions.tobytes() == expected.tobytes()
            assert frame.data["step"] == trajectory.steps[k]


def test_ovito_finds_the_chunks_of_hoomd_and_the_log(tmp_path):
    ovito = pytest.importorskip("ovito.io", reason="needs the package ovito: pip install ovito")
    disks = points()
    frames = ovito.import_file(str(written(tmp_path, disks)))
    assert frames.source.num_frames == 3
    box = box_around(disks)
    sides = box[:, 1] - box[:, 0]
    for k in range(3):
        data = frames.compute(k)
        assert data.attributes["Timestep"] == disks.steps[k]
        assert data.attributes["time"] == disks.time[k]
        types = {kind.id: kind.name for kind in data.particles.particle_types.types}
        properties = {name: np.array(values) for name, values in data.particles.items()}
        assert [types[one] for one in properties["Particle Type"]] == ["5", "0", "5"]
        assert bits(properties["positions"]) == bits(disks.positions[k])
        assert bits(properties["velocities"]) == bits(disks.more["velocities"][k])
        assert bits(properties["angular_velocities"]) == bits(disks.more["angular_velocities"][k])
        assert bits(properties["masses"]) == bits(disks.masses)
        assert bits(properties["radius"]) == bits(disks.more["radius"])
        position, images = wrapped(disks.positions[k], box[:, 0], sides, disks.periodic)
        assert bits(properties["Position"]) == bits(position)
        assert properties["Periodic Image"].tolist() == images.tolist()
        assert bits(properties["Radius"]) == bits(disks.more["radius"])
        assert bits(properties["Velocity"]) == bits(disks.more["velocities"][k].astype(np.float32))
        assert data.cell.is2D
        assert np.diag(np.array(data.cell)[:, :3])[:2] == pytest.approx(sides[:2].astype(np.float32))


def test_a_directory_may_have_a_name_that_is_not_utf8(tmp_path):
    directory = tmp_path / b"\xff".decode(errors="surrogateescape")
    directory.mkdir()
    disks = points()
    path = written(directory, disks)
    assert path.read_bytes() == written(tmp_path, disks).read_bytes()


def test_a_trajectory_without_species_is_of_species_0(tmp_path):
    with gsd.hoomd.open(str(written(tmp_path, replace(points(), species=None)))) as frames:
        assert frames[0].particles.types == ["0"]
        assert frames[2].particles.typeid.tolist() == [0, 0, 0]
