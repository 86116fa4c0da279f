"""XTC and TRR: their compression and their places of frames by MDAnalysis, the heads of frames by numpy.

MDAnalysis reads 32 bits of the 64 that a TRR file of GROMACS in double precision has; these are read here. Of XTC files
of nine particles or fewer, which are not compressed, it returns a precision that was never set.

Literature: GROMACS reference manual, file formats.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from crosscheck.trajectories.frames import DOUBLE, EXACT, SINGLE, Box, Cut, Floats, Rounding, Units, first_line
from crosscheck.trajectories.readers._coordinates import NO_TOPOLOGY, Coordinates, Numbers, decimal, read_topology

FORMAT = "XTC or TRR"
HOLDS = "frames"

_UNITS = Units("nm", "ps", "nm/ps")
#: Most particles of an XTC frame that is not compressed.
_PLAIN = 9
#: Numbers of the blocks with edges and with positions in a TRR frame; velocities and forces follow.
_EDGES, _POSITIONS = 2, 7
#: Bytes before the precision in an XTC frame, and most bytes of the head of a TRR frame.
_TO_PRECISION, _HEAD = 56, 128


class _Head(NamedTuple):
    """Head of a frame. precision: units into which XTC divides one of length; 0: it is not compressed. doubles: whether
    numbers have 64 bits. sizes: bytes of the blocks of a TRR frame. start: where they begin in it."""

    step: int
    time: float
    precision: float = 0.0
    doubles: bool = False
    sizes: tuple[int, ...] = ()
    start: int = 0


@dataclass(frozen=True)
class _Gromacs(Coordinates):
    places: tuple[int, ...] = ()

    @cached_property
    def _reader(self) -> Any:
        return _opened(self.path)

    def numbers(self, index: int) -> Numbers:
        """See `Coordinates`."""
        place = self.places[index]
        offset = int(self._reader.offsets[place])
        head = _head(self.path, offset)
        if head.doubles:
            return _in_doubles(self.path, offset, head)
        self._reader.seek(place)
        frame = self._reader.read()
        velocities = np.array(frame.v, dtype=np.float64) if getattr(frame, "hasv", False) else None
        return Numbers(np.array(frame.x, dtype=np.float64), velocities, _box(np.array(frame.box, dtype=np.float64)))


def knows(path: Path) -> bool:
    """Whether the file is one of these formats. path: of a regular file."""
    return path.suffix in (".xtc", ".trr")


def open_file(path: Path, topology: Path | None) -> Coordinates:
    """Opens the file. path: of the file. topology: ids, types and masses of the particles; None: they are 1, 2 ...

    ValueError, or what MDAnalysis raises, if no frame of it is whole.
    """
    reader = _opened(path)
    count = len(reader)
    remarks: list[str] = []
    while count:
        try:
            heads = [_head(path, int(offset)) for offset in reader.offsets[:count]]
            reader.seek(count - 1)
            reader.read()
            break
        except (OSError, ValueError) as error:
            count -= 1
            if not count:
                raise
            remarks = [Cut.after(count, first_line(error))]
    # positions may be written at other intervals than velocities
    places = [place for place in range(count) if path.suffix == ".xtc" or heads[place].sizes[_POSITIONS]]
    if not places:
        raise ValueError("there is no frame with positions")
    if len(places) < count:
        remarks.append(f"{count - len(places)} of {count} frames have no positions: they are left out.")
        heads = [heads[place] for place in places]
    if topology is None:
        remarks.append(NO_TOPOLOGY)
    rounding = DOUBLE if all(head.doubles for head in heads) else SINGLE
    positions = rounding
    if path.suffix == ".xtc":
        positions = _of_xtc(min(head.precision for head in heads))
    return _Gromacs(
        path,
        path.suffix[1:].upper(),
        np.array([head.time for head in heads]),
        np.array([head.step for head in heads]),
        "wrapped",
        _UNITS,
        EXACT | {"positions": positions, "velocities": rounding, "box": rounding},
        tuple(remarks),
        read_topology(topology),
        tuple(places),
    )


def _opened(path: Path) -> Any:
    from MDAnalysis.lib.formats.libmdaxdr import TRRFile, XTCFile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return (XTCFile if path.suffix == ".xtc" else TRRFile)(str(path))


def _of_xtc(precision: float) -> Rounding:
    """Rounding to a whole number of units; and of 32 bits, of the product with the precision and of that back."""
    if not precision:
        return SINGLE
    return Rounding(0.5 / precision, 4 * SINGLE.relative, f"1/{precision:g} of its unit")


def _head(path: Path, offset: int) -> _Head:
    """The head of the frame that begins there."""
    with path.open("rb") as file:
        file.seek(offset)
        data = file.read(_HEAD)
    if path.suffix == ".xtc":
        number, step = np.frombuffer(data, ">i4", 2, 4)
        (time,) = np.frombuffer(data, ">f4", 1, 12)
        (precision,) = np.frombuffer(data, ">f4", 1, _TO_PRECISION) if number > _PLAIN else (0.0,)
        return _Head(int(step), decimal(time), float(precision))
    (length,) = np.frombuffer(data, ">i4", 1, 8)  # of the name of the format
    start = 12 + 4 * ((int(length) + 3) // 4)
    numbers = np.frombuffer(data, ">i4", 13, start)
    sizes = tuple(map(int, numbers[:10]))
    doubles = sizes[_EDGES] == 72 or any(size == 24 * int(numbers[10]) > 0 for size in sizes[_POSITIONS:])
    (time,) = np.frombuffer(data, ">f8" if doubles else ">f4", 1, start + 52)
    after = start + 52 + (16 if doubles else 8)
    return _Head(int(numbers[11]), float(time) if doubles else decimal(time), 0.0, doubles, sizes, after)


def _in_doubles(path: Path, offset: int, head: _Head) -> Numbers:
    """Numbers of a TRR frame of 64 bits: the blocks stand in the order of their sizes."""
    with path.open("rb") as file:
        file.seek(offset + head.start)
        blocks = [np.frombuffer(file.read(size), ">f8").astype(np.float64) for size in head.sizes]
    if any(8 * len(block) < size for block, size in zip(blocks, head.sizes, strict=True)):
        raise ValueError("it is not complete")
    box, positions, velocities = blocks[_EDGES], blocks[_POSITIONS], blocks[_POSITIONS + 1]
    return Numbers(
        positions.reshape(-1, 3),
        velocities.reshape(-1, 3) if velocities.size else None,
        _box(box.reshape(3, 3)) if box.size else None,
    )


def _box(vectors: Floats) -> Box | None:
    """A box along whose edges everything may be periodic; None if there are none."""
    return Box(vectors, np.zeros(3), np.abs(vectors).sum(axis=1) > 0, stated=False) if vectors.any() else None
