"""DCD, read by MDAnalysis in the file's own units.

A DCD file states no units, and its programs write different things: CHARMM and those who follow it have times in units
of (u Angstrom^2 mol/kcal)^1/2, LAMMPS has its own unit, and what VMD writes has none.
"""

from __future__ import annotations

import os
import struct
import warnings
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.trajectories.frames import DOUBLE, EXACT, SINGLE, Box, Cut, Floats, Integers, Units
from crosscheck.trajectories.readers._coordinates import NO_TOPOLOGY, Coordinates, Numbers, decimal, read_topology
from crosscheck.trajectories.vectors import from_cosines

FORMAT = "DCD"
HOLDS = "frames"

#: Words in the title of a file by which its program is known.
_LAMMPS, _VMD = "LAMMPS", "DCD plugin"
#: Where the header has the number of frames and the last step (bytes), and how it begins.
_FRAMES, _LAST, _FIRST_BLOCK = 8, 20, 84


@dataclass(frozen=True)
class _Dcd(Coordinates):
    @cached_property
    def _reader(self) -> Any:
        return _opened(self.path)

    def numbers(self, index: int) -> Numbers:
        """See `Coordinates`."""
        self._reader.seek(index)
        frame = self._reader.read()
        box = _box(np.array(frame.unitcell)) if self._reader.header["is_periodic"] else None
        return Numbers(np.array(frame.xyz, dtype=np.float64), None, box)


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    return path.suffix == ".dcd"


def open_file(path: Path, topology: Path | None) -> Coordinates:
    """Opens the file. path: of the file. topology: ids, types and masses of the particles; None: they are 1, 2 ...

    ValueError, or what MDAnalysis raises, if no frame of it is whole.
    """
    reader = _opened(path)
    count = len(reader)
    if not count:
        raise ValueError("there is no whole frame")
    header = reader.header
    frames, last = _stated(path)
    remarks: list[str] = []
    if frames > count:
        remarks.append(Cut.after(count, f"of {frames} frames, {count} are whole"))
    title = str(header["remarks"])
    steps = int(header["istart"]) + np.arange(count) * int(header["nsavc"])
    step_length = decimal(header["delta"])
    units = Units("Angstrom", "ps", "")
    if _LAMMPS in title:
        units = Units()
        remarks.append("a DCD file of LAMMPS states no units: its own are taken.")
        steps = _of_lammps(steps, last, int(header["nsavc"])) if frames == count else steps
        times = np.asarray(step_length * steps, dtype=np.float64)
    elif _VMD in title or not step_length:
        remarks.append("it states no times.")
        times = np.full(count, np.nan)
    else:
        from MDAnalysis.units import convert

        remarks.append("a DCD file states no units: those of CHARMM are taken.")
        times = np.array([decimal(time) for time in convert(step_length, "AKMA", "ps") * steps])
    if topology is None:
        remarks.append(NO_TOPOLOGY)
    return _Dcd(
        path,
        FORMAT,
        times,
        None if _VMD in title else steps,
        "wrapped",
        units,
        # edges are computed from angles
        EXACT | {"positions": SINGLE, "box": DOUBLE._replace(relative=8 * DOUBLE.relative)},
        tuple(remarks),
        read_topology(topology),
    )


def _opened(path: Path) -> Any:
    from MDAnalysis.lib.formats.libdcd import DCDFile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return DCDFile(os.fspath(path))


def _stated(path: Path) -> tuple[int, int]:
    """Number of frames and last step, as the header states them."""
    with path.open("rb") as file:
        data = file.read(24)
    order = "<" if struct.unpack_from("<i", data)[0] == _FIRST_BLOCK else ">"
    return struct.unpack_from(f"{order}i", data, _FRAMES)[0], struct.unpack_from(f"{order}i", data, _LAST)[0]


def _of_lammps(steps: Integers, last: int, every: int) -> Integers:
    """Steps of a file by LAMMPS: its first frame may be of any step, the next ones are of multiples of the interval."""
    from_end = last - np.arange(len(steps))[::-1] * every
    if len(steps) > 1 and last != steps[-1] and 0 < from_end[1] - steps[0] < every:
        return np.append(steps[:1], from_end[1:])
    return steps


def _box(cell: Floats) -> Box | None:
    """The box of a, gamma, b, beta, alpha, c, with angles or their cosines; or, of newer CHARMM, of the six numbers of
    a symmetric matrix of edges. None: it is 0."""
    a, gamma, b, beta, alpha, c = map(float, cell)
    angles = np.array([alpha, beta, gamma])
    if (np.abs(angles) <= 1).all():  # as LAMMPS, NAMD and VMD write them
        vectors = from_cosines((a, b, c), angles)
    elif (cell < 0).any() or (angles > 180).any():
        vectors = np.array([[a, gamma, beta], [gamma, b, alpha], [beta, alpha, c]])
    else:
        vectors = from_cosines((a, b, c), [0.0 if one == 90 else np.cos(np.radians(one)) for one in angles])
    return Box(vectors, np.zeros(3), np.abs(vectors).sum(axis=1) > 0, stated=False) if vectors.any() else None
