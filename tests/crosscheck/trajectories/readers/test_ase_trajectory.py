"""ASE's own trajectories, to the last bit of positions, and to the rounding of a division for velocities."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from ase import Atoms
from ase.io.trajectory import Trajectory
from truth import beyond, positions_of

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, Source
from crosscheck.trajectories.reading import open_results

POSITIONS, VELOCITIES = np.random.default_rng(1).normal(size=(2, 5, 8, 3))


def write(path: Path, names: str = "Ar3Kr5", *, masses: bool = False, times: bool = True) -> None:
    with Trajectory(str(path), "w") as file:
        for k in range(5):
            atoms = Atoms(names, POSITIONS[k], cell=[[5, 0, 0], [1, 6, 0], [0, 0, 7]], pbc=[True, True, False])
            if masses:
                atoms.set_masses(np.arange(1.0, 9))
            atoms.set_velocities(VELOCITIES[k])
            atoms.info = {"time": 0.1 * k} if times else {}
            file.write(atoms)


def opened(path: Path) -> Source:
    found = open_results(path)
    assert isinstance(found, Source)
    return found


@pytest.mark.parametrize("masses", [False, True])
def test_what_ase_writes(tmp_path: Path, masses: bool) -> None:
    write(tmp_path / "a.traj", masses=masses)
    source = opened(tmp_path / "a.traj")
    assert np.array_equal(positions_of(source), POSITIONS)
    assert source.rounding["positions"] == DOUBLE
    assert beyond(source, "velocities", VELOCITIES) <= 1
    assert source.times.tolist() == (np.arange(5) * 0.1).tolist()
    frame = source.read(4)
    assert frame.types is not None
    assert frame.types.tolist() == ["Ar"] * 3 + ["Kr"] * 5
    of_ase = [39.948] * 3 + [83.798] * 5  # by which ASE divides momenta
    assert frame.masses is not None
    assert frame.masses.tolist() == (list(range(1, 9)) if masses else of_ase)
    assert frame.box is not None
    assert frame.box.vectors.tolist() == [[5, 0, 0], [1, 6, 0], [0, 0, 7]]
    assert frame.box.periodic.tolist() == [True, True, False]
    assert frame.box.stated
    assert source.remarks == ()


def test_what_it_leaves_open_is_said(tmp_path: Path) -> None:
    write(tmp_path / "a.traj", "X8", masses=True, times=False)
    source = opened(tmp_path / "a.traj")
    assert np.isnan(source.times).all()
    assert source.remarks == ("it states no times (a key `time` in Atoms.info would).",)
    assert source.read(0).types is None


def test_a_file_that_ends_early(tmp_path: Path) -> None:
    write(tmp_path / "a.traj")
    data = (tmp_path / "a.traj").read_bytes()
    for share in (0.99, 0.7):
        (tmp_path / "cut.traj").write_bytes(data[: int(share * len(data))])
        source = opened(tmp_path / "cut.traj")
        assert 0 < len(source) < 5
        assert np.array_equal(positions_of(source), POSITIONS[: len(source)])
        assert f"what follows frame {len(source) - 1} (counted from 0) is not read" in source.remarks[0]
    (tmp_path / "cut.traj").write_bytes(data[:60])
    with pytest.raises(UsageError, match=r"cut\.traj: cannot be read as ASE trajectory") as caught:
        opened(tmp_path / "cut.traj")
    assert "\n" not in str(caught.value)


def test_the_name_alone_does_not_make_one(tmp_path: Path) -> None:
    """Dumps of LAMMPS are often called .traj."""
    box = "ITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n"
    dump = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\n{box}ITEM: ATOMS id x y z\n1 0 0 0\n"
    (tmp_path / "a.traj").write_text(dump)
    assert opened(tmp_path / "a.traj").format == "LAMMPS dump"
