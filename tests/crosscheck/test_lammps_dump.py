"""The parser of dumps: every number to the last bit, text and binary, and what is wrong with a damaged file."""

from __future__ import annotations

import gzip
import struct
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from crosscheck.lammps_dump import DumpFrame, dump_index, is_dump, opened, read_frame

NAMES = ("id", "type", "x", "y", "z", "vx")


def text_of(step: int, table: NDArray[np.float64], box: str = "pp fs mm\n0 1\n-1 1\n0 2.5") -> bytes:
    rows = "".join(f"{int(row[0])} {int(row[1])} {' '.join(map(repr, row[2:].tolist()))}\n" for row in table)
    return (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(table)}\nITEM: BOX BOUNDS {box}\n"
        f"ITEM: ATOMS {' '.join(NAMES)}\n{rows}"
    ).encode()


def binary_of(
    step: int, table: NDArray[np.float64], chunks: int = 1, units: bytes = b"", time: float | None = None
) -> bytes:
    """As LAMMPS writes it, the rows of each process in a chunk."""
    names = " ".join(NAMES).encode()
    head = struct.pack("=q10sii", -10, b"DUMPCUSTOM", 1, 2) + struct.pack("=qqi", step, len(table), 0)
    head += struct.pack("=6i6d", 0, 0, 1, 2, 3, 3, 0, 1, -1, 1, 0, 2.5) + struct.pack("=i", len(NAMES))
    head += struct.pack("=i", len(units)) + units
    head += b"\0" if time is None else struct.pack("=bd", 1, time)
    head += struct.pack("=i", len(names)) + names + struct.pack("=i", chunks)
    parts = np.array_split(table, chunks)
    return head + b"".join(struct.pack("=i", part.size) + part.astype("=f8").tobytes() for part in parts)


def table_of(rows: list[tuple[float, ...]]) -> NDArray[np.float64]:
    return np.array([(k + 1, k % 3 + 1, *row) for k, row in enumerate(rows)]).reshape(-1, len(NAMES))


def frames_of(path: Path) -> list[DumpFrame]:
    with opened(path) as file:
        return [read_frame(file, key) for key in dump_index(path).keys]


def table_in(frame: DumpFrame) -> NDArray[np.float64]:
    return np.stack([frame.columns[name].astype(np.float64) for name in NAMES], axis=1)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(st.tuples(*[st.floats(allow_nan=False)] * 4), max_size=8),
    st.sampled_from(["a.dump", "a.dump.gz", "a.bin"]),
    st.integers(1, 3),
)
def test_every_number_is_read_to_the_last_bit(
    tmp_path: Path, rows: list[tuple[float, ...]], name: str, chunks: int
) -> None:
    table = table_of(rows)
    frames = [binary_of(k, table, chunks) if name.endswith("bin") else text_of(k, table) for k in range(2)]
    data = b"".join(frames)
    (tmp_path / name).write_bytes(gzip.compress(data, 0) if name.endswith(".gz") else data)
    assert is_dump(tmp_path / name)
    found = frames_of(tmp_path / name)
    assert [one.step for one in found] == [0, 1]
    for one in found:
        assert table_in(one).tobytes() == table.tobytes()
        assert one.boundary == ("pp", "fs", "mm")
        assert one.vectors.tolist() == [[1, 0, 0], [0, 2, 0], [0, 0, 2.5]]
        assert one.lower.tolist() == [0, -1, 0]
        assert one.columns["id"].dtype == np.int64


def test_what_processes_have_written_one_after_another_is_one_table(tmp_path: Path) -> None:
    table = table_of([(k, 2.0 * k, 3.0 * k, 0.5) for k in range(7)])
    (tmp_path / "a.bin").write_bytes(binary_of(5, table, chunks=4, units=b"lj", time=0.25))
    (frame,) = frames_of(tmp_path / "a.bin")
    assert table_in(frame).tolist() == table.tolist()
    assert frame.time == 0.25
    assert dump_index(tmp_path / "a.bin").units == "lj"


