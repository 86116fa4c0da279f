"""GSD of HOOMD's schema, read by the package gsd: its numbers of 32 bits, and those of 64 bits beside them.

`gsd.hoomd` returns HOOMD's defaults for what is not in a file, a mass of 1 as well as no velocity, and of what a
program logs, frame 0 again where a later frame has none. So chunks are read here by their names.

Literature: documentation of GSD, schema `hoomd`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.trajectories.frames import DOUBLE, SINGLE, Box, Frame, Rounding, Source, Units, Wrapping
from crosscheck.trajectories.readers._coordinates import decimal
from crosscheck.trajectories.rounding import unwrapped
from crosscheck.trajectories.vectors import in_space, moved

FORMAT = "GSD"
HOLDS = "frames"
#: Quantities of `Frame` -> the chunk of HOOMD's schema, and those of 64 bits that programs log, of positions that are
#: not wrapped into the box.
_CHUNKS: dict[str, tuple[str, tuple[str, ...]]] = {
    "positions": ("particles/position", ("positions", "position")),
    "velocities": ("particles/velocity", ("velocities", "velocity")),
    "spins": ("", ("angular_velocities", "angular_velocity")),
    "masses": ("particles/mass", ("masses", "mass")),
    "diameters": ("particles/diameter", ("diameters", "diameter")),
}
#: What the schema says of a chunk that some frames leave out.
_DEFAULTS = {"particles/velocity": 0.0, "particles/mass": 1.0, "particles/diameter": 1.0, "particles/position": 0.0}
_IMAGE, _RADIUS, _CELL = "particles/image", "log/particles/radius", "log/cell"


class _Chunks:
    """Chunks of a file by their names."""

    def __init__(self, path: Path) -> None:
        import gsd.fl

        # the package demands these words, and does not use them to read
        self.file = gsd.fl.open(str(path), "r", application="", schema="hoomd", schema_version=[1, 0])
        self.count = int(self.file.nframes)

    def has(self, name: str, index: int) -> bool:
        return bool(name) and bool(self.file.chunk_exists(frame=index, name=name))

    def anywhere(self, name: str) -> int | None:
        """The first frame that has this chunk."""
        return next((index for index in range(self.count) if self.has(name, index)), None)

    def held(self, name: str, index: int) -> Any:
        """The chunk of this frame, else that of frame 0, for which all others leave it out; None without it."""
        for frame in (index, 0):
            if self.has(name, frame):
                return self.file.read_chunk(frame=frame, name=name)
        return None

    def number(self, index: int) -> int:
        """Number of particles."""
        found = self.held("particles/N", index)
        return 0 if found is None else int(found[0])

    def of_particles(self, name: str, index: int) -> Any:
        """A chunk with a value for each particle: that of frame 0 counts only if there are as many."""
        found = self.held(name, index)
        return None if found is not None and len(found) != self.number(index) else found

    def exact(self, names: Sequence[str], index: int, plain: str) -> Any:
        """What is logged with 64 bits; None if it is not, or is of frame 0, and the plain chunk of this frame."""
        for name in (f"log/particles/{name}" for name in names):
            if self.has(name, index) or not self.has(plain, index):
                found = self.of_particles(name, index)
                if found is not None and found.dtype == np.float64:
                    return found
        return None


@dataclass(frozen=True)
class _Gsd(Source):
    stated: frozenset[str] = frozenset()

    @cached_property
    def _chunks(self) -> _Chunks:
        return _Chunks(self.path)

    def _frame(self, index: int) -> Frame:
        chunks = self._chunks
        box = _box(chunks, index)
        found = {quantity: self._values(quantity, index) for quantity in _CHUNKS}
        positions = in_space(found["positions"])
        image = chunks.of_particles(_IMAGE, index)
        if image is not None and box is not None and not self._logged("positions", index):
            positions = moved(positions, image, box.vectors)
        spins = found["spins"]
        if spins is not None and spins.size == len(spins):  # in the plane, about z
            spins = np.pad(spins.reshape(-1, 1), ((0, 0), (2, 0)))
        return Frame(
            float(self.times[index]),
            None if self.steps is None else int(self.steps[index]),
            np.arange(1, chunks.number(index) + 1),
            positions,
            None if found["velocities"] is None else in_space(found["velocities"]),
            spins,
            self._types(index),
            found["masses"],
            found["diameters"],
            box,
        )

    def _logged(self, quantity: str, index: int) -> bool:
        plain, names = _CHUNKS[quantity]
        return self._chunks.exact(names, index, plain) is not None

    def _values(self, quantity: str, index: int) -> Any:
        """A quantity, as doubles; None if the file has it nowhere."""
        chunks = self._chunks
        plain, names = _CHUNKS[quantity]
        values = chunks.exact(names, index, plain)
        if values is None and quantity == "diameters":
            radii = chunks.of_particles(_RADIUS, index)
            values = None if radii is None else 2 * np.asarray(radii, dtype=np.float64)
        if values is None and plain in self.stated:
            values = chunks.of_particles(plain, index)
            if values is None:
                shape = (chunks.number(index), 3) if plain in ("particles/velocity", "particles/position") else None
                values = np.full(shape or chunks.number(index), _DEFAULTS[plain])
        return None if values is None else np.asarray(values, dtype=np.float64)

    def _types(self, index: int) -> Any:
        chunks = self._chunks
        if "particles/typeid" not in self.stated:
            return None
        numbers = chunks.of_particles("particles/typeid", index)
        numbers = np.zeros(chunks.number(index), dtype=np.int64) if numbers is None else numbers
        stored = chunks.held("particles/types", index)
        if stored is None:
            return np.asarray(numbers, dtype=np.int64)
        names = [bytes(row).rstrip(b"\0").decode("utf-8") for row in stored.astype(np.uint8)]
        return np.array(names)[numbers]


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    return path.suffix == ".gsd"


def open_file(path: Path, topology: Path | None) -> Source:
    """Opens the file. path: of the file. topology: not used. ValueError if it has no frame, or no positions.

    Times are those of log/time, where they are; the schema of HOOMD has steps alone.
    """
    chunks = _Chunks(path)
    if not chunks.count:
        raise ValueError("there is no frame")
    frames = range(chunks.count)
    names = [plain for plain, _ in _CHUNKS.values() if plain] + ["particles/typeid", _IMAGE]
    stated = frozenset(name for name in names if chunks.anywhere(name) is not None)
    plain, logged = _CHUNKS["positions"]
    exact = all(any(chunks.has(f"log/particles/{name}", k) for name in logged) for k in frames)
    if plain not in stated and not exact:
        raise ValueError("it has no positions")
    steps = np.array([_step(chunks, index) for index in frames])
    times = np.array([_time(chunks, index) for index in frames])
    timed = bool(np.isfinite(times).all())
    remarks = [] if timed else ["it states steps and no times."]
    left = [quantity for quantity in ("velocities", "masses") if not _has(chunks, quantity, stated)]
    if left:
        remarks.append(f"it states no {' and no '.join(left)}: HOOMD's defaults are not compared.")
    wrapping: Wrapping = "unwrapped" if exact or _IMAGE in stated else "wrapped"
    return _Gsd(
        path,
        FORMAT,
        times if timed else steps.astype(np.float64),
        steps,
        wrapping,
        Units("", "" if timed else "step", ""),
        {quantity: _rounding(chunks, quantity, exact) for quantity in _CHUNKS} | {"box": _of_box(chunks)},
        tuple(remarks),
        stated,
    )


def _has(chunks: _Chunks, quantity: str, stated: frozenset[str]) -> bool:
    plain, names = _CHUNKS[quantity]
    return plain in stated or any(chunks.anywhere(f"log/particles/{name}") is not None for name in names)


def _step(chunks: _Chunks, index: int) -> int:
    found = chunks.held("configuration/step", index)
    return 0 if found is None else int(found[0])


def _time(chunks: _Chunks, index: int) -> float:
    if not chunks.has("log/time", index):
        return float("nan")
    time = np.ravel(chunks.file.read_chunk(frame=index, name="log/time"))[0]
    return decimal(time) if time.dtype == np.float32 else float(time)


def _rounding(chunks: _Chunks, quantity: str, exact: bool) -> Rounding:
    """By how much the file has rounded a quantity: 64 bits if all frames log it, or if its own chunk has them."""
    plain, names = _CHUNKS[quantity]
    constant = quantity in ("masses", "diameters")  # of frame 0 for all
    logged = [f"log/particles/{name}" for name in names] + ([_RADIUS] if quantity == "diameters" else [])
    frames = range(1 if constant else chunks.count)
    if all(any(chunks.has(name, index) for name in logged) for index in frames):
        return DOUBLE
    first = chunks.anywhere(plain) if plain else None
    if first is None:
        return DOUBLE
    rounding = _bits(chunks, first, plain)
    box = _box(chunks, first)
    if quantity != "positions" or box is None or exact or chunks.anywhere(_IMAGE) is None:
        return rounding
    return unwrapped(max(rounding, _bits(chunks, first, "configuration/box")), box.vectors)


def _of_box(chunks: _Chunks) -> Rounding:
    """Rounding of the edges of the box."""
    return DOUBLE if chunks.has(_CELL, 0) else _bits(chunks, 0, "configuration/box")


def _bits(chunks: _Chunks, index: int, name: str) -> Rounding:
    """Rounding of the numbers of a chunk."""
    values = chunks.held(name, index)
    return SINGLE if values is not None and values.dtype.itemsize == 4 else DOUBLE


def _box(chunks: _Chunks, index: int) -> Box | None:
    """The box of HOOMD, Lx, Ly, Lz, xy, xz, yz, which is centred at the origin.

    `simulate` logs the sides of the scene's own box with 64 bits, from the origin, 0 along axes without one: HOOMD's
    box is also around particles in open space. The schema has no word for walls.
    """
    numbers, cell = (chunks.held(name, index) for name in ("configuration/box", _CELL))
    if cell is not None:
        return Box(np.diag(cell), np.zeros(3), np.asarray(cell) > 0, stated=False) if np.any(cell) else None
    if numbers is None:
        return None
    x, y, z, xy, xz, yz = map(float, numbers)
    vectors = np.array([[x, 0, 0], [xy * y, y, 0], [xz * z, yz * z, z]])
    return Box(vectors, -vectors.sum(axis=0) / 2, np.array([side > 0 for side in (x, y, z)]), stated=False)
