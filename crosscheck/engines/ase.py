"""ASE as an engine: velocity Verlet for a one-component Lennard-Jones system, in Python.

Literature: A. H. Larsen et al., J. Phys.: Condens. Matter 29, 273002 (2017).

ASE's own units (eV, angstrom, u, and the time that follows from them) are consistent: the scene's numbers go in as they
are, but for lengths in a power of two of the scene's unit (see `_scale`): that rounds nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.progress import report
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times, strides, timed
from crosscheck.errors import UsageError
from crosscheck.scene import Floats, LennardJones, Method, Scene, State


class AseEngine:
    """`ase.md.verlet.VelocityVerlet` with `ase.calculators.lj.LennardJones`, one species, no walls."""

    name = "ase"
    promises = ("restarts",)
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
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        return self.run_from(scene, method, None)[0]

    def run_from(
        self, scene: Scene, method: Method, start: Mapping[str, Floats] | None
    ) -> tuple[Run, dict[str, Floats] | None]:
        from ase.md.verlet import VelocityVerlet

        lj = scene.lennard_jones
        assert lj is not None
        state = scene.initial_state()
        unit = _scale(lj)
        atoms = _atoms(scene, state, lj, unit)
        if start is not None:
            _resume(atoms, start)
        dynamics = VelocityVerlet(atoms, timestep=method.step)
        steps, every = strides(scene, method)
        times = sample_times(scene, method)
        shape = (times.size, scene.number, scene.dimension)
        output = scene.output

        run = Run(time=times, cost=Cost())
        for name in output.observables:
            run[name] = np.full(times.size, np.nan)
        if output.trajectory:
            run["positions"], run["velocities"] = np.full(shape, np.nan), np.full(shape, np.nan)

        atoms.get_forces()
        _record(run, 0, atoms, lj, unit)
        with timed(run.cost):
            for sample in range(1, times.size):
                if not _advance(dynamics, every):
                    run.diverged = True
                    break
                _record(run, sample, atoms, lj, unit)
                report(sample * every / steps)
            if not run.diverged:
                run.diverged = not _advance(dynamics, steps % every)
        run.cost.steps, run.cost.evaluations = dynamics.nsteps, dynamics.nsteps + 1

        nan_state = np.full(shape[1:], np.nan)
        d = scene.dimension
        run["final_positions"] = nan_state if run.diverged else atoms.get_positions()[:, :d] / unit
        run["final_velocities"] = nan_state if run.diverged else atoms.get_velocities()[:, :d] / unit
        if output.forces:
            run["forces"] = nan_state if run.diverged else atoms.get_forces()[:, :d] / unit
        return run, None if run.diverged else _state(atoms)


def _scale(lj: LennardJones) -> float:
    """Lengths for ASE over those of the scene: a power of two that brings the cutoff to between 2 and 4.

    `ase.neighborlist.NeighborList` adds 0.3 to every cutoff, whatever the unit of length: nearly all pairs of a scene
    in SI units. Energies are then in units of the scale squared; time and mass are the scene's.
    """
    return math.ldexp(1.0, 2 - math.frexp(lj.cutoff)[1])


def _state(atoms: Any) -> dict[str, Floats]:
    """All that decides what follows: the order of summation is that of the list, hence where it was made."""
    return {
        "positions": atoms.get_positions(),
        "momenta": atoms.get_momenta(),
        "list": np.array(atoms.calc.nl.nl.coordinates),
    }


def _resume(atoms: Any, start: Mapping[str, Floats]) -> None:
    """Brings the atoms to a state of `_state`, and the neighbour list to what it was then."""
    for name in ("list", "positions", "momenta"):
        found = start.get(name)
        if found is None or found.shape != (len(atoms), 3) or found.dtype != np.float64:
            raise UsageError(f"the restart file does not fit: array {name} of shape ({len(atoms)}, 3) is missing")
    atoms.set_positions(start["list"])
    atoms.get_forces()
    atoms.set_positions(start["positions"])
    atoms.set_momenta(start["momenta"])


def _atoms(scene: Scene, state: State, lj: LennardJones, unit: float) -> Any:
    """The scene as an `Atoms` object in three dimensions; axes that the scene does not have are open, at 0.

    unit: see `_scale`.
    """
    from ase import Atoms
    from ase.calculators.lj import LennardJones as Calculator

    missing = 3 - scene.dimension
    # a cell of rank 3 makes ASE compute the stress; along open axes its length has no other effect
    cell = [1.0] * 3
    periodic = [boundary == "periodic" for boundary in scene.boundaries] + [False] * missing
    for axis, is_periodic in enumerate(periodic):
        if is_periodic:
            assert state.lengths is not None
            cell[axis] = float(state.lengths[axis]) * unit
    atoms = Atoms(
        numbers=np.zeros(scene.number, dtype=int),
        positions=np.pad(state.positions * unit, ((0, 0), (0, missing))),
        masses=state.masses,
        cell=cell,
        pbc=periodic,
        calculator=Calculator(epsilon=_one(lj.epsilon) * unit**2, sigma=_sigma(lj) * unit, rc=lj.cutoff * unit),
    )
    atoms.set_velocities(np.pad(state.velocities * unit, ((0, 0), (0, missing))))
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


def _record(run: Run, sample: int, atoms: Any, lj: LennardJones, unit: float) -> None:
    """Writes the present state into the arrays of the run, at this sample. unit: see `_scale`."""
    if "positions" in run and "velocities" in run:
        d = run["positions"].shape[2]
        run["positions"][sample] = atoms.get_positions()[:, :d] / unit
        run["velocities"][sample] = atoms.get_velocities()[:, :d] / unit
    if "kinetic_energy" in run:
        run["kinetic_energy"][sample] = atoms.get_kinetic_energy() / unit**2
    if "potential_energy" in run:
        run["potential_energy"][sample] = atoms.get_potential_energy() / unit**2 + _unshift(atoms, lj, unit)
    if "virial" in run:
        # the stress is sum phi'(r) r r/V, hence W = -V tr(stress)
        run["virial"][sample] = -atoms.get_volume() * np.sum(atoms.get_stress()[:3]) / unit**2


def _unshift(atoms: Any, lj: LennardJones, unit: float) -> float:
    """Difference of plain truncation from ASE's energy, which is shifted: phi(cutoff) per pair within the cutoff."""
    from ase.neighborlist import neighbor_list

    if lj.truncation == "shifted":
        return 0.0
    pairs = len(neighbor_list("i", atoms, lj.cutoff * unit)) // 2
    s6 = (_sigma(lj) / lj.cutoff) ** 6
    return pairs * 4.0 * _one(lj.epsilon) * (s6 * s6 - s6)
