"""LAMMPS dumps, text (also gzipped) and binary: frames as the file states them, to the last bit.

ASE multiplies velocities as if they were in units "metal", and drops ids, image flags and times; MDAnalysis keeps 32
bits of a number, and stops at ITEM: TIME and ITEM: UNITS. So the items are told apart here, and numpy reads the
numbers.

Literature: documentation of LAMMPS, commands `dump` and `dump_modify`.
"""

from __future__ import annotations

import gzip
import itertools
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.columns import SAMPLE, printed, read_columns, whole

#: Columns that hold words or whole numbers; all others hold numbers.
_WORDS, _WHOLE = ("element", "typelabel"), ("id", "type", "mol", "proc", "procp1", "ix", "iy", "iz")
#: What is no column, and has numbers: the box.
BOUNDS = "BOX BOUNDS"
#: A column with the time, the same for all particles.
_TIME = "v_time"
#: What gzip raises for a file that is cut or damaged.
_DAMAGED = (ValueError, EOFError, OSError, zlib.error)
#: Most lines of an item that is not a list of particles.
_MOST_LINES = 16
#: Longest word of a binary file: names of all columns.
_MOST_CHARACTERS = 2**20


class DumpFrame(NamedTuple):
    """A frame of a dump, in its own units.

    step: number of the time step. time: of the item TIME, None if there is none. units: of the item UNITS, "" if there
    is none. vectors: edges of the box as rows, (3, 3), length. lower: its lower corner, (3,), length. boundary: two
    letters for each axis, such as "pp"; "" if the file has none. columns: name -> (N,) values, in the order of the
    file. decimals: name -> the first numbers of the column, and those of the box (`BOUNDS`), as they are printed; empty
    for a binary dump.
    """

    step: int
    time: float | None
    units: str
    vectors: NDArray[np.float64]
    lower: NDArray[np.float64]
    boundary: tuple[str, ...]
    columns: dict[str, NDArray[Any]]
    decimals: dict[str, list[str]]


class FrameKey(NamedTuple):
    """A frame without its particles.

    offset: where it begins in its file (bytes, of the text without compression). step, number: of its time step and of
    its particles. time: of the item TIME, else of the column v_time of its first particle (`variable time atom time`);
    None without both. names: of its columns.
    """

    offset: int
    step: int
    time: float | None
    number: int
    names: tuple[str, ...]


class DumpIndex(NamedTuple):
    """What is in a dump.

    keys: of the whole frames, in the order of the file. units: of the item UNITS, "" if there is none. sample: the last
    frame that has particles, of a text with the first of them alone; None if there is none. broken: on each frame that
    breaks off where another one begins, as after a crash and a restart: its place and why, in a few words. cut: why the
    end of the file is not a whole frame, in a few words; "" if it is.
    """

    keys: tuple[FrameKey, ...]
    units: str
    sample: DumpFrame | None
    broken: tuple[str, ...]
    cut: str


def is_dump(path: Path) -> bool:
    """Whether a file begins as a LAMMPS dump does. path: of a regular file."""
    try:
        with opened(path) as file:
            start = file.read(26)
    except _DAMAGED:
        return False
    # a binary dump of October 2020 and later: minus the length of its name, then the name
    return start.startswith(b"ITEM:") or (start[4:8] == b"\xff" * 4 and start[8:].startswith(b"DUMP"))


def dump_index(path: Path) -> DumpIndex:
    """What is in a dump, from one pass through it that keeps no frame. path: of the dump.

    ValueError if its frames are in several units.
    """
    with opened(path) as file:
        text = file.read(5) == b"ITEM:"
        file.seek(0)
        return _text_index(file) if text else _binary_index(file)


def read_frame(file: IO[bytes], key: FrameKey) -> DumpFrame:
    """One frame. file: of `opened`. key: of the frame. ValueError, with the reason, if it cannot be read."""
    file.seek(key.offset)
    text = file.read(5) == b"ITEM:"
    file.seek(key.offset)
    if not text:
        return _binary_frame(file)
    head = _head(file)
    assert head is not None
    return _text_frame(head, list(itertools.islice(file, head.number)))


