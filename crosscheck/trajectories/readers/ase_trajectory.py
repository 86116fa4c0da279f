"""Trajectories of ASE (.traj), read by ASE."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.trajectories.frames import DOUBLE, EXACT, Box, Cut, Frame, Source, Units, first_line

FORMAT = "ASE trajectory"
HOLDS = "frames"
#: How such a file begins.
_MAGIC = b"- of UlmASE-Trajectory"
#: ASE's unit of time, (u/eV)^1/2 Angstrom, has no name of its own.
_UNITS = Units("Angstrom", "", "Angstrom/ASE-time")


@dataclass(frozen=True)
class _Trajectory(Source):
    @cached_property
    def _file(self) -> Any:
        from ase.io.trajectory import Trajectory

        return Trajectory(str(self.path))

    def _frame(self, index: int) -> Frame:
        """The numbers as they stand in the file; velocities are momenta over masses, which are the file's, or ASE's."""
        atoms = self._file[index]
        moving = "momenta" in atoms.arrays
        names = np.array(atoms.get_chemical_symbols())
        cell = np.array(atoms.cell, dtype=np.float64)
        return Frame(
            float(self.times[index]),
            None,
            np.arange(1, len(atoms) + 1),
            atoms.arrays["positions"],
            np.asarray(atoms.get_velocities()) if moving else None,
            types=None if (names == "X").all() else names,
            masses=np.asarray(atoms.get_masses()) if moving else atoms.arrays.get("masses"),
            box=Box(cell, np.zeros(3), np.array(atoms.pbc)) if cell.any() else None,
        )


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    with path.open("rb") as file:
        return file.read(len(_MAGIC)) == _MAGIC


def open_file(path: Path, topology: Path | None) -> Source:
    """Opens the file. path: of the file. topology: not used. ValueError, or what ASE raises, if it has no whole frame.

    Times are those of `info["time"]`, if it is there.
    """
    from ase.io.trajectory import Trajectory

    times: list[float] = []
    remarks: list[str] = []
    with Trajectory(str(path)) as file:
        count = len(file)
        try:
            for index in range(count):  # without the particles
                times.append(float((file.backend[index].get("info") or {}).get("time", np.nan)))
            file[count - 1]
        except Exception as error:  # ASE raises what it likes for a damaged file
            times = times[: count - 1]
            if not times:
                raise
            remarks.append(Cut.after(len(times), first_line(error)))
    if not times:
        raise ValueError("there is no frame")
    if not np.isfinite(times).all():
        remarks.append("it states no times (a key `time` in Atoms.info would).")
    # velocities were multiplied by masses, and are divided again
    rounding = EXACT | {"velocities": DOUBLE._replace(relative=3 * DOUBLE.relative)}
    return _Trajectory(path, FORMAT, np.array(times), None, "wrapped", _UNITS, rounding, tuple(remarks))
