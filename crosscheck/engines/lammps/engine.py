"""LAMMPS as an engine: velocity Verlet (`fix nve`) for Lennard-Jones, springs, gravity and soft grains.

Literature: A. P. Thompson et al., Comput. Phys. Commun. 271, 108171 (2022).

All scenes run in `units lj`, where LAMMPS multiplies by no conversion factor: the numbers are the scene's own.
"""

from __future__ import annotations

from crosscheck.engines.capabilities import capability
from crosscheck.engines.lammps import granular, particles
from crosscheck.engines.lammps.instance import load, preload_mpi
from crosscheck.engines.protocol import Claims, Run
from crosscheck.scene import Method, Scene

#: Largest number of atom types, one for every pair of species and mass: LAMMPS's tables hold all pairs of types.
_MOST_TYPES = 100


class LammpsEngine:
    """Velocity Verlet, `fix nve`; of order 1 with `fix viscous`, which takes the velocity at the half-step.

    arguments: more of LAMMPS's command line.
    """

    name = "lammps"
    schemes = {"velocity_verlet": Claims((2, 2), (1, 1), symplectic=True, reversible=True)}
    capabilities = (
        capability(
            "spring",
            "stepping",
            words="dimension=1 dimension=2 dimension=3 masses[] spring.gamma",
            observables="positions velocities forces kinetic_energy potential_energy",
        ),
        capability(
            "gravity",
            "stepping",
            words="dimension=2 dimension=3 masses[] gravity.G gravity.softening",
            observables="positions velocities forces kinetic_energy potential_energy virial",
        ),
        capability(
            "lennard_jones",
            "stepping",
            words="""
                dimension=2 dimension=3 masses[] box.boundaries=periodic box.boundaries=open box.boundaries=wall
                box.wall box.wall.epsilon box.wall.sigma lennard_jones.epsilon lennard_jones.epsilon[]
                lennard_jones.length lennard_jones.length[] lennard_jones.length_form=sigma
                lennard_jones.length_form=r_m lennard_jones.truncation=truncated lennard_jones.truncation=shifted
                lennard_jones.truncation=force_shifted
            """,
            observables="positions velocities forces kinetic_energy potential_energy virial",
        ),
        capability(
            "hard_spheres",
            "stepping",
            words="""
                dimension=2 dimension=3 masses[] acceleration hard_spheres.diameter hard_spheres.diameter[]
                hard_spheres.restitution hard_spheres.friction hard_spheres.friction.static
                hard_spheres.friction.sliding hard_spheres.friction.inertia
                box.boundaries=periodic box.boundaries=open box.boundaries=hard
                box.faces box.faces.open box.faces.restitution box.faces.oscillation box.faces.oscillation.phase
                box.faces.friction box.faces.friction.static box.faces.friction.sliding
                box.cylinder box.cylinder.axis=x box.cylinder.axis=y box.cylinder.axis=z box.cylinder.angular_velocity
                box.cylinder.restitution box.cylinder.friction box.cylinder.friction.static
                box.cylinder.friction.sliding
                method.contact method.contact.law=hooke method.contact.law=hertz method.contact.stiffness
                method.contact.duration method.contact.friction=history method.contact.friction=dashpot
                method.contact.k_n method.contact.k_t method.contact.E method.contact.nu
                method.contact.gamma_n method.contact.gamma_t method.contact.mu
            """,
            observables="""
                positions velocities angular_velocities kinetic_energy rotational_energy collisional_virial contact_time
                wall_impulse wall_torque
            """,
        ),
    )
    #: Thousands of steps of some hundred particles take seconds; walls are granular ones throughout.
    promises = ("long_runs", "remarks_on_contacts", "springs_turned_at_walls")
    arguments: tuple[str, ...] = ()

    def version(self) -> str:
        return f"{load().__version__} (MPI from {preload_mpi()})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        if scene.hard_spheres is not None:
            return granular.unsupported(scene, method)
        if scene.spring is not None:
            return None
        if scene.gravity is not None:
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
        # -nonbuf: output is not buffered, so its last lines are in the log even after a crash
        lmp = lammps.lammps(cmdargs=["-log", "none", "-echo", "none", "-nonbuf", *self.arguments])
        try:
            if scene.hard_spheres is not None:
                return granular.integrate(lammps, lmp, scene, method)
            return particles.integrate(lammps, lmp, scene, method)
        finally:
            lmp.close()