def opened(path: Path) -> IO[bytes]:
    """The file, for `read_frame`; gzipped if its name ends in .gz. path: of a dump."""
    return gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb")  # type: ignore[return-value]


def _one_units(units: set[str]) -> str:
    """The units of a file; ValueError if there are several."""
    if len(units) > 1:
        raise ValueError(f"its frames are in units {' and '.join(sorted(units))}: split it")
    return next(iter(units), "")


# -- text ----------------------------------------------------------------------------------------------------


class _Head(NamedTuple):
    """What stands before the particles. box: title and three lines. names: of the columns."""

    step: int
    time: float | None
    units: str
    number: int
    box: tuple[str, list[str]]
    names: tuple[str, ...]


class _Lines:
    """Lines of a file, of which the end of the last one may be given back, to be read again."""

    def __init__(self, file: IO[bytes]) -> None:
        self.file = file
        self._back = b""

    def __iter__(self) -> Iterator[bytes]:
        return self

    def __next__(self) -> bytes:
        line, self._back = self._back or next(self.file), b""
        return line

    def give_back(self, part: bytes) -> None:
        self._back = part

    def offset(self) -> int:
        """Where the next line begins, in bytes."""
        return self.file.tell() - len(self._back)


def _text_index(file: IO[bytes]) -> DumpIndex:
    lines = _Lines(file)
    keys: list[FrameKey] = []
    units: set[str] = set()
    broken: list[str] = []
    last: tuple[_Head, list[bytes]] | None = None
    cut = ""
    try:
        while True:
            offset = lines.offset()
            head = _head(lines)
            if head is None:
                break
            if head.units:
                units.add(head.units)
            count, first, ended = _passed(lines, head.number)
            if count == head.number:
                keys.append(FrameKey(offset, head.step, _time(head, first), head.number, head.names))
                last = (head, first) if count else last
            else:
                reason = f"the frame of step {head.step} has {count} lines for {head.number} particles"
                if ended:
                    cut = f"{reason}: it is not complete"
                    break
                broken.append(reason)
    except _DAMAGED as error:
        cut = str(error) or type(error).__name__
    sample = None if last is None else _text_frame(*last)
    return DumpIndex(tuple(keys), _one_units(units), sample, tuple(broken), cut)


def _time(head: _Head, rows: list[bytes]) -> float | None:
    """See `FrameKey`."""
    if head.time is None and _TIME in head.names and rows:
        return float(rows[0].split()[head.names.index(_TIME)])
    return head.time


def _passed(lines: _Lines, number: int) -> tuple[int, list[bytes], bool]:
    """Passes the rows of a frame: how many are whole, the first of them, and whether the file ended in them."""
    first: list[bytes] = []
    count = 0
    line = b"\n"
    for line in itertools.islice(lines.file, number):
        if b"ITEM:" in line:  # of another frame, maybe in mid-line
            lines.give_back(line[line.index(b"ITEM:") :])
            return count, first, False
        if count < SAMPLE:
            first.append(line)
        count += 1
    if not line.endswith(b"\n"):  # the last number may have lost digits
        return count - 1, first, True
    return count, first, count < number


def _head(lines: Iterator[bytes] | IO[bytes]) -> _Head | None:
    """Reads up to the line ITEM: ATOMS; None at the end of the file. ValueError if something is missing before it."""
    items: dict[str, list[str]] = {}
    title = ""
    for raw in lines:
        line = raw.decode("utf-8", "replace").strip()
        if line.startswith("ITEM:"):
            title = line[5:].strip()
            items[title] = []
            if title.startswith("ATOMS"):
                break
        elif title and line and len(items[title]) < _MOST_LINES:
            items[title].append(line)
        elif line:
            raise ValueError(f"'{line[:40]}' stands where a line ITEM: is due")
    if not items:
        return None
    return _as_head(items, title)


