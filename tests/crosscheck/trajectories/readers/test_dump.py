"""Dumps of LAMMPS in all its ways against what it held in memory; and files that crashes, restarts and people leave."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from truth import Truth, beyond, frames_of, positions_of

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, Source
from crosscheck.trajectories.reading import open_results

HEAD = "ITEM: NUMBER OF ATOMS\n{number}\nITEM: BOX BOUNDS {kinds}\n0 10\n0 10\n0 10\nITEM: ATOMS {columns}\n"


def frame(step: int, *rows: str, columns: str = "id x y z", kinds: str = "pp pp pp", before: str = "") -> str:
    head = HEAD.format(number=len(rows), kinds=kinds, columns=columns)
    return f"{before}ITEM: TIMESTEP\n{step}\n{head}" + "".join(f"{row}\n" for row in rows)


def opened(tmp_path: Path, text: str, name: str = "a.dump") -> Source:
    path = tmp_path / name
    path.write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
    found = open_results(path)
    assert isinstance(found, Source)
    return found


@pytest.mark.parametrize(
    ("name", "exact", "wrapping"),
    [
        ("unwrapped.dump", True, "unwrapped"),
        ("zipped.dump.gz", True, "unwrapped"),
        ("binary.bin", True, "unwrapped"),
        ("scaled.dump", False, "unwrapped"),
        ("su.dump", False, "unwrapped"),
        ("plain.dump", False, "unwrapped"),
    ],
)
def test_positions_are_those_of_lammps_whatever_the_columns(
    lammps: Truth, name: str, exact: bool, wrapping: str
) -> None:
    source = lammps.source(name)
    true = lammps.unwrapped("lj")
    assert lammps.of("lj", "image").any()  # else nothing would be told
    assert source.wrapping == wrapping
    assert [one.ids.tolist() for one in source.frames()] == [list(range(1, 109))] * 5
    assert np.array_equal(positions_of(source), true) is exact
    assert beyond(source, "positions", true) <= 1


@pytest.mark.parametrize("name", ["unwrapped.dump", "binary.bin"])
def test_everything_else_that_a_dump_states(lammps: Truth, name: str) -> None:
    source = lammps.source(name)
    assert source.units == ("sigma", "tau", "sigma/tau")
    assert source.times.tolist() == [0, 0.1, 0.2, pytest.approx(0.3, abs=1e-16), 0.4]
    assert source.steps is not None
    assert source.steps.tolist() == [0, 20, 40, 60, 80]
    assert source.remarks == ()
    assert source.rounding["velocities"] == DOUBLE
    for number, one in enumerate(source.frames()):
        assert np.array_equal(one.velocities, lammps.of("lj", "v")[number])
        assert one.types is not None
        assert one.types.tolist() == [2] * 20 + [1] * 88
        assert one.box is not None
        assert np.array_equal(one.box.vectors, lammps.edges("lj"))
        assert one.box.periodic.all()
        if name == "unwrapped.dump":
            assert one.masses is not None
            assert one.masses.tolist() == [2.5] * 20 + [1.0] * 88


def test_default_columns_of_lammps_are_read_with_what_they_have_lost(lammps: Truth) -> None:
    source = lammps.source("plain.dump")
    assert source.units == ("", "step", "")
    assert source.times.tolist() == [0, 20, 40, 60, 80]
    assert source.remarks == ("it states steps and no times (dump_modify time yes states all).",)
    assert "6 significant digits" in source.rounding["velocities"].name
    assert beyond(source, "velocities", lammps.of("lj", "v")) <= 1
    atom = lammps.source("atom.dump")  # fractions of the box, without images
    assert atom.wrapping == "wrapped"
    assert beyond(atom, "positions", lammps.of("lj", "x")) <= 1


def test_names_of_types_and_times_in_a_column(lammps: Truth) -> None:
    named = frames_of(lammps.source("element.dump"))
    assert named[0].types is not None
    assert named[0].types.tolist() == ["Kr"] * 20 + ["Ar"] * 88
    labels = frames_of(lammps.source("labels.dump"))
    assert labels[0].types is not None
    assert set(labels[0].types.tolist()) == {"O", "H"}
    timed = lammps.source("v_time.dump")
    assert timed.times.tolist() == [0, 0.1, 0.2, 0.3, 0.4]
    assert timed.remarks == ()


def test_ids_may_have_gaps(lammps: Truth) -> None:
    ids = lammps.of("full", "id")
    assert ids.max() > len(ids)
    assert all(one.ids.tolist() == ids.tolist() for one in lammps.source("labels.dump").frames())


@pytest.mark.parametrize("name", ["tilted.dump", "tilted.bin", "tilted_su.dump"])
def test_tilted_boxes(lammps: Truth, name: str) -> None:
    source, true = lammps.source(name), lammps.unwrapped("tilted")
    assert lammps.of("tilted", "image").any()
    assert beyond(source, "positions", true) <= 1
    assert source.rounding["positions"].of(true).max() < 1e-12
    box = source.read(0).box
    assert box is not None
    assert np.allclose(box.vectors, lammps.edges("tilted"), rtol=0, atol=1e-14)
    assert box.lower.tolist() == [0, -1, 0]


@pytest.mark.parametrize("name", ["general.dump", "general.bin"])
def test_general_boxes_have_edges_in_any_direction(lammps: Truth, name: str) -> None:
    box = lammps.source(name).read(0).box
    assert box is not None
    assert np.allclose(box.vectors, [[12, 0, 3.6], [4.8, 12, 0], [0, 2.4, 12]], rtol=0, atol=1e-14)
    first, last = (one.positions for one in (lammps.source("general.dump").read(0), lammps.source(name).read(4)))
    assert np.allclose(first[0], [0, 0, 0])
    assert np.abs(last - first).max() > 0


def test_grains_have_spins_sizes_and_masses(lammps: Truth) -> None:
    source = lammps.source("grains.dump")
    last = source.read(4)
    assert np.array_equal(last.spins, lammps.of("grains", "omega"))
    assert np.array_equal(last.diameters, 2 * lammps.of("grains", "radius"))
    assert np.array_equal(last.masses, lammps.of("grains", "rmass"))
    assert last.box is not None
    assert last.box.periodic.tolist() == [True, True, False]
    assert last.box.stated
    assert source.wrapping == "wrapped"


def test_a_plane_needs_no_third_column(lammps: Truth) -> None:
    source = lammps.source("flat.dump")
    assert np.array_equal(positions_of(source), lammps.unwrapped("flat"))
    assert np.array_equal(source.read(4).velocities, lammps.of("flat", "v")[4])
    assert source.wrapping == "unwrapped"


# -- files as they are found ---------------------------------------------------------------------------------


def test_any_order_of_particles_frames_and_columns(tmp_path: Path) -> None:
    text = frame(20, "3 0 9 1", "1 2 7 0", columns="z id x y".replace("z id", "id z")) + frame(0, "1 0 0 0")
    source = opened(tmp_path, text)
    assert source.steps is not None
    assert source.steps.tolist() == [20, 0]
    first = source.read(0)
    assert first.ids.tolist() == [1, 3]
    assert first.positions.tolist() == [[7, 0, 2], [9, 1, 0]]
    assert len(source.read(1).ids) == 1


@pytest.mark.parametrize("name", ["a.dump", "a.dump.gz"])
def test_a_frame_that_is_cut_at_the_end_is_left_out(tmp_path: Path, name: str) -> None:
    whole = frame(0, "1 1 2 3", "2 4 5 6") + frame(10, "1 1 2 3.25", "2 4 5 6.5")
    for end in range(len(frame(0, "1 1 2 3", "2 4 5 6")) + 1, len(whole)):
        source = opened(tmp_path, whole[:end], name)
        assert source.times.tolist() == [0], repr(whole[end - 9 : end])
        assert source.read(0).positions.tolist() == [[1, 2, 3], [4, 5, 6]]
        assert "what follows step 0 is not read" in source.remarks[0]
    assert opened(tmp_path, whole, name).times.tolist() == [0, 10]


def test_gzip_that_ends_early(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    rows = [f"{k} {' '.join(map(repr, rng.normal(size=3).tolist()))}" for k in range(1, 2000)]
    data = gzip.compress((frame(0, *rows) + frame(1, *rows)).encode())
    (tmp_path / "a.dump.gz").write_bytes(data[: int(0.8 * len(data))])
    source = open_results(tmp_path / "a.dump.gz")
    assert isinstance(source, Source)
    assert source.times.tolist() == [0]
    assert "end-of-stream" in source.remarks[0]


@pytest.mark.parametrize("rest", ["2 4 5", "2 4 5 6.1", ""])
def test_a_restart_after_a_crash_goes_on_in_the_same_file(tmp_path: Path, rest: str) -> None:
    """The frame that was cut is left out, even if the next one begins in its last line; the step comes again."""
    cut = frame(10, "1 1 2 3", "2 4 5 6").removesuffix("2 4 5 6\n") + rest
    text = frame(0, "1 1 2 3", "2 4 5 6") + cut + frame(10, "1 1 2 3", "2 4 5 7") + frame(20, "1 1 2 3", "2 4 5 8")
    source = opened(tmp_path, text)
    assert source.times.tolist() == [0, 10, 20]
    assert [one.positions[1, 2] for one in source.frames()] == [6, 7, 8]
    assert source.remarks[0].startswith("the frame of step 10 has 1 lines for 2 particles, and another frame follows")


def test_a_restarted_run_states_frames_twice(tmp_path: Path) -> None:
    source = opened(tmp_path, frame(0, "1 1 2 3") + frame(10, "1 1 2 4") * 2 + frame(20, "1 1 2 5"))
    assert source.steps is not None
    assert source.steps.tolist() == [0, 10, 10, 20]


def test_lines_may_end_as_on_windows(tmp_path: Path) -> None:
    text = frame(0, "1 1 2 3", "2 4 5 6", before="ITEM: UNITS\nmetal\nITEM: TIME\n0.5\n")
    source = opened(tmp_path, text.replace("\n", "\r\n"))
    assert source.times.tolist() == [0.5]
    assert source.units == ("Angstrom", "ps", "Angstrom/ps")
    assert source.read(0).positions.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_frames_without_particles(tmp_path: Path) -> None:
    source = opened(tmp_path, frame(0) + frame(10, "1 1 2 0.12345678901234567") + frame(20))
    assert [len(one.ids) for one in source.frames()] == [0, 1, 0]
    assert source.rounding["positions"] == DOUBLE
    empty = opened(tmp_path, frame(0) + frame(10))
    assert empty.remarks[-1] == "none of its frames has particles."
    assert empty.read(1).positions.shape == (0, 3)


@pytest.mark.parametrize(
    ("text", "remark"),
    [
        (
            frame(0, "1 1 2 3", before="ITEM: TIME\n0\n") + frame(10, "1 1 2 3"),
            "it states steps, and times of 1 of 2 frames",
        ),
        (frame(0, "1 2 3", columns="x y z"), "it has no column id: particles are taken in the order of the file"),
        (frame(0, "1 1 2 3") + frame(5, "1 1 2 3 4", columns="id x y z vx"), "its columns change at step 5"),
        (frame(0, "1 1 2 3", kinds=""), "it does not state which boundaries are periodic"),
    ],
)
def test_what_a_file_leaves_open_is_said(tmp_path: Path, text: str, remark: str) -> None:
    assert any(remark in one for one in opened(tmp_path, text).remarks)
    box = opened(tmp_path, text).read(0).box
    assert box is not None
    assert box.stated == ("boundaries" not in remark)


def test_images_are_used_as_far_as_they_go(tmp_path: Path) -> None:
    row = "1 1 2 3 2"
    assert opened(tmp_path, frame(0, row, columns="id x y z ix", kinds="pp ff ss")).wrapping == "unwrapped"
    some = opened(tmp_path, frame(0, row, columns="id x y z ix"))
    assert some.wrapping == "wrapped"
    assert some.read(0).positions.tolist() == [[21, 2, 3]]
    both = frame(0, "1 1 1 1", columns="id xu yu zu") + frame(1, "1 1 1 1")
    assert opened(tmp_path, both).wrapping == "wrapped"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (frame(0, "1 1 2")[:-1], "it is not complete"),
        (frame(0, "1 1 2", "2 1 2 3"), "'1 1 2' has 3 values for the columns id x y z"),
        (frame(0, "1 1 2 x"), "could not convert string 'x' to float64"),
        (frame(0, "1.5 1 2 3"), "id must hold whole numbers"),
        (frame(0, "1 1 2 3", "1 2 3 4"), "two particles have the id 1"),
        (frame(0, "1 1 2 3 4", columns="id x y z x"), "column x is there twice"),
        (frame(0, "1 1 2 3", columns="id vx vy vz"), "it has no coordinates"),
        (frame(0, "1 1 2 3").replace("ATOMS id", "ENTRIES id"), "it holds no particles"),
        (frame(0, "1 1 2 3").replace("\n0 10\n0 10\n", "\n0 10\n"), "BOX BOUNDS needs three lines of two numbers"),
        (frame(0, "1 1 2 3", kinds="abc origin pp pp pp"), "BOX BOUNDS needs three lines of four numbers"),
        (frame(0, "1 1 2 3").replace("STEP\n0\n", "STEP\nzero\n"), "TIMESTEP 'zero'"),
        (frame(0, "1 1 2 3", before="ITEM: UNITS\nlj\n") + frame(1, before="ITEM: UNITS\nsi\n"), "units lj and si"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        opened(tmp_path, text).read(0)
    assert "\n" not in str(caught.value)
    assert "a.dump" in str(caught.value)
