"""The table of formats: what is asked for is refused before a run if it cannot be, and a scene starts from a file."""

import numpy as np
import pytest
from hard_disks import disks, fall
from trajectory_files import bits

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Face,
    File,
    GrainFriction,
    HardSpheres,
    LatticeGas,
    LennardJones,
    Occupations,
    Output,
    Scene,
    explicit,
)
from crosscheck.trajectories import formats
from crosscheck.trajectories.formats import Format, check_formats, write_trajectories
from crosscheck.trajectories.trajectory import QUANTITIES

GRAINS = HardSpheres(friction=GrainFriction(tangential_restitution=0.0))


def test_the_table_has_every_file_of_the_folder():
    assert list(formats.formats()) == ["dump", "extxyz", "gsd", "npz"]
    assert set(formats.DEFAULT) <= set(formats.formats())
    assert all(set(one.holds) <= set(QUANTITIES) for one in formats.formats().values())


def test_a_format_gets_the_quantities_that_it_holds_and_is_written_once(tmp_path, monkeypatch):
    got = []
    table = {"one": Format("one", lambda path, trajectory: got.append((path.name, set(trajectory.more))), ("radius",))}
    monkeypatch.setattr(formats, "formats", lambda: table)
    scene = disks()
    write_trajectories(tmp_path, "e", scene, fall(scene), names=("one", "one"))
    assert got == [("trajectory-e.one", {"radius"})]


GAS = Scene(
    name="gas",
    dimension=2,
    duration=1.0,
    lattice_gas=LatticeGas(model="hpp", columns=4, rows=4),
    initial=Occupations(kind="occupations", density=0.5, seed=1),
)


@pytest.mark.parametrize(
    ("names", "scene", "message"),
    [
        (["gsd", "xyz"], disks(), "--format xyz: unknown; take dump, extxyz, gsd, npz"),
        (["dump"], disks(output=Output(interval=1.0)), "--format dump: .*: set output.trajectory = true$"),
        (["npz"], disks(output=Output()), "set output.trajectory = true, and output.interval$"),
        (["gsd"], GAS, "--format gsd: scene gas is a lattice gas"),
    ],
)
def test_what_cannot_be_written_is_refused(names, scene, message):
    with pytest.raises(UsageError, match=message):
        check_formats(names, scene)


def test_a_package_that_is_missing_is_named(monkeypatch):
    monkeypatch.setattr(formats, "formats", lambda: {"one": Format("one", None, package="no_such_package")})
    with pytest.raises(UsageError, match="--format one: the package no_such_package is missing: pip install"):
        check_formats(["one"], disks())


@pytest.mark.parametrize("scene", [disks(), GAS])
def test_what_nobody_asked_for_is_not_refused(scene):
    check_formats((), scene)


def test_a_run_without_positions_has_no_trajectory(tmp_path):
    assert write_trajectories(tmp_path, "free", disks(), {"time": np.arange(3.0)}) == []
    assert list(tmp_path.iterdir()) == []


# -- a scene that starts from the last frame -----------------------------------------------------------------


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


def from_trajectory(tmp_path, name, scene: Scene, changes=None, **recorded) -> Scene:
    """`scene`, changed, which starts from the trajectory of its own free flight."""
    (path,) = write_trajectories(tmp_path, "free", scene, fall(scene, **recorded), names=(name,))
    table = scene.model_copy(update={"initial": File(kind="file", path=path.name)} | (changes or {}))
    (tmp_path / "scene.toml").write_text(table.to_toml())
    return Scene.load(tmp_path / "scene.toml")


TEXT = pytest.mark.parametrize("name", ["extxyz", "dump"])


@TEXT
def test_a_scene_starts_from_the_last_frame_with_the_same_bits(tmp_path, name):
    scene = argon()
    found, run = from_trajectory(tmp_path, name, scene), fall(scene)
    state = found.initial_state()
    assert bits(state.positions) == bits(run["final_positions"])
    assert bits(state.velocities) == bits(run["final_velocities"])
    assert np.abs(state.positions).max() < 1e-8


@TEXT
def test_grains_in_a_plane_start_from_their_trajectory(tmp_path, name):
    scene = disks(hard_spheres=GRAINS)
    state = from_trajectory(tmp_path, name, scene, angular_velocities=np.full((3, 3, 1), 0.1)).initial_state()
    assert bits(state.positions) == bits(fall(scene)["final_positions"])
    assert state.angular_velocities.tolist() == [[0.1]] * 3


@TEXT
def test_grains_that_flew_out_of_an_open_side_start_from_their_trajectory(tmp_path, name):
    """The box of a dump goes around them there: it says nothing of the scene's."""
    box = Box(lengths=(6.4, 5.0), boundaries=("hard", "hard"), faces={"y+": Face(open=True)})
    scene = disks(box=box)
    state = from_trajectory(tmp_path, name, scene).initial_state()
    assert state.positions[2, 1] == 1.5 + 2 * 1.9  # beyond y = 5


@TEXT
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"box": Box(lengths=(2.04e-9, 2.04e-9, 2.05e-9))}, "the box along z is 2.04e-09 in the file, 2.05e-09 in"),
        ({"masses": 6.63e-26}, "the mass of particle 2 is 1.1e-25 in the file, 6.63e-26 in the scene"),
        ({"species": (0, 1, 1)}, "the species of particle . is .* in the file"),
    ],
)
def test_a_trajectory_of_another_scene_is_refused(tmp_path, name, change, message):
    with pytest.raises(UsageError, match=message):
        from_trajectory(tmp_path, name, argon(), change)


@TEXT
@pytest.mark.parametrize("species", [(0, 0, 1), (0, 2, 200)])
def test_what_the_scene_does_not_say_comes_from_the_trajectory(tmp_path, name, species):
    scene = argon(species=species)
    (path,) = write_trajectories(tmp_path, "free", scene, fall(scene), names=(name,))
    table = scene.model_copy(update={"initial": File(kind="file", path=path.name), "species": None})
    lines = [line for line in table.to_toml().splitlines() if "6.63e-26" not in line and "1.1e-25" not in line]
    (tmp_path / "scene.toml").write_text("\n".join(lines).replace("masses = [\n]\n", ""))
    found = Scene.load(tmp_path / "scene.toml")
    assert found.masses == scene.masses
    assert found.species == scene.species
