"""Files are known by what is in them; a directory stands for its results; one frame is in memory at a time."""

from __future__ import annotations

import gzip
import os
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from MDAnalysis.lib.formats.libmdaxdr import XTCFile
from scene_files import FLUID, load
from truth import Truth

from crosscheck.engines.protocol import Run
from crosscheck.errors import UsageError
from crosscheck.scene import Method
from crosscheck.simulate.arrays import write_arrays
from crosscheck.simulate.observables import Result
from crosscheck.trajectories.frames import EXACT, Series, Source
from crosscheck.trajectories.reading import formats, open_results, reader_of, results_in

NUMBER = 2000


def dump_of(frames: int) -> str:
    rng = np.random.default_rng(1)
    head = f"ITEM: NUMBER OF ATOMS\n{NUMBER}\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n"
    rows = (f"{k + 1} {a!r} {b!r} {c!r}\n" for k, (a, b, c) in enumerate(rng.uniform(size=(NUMBER, 3)).tolist()))
    body = head + "".join(rows)
    return "".join(f"ITEM: TIMESTEP\n{k}\n{body}" for k in range(frames))


def xyz_of(frames: int) -> str:
    body = "".join(f"Ar {a!r} {b!r} {c!r}\n" for a, b, c in np.random.default_rng(1).uniform(size=(NUMBER, 3)).tolist())
    return f"{NUMBER}\nProperties=species:S:1:pos:R:3 time=0\n{body}" * frames


def write_xtc(path: Path, frames: int) -> None:
    with XTCFile(str(path), "w") as file:
        for k in range(frames):
            file.write(np.zeros((NUMBER, 3), dtype=np.float32), np.eye(3, dtype=np.float32), k, 0.1 * k, 1000.0)


def write_npz(path: Path, frames: int) -> None:
    positions = np.random.default_rng(1).normal(size=(frames, NUMBER, 3))
    run = Run(time=np.arange(float(frames)), positions=positions, velocities=positions)
    scene = load(path.parent, FLUID)
    write_arrays(path, scene, Method(scheme="leapfrog", dt=0.1), Result("refimpl", "1", run, {}))


WRITERS: dict[str, Callable[[Path, int], object]] = {
    "a.dump": lambda path, frames: path.write_text(dump_of(frames)),
    "a.dump.gz": lambda path, frames: path.write_bytes(gzip.compress(dump_of(frames).encode(), 1)),
    "a.xyz": lambda path, frames: path.write_text(xyz_of(frames)),
    "a.xtc": write_xtc,
    "a.npz": write_npz,
}


def peak(path: Path) -> int:
    """Most bytes in use while all frames of a file are read, one after another."""
    tracemalloc.start()
    source = open_results(path)
    assert isinstance(source, Source)
    for frame in source.frames():
        assert len(frame.ids) == NUMBER
    found = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return found


@pytest.mark.parametrize("name", sorted(WRITERS))
def test_memory_does_not_grow_with_the_number_of_frames(tmp_path: Path, name: str) -> None:
    few, many = tmp_path / "few", tmp_path / "many"
    for directory, frames in ((few, 4), (many, 16)):
        directory.mkdir()
        WRITERS[name](directory / name, frames)
    peak(few / name)  # what is imported and cached once
    assert peak(many / name) < 1.2 * peak(few / name)


def test_every_reader_is_named_and_says_what_it_holds() -> None:
    assert len({reader.FORMAT for reader in formats()}) == len(formats()) == 12
    assert {reader.HOLDS for reader in formats()} == {"frames", "frame", "table"}


def test_files_are_known_by_their_content(lammps: Truth, tmp_path: Path) -> None:
    kinds = {
        "unwrapped.dump": "LAMMPS dump",
        "binary.bin": "LAMMPS dump",
        "lj.data": "LAMMPS data",
        "log.lj": "LAMMPS log",
    }
    for name, kind in kinds.items():
        (tmp_path / "results.txt").write_bytes(lammps.path(name).read_bytes())
        reader = reader_of(tmp_path / "results.txt")
        assert reader is not None
        assert kind == reader.FORMAT


def test_no_file_of_lammps_is_known_to_two_readers(lammps: Truth) -> None:
    for path in lammps.directory.iterdir():
        known = [reader.FORMAT for reader in formats() if reader.knows(path)]
        assert len(known) == 1, path
        if path.name != "truth.npz":
            assert isinstance(open_results(path), Source | Series)


def test_other_files_are_refused_with_a_list(tmp_path: Path) -> None:
    for data in (b"", b"hello\n", b"\0" * 100):
        (tmp_path / "a.txt").write_bytes(data)
        with pytest.raises(UsageError, match="none of the formats that are read: ASE trajectory, DCD, LAMMPS dump"):
            open_results(tmp_path / "a.txt")


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "a.xyz").write_text("1\n\nAr 0 0 0\n")
    for path, topology, message in (
        (tmp_path / "none.xyz", None, "No such file"),
        (tmp_path / "pipe", None, "it is a pipe"),
        (tmp_path, None, "it is a directory"),
        (tmp_path / "a.xyz", tmp_path / "none.pdb", r"none\.pdb: cannot be read"),
    ):
        with pytest.raises(UsageError, match=message) as caught:
            open_results(path, topology)
        assert "\n" not in str(caught.value)


def test_a_directory_stands_for_its_only_results(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no file of results in it"):
        results_in(tmp_path)
    (tmp_path / "notes.txt").write_text("hello\n")
    (tmp_path / "broken.gz").write_bytes(b"\x1f\x8b")
    os.mkfifo(tmp_path / "pipe")
    names = ["log.csv", "start.data", "b.xyz", "arrays-refimpl.npz"]  # each is preferred to those before
    texts = ["time,E\n0,1\n", "\n\n1 atoms\n0 1 xlo xhi\n", "1\n\nAr 0 0 0\n", ""]
    for name, text in zip(names, texts, strict=True):
        (tmp_path / name).write_text(text)
        assert results_in(tmp_path) == tmp_path / name
    (tmp_path / "arrays-lammps.npz").write_text("")
    with pytest.raises(UsageError, match=r"several files of results \(arrays-lammps\.npz, arrays-refimpl\.npz\)"):
        results_in(tmp_path)
    assert results_in(tmp_path / "b.xyz") == tmp_path / "b.xyz"


def test_a_damaged_frame_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.dump").write_text(dump_of(2).replace("\n2 0.", "\n2 x.", 1))
    source = open_results(tmp_path / "a.dump")
    assert isinstance(source, Source)
    assert len(source.read(1).ids) == NUMBER
    with pytest.raises(UsageError, match=r"a\.dump: frame 0 \(counted from 0\) cannot be read \(could not convert"):
        source.read(0)


@pytest.mark.parametrize(
    ("name", "rounding"),
    [
        ("unwrapped.dump", "float64"),
        ("lj.data", "16 significant digits"),
        ("lj.extxyz", "6 significant digits"),
        ("lj.xtc", "float32"),
        ("lj.dcd", "float64"),
    ],
)
def test_edges_of_the_box_are_within_their_stated_rounding(lammps: Truth, name: str, rounding: str) -> None:
    source, true = lammps.source(name), lammps.edges("lj")
    box = source.read(0).box
    assert box is not None
    assert (np.abs(box.vectors - true) <= source.rounding["box"].of(box.vectors)).all()
    assert source.rounding["box"].name == rounding
    assert source.rounding.keys() == EXACT.keys()
