"""Extended XYZ, which ASE and OVITO read; others read its first columns as plain XYZ.

Every number is the shortest decimal that reads back to the same bits: ASE's own writer keeps eight decimals.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from crosscheck.scene import Floats
from crosscheck.trajectories.decimals import decimals
from crosscheck.trajectories.formats import Format
from crosscheck.trajectories.trajectory import Trajectory


def write(path: Path, trajectory: Trajectory) -> None:
    """Writes a trajectory to `path`, positions not wrapped.

    trajectory: what to write. Species 0, 1, ... are named H, He, ...; without species the particles are called X. Where
    there are more species than elements, all are called X, and the column `species_number` has their numbers.
    Velocities are also written as momenta, which is what ASE reads.
    """
    number = len(trajectory.masses)
    names, numbers = _species(trajectory)
    lattice = ""
    if trajectory.cell.any():
        lattice = f'Lattice="{next(decimals(np.diag(trajectory.cell).reshape(1, 9)))}" '
    around = " ".join("T" if one else "F" for one in trajectory.periodic)
    constants = {"masses": trajectory.masses}
    constants |= {name: values for name, values in trajectory.more.items() if values.ndim == 1}
    ends = [f"{text}{mark}\n" for text, mark in zip(decimals(_side_by_side(constants)), numbers, strict=True)]
    with path.open("w", encoding="utf-8") as file:
        for sample, time in enumerate(trajectory.time.tolist()):
            vectors = {"pos": trajectory.positions[sample]}
            for name, values in trajectory.more.items():
                if values.ndim == 1:
                    continue
                if name == "velocities":
                    with np.errstate(over="ignore"):
                        vectors["momenta"] = values[sample] * trajectory.masses[:, None]
                vectors[name] = values[sample]
            columns = ["species:S:1", *(f"{name}:R:3" for name in vectors), *(f"{name}:R:1" for name in constants)]
            columns += ["species_number:I:1"] if any(numbers) else []
            file.write(f'{number}\n{lattice}Properties={":".join(columns)} time={time!r} pbc="{around}"\n')
            rows = zip(names, decimals(_side_by_side(vectors)), ends, strict=True)
            file.writelines(f"{name} {row} {end}" for name, row, end in rows)


def _side_by_side(columns: dict[str, Floats]) -> Floats:
    """The columns, each (N,) or (N, k), as one table."""
    return np.column_stack(list(columns.values()))


def _species(trajectory: Trajectory) -> tuple[list[str], list[str]]:
    """The name of each particle, and what ends its line: " number", where names cannot say it, else nothing."""
    from ase.data import chemical_symbols

    species = trajectory.species
    if species is None:
        return ["X"] * len(trajectory.masses), [""] * len(trajectory.masses)
    if species.max() + 1 < len(chemical_symbols):
        return [chemical_symbols[one + 1] for one in species], [""] * species.size
    return ["X"] * species.size, [f" {one}" for one in species.tolist()]


FORMAT = Format("extxyz", write, ("velocities", "angular_velocities", "radius"))
