"""ASE as an engine: velocity Verlet for a one-component Lennard-Jones system, in Python.

Literature: A. H. Larsen et al., J. Phys.: Condens. Matter 29, 273002 (2017).

ASE's own units (eV, angstrom, u, and the time that follows from them) are consistent: the scene's numbers go in
unconverted, and its time step is ASE's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.progress import report
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times, strides, timed
from crosscheck.scene import LennardJones, Method, Scene, State

#: `ase.neighborlist.NeighborList` adds this number to every cutoff, whatever the scene's unit of length.
_SKIN = 0.3


class AseEngine:
    """`ase.md.verlet.VelocityVerlet` with `ase.calculators.lj.LennardJones`, one species, no walls."""

    name = "ase"
    schemes = {"velocity_verlet": Claims((2, 2), None, symplectic=True)}
    capabilities = (
        capability(
            "lennard_jones",
            "stepping",
            words="""
                dimension=2 dimension=3 masses[] box.boundaries=periodic box.boundaries=open lennard_jones.epsilon
                lennard_jones.length lennard_jones.length_form=sigma lennard_jones.length_form=r_m
                lennard_jones.truncation=truncated lennard_jones.truncation=shifted
            """,
            observables="positions velocities forces kinetic_energy potential_energy virial",
        ),
    )

    def version(self) -> str:
        import ase

        return str(ase.__version__)

    def supports(self, scene: Scene, method: Method) -> str | None:
        lj = scene.lennard_jones
        if lj is not None and lj.cutoff < _SKIN:
            return f"its neighbour list adds a fixed {_SKIN} to the cutoff: choose a smaller unit of length"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        from ase.md.verlet import VelocityVerlet

        lj = scene.lennard_jones
        assert lj is not None
        state = scene.initial_state()
        atoms = _atoms(scene, state, lj)
        dynamics = VelocityVerlet(atoms, timestep=method.step)
        steps, every = strides(scene, method)
        times = sample_times(scene, method)
        shape = (times.size, scene.number, scene.dimension)
        output = scene.output

        run = Run(time=times, final_positions=state.positions, final_velocities=state.velocities, cost=Cost())
        for name in output.observables:
            run[name] = np.full(times.size, np.nan)
        if output.trajectory:
            run["positions"], run["velocities"] = np.full(shape, np.nan), np.full(shape, np.nan)

        atoms.get_forces()
        _record(run, 0, atoms, lj)
        with timed(run.cost):
            for sample in range(1, times.size):
                if not _advance(dynamics, every):
                    run.diverged = True
                    break
                _record(run, sample, atoms, lj)
                report(sample * every / steps)
            if not run.diverged:
                run.diverged = not _advance(dynamics, steps % every)
        run.cost.steps, run.cost.evaluations = dynamics.nsteps, dynamics.nsteps + 1

        nan_state = np.full(shape[1:], np.nan)
        d = scene.dimension
        run["final_positions"] = nan_state if run.diverged else atoms.get_positions()[:, :d]
        run["final_velocities"] = nan_state if run.diverged else atoms.get_velocities()[:, :d]
        if output.forces:
            run["forces"] = nan_state if run.diverged else atoms.get_forces()[:, :d]
        return run


def _atoms(scene: Scene, state: State, lj: LennardJones) -> Any:
    """The scene as an `Atoms` object in three dimensions; axes that the scene does not have are open, at 0."""
    from ase import Atoms
    from ase.calculators.lj import LennardJones as Calculator

    missing = 3 - scene.dimension
    # a cell of rank 3 makes ASE compute the stress; along open axes its length has no other effect
    cell = [1.0] * 3
    periodic = [boundary == "periodic" for boundary in scene.boundaries] + [False] * missing
    for axis, is_periodic in enumerate(periodic):
        if is_periodic:
            assert state.lengths is not None
            cell[axis] = float(state.lengths[axis])
    atoms = Atoms(
        numbers=np.zeros(scene.number, dtype=int),
        positions=np.pad(state.positions, ((0, 0), (0, missing))),
        masses=state.masses,
        cell=cell,
        pbc=periodic,
        calculator=Calculator(epsilon=_one(lj.epsilon), sigma=_sigma(lj), rc=lj.cutoff),
    )
    atoms.set_velocities(np.pad(state.velocities, ((0, 0), (0, missing))))
    return atoms


def _one(value: float | tuple[float, ...]) -> float:
    """The value of the only species."""
    return value if isinstance(value, float) else value[0]


def _sigma(lj: LennardJones) -> float:
    return _one(lj.length) * (2 ** (-1 / 6) if lj.length_form == "r_m" else 1.0)


def _advance(dynamics: Any, steps: int) -> bool:
    """Takes the steps; False if the state is no longer finite."""
    try:
        dynamics.run(steps)
    except ValueError:
        # the neighbour list refuses positions that are not finite; any other ValueError is an error
        if np.isfinite(dynamics.atoms.positions).all():
            raise
        return False
    return bool(np.isfinite(dynamics.atoms.positions).all() and np.isfinite(dynamics.atoms.get_momenta()).all())


def _record(run: Run, sample: int, atoms: Any, lj: LennardJones) -> None:
    """Writes the present state into the arrays of the run, at this sample."""
    if "positions" in run and "velocities" in run:
        d = run["positions"].shape[2]
        run["positions"][sample] = atoms.get_positions()[:, :d]
        run["velocities"][sample] = atoms.get_velocities()[:, :d]
    if "kinetic_energy" in run:
        run["kinetic_energy"][sample] = atoms.get_kinetic_energy()
    if "potential_energy" in run:
        run["potential_energy"][sample] = atoms.get_potential_energy() + _unshift(atoms, lj)
    if "virial" in run:
        # the stress is sum phi'(r) r r/V, hence W = -V tr(stress)
        run["virial"][sample] = -atoms.get_volume() * np.sum(atoms.get_stress()[:3])


def _unshift(atoms: Any, lj: LennardJones) -> float:
    """Difference of plain truncation from ASE's energy, which is shifted: phi(cutoff) per pair within the cutoff."""
    from ase.neighborlist import neighbor_list

    if lj.truncation == "shifted":
        return 0.0
    pairs = len(neighbor_list("i", atoms, lj.cutoff)) // 2
    s6 = (_sigma(lj) / lj.cutoff) ** 6
    return pairs * 4.0 * _one(lj.epsilon) * (s6 * s6 - s6)
