"""NetCDF in AMBER's convention, as AMBER and LAMMPS (dump netcdf) write it, read by the package netCDF4.

MDAnalysis reads AMBER's format alone: not the one that LAMMPS writes today (CDF-5, its own units and ids), and 32 bits
of each number.

Literature: AMBER NetCDF trajectory/restart convention, version 1.0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.trajectories.frames import (
    DOUBLE,
    SINGLE,
    Box,
    Cut,
    Floats,
    Frame,
    Rounding,
    Source,
    Units,
    Wrapping,
    chosen,
    ordered,
)
from crosscheck.trajectories.readers._coordinates import NO_TOPOLOGY, Topology, decimal, read_topology
from crosscheck.trajectories.readers._netcdf_header import whole_frames
from crosscheck.trajectories.rounding import scaled, unwrapped
from crosscheck.trajectories.vectors import from_cosines, moved

FORMAT = "NetCDF"
HOLDS = "frames"

#: Names of units in such files.
_NAMES = {
    "angstrom": "Angstrom",
    "nanometers": "nm",
    "nanometer": "nm",
    "micrometers": "um",
    "centimeter": "cm",
    "meter": "m",
    "Bohr": "Bohr",
    "picosecond": "ps",
    "femtosecond": "fs",
    "femtoseconds": "fs",
    "nanosecond": "ns",
    "nanoseconds": "ns",
    "microsecond": "us",
    "microseconds": "us",
    "second": "s",
    "atomic time units": "LAMMPS-electron-time",
}
#: How files of the classic formats begin, and those that are HDF5 files.
_CLASSIC, _HDF5 = b"CDF", b"\x89HDF\r\n"
#: Variables that hold positions, as they are preferred.
_POSITIONS = ("unwrapped_coordinates", "coordinates", "scaled_coordinates")
_SPINS, _IMAGES = ("omegax", "omegay", "omegaz"), ("ix", "iy", "iz")
#: Whole numbers up to here have a number of 32 bits each.
_MOST_STEPS = 2**24


@dataclass(frozen=True)
class _NetCdf(Source):
    topology: Topology | None = None

    @cached_property
    def _file(self) -> Any:
        return _opened(self.path)

    def _frame(self, index: int) -> Frame:
        file = self._file
        box = _box(file, index)
        positions = _positions(file, index, box)
        ids, types, masses = (_value(file, name, index) for name in ("id", "type", "mass"))
        diameters, known = _diameters(file, index), self.topology
        if known is not None and len(known.ids) != len(positions):
            raise ValueError(f"the topology has {len(known.ids)} particles, the coordinates {len(positions)}")
        if ids is None:
            ids = np.arange(1, len(positions) + 1) if known is None else known.ids
        if known is not None:
            order = np.searchsorted(known.ids, ids)
            types = types if types is not None or known.types is None else known.types[order]
            masses = masses if masses is not None or known.masses is None else known.masses[order]
            diameters = diameters if diameters is not None or known.diameters is None else known.diameters[order]
        frame = Frame(
            float(self.times[index]),
            None if self.steps is None else int(self.steps[index]),
            ids.astype(np.int64),
            positions,
            _value(file, "velocities", index),
            _vectors(file, _SPINS, index),
            types,
            masses,
            diameters,
            box,
        )
        return ordered(chosen(frame, ids > 0))  # particles that a run of LAMMPS has lost leave the fill value


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    with path.open("rb") as file:
        start = file.read(len(_HDF5))
    return start.startswith(_CLASSIC) or (start == _HDF5 and path.suffix in (".nc", ".ncdf", ".netcdf"))


def open_file(path: Path, topology: Path | None) -> Source:
    """Opens the file. path: of the file. topology: types and masses of the particles, and ids if the file has none.

    Times are in the file's unit; LAMMPS stores steps, and the length of a step as a factor. ValueError if no frame of
    it is whole, or if there are no coordinates.
    """
    remarks: list[str] = []
    with _opened(path) as file:
        name = _of_positions(file)
        framed = "frame" in file[name].dimensions
        count = len(file.dimensions["frame"]) if framed else 1
        with path.open("rb") as raw:
            classic = raw.read(len(_CLASSIC)) == _CLASSIC
        whole = whole_frames(path) if classic and framed else count
        if whole < count:
            remarks.append(Cut.after(whole, f"{whole} of {count} are whole"))
            count = whole
        if not count:
            raise ValueError("there is no whole frame")
        times, steps = _times(file, count)
        if steps is not None and file["time"].dtype.itemsize == 4 and steps.max() > _MOST_STEPS:
            remarks.append("its steps have 32 bits and are rounded.")
        if topology is None and "type" not in file.variables and "mass" not in file.variables:
            remarks.append(NO_TOPOLOGY)
        if not np.isfinite(times).all():
            remarks.append("it states no times.")
        imaged = name == _POSITIONS[0] or all(one in file.variables for one in _IMAGES)
        wrapping: Wrapping = "unwrapped" if imaged else "wrapped"
        units, rounding = _units(file, name), _rounding(file, name)
    return _NetCdf(path, FORMAT, times, steps, wrapping, units, rounding, tuple(remarks), read_topology(topology))


def _opened(path: Path) -> Any:
    import netCDF4

    file = netCDF4.Dataset(str(path))
    file.set_auto_maskandscale(False)
    return file


def _of_positions(file: Any) -> str:
    """The variable with the positions; ValueError if there is none."""
    found = next((name for name in _POSITIONS if name in file.variables), None)
    if found is None:
        raise ValueError(f"there is no variable {', '.join(_POSITIONS)}")
    return found


def _times(file: Any, count: int) -> tuple[Floats, Any]:
    """Times of the frames, NaN without; and steps, or None."""
    if "time" not in file.variables:
        return np.full(count, np.nan), None
    values = np.atleast_1d(np.asarray(file["time"][...]))[:count]
    factor = decimal(getattr(file["time"], "scale_factor", 1.0))
    if getattr(file, "program", "") == "LAMMPS":
        return np.asarray(values.astype(np.float64) * factor), np.rint(values).astype(np.int64)
    exact = values.astype(np.float64) if values.dtype.itemsize == 8 else np.array([decimal(time) for time in values])
    return exact * factor, None


def _units(file: Any, positions: str) -> Units:
    """Units of length, time and velocity by their names; "" for those that are not stated or not known."""

    def unit(name: str, reduced: str) -> str:
        text = str(getattr(file.variables.get(name), "units", ""))
        if text == "lj":
            return reduced
        parts = [_NAMES.get(part.strip(), "") for part in text.split("/")]
        return "/".join(parts) if all(parts) else ""

    length = positions if positions != _POSITIONS[2] else "cell_lengths"
    return Units(unit(length, "sigma"), unit("time", "tau"), unit("velocities", "sigma/tau"))


def _value(file: Any, name: str, index: int) -> Any:
    """A variable at one frame, or one that is constant in time; floating-point numbers as doubles. None without it."""
    if name not in file.variables:
        return None
    variable = file[name]
    values = np.asarray(variable[index] if "frame" in variable.dimensions else variable[...])
    if values.dtype.kind != "f":
        return values
    return values.astype(np.float64) * float(getattr(variable, "scale_factor", 1.0))


def _vectors(file: Any, names: tuple[str, ...], index: int) -> Any:
    """Vectors whose components are variables; None if one is not there."""
    parts = [_value(file, name, index) for name in names]
    return None if any(part is None for part in parts) else np.stack(parts, axis=1)


def _diameters(file: Any, index: int) -> Any:
    diameters, radii = _value(file, "diameter", index), _value(file, "radius", index)
    return diameters if diameters is not None or radii is None else 2 * radii


def _box(file: Any, index: int) -> Box | None:
    """The box; edges of length 0 are those along which nothing is periodic."""
    lengths, angles = _value(file, "cell_lengths", index), _value(file, "cell_angles", index)
    if lengths is None or not lengths.any():
        return None
    cosines = np.zeros(3) if angles is None else np.where(angles == 90, 0.0, np.cos(np.radians(angles)))
    lower = _value(file, "cell_origin", index)
    return Box(from_cosines(lengths, cosines), np.zeros(3) if lower is None else lower, lengths > 0)


def _positions(file: Any, index: int, box: Box | None) -> Floats:
    name = _of_positions(file)
    values = np.asarray(_value(file, name, index))
    if name == _POSITIONS[2]:
        if box is None or not box.vectors.any(axis=1).all():
            raise ValueError("positions are fractions of a box that it does not state")
        values = moved(np.broadcast_to(box.lower, values.shape), values, box.vectors)
    images = None if name == _POSITIONS[0] or box is None else _vectors(file, _IMAGES, index)
    return values if images is None or box is None else moved(values, images, box.vectors)


def _rounding(file: Any, positions: str) -> dict[str, Rounding]:
    """By how much the file has rounded each quantity: 32 or 64 bits, and what a factor rounds."""

    def held(name: str) -> Rounding:
        if name not in file.variables:
            return DOUBLE
        found = SINGLE if file[name].dtype.itemsize == 4 else DOUBLE
        factor = float(getattr(file[name], "scale_factor", 1.0))
        return found if factor == 1 else found._replace(relative=found.relative + DOUBLE.relative)

    found = {
        "positions": held(positions),
        "velocities": held("velocities"),
        "spins": held(_SPINS[0]),
        "masses": held("mass"),
        "diameters": held("diameter" if "diameter" in file.variables else "radius"),
        "box": held("cell_lengths"),
    }
    box = _box(file, 0)
    if box is not None and positions == _POSITIONS[2]:
        found["positions"] = scaled(found["positions"], box.vectors, box.lower, 1.0)
    if box is not None and positions != _POSITIONS[0] and _IMAGES[0] in file.variables:
        found["positions"] = unwrapped(found["positions"], box.vectors)
    return found
