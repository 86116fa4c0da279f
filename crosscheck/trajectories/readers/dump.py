"""LAMMPS dumps, text or binary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO

import numpy as np

from crosscheck.lammps_dump import BOUNDS, DumpFrame, DumpIndex, FrameKey, dump_index, is_dump, opened, read_frame
from crosscheck.trajectories.frames import EXACT, Box, Cut, Floats, Frame, Rounding, Source, Units, Wrapping, ordered
from crosscheck.trajectories.rounding import of_decimals, scaled, unwrapped
from crosscheck.trajectories.vectors import moved

FORMAT = "LAMMPS dump"
HOLDS = "frames"

#: Units of LAMMPS: length, time, velocity. Documentation of its command `units`. In "electron", velocities are in Bohr
#: per (u Bohr^2/Hartree)^1/2 = 1.03275 fs: no atomic units, since masses are in u.
UNITS = {
    "lj": Units("sigma", "tau", "sigma/tau"),
    "real": Units("Angstrom", "fs", "Angstrom/fs"),
    "metal": Units("Angstrom", "ps", "Angstrom/ps"),
    "si": Units("m", "s", "m/s"),
    "cgs": Units("cm", "s", "cm/s"),
    "electron": Units("Bohr", "fs", "Bohr/LAMMPS-electron-time"),
    "micro": Units("um", "us", "um/us"),
    "nano": Units("nm", "ns", "nm/ns"),
}

#: Columns of positions, as they are preferred: the last letters of their names. "s": fractions of the box; "u": already
#: unwrapped, so that no image flags are added.
_FORMS = ("u", "su", "", "s")
#: Quantities of `Frame` -> columns.
_COLUMNS = {
    "velocities": ("vx", "vy", "vz"),
    "spins": ("omegax", "omegay", "omegaz"),
    "masses": ("mass",),
    "diameters": ("diameter", "radius"),
}


@dataclass(frozen=True)
class _Dump(Source):
    keys: tuple[FrameKey, ...] = ()

    @cached_property
    def _file(self) -> IO[bytes]:
        return opened(self.path)

    def _frame(self, index: int) -> Frame:
        key = self.keys[index]
        return _as_frame(read_frame(self._file, key), float(self.times[index]))


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    return is_dump(path)


def open_file(path: Path, topology: Path | None) -> Source:
    """Opens a dump. path: of the file. topology: not used. ValueError, with the reason, if no frame of it is whole.

    Times are those of ITEM: TIME, else steps.
    """
    found = dump_index(path)
    keys = found.keys
    if not keys:
        raise ValueError(found.cut or "there is no frame")
    timed = all(key.time is not None for key in keys)
    units = UNITS.get(found.units, Units())
    sample = found.sample
    return _Dump(
        path,
        FORMAT if sample is None or sample.decimals else f"{FORMAT}, binary",
        np.array([key.time if timed else key.step for key in keys], dtype=np.float64),
        np.array([key.step for key in keys]),
        "unwrapped" if sample is None else _wrapping(keys, sample.boundary),
        units if timed else Units(units.length, "step", units.velocity),
        EXACT if sample is None else _rounding(sample),
        tuple(_remarks(found, timed)),
        keys,
    )


def _remarks(found: DumpIndex, timed: bool) -> Iterator[str]:
    keys, sample = found.keys, found.sample
    if found.cut:
        yield Cut(f"what follows step {keys[-1].step} is not read: {found.cut}.")
    for reason in found.broken:
        yield f"{reason}, and another frame follows: it is left out."
    if not timed:
        stated = sum(key.time is not None for key in keys)
        some = f", and times of {stated} of {len(keys)} frames" if stated else " and no times"
        yield f"it states steps{some} (dump_modify time yes states all)."
    if "id" not in keys[0].names:
        yield "it has no column id: particles are taken in the order of the file, which LAMMPS changes."
    if any(key.names != keys[0].names for key in keys):
        other = next(key for key in keys if key.names != keys[0].names)
        yield f"its columns change at step {other.step}."
    if sample is None:
        yield "none of its frames has particles."
    elif not any(sample.boundary):
        yield "it does not state which boundaries are periodic: none is taken to be."


def _form(names: Sequence[str]) -> str:
    """Which of `_FORMS` these columns have; ValueError without coordinates. In the plane, there may be no z."""
    for form in _FORMS:
        if all(f"{axis}{form}" in names for axis in "xyz"):
            return form
    for form in _FORMS:
        if all(f"{axis}{form}" in names for axis in "xy") and not any(f"z{other}" in names for other in _FORMS):
            return form
    raise ValueError("it has no coordinates: dump x y z, xs ys zs, xu yu zu or xsu ysu zsu")


def _wrapping(keys: Sequence[FrameKey], boundary: Sequence[str]) -> Wrapping:
    """Whether all frames state in which image of the box a particle is."""
    for names in {key.names for key in keys}:
        if "u" in _form(names):
            continue
        if any(kind == "pp" and not _still(names, k) for k, kind in enumerate(boundary) if f"i{'xyz'[k]}" not in names):
            return "wrapped"
    return "unwrapped"


def _still(names: Sequence[str], axis: int) -> bool:
    """Whether particles have no coordinate along this axis."""
    return axis == 2 and "z" not in {name[0] for name in names if name[1:] in _FORMS}


def _positions(frame: DumpFrame) -> Floats:
    """Positions (N, 3), unwrapped as far as the columns allow. ValueError without coordinates."""
    columns = frame.columns
    form = _form(tuple(columns))
    number = len(next(iter(columns.values())))
    flat = f"z{form}" not in columns
    values = np.stack([columns.get(f"{axis}{form}", np.zeros(number)) for axis in "xyz"], axis=1)
    if "s" in form:
        values = moved(np.broadcast_to(frame.lower, values.shape), values, frame.vectors)
        if flat:
            values[:, 2] = 0.0
    if "u" not in form:
        images = np.stack([columns.get(f"i{axis}", np.zeros(number, dtype=np.int64)) for axis in "xyz"], axis=1)
        if images.any():
            values = moved(values, images, frame.vectors)
    return np.ascontiguousarray(values, dtype=np.float64)


def _vectors(frame: DumpFrame, names: Sequence[str]) -> Floats | None:
    """Vectors (N, 3); in the plane, there may be no third component."""
    if not all(name in frame.columns for name in names[:2]):
        return None
    number = len(frame.columns[names[0]])
    return np.stack([frame.columns.get(name, np.zeros(number)) for name in names], axis=1)


def _as_frame(frame: DumpFrame, time: float) -> Frame:
    columns = frame.columns
    positions = _positions(frame)
    number = len(positions)
    ids = columns["id"] if "id" in columns else np.arange(1, number + 1)
    diameters = columns.get("diameter")
    if diameters is None and "radius" in columns:
        diameters = 2 * columns["radius"]
    types = next((columns[name] for name in ("type", "typelabel", "element") if name in columns), None)
    periodic = np.array([flag == "pp" for flag in frame.boundary])
    return ordered(
        Frame(
            time,
            frame.step,
            ids,
            positions,
            _vectors(frame, _COLUMNS["velocities"]),
            _vectors(frame, _COLUMNS["spins"]),
            types,
            columns.get("mass"),
            diameters,
            Box(frame.vectors, frame.lower, periodic, stated=any(frame.boundary)),
        )
    )


def _rounding(frame: DumpFrame) -> dict[str, Rounding]:
    """By how much the file has rounded each quantity, from the decimals of a frame."""
    form = _form(tuple(frame.columns))
    coordinates = tuple(f"{axis}{form}" for axis in "xyz")
    found: dict[str, Rounding] = {}
    for quantity, names in (_COLUMNS | {"positions": coordinates}).items():
        found[quantity] = of_decimals([word for name in names for word in frame.decimals.get(name, ())])
    found["box"] = _of_bounds(frame)
    if "diameter" not in frame.columns:
        found["diameters"] = found["diameters"]._replace(absolute=2 * found["diameters"].absolute)
    if "s" in form:
        fractions = np.stack([frame.columns[name] for name in coordinates if name in frame.columns])
        largest = float(np.abs(fractions).max())
        if form == "su":
            positions = found["positions"]
            found["positions"] = positions._replace(absolute=positions.absolute + _of_counter(fractions))
        found["positions"] = scaled(found["positions"], frame.vectors, frame.lower, largest)
    if "u" not in form and any(f"i{axis}" in frame.columns for axis in "xyz"):
        found["positions"] = unwrapped(found["positions"], frame.vectors)
    return found


def _of_bounds(frame: DumpFrame) -> Rounding:
    """Rounding of the edges, differences of two printed bounds."""
    bound = of_decimals(frame.decimals.get(BOUNDS, ()))
    reach = float(np.abs(frame.lower).max())
    return bound._replace(absolute=2 * (bound.absolute + bound.relative * reach), relative=2 * bound.relative)


def _of_counter(fractions: Floats) -> float:
    """Rounding of unwrapped fractions of the box by LAMMPS itself: it adds its counter of images, which begins at 2^9
    (2^20 where image flags have 64 bits), and takes that number away again. Left are multiples of 2^-43 (2^-32)."""
    units = fractions * 2.0**32
    return 2.0**-33 if (np.abs(units - np.rint(units)) < 2.0**-14).all() else 2.0**-44