def _as_head(items: dict[str, list[str]], title: str) -> _Head:
    """What the items before the particles say. title: of the last one. ValueError if it is not complete."""
    if any(name.startswith(("ENTRIES", "GRID")) for name in items):
        raise ValueError("it holds no particles, as those of dump atom and dump custom do")
    box = next((name for name in items if name.startswith("BOX BOUNDS")), None)
    if box is None or not items.get("NUMBER OF ATOMS") or not items.get("TIMESTEP") or not title.startswith("ATOMS"):
        raise ValueError("the last frame has no TIMESTEP, NUMBER OF ATOMS, BOX BOUNDS and ATOMS: it is not complete")
    time, units = items.get("TIME"), items.get("UNITS")
    try:
        return _Head(
            int(items["TIMESTEP"][0]),
            float(time[0]) if time else None,
            units[0] if units else "",
            int(items["NUMBER OF ATOMS"][0]),
            (box, items[box]),
            tuple(title.split()[1:]),
        )
    except ValueError:
        raise ValueError(
            f"TIMESTEP '{items['TIMESTEP'][0]}', TIME '{(time or ['none'])[0]}' or NUMBER OF ATOMS "
            f"'{items['NUMBER OF ATOMS'][0]}' is no number"
        ) from None


def _text_frame(head: _Head, rows: list[bytes]) -> DumpFrame:
    """The frame of these rows, which may be the first ones alone."""
    words = {name for name in head.names if name in _WORDS}
    read = read_columns(rows, head.names, words | ({"type"} if _names_of_types(head, rows) else set()))
    columns = {
        name: whole(name, column) if name in _WHOLE and column.dtype.kind == "f" else column
        for name, column in read.items()
    }
    lower, vectors, boundary = _bounds(*head.box)
    decimals = printed(rows[:SAMPLE], head.names)
    decimals[BOUNDS] = [word for line in head.box[1][:3] for word in line.split()]
    return DumpFrame(head.step, head.time, head.units, vectors, lower, boundary, columns, decimals)


def _names_of_types(head: _Head, rows: list[bytes]) -> bool:
    """Whether the column `type` has names in place of numbers."""
    if "type" not in head.names or not rows:
        return False
    at = head.names.index("type")
    first = rows[0].decode("utf-8", "replace").split()
    return len(first) > at and not first[at].lstrip("+-").isdigit()


def _bounds(title: str, lines: list[str]) -> tuple[NDArray[np.float64], NDArray[np.float64], tuple[str, ...]]:
    """Lower corner, edges, and letters of the boundaries."""
    flags = title.split()[2:]
    rows = [[float(word) for word in line.split()] for line in lines[:3]]
    general = "abc" in flags
    if len(rows) != 3 or any(len(row) < (4 if general else 2) for row in rows):
        raise ValueError(f"BOX BOUNDS needs three lines of {'four' if general else 'two'} numbers")
    kinds = tuple(flag for flag in flags if flag not in ("xy", "xz", "yz", "abc", "origin"))
    kinds = kinds if len(kinds) == 3 else ("", "", "")
    if general:  # its edges, and its corner in the last column
        table = np.array([row[:4] for row in rows])
        return table[:, 3], table[:, :3], kinds
    tilts = (0.0, 0.0, 0.0) if any(len(row) < 3 for row in rows) else (rows[0][2], rows[1][2], rows[2][2])
    lower, vectors = _from_bounds(np.array([row[:2] for row in rows]), tilts)
    return lower, vectors, kinds


