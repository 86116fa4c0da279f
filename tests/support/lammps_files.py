"""Files that LAMMPS writes, in all its ways, and what it held in memory when it wrote them.

Run as a program, in a process of its own: python lammps_files.py DIRECTORY. Beside the files it leaves `truth.npz`: the
arrays of each run at the steps of its dumps, by run and name, "lj/x" (F, N, 3) and so on, in the order of the ids.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

#: Steps between frames, and frames, of every run.
EVERY, FRAMES = 20, 5

LIQUID = """
units lj
lattice fcc 0.8442
region box block 0 3 0 3 0 3
create_box 2 box
create_atoms 1 box
set atom 1*20 type 2
mass 1 1.0
mass 2 2.5
velocity all create 3.0 87287 loop geom
pair_style lj/cut 2.5
pair_coeff * * 1.0 1.0 2.5
neigh_modify every 1 delay 0 check yes
timestep 0.005
fix 1 all nve
dump full all custom 20 unwrapped.dump id type mass xu yu zu vx vy vz
dump_modify full format float %.17g time yes units yes
dump plain all custom 20 plain.dump id type x y z ix iy iz vx vy vz
dump scaled all custom 20 scaled.dump id type xs ys zs ix iy iz
dump_modify scaled format float %.17g
dump su all custom 20 su.dump id type xsu ysu zsu
dump_modify su format float %.17g
dump gz all custom 20 zipped.dump.gz id type x y z ix iy iz
dump_modify gz format float %.17g time yes
dump bin all custom 20 binary.bin id type x y z ix iy iz vx vy vz
dump_modify bin time yes units yes
dump el all custom 20 element.dump element id x y z
dump_modify el element Ar Kr sort id
dump atom all atom 20 atom.dump
variable time atom time
dump time all custom 20 v_time.dump id type v_time x y z
dump dcd all dcd 20 lj.dcd
dump xtc all xtc 1 lj.xtc
dump xyz all xyz 20 lj.xyz
dump_modify xyz time yes
dump ext all extxyz 20 lj.extxyz
dump_modify ext element Ar Kr format line "%s %.17g %.17g %.17g %.17g %.17g %.17g %g %g %g"
thermo 20
compute more all pressure NULL virial
thermo_style custom step time temp etotal press c_more[1]
"""
TILTED = """
units metal
atom_style charge
region box prism 0 10 -1 11 0 12 2 1 -1.5
create_box 1 box
create_atoms 1 random 40 12345 box
mass 1 39.948
velocity all create 3000 4928
pair_style zero 3
pair_coeff * *
timestep 0.001
fix 1 all nve
dump x all custom 20 tilted.dump id type x y z ix iy iz
dump_modify x format float %.17g
dump su all custom 20 tilted_su.dump id type xsu ysu zsu
dump_modify su format float %.17g
dump bin all custom 20 tilted.bin id type x y z ix iy iz
dump dcd all dcd 20 tilted.dcd
dump xtc all xtc 1 tilted.xtc
"""
GENERAL = """
units metal
lattice custom 4.0 a1 1 0 0.3 a2 0.4 1 0 a3 0 0.2 1 basis 0 0 0 triclinic/general
create_box 1 NULL 0 3 0 3 0 3
create_atoms 1 box
mass 1 39.948
velocity all create 300 4928
pair_style zero 3
pair_coeff * *
fix 1 all nve
dump x all custom 20 general.dump id type x y z
dump_modify x triclinic/general yes format float %.17g
dump bin all custom 20 general.bin id type x y z
dump_modify bin triclinic/general yes
"""
GRAINS = """
units si
atom_style sphere
boundary p p f
region box block 0 1 0 1 0 2
create_box 1 box
create_atoms 1 random 30 123 box overlap 0.11 maxtry 500
set type 1 diameter 0.1
set atom 1*10 diameter 0.08
set type 1 density 2500
velocity all create 1e23 4928
set group all omega 1.0 2.0 3.0
set atom 5 omega 0.1 0.2 0.3
comm_modify vel yes
pair_style granular
pair_coeff * * hooke 1e4 10 tangential linear_history 1e3 1 0.5
timestep 1e-4
fix 1 all nve/sphere
fix 2 all gravity 9.81 vector 0 0 -1
dump x all custom 20 grains.dump id type x y z vx vy vz omegax omegay omegaz radius mass
dump_modify x format float %.17g
"""
FLAT = """
units lj
dimension 2
lattice hex 0.8
region box block 0 4 0 4 -0.5 0.5
create_box 1 box
create_atoms 1 box
mass 1 1
velocity all create 2 4928
pair_style lj/cut 2.5
pair_coeff * * 1 1
fix 1 all nve
fix 2 all enforce2d
dump x all custom 20 flat.dump id type x y vx vy ix iy
dump_modify x format float %.17g
"""
FULL = """
units real
atom_style full
region box block 0 20 0 20 0 20
create_box 2 box
create_atoms 1 random 20 123 box overlap 1 maxtry 500
set atom 1*5 type 2
set group all mol 3
set type 1 charge 0.5
mass 1 16
mass 2 1
velocity all create 300 4928
pair_style zero 3
pair_coeff * *
fix 1 all nve
delete_atoms random count 4 yes all NULL 99
labelmap atom 1 O 2 H
dump x all custom 20 labels.dump id typelabel x y z
"""
RUNS = {"lj": LIQUID, "tilted": TILTED, "general": GENERAL, "grains": GRAINS, "flat": FLAT, "full": FULL}


def run(lammps: Any, name: str, text: str) -> dict[str, Any]:
    """Runs one, writes its data file, and returns what LAMMPS held at each dump."""
    lmp = lammps(cmdargs=["-log", f"log.{name}", "-screen", "none"])
    lmp.commands_list(text.strip().splitlines())
    kept: dict[str, list[Any]] = {"x": [], "v": [], "image": [], "step": []}
    for frame in range(FRAMES):
        lmp.command(f"run {EVERY if frame else 0} {'pre no' if frame else ''} post no")
        kept["x"].append(_gathered(lmp, "x", 1, 3))
        kept["v"].append(_gathered(lmp, "v", 1, 3))
        kept["image"].append(_gathered(lmp, "image", 0, 3))
        kept["step"].append(int(lmp.extract_global("ntimestep")))
    found: dict[str, Any] = {key: np.array(values) for key, values in kept.items()}
    found["id"], found["type"] = _gathered(lmp, "id", 0, 1)[:, 0], _gathered(lmp, "type", 0, 1)[:, 0]
    if name == "grains":
        found |= {"omega": _gathered(lmp, "omega", 1, 3), "radius": _gathered(lmp, "radius", 1, 1)[:, 0]}
        found["rmass"] = _gathered(lmp, "rmass", 1, 1)[:, 0]
    low, high, xy, yz, xz, *_ = lmp.extract_box()
    found["box"] = np.array([*low, *high, xy, xz, yz])
    lmp.command(f"write_data {name}.data{' triclinic/general' if name == 'general' else ''}")
    if name == "lj":
        _other_styles(lmp)
    lmp.close()
    return found


def _gathered(lmp: Any, name: str, kind: int, count: int) -> Any:
    """A property of all atoms, in the order of their ids, which may have gaps."""
    values = np.ctypeslib.as_array(lmp.gather_concat(name, kind, count)).reshape(-1, count).copy()
    ids = np.ctypeslib.as_array(lmp.gather_concat("id", 0, 1)).copy()
    return values[np.argsort(ids)]


def _other_styles(lmp: Any) -> None:
    """More runs in the same log, in the other styles of thermodynamic output, without dumps."""
    for line in LIQUID.splitlines():
        if line.startswith("dump "):
            lmp.command(f"undump {line.split()[1]}")
    for style in ("one", "multi", "yaml"):
        lmp.command(f"thermo_modify line {style}")
        lmp.command("run 40")


def main(directory: Path) -> None:
    """Writes all files into a directory."""
    from crosscheck.engines.lammps.instance import load

    lammps = load().lammps
    os.chdir(directory)
    truth = {f"{name}/{key}": value for name, text in RUNS.items() for key, value in run(lammps, name, text).items()}
    np.savez("truth.npz", **truth)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
