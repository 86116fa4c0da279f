"""LAMMPS as an engine: velocity Verlet (`fix nve`) for Lennard-Jones, springs, gravity and soft grains.

Literature: A. P. Thompson et al., Comput. Phys. Commun. 271, 108171 (2022).

All scenes run in `units lj`, where LAMMPS multiplies by no conversion factor: the numbers are the scene's own.
"""

from __future__ import annotations

import numpy as np

from crosscheck.engines.lammps import granular, particles
from crosscheck.engines.lammps.instance import load, preload_mpi
from crosscheck.engines.protocol import Claims, Run
from crosscheck.scene import Method, Scene

#: Atom types, one for every pair of species and mass: LAMMPS has tables over the pairs of types.
_MOST_TYPES = 100


class LammpsEngine:
    """`fix nve` takes a velocity-dependent force (`fix viscous`) at the half-step velocity: first order then."""

    name = "lammps"
    schemes = {"velocity_verlet": Claims((2, 2), (1, 1), symplectic=True, reversible=True)}

    def version(self) -> str:
        return f"{load().__version__} (MPI from {preload_mpi()})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        if method.scheme not in self.schemes:
            return f"no scheme '{method.scheme}': fix nve is velocity Verlet"
        if scene.hard_spheres is not None:
            return granular.unsupported(scene, method)
        if np.min(scene.masses) <= 0:
            return "LAMMPS needs positive masses"
        if scene.spring is not None:
            if "virial" in scene.output.observables:
                return "fix spring/self contributes no virial"
            return None
        if scene.gravity is not None:
            if scene.dimension == 1:
                return "gravity is for two or three dimensions"
            if scene.number > particles.MOST_BODIES:
                return f"gravity by an all-pairs neighbour list: at most {particles.MOST_BODIES} bodies"
        elif "wall" in scene.boundaries:
            state = scene.initial_state()
            assert state.lengths is not None
            walled = [axis for axis, boundary in enumerate(scene.boundaries) if boundary == "wall"]
            inside = (state.positions > 0) & (state.positions < state.lengths)
            if not inside[:, walled].all():
                return "a particle starts on or beyond a wall"
        types = len(set(particles.kinds(scene)))
        if types > _MOST_TYPES:
            return f"one atom type for each pair of species and mass: at most {_MOST_TYPES}, found {types}"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        lammps = load()
        # -nonbuf: the last lines are in the log even after a crash
        lmp = lammps.lammps(cmdargs=["-log", "none", "-echo", "none", "-nonbuf"])
        try:
            if scene.hard_spheres is not None:
                return granular.integrate(lammps, lmp, scene, method)
            return particles.integrate(lammps, lmp, scene, method)
        finally:
            lmp.close()