def _from_bounds(
    bounds: NDArray[np.float64], tilts: tuple[float, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower corner and edges of a box whose hull has these bounds, (3, 2), and whose tilts are xy, xz, yz."""
    xy, xz, yz = tilts
    low, high = bounds.T.copy()
    low[0] -= min(0.0, xy, xz, xy + xz)
    high[0] -= max(0.0, xy, xz, xy + xz)
    low[1] -= min(0.0, yz)
    high[1] -= max(0.0, yz)
    vectors = np.diag(high - low)
    vectors[1, 0], vectors[2, 0], vectors[2, 1] = xy, xz, yz
    return low, vectors


# -- binary --------------------------------------------------------------------------------------------------


class _BinaryHead(NamedTuple):
    """What stands before the chunks of a binary frame; `size` of the rows, and number of `chunks`."""

    step: int
    number: int
    boundary: tuple[str, ...]
    lower: NDArray[np.float64]
    vectors: NDArray[np.float64]
    size: int
    units: str
    time: float | None
    names: tuple[str, ...]
    chunks: int


def _binary_index(file: IO[bytes]) -> DumpIndex:
    keys: list[FrameKey] = []
    units: set[str] = set()
    cut = ""
    try:
        while file.read(1):
            offset = file.seek(-1, 1)
            head = _binary_head(file)
            if head.units:
                units.add(head.units)
            for _ in range(head.chunks):
                size = _chunk_size(file, head)
                if size and (file.seek(size - 1, 1) < 0 or not file.read(1)):
                    raise ValueError(f"the frame of step {head.step} ends before its {head.number} particles do")
            keys.append(FrameKey(offset, head.step, head.time, head.number, head.names))
    except _DAMAGED as error:
        cut = str(error) or type(error).__name__
    last = next((key for key in reversed(keys) if key.number), None)
    sample = None if last is None else read_frame(file, last)
    return DumpIndex(tuple(keys), _one_units(units), sample, (), cut)


def _unpack(file: IO[bytes], form: str) -> tuple[Any, ...]:
    size = struct.calcsize(form)
    data = file.read(size)
    if len(data) < size:
        raise ValueError("the last frame is not complete")
    return struct.unpack(form, data)


def _binary_head(file: IO[bytes]) -> _BinaryHead:
    (mark,) = _unpack(file, "=q")
    if not -64 < mark < 0:
        raise ValueError(
            "a binary dump of LAMMPS before October 2020, which does not name its columns, or damaged: write it as text"
        )
    file.read(-mark)
    order, revision = _unpack(file, "=ii")
    if order != 1 or revision < 2:
        raise ValueError("a binary dump of another byte order or revision: write it as text")
    step, number, triclinic = _unpack(file, "=qqi")
    letters = dict(enumerate("pfsm"))
    flags = [letters.get(flag, "") for flag in _unpack(file, "=6i")]
    boundary = tuple(flags[2 * k] + flags[2 * k + 1] for k in range(3))
    if triclinic == 2:
        vectors, lower = np.array(_unpack(file, "=9d")).reshape(3, 3), np.array(_unpack(file, "=3d"))
    else:
        bounds = np.array(_unpack(file, "=6d")).reshape(3, 2)
        lower, vectors = _from_bounds(bounds, _unpack(file, "=3d") if triclinic else (0.0, 0.0, 0.0))
    (size,) = _unpack(file, "=i")
    units = _word(file)
    (timed,) = _unpack(file, "=b")
    time = float(_unpack(file, "=d")[0]) if timed else None
    names = tuple(_word(file).split())
    (chunks,) = _unpack(file, "=i")
    if size != len(names) or number < 0 or chunks < 0:
        raise ValueError(f"the head of the frame of step {step} is damaged")
    return _BinaryHead(step, number, boundary, lower, vectors, size, units, time, names, chunks)


def _word(file: IO[bytes]) -> str:
    (length,) = _unpack(file, "=i")
    if not 0 <= length < _MOST_CHARACTERS:
        raise ValueError("the head of a frame is damaged")
    return file.read(length).rstrip(b"\0").decode("ascii")


def _chunk_size(file: IO[bytes], head: _BinaryHead) -> int:
    """Bytes of the chunk that begins here, that of one process."""
    (count,) = _unpack(file, "=i")
    if not 0 <= count <= head.number * head.size:
        raise ValueError(f"the frame of step {head.step} is damaged")
    return int(8 * count)


def _binary_frame(file: IO[bytes]) -> DumpFrame:
    head = _binary_head(file)
    parts = [np.frombuffer(file.read(_chunk_size(file, head)), dtype="=f8") for _ in range(head.chunks)]
    values = np.concatenate(parts) if parts else np.empty(0)
    if values.size != head.number * head.size:
        raise ValueError(f"the frame of step {head.step} has {values.size} numbers for {head.number} particles")
    table = values.reshape(head.number, head.size)
    columns: dict[str, NDArray[Any]] = {}
    for k, name in enumerate(head.names):
        column = np.ascontiguousarray(table[:, k])
        # names of types are stored as their numbers
        columns[name] = whole(name, column) if name in (*_WHOLE, *_WORDS) else column
    return DumpFrame(head.step, head.time, head.units, head.vectors, head.lower, head.boundary, columns, {})
