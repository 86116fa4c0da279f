"""Data files that LAMMPS writes, of all atom styles that are read, and files that people write."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from truth import Truth, beyond

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, Source
from crosscheck.trajectories.readers.lammps_data import STYLES
from crosscheck.trajectories.reading import open_results

HEADER = "by hand\n\n2 atoms\n2 atom types\n\n0 10 xlo xhi\n-1 10 ylo yhi\n0 5 zlo zhi\n"
MASSES = "\nMasses\n\n1 2.5\n2 3.5 # heavy\n"
ATOMS = "\nAtoms # atomic\n\n7 2 1 2 3\n4 1 4 5 6\n"


def opened(tmp_path: Path, text: str, name: str = "start.data") -> Source:
    (tmp_path / name).write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
    found = open_results(tmp_path / name)
    assert isinstance(found, Source)
    return found


@pytest.mark.parametrize("run", ["lj", "flat", "full", "tilted", "grains"])
def test_what_lammps_writes_at_the_end_of_a_run(lammps: Truth, run: str) -> None:
    source = lammps.source(f"{run}.data")
    frame = source.read(0)
    assert np.array_equal(frame.velocities, lammps.of(run, "v")[-1])
    assert frame.ids.tolist() == lammps.of(run, "id").tolist()
    assert frame.types is not None
    assert frame.types.tolist() == lammps.of(run, "type").tolist()
    assert frame.step == 80
    assert source.wrapping == "unwrapped"
    # LAMMPS puts particles back into the box before it writes: another image, and another rounding
    true = lammps.unwrapped(run)[-1][None]
    assert beyond(source, "positions", true) <= 1
    if run != "tilted":
        assert np.abs(frame.positions - true[0]).max() < 1e-14
    assert frame.box is not None
    assert np.allclose(frame.box.vectors, lammps.edges(run), rtol=0, atol=1e-14)


def test_units_masses_and_what_is_left_open(lammps: Truth) -> None:
    source = lammps.source("lj.data")
    assert source.units == ("sigma", "", "sigma/tau")
    assert source.remarks == ("it states no time.",)
    masses = source.read(0).masses
    assert masses is not None
    assert masses.tolist() == [2.5] * 20 + [1.0] * 88
    assert source.rounding["velocities"] == DOUBLE
    general = lammps.source("general.data").read(0)
    assert general.box is not None
    assert np.allclose(general.box.vectors, [[12, 0, 3.6], [4.8, 12, 0], [0, 2.4, 12]], rtol=0, atol=1e-14)


def test_grains_have_spins_and_masses_by_their_density(lammps: Truth) -> None:
    source = lammps.source("grains.data")
    frame = source.read(0)
    assert np.array_equal(frame.spins, lammps.of("grains", "omega"))
    assert np.array_equal(frame.diameters, 2 * lammps.of("grains", "radius"))
    assert frame.masses is not None
    assert np.allclose(frame.masses, lammps.of("grains", "rmass"), rtol=1e-15)
    assert beyond(source, "masses", lammps.of("grains", "rmass")[None]) <= 1


@pytest.mark.parametrize("style", sorted(STYLES))
@pytest.mark.parametrize("images", [False, True])
def test_columns_of_every_style(tmp_path: Path, style: str, images: bool) -> None:
    values = {"id": "3", "type": "2", "x": "1.5", "y": "2.5", "z": "0.5", "mol": "9", "diameter": "2", "density": "4"}
    row = " ".join(values.get(name, "0") for name in STYLES[style].split()) + (" 1 0 -1" if images else "")
    text = HEADER.replace("2 atoms", "1 atoms") + MASSES + f"\nAtoms # {style}\n\n{row}\n"
    source = opened(tmp_path, text)
    frame = source.read(0)
    assert frame.positions.tolist() == ([[11.5, 2.5, -4.5]] if images else [[1.5, 2.5, 0.5]])
    assert source.wrapping == ("unwrapped" if images else "wrapped")
    assert frame.ids.tolist() == [3]
    assert frame.types is not None
    assert frame.types.tolist() == [2]
    assert frame.masses is not None
    assert frame.masses[0] == pytest.approx(4 * np.pi / 3 * 4 if "diameter" in STYLES[style] else 3.5)


@pytest.mark.parametrize("name", ["start.data", "data.start", "start.lmp", "start.data.gz"])
def test_a_file_by_hand(tmp_path: Path, name: str) -> None:
    velocities = "\nVelocities\n\n4 0.5 0 0\n7 1.5 0 0\n"
    source = opened(tmp_path, HEADER + MASSES + ATOMS + velocities, name)
    frame = source.read(0)
    assert frame.ids.tolist() == [4, 7]
    assert frame.positions.tolist() == [[4, 5, 6], [1, 2, 3]]
    assert frame.velocities is not None
    assert frame.velocities.tolist() == [[0.5, 0, 0], [1.5, 0, 0]]
    assert frame.masses is not None
    assert frame.masses.tolist() == [2.5, 3.5]
    assert frame.box is not None
    assert frame.box.lower.tolist() == [0, -1, 0]
    assert not frame.box.stated
    assert "it states no boundaries: all are taken to be periodic." in source.remarks


def test_types_may_have_labels(tmp_path: Path) -> None:
    labels = "\nAtom Type Labels\n\n1 Ar\n2 Kr\n"
    atoms = ATOMS.replace("7 2", "7 Kr").replace("4 1", "4 Ar")
    for masses in (MASSES, MASSES.replace("\n1 ", "\nAr ").replace("\n2 3", "\nKr 3")):
        frame = opened(tmp_path, HEADER + labels + masses + atoms).read(0)
        assert frame.types is not None
        assert frame.types.tolist() == ["Ar", "Kr"]
        assert frame.masses is not None
        assert frame.masses.tolist() == [2.5, 3.5]


def test_hybrid_styles_begin_as_atomic_does(tmp_path: Path) -> None:
    source = opened(tmp_path, HEADER + "\nAtoms # hybrid sphere charge\n\n7 2 1 2 3 0.5 1 0.1\n4 1 4 5 6 0.5 1 0.1\n")
    assert source.read(0).positions.tolist() == [[4, 5, 6], [1, 2, 3]]
    assert source.wrapping == "wrapped"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEADER + MASSES + ATOMS.replace("4 1 4 5 6\n", ""), "section Atoms has 1 rows for 2 atoms"),
        (HEADER + ATOMS[:-1], "its last line has no end"),
        (HEADER + ATOMS.replace("4 1 4 5 6", "4 1 4 5"), "'4 1 4 5' has 4 values for the columns id type x y z"),
        (HEADER + ATOMS.replace("atomic", "smd"), "atom style smd is none of those read: name one"),
        (HEADER + ATOMS.replace("# atomic", "").replace("3\n", "3 1\n"), "it does not name its atom style"),
        (HEADER + ATOMS.replace("# atomic", "# full"), "section Atoms has 5 columns, atom style full has 7"),
        (HEADER + ATOMS + "\nVelocities\n\n4 0 0 0\n", "section Velocities has other ids than section Atoms"),
        (HEADER + MASSES.replace("2 3.5 # heavy\n", "") + ATOMS, "section Masses has no type 2"),
        (HEADER.replace("0 5 zlo zhi\n", "") + ATOMS, "its header has no zlo zhi"),
        (HEADER + ATOMS.replace("\n7", "\n4"), "two particles have the id 4"),
        (HEADER, "section Atoms has 0 rows for 2 atoms|does not name its atom style"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        opened(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "start.data" in str(caught.value)
