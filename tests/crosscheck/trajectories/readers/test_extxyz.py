"""Extended and plain XYZ by LAMMPS, ASE, `simulate` and others."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from truth import Truth, beyond, positions_of

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, Source
from crosscheck.trajectories.reading import open_results
from crosscheck.trajectories.trajectory import Trajectory
from crosscheck.trajectories.writers import extxyz


def opened(tmp_path: Path, text: str, name: str = "a.xyz") -> Source:
    path = tmp_path / name
    path.write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
    found = open_results(path)
    assert isinstance(found, Source)
    return found


def test_lammps_extxyz_has_names_times_and_boxes(lammps: Truth) -> None:
    source = lammps.source("lj.extxyz")
    assert np.array_equal(positions_of(source), lammps.of("lj", "x"))
    assert np.array_equal(source.read(2).velocities, lammps.of("lj", "v")[2])
    assert source.times.tolist() == [0, 0.1, 0.2, 0.3, 0.4]
    assert source.steps is not None
    assert source.steps.tolist() == [0, 20, 40, 60, 80]
    assert source.rounding["positions"] == DOUBLE
    frame = source.read(0)
    assert frame.types is not None
    assert frame.types.tolist() == ["Kr"] * 20 + ["Ar"] * 88
    assert frame.box is not None
    assert frame.box.periodic.all()
    assert np.allclose(frame.box.vectors, lammps.edges("lj"), rtol=5e-6)


def test_plain_xyz_of_lammps_states_steps_and_times_in_words(lammps: Truth) -> None:
    source = lammps.source("lj.xyz")
    assert source.times.tolist() == [0, 0.1, 0.2, 0.3, 0.4]
    assert source.steps is not None
    assert source.steps.tolist() == [0, 20, 40, 60, 80]
    assert beyond(source, "positions", lammps.of("lj", "x")) <= 1
    assert source.rounding["positions"].name == "6 significant digits"
    types = source.read(0).types
    assert types is not None
    assert types.tolist() == ["2"] * 20 + ["1"] * 88


def test_what_ase_writes(tmp_path: Path) -> None:
    from ase import Atoms
    from ase.io import write

    rng = np.random.default_rng(2)
    images = []
    for k in range(3):
        atoms = Atoms("Ar4Kr6", rng.normal(size=(10, 3)), cell=[[5, 0, 0], [1, 6, 0], [0, 0, 7]], pbc=[1, 1, 0])
        atoms.set_velocities(rng.normal(size=(10, 3)))
        atoms.info |= {"time": 0.5 * k, "note": "a = b"}
        images.append(atoms)
    write(tmp_path / "a.extxyz", images)
    source = open_results(tmp_path / "a.extxyz")
    assert isinstance(source, Source)
    assert source.times.tolist() == [0, 0.5, 1]
    assert source.rounding["positions"].name == "8 decimals"
    assert beyond(source, "positions", np.array([one.positions for one in images])) <= 1
    assert beyond(source, "velocities", np.array([one.get_velocities() for one in images])) <= 1
    assert any("momenta over masses" in remark for remark in source.remarks)
    masses = source.read(0).masses
    assert masses is not None
    assert masses.tolist() == [39.948] * 4 + [83.798] * 6
    box = source.read(1).box
    assert box is not None
    assert box.vectors.tolist() == [[5, 0, 0], [1, 6, 0], [0, 0, 7]]
    assert box.periodic.tolist() == [True, True, False]
    assert box.stated


def test_what_simulate_writes_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    more = {"velocities": rng.normal(size=(3, 8, 3)), "radius": rng.uniform(size=8)}
    more["angular_velocities"] = rng.normal(size=(3, 8, 3))
    masses, species = rng.uniform(1, 2, 8), np.arange(8) % 2
    written = Trajectory(
        np.array([0, 0.1, 0.30000000000000004]),
        np.arange(3),
        rng.normal(size=(3, 8, 3)),
        3,
        np.array([5.0, 6, 0]),
        np.array([True, False, False]),
        np.zeros((3, 2), dtype=bool),
        masses,
        species,
        more,
    )
    extxyz.write(tmp_path / "a.extxyz", written)
    source = open_results(tmp_path / "a.extxyz")
    assert isinstance(source, Source)
    assert source.times.tolist() == written.time.tolist()
    for k, frame in enumerate(source.frames()):
        assert np.array_equal(frame.positions, written.positions[k])
        assert np.array_equal(frame.velocities, more["velocities"][k])
        assert np.array_equal(frame.spins, more["angular_velocities"][k])
        assert np.array_equal(frame.masses, masses)
        assert np.array_equal(frame.diameters, 2 * more["radius"])
        assert frame.types is not None
        assert frame.types.tolist() == ["H", "He"] * 4


def test_columns_in_any_order_with_ids_and_names_that_are_no_elements(tmp_path: Path) -> None:
    head = 'Properties=id:I:1:species:S:1:mass:R:1:velo:R:3:pos:R:3:flag:L:1 Time=1.599999964 pbc="T T F" step=7'
    text = f"2\n{head}\n9 polymer 2.5 1 2 3 4 5 6 T\n4 S1 0.5 0 0 0 7 8 9 F\n"
    for name in ("a.xyz", "a.extxyz.gz"):
        source = opened(tmp_path, text, name)
        frame = source.read(0)
        assert frame.time == 1.599999964
        assert frame.step == 7
        assert frame.ids.tolist() == [4, 9]
        assert frame.positions.tolist() == [[7, 8, 9], [4, 5, 6]]
        assert frame.types is not None
        assert frame.types.tolist() == ["S1", "polymer"]
        assert frame.masses is not None
        assert frame.masses.tolist() == [0.5, 2.5]
        assert frame.box is None
        assert source.remarks == ()


def test_numbers_of_atoms_and_particles_without_names(tmp_path: Path) -> None:
    frame = opened(tmp_path, '1\nProperties=Z:I:1:pos:R:2 Lattice="2 0 0 0 3 0 0 0 4" Origin="1 1 0"\n18 1 2\n').read(0)
    assert frame.types is not None
    assert frame.types.tolist() == [18]
    assert frame.positions.tolist() == [[1, 2, 0]]
    assert frame.box is not None
    assert frame.box.lower.tolist() == [1, 1, 0]
    assert frame.box.periodic.all()
    assert not frame.box.stated
    assert opened(tmp_path, "1\n\nX 1 2 3\n").read(0).types is None


@pytest.mark.parametrize(
    ("comment", "time", "step"),
    [
        (" i =        3, time =        1.500, E =       -17.1", 1.5, 3),
        ("Atoms. Timestep: 40", np.nan, 40),
        ("step 12 time: 0.25", 0.25, 12),
        ("generated by hand", np.nan, None),
        ("Properties=species:S:1:pos:R:3 timestep=5", np.nan, 5),
    ],
)
def test_times_and_steps_in_second_lines_of_all_kinds(
    tmp_path: Path, comment: str, time: float, step: int | None
) -> None:
    frame = opened(tmp_path, f"1\n{comment}\nAr 1 2 3\n").read(0)
    assert frame.time == pytest.approx(time, nan_ok=True)
    assert frame.step == step


def test_times_with_too_few_digits_are_not_used(tmp_path: Path) -> None:
    source = opened(tmp_path, "".join(f"1\nTimestep={k} Time=0.000000\nAr 1 2 3\n" for k in range(3)))
    assert np.isnan(source.times).all()
    assert any("too few digits" in remark for remark in source.remarks)
    some = opened(tmp_path, "1\ntime=1.0\nAr 1 2 3\n1\n\nAr 1 2 3\n")
    assert any("1 of 2 frames state no time" in remark for remark in some.remarks)


def test_plain_xyz_with_more_columns(tmp_path: Path) -> None:
    source = opened(tmp_path, "1\n\nAr 1 2 3 0.5 charge\n")
    assert source.read(0).positions.tolist() == [[1, 2, 3]]
    assert any("columns without names" in remark for remark in source.remarks)


def test_a_frame_that_is_cut_is_left_out(tmp_path: Path) -> None:
    text = "2\ntime=0\nAr 1 2 3\nAr 4 5 6\n" + "2\ntime=1\nAr 1 2 3.25\nAr 4 5 6.5\n"
    for end in range(text.index("2\ntime=1") + 1, len(text)):
        source = opened(tmp_path, text[:end])
        assert source.times.tolist() == [0]
        assert any("what follows frame 0 (counted from 0) is not read" in one for one in source.remarks)
    assert opened(tmp_path, text.replace("\n", "\r\n")).times.tolist() == [0, 1]
    assert len(opened(tmp_path, "0\nempty\n" + text + "\n\n")) == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("two\n\n", "'two' stands where a number of particles is due"),
        ("2\n\nAr 1 2 3\n", "the last frame has 1 whole lines for 2 particles"),
        ("1\n\nAr 1 2 x\n", "could not convert string 'x' to float64"),
        ("2\n\nAr 1 2 3\nAr 1 2\n", "'Ar 1 2' has 3 values for the columns species pos_1 pos_2 pos_3"),
        ("1\nProperties=species:S:1:pos:R\nAr 1 2 3\n", "is no list of name:type:number"),
        ("1\nProperties=species:S:1:force:R:3\nAr 1 2 3\n", "has no pos"),
        ("1\nProperties=species:S:1:pos:R:3:momenta:R:3\nBead 1 2 3 4 5 6\n", "Bead is no element"),
        ("1\nProperties=id:I:1:pos:R:3\n1.5 1 2 3\n", "id must hold whole numbers"),
        ('1\nLattice="1 2 3"\nAr 1 2 3\n', "Lattice"),
        ("", "there is no frame"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        opened(tmp_path, text).read(0)
    assert "\n" not in str(caught.value)
    assert "a.xyz" in str(caught.value)
