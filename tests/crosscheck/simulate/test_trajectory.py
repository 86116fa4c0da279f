"""Trajectories as files: what a reader of the format finds in them, to the last bit."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hard_disks import disks, fall
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crosscheck.errors import UsageError
from crosscheck.scene import Box, File, GrainFriction, HardSpheres, LennardJones, Output, Scene, explicit
from crosscheck.simulate.trajectory import Trajectory, write_extxyz, write_trajectories

#: Of any size, with the smallest ones, which have fewer bits.
numbers = st.floats(-1e300, 1e300, allow_subnormal=True) | st.floats(-1e-300, 1e-300)


def bits(values) -> bytes:
    return np.ascontiguousarray(values, dtype=np.float64).tobytes()


def test_a_trajectory_has_radii_and_spins(tmp_path):
    import ase.io

    scene = disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)))
    run = fall(scene, angular_velocities=np.full((3, 3, 1), 2.5))
    run["positions"][2] = np.nan  # stopped
    frames = ase.io.read(*write_trajectories(tmp_path, "refimpl", scene, run), ":")
    assert len(frames) == 2
    assert frames[1].arrays["radius"].tolist() == [0.5] * 3
    assert frames[1].arrays["angular_velocities"].tolist() == [[0, 0, 2.5]] * 3


@settings(max_examples=100)
@given(
    vectors=arrays(np.float64, (2, 2, 3, 3), elements=numbers),
    masses=arrays(np.float64, 3, elements=st.floats(5e-324, 1e300)),
    cell=arrays(np.float64, 3, elements=st.floats(5e-324, 1e300)),
    time=arrays(np.float64, 2, elements=numbers),
)
def test_every_number_reads_back_to_the_same_bits(vectors, masses, cell, time):
    import ase.io

    trajectory = Trajectory(
        time, vectors[0], cell, np.array([True, False, True]), masses, np.array([0, 2, 1]),
        {"velocities": vectors[1], "radius": masses, "angular_velocities": vectors[0]},
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as directory, np.errstate(over="ignore"):
        path = Path(directory) / "a.extxyz"
        write_extxyz(path, trajectory)
        frames = ase.io.read(path, ":")
        momenta = masses[:, None] * vectors[1]
    assert [frame.get_chemical_symbols() for frame in frames] == [["H", "Li", "He"]] * 2
    for k, frame in enumerate(frames):
        found = frame.arrays
        assert bits(found["positions"]) == bits(vectors[0, k])
        assert bits(found["velocities"]) == bits(vectors[1, k])
        assert bits(found["angular_velocities"]) == bits(vectors[0, k])
        assert bits(found["momenta"]) == bits(momenta[k])
        assert bits(found["masses"]) == bits(found["radius"]) == bits(masses)
        assert bits(frame.info["time"]) == bits(time[k])
        assert bits(frame.cell) == bits(np.diag(cell))
        assert frame.pbc.tolist() == [True, False, True]


def argon(**changes) -> Scene:
    """Three atoms in SI units."""
    positions = np.array([[1.7e-10, 2e-10, 1e-10], [1.9e-9 / 3, 7e-10, 1e-9], [1.5e-9, 1.1e-9, 3e-10]])
    entries = {
        "name": "argon",
        "dimension": 3,
        "duration": 2e-13,
        "masses": (6.63e-26, 6.63e-26, 1.1e-25),
        "species": (0, 0, 1),
        "lennard_jones": LennardJones(cutoff=8.5e-10, length=3.4e-10, epsilon=1.65e-21),
        "box": Box(lengths=(2.04e-9,) * 3),
        "initial": explicit(positions, 1e3 / 7 * np.arange(9.0).reshape(3, 3)),
        "output": Output(interval=1e-13, trajectory=True),
    }
    return Scene(**(entries | changes))


def from_trajectory(tmp_path, scene: Scene, **changes) -> Scene:
    """`scene`, started from the trajectory of its own free flight."""
    write_trajectories(tmp_path, "free", scene, fall(scene))
    file = File(kind="file", path="trajectory-free.extxyz")
    table = scene.model_copy(update={"initial": file} | changes)
    (tmp_path / "scene.toml").write_text(table.to_toml())
    return Scene.load(tmp_path / "scene.toml")


def test_a_scene_starts_from_the_last_frame_with_the_same_bits(tmp_path):
    scene = argon()
    state, run = from_trajectory(tmp_path, scene).initial_state(), fall(scene)
    assert bits(state.positions) == bits(run["final_positions"])
    assert bits(state.velocities) == bits(run["final_velocities"])
    assert np.abs(state.positions).max() < 1e-8


def test_grains_in_a_plane_start_from_their_trajectory(tmp_path):
    scene = disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)))
    write_trajectories(tmp_path, "free", scene, fall(scene, angular_velocities=np.full((3, 3, 1), 0.1)))
    file = File(kind="file", path="trajectory-free.extxyz")
    (tmp_path / "scene.toml").write_text(scene.model_copy(update={"initial": file}).to_toml())
    state = Scene.load(tmp_path / "scene.toml").initial_state()
    assert bits(state.positions) == bits(fall(scene)["final_positions"])
    assert state.angular_velocities.tolist() == [[0.1]] * 3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"box": Box(lengths=(2.04e-9, 2.04e-9, 2.05e-9))}, "the box along z is 2.04e-09 in the file, 2.05e-09 in"),
        ({"masses": 6.63e-26}, "the mass of particle 2 is 1.1e-25 in the file, 6.63e-26 in the scene"),
        ({"species": (0, 1, 1)}, "the species of particle . is .* one name must go with one species throughout"),
    ],
)
def test_a_trajectory_of_another_scene_is_refused(tmp_path, change, message):
    with pytest.raises(UsageError, match=message):
        from_trajectory(tmp_path, argon(), **change)


def test_what_the_scene_does_not_say_comes_from_the_trajectory(tmp_path):
    scene = argon()
    write_trajectories(tmp_path, "free", scene, fall(scene))
    table = scene.model_copy(update={"initial": File(kind="file", path="trajectory-free.extxyz"), "species": None})
    lines = [line for line in table.to_toml().splitlines() if "6.63e-26" not in line and "1.1e-25" not in line]
    text = "\n".join(lines).replace("masses = [\n]\n", "")
    (tmp_path / "scene.toml").write_text(text)
    found = Scene.load(tmp_path / "scene.toml")
    assert found.masses == scene.masses
    assert found.species == scene.species