@pytest.mark.parametrize(
    ("box", "lower", "vectors"),
    [
        ("xy xz yz pp pp pp\n0 3 1\n0 2 0\n0 2 0", [0, 0, 0], [[2, 0, 0], [1, 2, 0], [0, 0, 2]]),
        ("xy xz yz pp pp pp\n-1.5 3 1\n-1 4 -1.5\n0 2 1", [0, -1, 0], [[2, 0, 0], [1, 4, 0], [-1.5, 1, 2]]),
        ("xy xz yz pp pp pp\n-1.5 2 -1\n0 2 -0.5\n0 2 0", [0, 0, 0], [[2, 0, 0], [-1, 2, 0], [-0.5, 0, 2]]),
        ("abc origin pp pp pp\n1 2 3 -1\n4 5 6 -2\n7 8 10 -3", [-1, -2, -3], [[1, 2, 3], [4, 5, 6], [7, 8, 10]]),
        ("\n0 1\n0 2\n0 3", [0, 0, 0], [[1, 0, 0], [0, 2, 0], [0, 0, 3]]),
    ],
)
def test_boxes_are_given_by_their_hull(
    tmp_path: Path, box: str, lower: list[float], vectors: list[list[float]]
) -> None:
    (tmp_path / "a.dump").write_bytes(text_of(0, table_of([(0, 0, 0, 0)]), box))
    (frame,) = frames_of(tmp_path / "a.dump")
    assert frame.lower.tolist() == lower
    assert frame.vectors.tolist() == vectors


@pytest.mark.parametrize("form", [text_of, binary_of])
def test_every_prefix_of_a_file_is_its_whole_frames(tmp_path: Path, form: object) -> None:
    table = table_of([(1.5, 2, 3, 0.125), (4, 5, 6, -0.5)])
    frames = [form(k, table) for k in range(3)]  # type: ignore[operator]
    data = b"".join(frames)
    ends = [sum(map(len, frames[: k + 1])) for k in range(3)]
    for end in sorted({*range(30, len(data), 7), *(one + k for one in ends for k in (-9, -2, -1, 0))}):
        (tmp_path / "a.dump").write_bytes(data[:end])
        index = dump_index(tmp_path / "a.dump")
        assert len(index.keys) == sum(end >= one for one in ends), end
        assert bool(index.cut) == (end not in ends)
        assert "\n" not in index.cut
        for one in frames_of(tmp_path / "a.dump"):
            assert table_in(one).tolist() == table.tolist()


@pytest.mark.parametrize(
    ("place", "data", "message"),
    [
        (0, struct.pack("=q", 100), "before October 2020"),
        (18, struct.pack("=i", 16777216), "another byte order or revision"),
        (22, struct.pack("=i", 1), "another byte order or revision"),
        (34, struct.pack("=q", -5), "is damaged"),
        (118, struct.pack("=i", 9), "the head of the frame of step 3 is damaged"),
        (122, struct.pack("=i", -1), "the head of a frame is damaged"),
    ],
)
def test_damaged_heads_of_binary_dumps(tmp_path: Path, place: int, data: bytes, message: str) -> None:
    whole = binary_of(3, table_of([(1, 2, 3, 4)]))
    (tmp_path / "a.bin").write_bytes(whole[:place] + data + whole[place + len(data) :])
    index = dump_index(tmp_path / "a.bin")
    assert index.keys == ()
    assert message in index.cut


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(st.booleans(), st.integers(0, 2000), st.binary(min_size=1, max_size=8))
def test_no_damage_is_more_than_a_value_error(tmp_path: Path, text: bool, place: int, noise: bytes) -> None:
    table = table_of([(1.5, 2, 3, 0.125), (4, 5, 6, -0.5)])
    data = b"".join(text_of(k, table) if text else binary_of(k, table, 2, b"metal", 0.5) for k in range(3))
    place %= len(data)
    (tmp_path / "a.dump").write_bytes(data[:place] + noise + data[place + len(noise) :])
    with suppress(ValueError):
        frames_of(tmp_path / "a.dump")


def test_other_files_are_no_dumps(tmp_path: Path) -> None:
    path = tmp_path / "a.gz"
    for data in (b"", b"3\n\nAr 0 0 0\n", b"\x89HDF\r\n", gzip.compress(b"3\n\n"), gzip.compress(b"ITEM: TI")[:12]):
        path.write_bytes(data)
        assert not is_dump(path)
