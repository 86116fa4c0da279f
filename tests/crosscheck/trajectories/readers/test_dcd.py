"""DCD: what the programs that write it mean by its times, and its boxes of three kinds."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from MDAnalysis.lib.formats.libdcd import DCDFile
from numpy.typing import NDArray
from truth import Truth, beyond, positions_of

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import SINGLE, Source
from crosscheck.trajectories.reading import open_results

#: CHARMM's unit of time, (u Angstrom^2 mol/kcal)^1/2, in ps.
AKMA = 0.04888821


def opened(path: Path) -> Source:
    found = open_results(path)
    assert isinstance(found, Source)
    return found


def write(
    path: Path,
    positions: NDArray[np.float64],
    remarks: str = "made by a test",
    cell: tuple[float, ...] = (5, 90, 6, 90, 90, 7),
    first: int = 10,
    delta: float = 0.002 / AKMA,
) -> None:
    with DCDFile(str(path), "w") as file:
        file.write_header(remarks, positions.shape[1], first, 10, delta, 1)
        for one in positions:
            file.write(one.astype(np.float32), np.array(cell, dtype=np.float64))


@pytest.fixture
def positions() -> NDArray[np.float64]:
    return np.random.default_rng(5).normal(size=(4, 6, 3))


@pytest.mark.parametrize("run", ["lj", "tilted"])
def test_what_lammps_writes_is_in_its_own_units(lammps: Truth, run: str) -> None:
    source = lammps.source(f"{run}.dcd")
    assert np.array_equal(positions_of(source), lammps.of(run, "x").astype(np.float32))
    assert beyond(source, "positions", lammps.of(run, "x")) <= 1
    assert source.times.tolist() == pytest.approx(np.arange(5) * (0.1 if run == "lj" else 0.02), abs=1e-15)
    assert source.steps is not None
    assert source.steps.tolist() == [0, 20, 40, 60, 80]
    assert source.units == ("", "", "")
    box = source.read(2).box
    assert box is not None
    assert np.allclose(box.vectors, lammps.edges(run), rtol=0, atol=1e-14)


def test_times_of_charmm_and_those_who_follow_it(tmp_path: Path, positions: NDArray[np.float64]) -> None:
    write(tmp_path / "a.dcd", positions)
    source = opened(tmp_path / "a.dcd")
    assert source.times.tolist() == pytest.approx([0.02, 0.04, 0.06, 0.08], rel=1e-6)
    assert source.units == ("Angstrom", "ps", "")
    assert source.rounding["positions"] == SINGLE
    assert "those of CHARMM are taken" in source.remarks[0]


def test_vmd_states_no_times(tmp_path: Path, positions: NDArray[np.float64]) -> None:
    write(tmp_path / "a.dcd", positions, remarks="Created by DCD plugin", delta=1.0)
    source = opened(tmp_path / "a.dcd")
    assert np.isnan(source.times).all()
    assert source.steps is None
    assert source.remarks[0] == "it states no times."


def test_the_first_frame_of_lammps_may_be_of_any_step(tmp_path: Path, positions: NDArray[np.float64]) -> None:
    write(tmp_path / "a.dcd", positions, remarks="Written by LAMMPS", first=7, delta=0.5)
    data = bytearray((tmp_path / "a.dcd").read_bytes())
    data[8:12], data[20:24] = struct.pack("<i", 4), struct.pack("<i", 30)  # frames, and the last step
    (tmp_path / "a.dcd").write_bytes(data)
    source = opened(tmp_path / "a.dcd")
    assert source.steps is not None
    assert source.steps.tolist() == [7, 10, 20, 30]
    assert source.times.tolist() == [3.5, 5, 10, 15]


@pytest.mark.parametrize(
    ("cell", "vectors"),
    [
        ((5, 90, 6, 90, 90, 7), np.diag([5, 6, 7])),
        ((5, 0, 6, 0, 0, 7), np.diag([5, 6, 7])),
        ((5, 60, 6, 90, 90, 7), [[5, 0, 0], [3, 27**0.5, 0], [0, 0, 7]]),
        ((5, 0.5, 6, 0, 0, 7), [[5, 0, 0], [3, 27**0.5, 0], [0, 0, 7]]),
        ((5, 1.5, 6, -0.5, 2, 7), [[5, 1.5, -0.5], [1.5, 6, 2], [-0.5, 2, 7]]),  # CHARMM's symmetric matrix
    ],
)
def test_boxes_of_angles_cosines_and_matrices(
    tmp_path: Path, positions: NDArray[np.float64], cell: tuple[float, ...], vectors: NDArray[np.float64]
) -> None:
    write(tmp_path / "a.dcd", positions, cell=cell)
    box = opened(tmp_path / "a.dcd").read(3).box
    assert box is not None
    assert np.allclose(box.vectors, vectors, rtol=0, atol=1e-14)
    assert box.periodic.all()
    assert not box.stated
    write(tmp_path / "b.dcd", positions, cell=(0,) * 6)
    assert opened(tmp_path / "b.dcd").read(0).box is None


def test_files_that_end_early(tmp_path: Path, positions: NDArray[np.float64]) -> None:
    write(tmp_path / "a.dcd", positions)
    data = (tmp_path / "a.dcd").read_bytes()
    (tmp_path / "cut.dcd").write_bytes(data[:-20])
    source = opened(tmp_path / "cut.dcd")
    assert np.array_equal(positions_of(source), positions[:3].astype(np.float32))
    assert source.remarks[0] == "what follows frame 2 (counted from 0) is not read: of 4 frames, 3 are whole."
    for size in (300, 100, 10):
        (tmp_path / "cut.dcd").write_bytes(data[:size])
        with pytest.raises(UsageError, match=r"cut\.dcd: cannot be read as DCD") as caught:
            opened(tmp_path / "cut.dcd")
        assert "\n" not in str(caught.value)
