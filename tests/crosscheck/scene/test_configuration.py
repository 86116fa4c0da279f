"""Configuration files: their numbers to the last bit, and everything else checked against the scene or refused."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_files import FLUID, SPRING, TURNING, changed, load

from crosscheck.errors import UsageError
from crosscheck.scene import Scene

#: After public reports of velocities in wrong units: reduced units, scaled coordinates, image flags, ids out of order.
DUMP = """ITEM: TIMESTEP
100
ITEM: NUMBER OF ATOMS
4
ITEM: BOX BOUNDS pp pp pp
0.0 6.0
0.0 6.0
0.0 6.0
ITEM: ATOMS id type xs ys zs ix iy iz vx vy vz
3 1 0.75 0.16666666666666666 0.16666666666666666 0 0 0 0.0 0.0 -0.25
1 1 0.08333333333333333 0.16666666666666666 0.16666666666666666 1 0 0 1.0 0.0 0.0
4 2 0.25 0.5 0.3333333333333333 0 -1 0 -1.0 0.0 0.0
2 1 0.4166666666666667 0.16666666666666666 0.16666666666666666 0 0 0 0.0 0.5 0.0
"""
BOXED = changed(FLUID, "box.lengths", [6.0, 6.0, 6.0])


def start(tmp_path: Path, text: str, table: dict[str, Any] = BOXED, name: str = "atoms.dump") -> Scene:
    (tmp_path / name).write_text(text)
    return load(tmp_path, changed(table, "initial", {"kind": "file", "path": name}))


def dump(columns: str, *rows: str, box: str = "pp pp pp", bounds: str = "0 6", before: str = "") -> str:
    lines = "\n".join(rows)
    sides = f"{bounds}\n" * 3
    return (
        f"{before}ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS {box}\n{sides}"
        f"ITEM: ATOMS {columns}\n{lines}\n"
    )


def test_a_dump_starts_a_scene_with_its_numbers(tmp_path: Path) -> None:
    scene = start(tmp_path, DUMP)
    state = scene.initial_state()
    assert state.positions.tolist() == [[0.5, 1, 1], [2.5, 1, 1], [4.5, 1, 1], [1.5, 3, 2]]
    assert state.velocities.tolist() == [[1, 0, 0], [0, 0.5, 0], [0, 0, -0.25], [-1, 0, 0]]
    assert scene.species == (0, 0, 0, 1)
    with gzip.open(tmp_path / "atoms.dump.gz", "wt") as file:
        file.write(DUMP)
    table = changed(BOXED, "initial", {"kind": "file", "path": "atoms.dump.gz"})
    assert load(tmp_path, table).initial == scene.initial


@pytest.mark.parametrize(
    ("columns", "row", "position"),
    [
        ("x y z", "0.1 0.2 0.3", [0.1, 0.2, 0.3]),
        ("xu yu zu", "-7.25 100.125 0.3", [-7.25, 100.125, 0.3]),
        ("xsu ysu zsu", "-0.5 2.0 0.5", [-3, 12, 3]),
        ("xu x yu y zu z", "6.5 0.5 1 1 2 2", [0.5, 1, 2]),
        ("fx x y z c_pe mol", "9.0 0.5 1 2 7 3", [0.5, 1, 2]),
    ],
)
def test_coordinates_of_every_kind(tmp_path: Path, columns: str, row: str, position: list[float]) -> None:
    state = start(tmp_path, dump(columns, row)).initial_state()
    assert state.positions.tolist() == [position]
    assert not state.velocities.any()


def test_a_binary_dump_starts_a_scene_too(tmp_path: Path) -> None:
    names = b"id type x y z vx vy vz"
    head = (
        struct.pack("=q10sii", -10, b"DUMPCUSTOM", 1, 2) + struct.pack("=qqi", 7, 2, 0) + struct.pack("=6i", *[0] * 6)
    )
    head += struct.pack("=6d", *[0.0, 6.0] * 3) + struct.pack("=iib", 8, 0, 0)
    head += struct.pack("=i", len(names)) + names + struct.pack("=i", 2)
    rows = [[2, 1, 4.1, 5, 5, 0, 0.5, 0], [1, 2, 0.1, 0.2, 0.3, -1, 0, 0]]  # of two processes
    (tmp_path / "a.bin").write_bytes(head + b"".join(struct.pack("=i8d", 8, *row) for row in rows))
    scene = load(tmp_path, changed(BOXED, "initial", {"kind": "file", "path": "a.bin"}))
    state = scene.initial_state()
    assert state.positions.tolist() == [[0.1, 0.2, 0.3], [4.1, 5, 5]]
    assert state.velocities.tolist() == [[-1, 0, 0], [0, 0.5, 0]]
    assert scene.species == (1, 0)


def test_the_last_frame_is_taken_and_its_box(tmp_path: Path) -> None:
    first = dump("id x y z", "1 9 9 9", bounds="0 10")
    state = start(tmp_path, dump("id x y z", "1 1 2 3", "7 2 2 3", before=first)).initial_state()
    assert state.positions.tolist() == [[1, 2, 3], [2, 2, 3]]


@pytest.mark.parametrize(
    ("text", "change", "message"),
    [
        (dump("x y z", "1 1 1", bounds="0 7"), {}, "the box along x is 7 in the file, 6 in the scene: make"),
        (dump("x y z", "1 1 1", box="ff pp pp"), {}, "the box along x is not periodic in the file, periodic in the"),
        (dump("x y z", "1 1 1", box="xy xz yz pp pp pp", bounds="0 6 1"), {}, "its box is tilted"),
        (dump("x y z mass", "1 1 1 2.5"), {"masses": 1.0}, "the mass of particle 0 is 2.5 in the file, 1 in the scene"),
        (dump("x y z type", "1 1 1 1", "2 1 1 2"), {"species": [1, 0]}, "species of particle 0 is 0 in the file, 1 in"),
        (dump("x y z element", "1 1 1 O", "2 1 1 H", "3 1 1 H"), {"species": [0, 0, 1]}, "one name must go with one"),
        (dump("x y z q", "1 1 1 0.5"), {}, "a scene has nothing like column q, which is not 0"),
        (dump("x y z diameter", "1 1 1 0.5"), {}, "particles have diameters, which only .hard_spheres. have"),
        (dump("x y z omegax omegay omegaz", "1 1 1 0 0 2"), {}, "particles rotate, those of the scene do not"),
        (dump("x y", "1 1"), {}, "column x is there, but not all of x, y, z"),
        (dump("id vx vy vz", "1 1 1 1"), {}, "it has no coordinates: dump x y z"),
        (dump("id x y z", "1 1 1 1", "1 2 2 2"), {}, "two particles have the same id"),
        (dump("x y z", "1 1 1", "2 2"), {}, "'2 2' has 2 values for the columns x y z"),
        (dump("x y z", "1 1 nan"), {}, "positions holds values that are not finite"),
        (DUMP[:-40], {}, "it is not complete|has . values for the columns"),
        (DUMP[:200], {}, "it is not complete"),
        ("ITEM: TIMESTEP\n", {}, "it is not complete"),
        ("LAMMPS data file\n\n2 atoms\n", {}, "the formats are .npz, .xyz, .extxyz, ASE's .traj, and LAMMPS dumps"),
    ],
)  # fmt: skip
def test_what_a_scene_cannot_hold_is_one_line(tmp_path: Path, text: str, change: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        start(tmp_path, text, BOXED | change)
    assert "\n" not in str(caught.value)
    assert "atoms.dump" in str(caught.value)


def test_what_the_scene_leaves_out_comes_from_the_file(tmp_path: Path) -> None:
    rows = dump("id type mass x y z", "1 2 4.0 1 1 1", "2 1 2.0 3 3 3")
    table = {name: value for name, value in BOXED.items() if name != "masses"}
    scene = start(tmp_path, rows, table)
    assert scene.masses == (4.0, 2.0)
    assert scene.species == (1, 0)


def test_a_plane_takes_no_third_coordinate(tmp_path: Path) -> None:
    plane = changed(changed(BOXED, "dimension", 2), "box.lengths", [6.0, 6.0])
    state = start(tmp_path, dump("x y z vx vy vz", "1 2 0 3 4 0", "2 2 0 0 0 0"), plane).initial_state()
    assert state.positions.tolist() == [[1, 2], [2, 2]]
    for row, what in (("2 2 1 0 0 0", "positions"), ("2 2 0 0 0 1", "velocities")):
        with pytest.raises(UsageError, match=f"{what} differ along z, and the scene has dimension 2"):
            start(tmp_path, dump("x y z vx vy vz", "1 2 0 3 4 0", row), plane)


def test_rotation_and_sizes_of_grains(tmp_path: Path) -> None:
    columns = "x y z omegax omegay omegaz radius"
    turning = start(
        tmp_path, dump(columns, "1 1 0 0 0 2.5 0.5", "3 3 0 0 0 -1 0.5", box="pp ff pp", bounds="0 5"), TURNING
    )
    assert turning.initial_state().angular_velocities.tolist() == [[2.5], [-1.0]]
    with pytest.raises(UsageError, match="particles do not rotate about z"):
        start(tmp_path, dump(columns, "1 1 0 1 0 0 0.5", "3 3 0 0 0 0 0.5", box="pp ff pp", bounds="0 5"), TURNING)
    with pytest.raises(UsageError, match=r"the diameter of particle 1 is 1\.2 in the file, 1 in the scene"):
        start(tmp_path, dump(columns, "1 1 0 0 0 0 0.5", "3 3 0 0 0 0 0.6", box="pp ff pp", bounds="0 5"), TURNING)


def test_scenes_in_open_space_have_no_box_to_compare(tmp_path: Path) -> None:
    space = changed(SPRING, "dimension", 3)
    state = start(tmp_path, dump("x y z", "-2 1 1", box="ss ss ss", bounds="-3 3"), space).initial_state()
    assert state.positions.tolist() == [[-2, 1, 1]]
    with pytest.raises(UsageError, match="the box along x is periodic in the file, not periodic in the scene"):
        start(tmp_path, dump("x y z", "-2 1 1"), space)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"lengths": [6.0, 6.0, 7.0]}, "the box along z is 7 in the file, 6 in the scene"),
        ({"masses": [1.0, 3.0]}, "the mass of particle 1 is 3 in the file, 1 in the scene"),
        ({"masses": [1.0]}, r"masses needs the shape \(2,\), found \(1,\)"),
        ({"charges": [1.0, 1.0]}, "array charges is not one of positions, velocities"),
        ({"positions": np.zeros((2, 2, 2))}, r"positions needs the shape \(N, d\), found \(2, 2, 2\)"),
        ({"species": [0.5, 1.0]}, "species must hold whole numbers"),
    ],
)
def test_arrays_that_do_not_fit(tmp_path: Path, arrays: dict[str, Any], message: str) -> None:
    np.savez(tmp_path / "start.npz", **({"positions": [[1.0, 1, 1], [3, 3, 3]]} | arrays))
    table = changed(changed(BOXED, "masses", 1.0), "initial", {"kind": "file", "path": "start.npz"})
    with pytest.raises(UsageError, match=message):
        load(tmp_path, table)


def test_files_that_are_none(tmp_path: Path) -> None:
    table = changed(BOXED, "initial", {"kind": "file", "path": "."})
    with pytest.raises(UsageError, match=r"cannot be read as a configuration \(it is a directory\)"):
        load(tmp_path, table)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(st.tuples(*[st.floats(-1e90, 1e90)] * 6))
def test_decimal_numbers_become_the_nearest_doubles(tmp_path: Path, row: tuple[float, ...]) -> None:
    state = start(tmp_path, dump("x y z vx vy vz", " ".join(map(repr, row)))).initial_state()
    assert [*state.positions[0].tolist(), *state.velocities[0].tolist()] == list(row)
