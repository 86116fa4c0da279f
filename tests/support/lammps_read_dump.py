"""LAMMPS reads dumps: `python -P lammps_read_dump.py DIRECTORY FILE DIMENSION [FILE DIMENSION ...]`, on its own.

FILE.npz beside each: `step` (S,), `x`, `v` (S, N, 3), positions not wrapped, and `type` (S, N), in the order of ids.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np

from crosscheck.engines.lammps.instance import load


def read(file: str, dimension: str) -> dict[str, Any]:
    with open(file, encoding="utf-8") as opened:
        lines = opened.read().splitlines()
    number, columns = int(lines[3]), lines[8].split()[2:]
    steps = [int(lines[k + 1]) for k, line in enumerate(lines) if line == "ITEM: TIMESTEP"]
    types = max(int(line.split()[columns.index("type")]) for line in lines[9 : 9 + number])
    lmp = load().lammps(cmdargs=["-log", "none", "-screen", "none"])
    lmp.commands_list(
        [
            "units lj",
            f"dimension {dimension}",
            "atom_modify map array sort 0 0",
            f"boundary {' '.join(lines[4].split()[3:])}",
            f"region box block {' '.join(lines[5:8])} units box",
            f"create_box {types} box",
            "mass * 1.0",
        ]
    )
    found: dict[str, list[Any]] = {"x": [], "v": [], "type": []}
    axes = "xyz"[: int(dimension)]  # in a plane, LAMMPS refuses to read the third coordinate
    fields = " ".join([*axes, *(f"v{axis}" for axis in axes if "vx" in columns)])
    for step in steps:
        lmp.command(f'read_dump "{file}" {step} {fields} box yes wrapped no replace no purge yes add keep')
        lower, upper = map(np.array, lmp.extract_box()[:2])
        images = np.array(lmp.gather_atoms("image", 0, 3)).reshape(-1, 3)
        found["x"].append(np.array(lmp.gather_atoms("x", 1, 3)).reshape(-1, 3) + images * (upper - lower))
        found["v"].append(np.array(lmp.gather_atoms("v", 1, 3)).reshape(-1, 3))
        found["type"].append(np.array(lmp.gather_atoms("type", 0, 1)))
    lmp.close()
    return {"step": steps, **found}


def main(directory: str, *words: str) -> None:
    os.chdir(directory)
    for file, dimension in zip(words[::2], words[1::2], strict=True):
        np.savez(f"{file}.npz", **read(file, dimension))


if __name__ == "__main__":
    main(*sys.argv[1:])
