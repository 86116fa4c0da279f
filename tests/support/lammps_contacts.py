"""Forces and torques of LAMMPS's contact laws: `python -P lammps_contacts.py in.npz out.npz`, a process of its own.

in.npz: `positions`, `velocities`, `spins` (N, 3), `radii`, `masses` (N,), `dimension` (2 or 3), and the commands
`pair_style` and `pair_coeff`, whole lines. Optional: `steps` and `dt`, of `fix nve/sphere`; `disc`, true for
I = m R^2/2. Open space, one atom type, units lj.

out.npz: `forces`, `torques` (N, 3) at the given state: without a step, so tangential springs are not stretched. With
`steps`: also `x`, `v`, `omega`, `f`, `torque` (steps + 1, N, 3), the start first. After the start, f and torque are
those of velocities and spins half a step earlier: v_{n-1} + f_{n-1} dt/(2 m), and so for the spins; springs are
stretched by dt times their slip.
"""

from __future__ import annotations

import ctypes
import sys

import numpy as np

from crosscheck.engines.lammps.engine import LammpsEngine
from crosscheck.engines.lammps.instance import load


def main(source: str, target: str) -> None:
    given = dict(np.load(source))
    LammpsEngine().version()  # says what is missing, if anything is
    lmp = load().lammps(cmdargs=["-log", "none", "-screen", "none"])
    x, number, plane = given["positions"], len(given["positions"]), int(given["dimension"]) == 2
    margin = 2 * float(given["radii"].max())
    edges = np.stack([x.min(axis=0) - margin, x.max(axis=0) + margin], axis=1)
    if plane:
        edges[2] = -0.5, 0.5
    lmp.commands_list(
        [
            "units lj",
            f"dimension {2 if plane else 3}",
            "atom_style sphere",
            "atom_modify map array sort 0 0",
            f"boundary s s {'p' if plane else 's'}",
            f"region box block {' '.join(repr(float(edge)) for edge in edges.ravel())} units box",
            "create_box 1 box",
            "comm_modify vel yes",
            f"neighbor {0.1 * margin!r} nsq",
        ]
    )
    lmp.create_atoms(number, list(range(1, number + 1)), [1] * number, x.ravel().tolist())
    for name, values in {
        "v": given["velocities"],
        "omega": given["spins"],
        "radius": given["radii"],
        "rmass": given["masses"],
    }.items():
        flat = np.ascontiguousarray(values, dtype=np.float64).ravel()
        lmp.scatter_atoms(name, 1, flat.size // number, (ctypes.c_double * flat.size)(*flat))
    disc = " disc" if given.get("disc") else ""
    lmp.commands_list(
        [
            str(given["pair_style"]),
            str(given["pair_coeff"]),
            f"fix integrate all nve/sphere{disc}",
            *(["fix plane all enforce2d"] if plane else []),
            f"timestep {float(given.get('dt', 1.0))!r}",
            "run 0 post no",
        ]
    )

    def read() -> dict[str, np.ndarray]:
        names = ("x", "v", "omega", "f", "torque")
        return {name: np.array(lmp.gather_atoms(name, 1, 3)).reshape(number, 3) for name in names}

    path = [read()]
    for _ in range(int(given.get("steps", 0))):
        lmp.command("run 1 pre no post no")
        path.append(read())
    steps = {name: np.array([row[name] for row in path]) for name in path[0]} if "steps" in given else {}
    np.savez(target, forces=path[0]["f"], torques=path[0]["torque"], **steps)
    lmp.close()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
