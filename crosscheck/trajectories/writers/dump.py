"""Dumps of LAMMPS in text, which LAMMPS (`read_dump`), OVITO, ASE and MDAnalysis read.

Every number is the shortest decimal that reads back to the same bits. The columns have LAMMPS's own names; `v_time` is
what its dump writes for `variable time atom time`. The lines `ITEM: TIME` and `ITEM: UNITS` of newer dumps would say
the time once, but MDAnalysis counts the lines of a header, and takes such a file for a damaged one.
"""

from __future__ import annotations

from itertools import repeat
from pathlib import Path

import numpy as np

from crosscheck.trajectories.decimals import decimals
from crosscheck.trajectories.formats import Format
from crosscheck.trajectories.trajectory import Trajectory, box_around

_NAMES = {
    "positions": ("xu", "yu", "zu"),
    "velocities": ("vx", "vy", "vz"),
    "angular_velocities": ("omegax", "omegay", "omegaz"),
}


def write(path: Path, trajectory: Trajectory) -> None:
    """Writes a trajectory to `path`.

    TIMESTEP is the number of steps. Positions are xu yu zu, not wrapped: image flags would add nothing, and a wrapped
    coordinate has fewer bits. Species 0, 1 ... are the types 1, 2 ...; ids are 1 ... N, in the scene's order. The box
    is `box_around`, with boundaries p (periodic), f (a wall), m (no wall, but a box) and s (no box); along an axis that
    the scene does not have it is thin and periodic, as LAMMPS wants it in the plane. trajectory: what to write.
    """
    number = len(trajectory.masses)
    constants = {"mass": trajectory.masses}
    if "radius" in trajectory.more:
        constants["radius"] = trajectory.more["radius"]
    types = (trajectory.species_of_all + 1).tolist()
    known = zip(range(1, number + 1), types, decimals(np.column_stack(list(constants.values()))), strict=True)
    starts = [f"{one} {kind} {values} " for one, kind, values in known]
    vectors = {"positions": trajectory.positions}
    vectors |= {name: trajectory.more[name] for name in _NAMES if name in trajectory.more}
    columns = ["id", "type", *constants, *(one for name in vectors for one in _NAMES[name]), "v_time"]
    edges = "\n".join(decimals(box_around(trajectory)))
    box = f"ITEM: NUMBER OF ATOMS\n{number}\nITEM: BOX BOUNDS {' '.join(_boundaries(trajectory))}\n{edges}\n"
    with path.open("w", encoding="utf-8") as file:
        for sample, (time, step) in enumerate(zip(trajectory.time.tolist(), trajectory.steps.tolist(), strict=True)):
            file.write(f"ITEM: TIMESTEP\n{step}\n{box}ITEM: ATOMS {' '.join(columns)}\n")
            table = np.concatenate([values[sample] for values in vectors.values()], axis=1)
            rows = zip(starts, decimals(table), repeat(f" {time!r}\n"), strict=False)
            file.writelines(start + row + end for start, row, end in rows)


def _boundaries(trajectory: Trajectory) -> list[str]:
    """LAMMPS's two letters of each axis, for its lower and its upper face."""
    letters = []
    for axis in range(3):
        if axis >= trajectory.dimension or trajectory.periodic[axis]:
            letters.append("pp")
        else:
            open_face = "m" if trajectory.cell[axis] > 0 else "s"
            letters.append("".join("f" if wall else open_face for wall in trajectory.walled[axis]))
    return letters


FORMAT = Format("lammpsdump", write, ("velocities", "angular_velocities", "radius"))
