"""What an engine is: a small protocol, and the `Run` it returns.

To add one: a class with these members, named by an entry point of group `crosscheck.engines` or by
`--engine path.py:Class`. Import heavy packages inside the methods: the class itself is also looked at, for `name` and
`schemes`, by the process that judges. See `docs/engines.md` and `examples/`.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from crosscheck.scene import AXES, GAS_TALLIES, TALLIES, Floats, Method, Scene


@dataclass(frozen=True)
class Claims:
    """What an engine says of one of its schemes.

    order, order_damped: global orders of the error (position, velocity) for f(r) and for f(r, v); None: no fixed order
    (adaptive), or velocity-dependent forces not supported. symplectic, reversible: of the map from the initial to the
    final (r, v); None: nothing is claimed, and nothing is checked. events: the scheme goes from event to event and has
    no time step. lattice: the scheme moves a lattice gas, by whole steps of 1. collisions: the scheme moves hard
    spheres by time steps and looks for collisions at each. The checks of integrators pass all three by.
    """

    order: tuple[int, int] | None
    order_damped: tuple[int, int] | None = None
    symplectic: bool | None = None
    reversible: bool | None = None
    events: bool = False
    lattice: bool = False
    collisions: bool = False

    @property
    def stepping(self) -> bool:
        """The scheme integrates forces by time steps dt."""
        return not (self.events or self.lattice or self.collisions)


@dataclass
class Cost:
    """Of one run. wall, cpu, compile: seconds (compile apart); evaluations: of the force; events: all kinds."""

    wall: float = 0.0
    cpu: float = 0.0
    compile: float = 0.0
    steps: int = 0
    evaluations: int = 0
    peak_bytes: int = 0
    events: int = 0


@dataclass
class Run:
    """What an engine returns.

    time: (samples,), the start included. Arrays that the scene did not ask for are None.
    positions, velocities: (samples, N, d), unwrapped, in the scene's order of particles.
    kinetic_energy, potential_energy, virial: (samples,), totals; the virial is sum over pairs of r_ij . F_ij; the
    potential energy is that of the truncation asked for, without tail corrections (the suite adds those).
    final_positions, final_velocities: (N, d), always. forces: (N, d), at the end.
    diverged: the run met a state that is not finite, or lost particles, and stopped there; samples after it are NaN.

    Of hard particles (their kinetic energy contains the rotation, and their potential energy that of the field and of
    square wells):
    angular_velocities, final_angular_velocities: (samples, N, 1 | 3) with a trajectory, and (N, 1 | 3); None where
    nothing rotates. tallies: the observables of `scene.TALLIES` by name, shapes as `tally_shapes` has them, and the
    arrays "field_*" of `output.fields`. stopped: why the run ended before its time (inelastic collapse), or "";
    samples after that are NaN, and the final state is that of the moment.

    Of lattice gases, N = 0 and tallies alone: see `gas_tally_shapes`.
    """

    time: Floats
    final_positions: Floats
    final_velocities: Floats
    positions: Floats | None = None
    velocities: Floats | None = None
    kinetic_energy: Floats | None = None
    potential_energy: Floats | None = None
    virial: Floats | None = None
    forces: Floats | None = None
    angular_velocities: Floats | None = None
    final_angular_velocities: Floats | None = None
    tallies: dict[str, Floats] = field(default_factory=dict)
    diverged: bool = False
    stopped: str = ""
    cost: Cost = field(default_factory=Cost)


@runtime_checkable
class Engine(Protocol):
    """WHO simulates. `name` and `schemes` are class attributes; the methods run in the engine's worker process."""

    name: str
    schemes: dict[str, Claims]

    def version(self) -> str:
        """Version of the engine; raises ImportError or OSError, with the reason, where it cannot run."""

    def supports(self, scene: Scene, method: Method) -> str | None:
        """None, or the reason why this scene cannot be run with this method."""

    def run(self, scene: Scene, method: Method) -> Run:
        """Runs the scene from its initial state for its duration."""


@contextmanager
def timed(cost: Cost) -> Iterator[None]:
    """Adds the block's wall and CPU seconds to `cost`, and notes the process's peak memory."""
    wall, cpu = time.perf_counter(), time.process_time()
    yield
    cost.wall += time.perf_counter() - wall
    cost.cpu += time.process_time() - cpu
    cost.peak_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def strides(scene: Scene, method: Method) -> tuple[int, int]:
    """Steps of a run with time steps, and steps between its samples."""
    steps = scene.steps(method.step)
    return steps, scene.every(method.step) or max(steps, 1)


def sample_times(scene: Scene, method: Method) -> Floats:
    """Times of the samples, from whole numbers of steps: the start and every `output.interval`; or start and end.

    Of a method without a step, `Scene.samples`.
    """
    if method.dt is None:
        return scene.samples()
    steps, every = strides(scene, method)
    return np.arange(0, steps + 1, every) * method.dt


#: Before the name of a tally, where the arrays of a run travel in one file.
TALLY = "tallies."
#: Columns of the tally "operation_counts".
OPERATIONS = (
    "tree_comparisons",
    "list_moves",
    "predictions",
    "cell_crossings",
    "invalid_events",
    "wall_events",
)


def face_names(scene: Scene) -> tuple[str, ...]:
    """Faces in the order of the wall tallies: x-, x+, y-, y+ ..., and the cylinder last, if there is one."""
    plane = tuple(f"{axis}{side}" for axis in AXES[: scene.dimension] for side in "-+")
    return (*plane, "cylinder") if scene.across else plane


def tally_shapes(scene: Scene, samples: int) -> dict[str, tuple[int, ...]]:
    """Shapes of the tallies that the scene asks for.

    All but rotational_energy accumulate from the start of the run, and are exact. collisions, events: numbers, of pairs
    and of all kinds. collisional_virial: sum over impulses of r_ij . dp_ij, positive for repulsion, wells included.
    dissipated_energy: lost in pair collisions. wall_impulse: momentum given by the particles to each face; wall_energy:
    energy given by each face to the particles; wall_collisions; wall_torque: angular impulse about the cylinder's axis
    given by it to the particles. kinetic_energy_integral, potential_energy_integral: over time. deepest_overlap: the
    largest (s - r)/s of a pair at its collision so far, s its contact distance. operation_counts: the columns of
    `OPERATIONS`. fields: "field_mass", over the grid, stands for them all. contact_time: number of pairs in contact,
    integrated over time; 0 of hard spheres, and the number of collisions times t_c of soft ones.
    """
    if scene.lattice_gas is not None:
        return gas_tally_shapes(scene, samples)
    faces = len(face_names(scene))
    wide: dict[str, tuple[int, ...]] = {
        "wall_impulse": (faces, scene.dimension),
        "wall_energy": (faces,),
        "wall_collisions": (faces,),
        "operation_counts": (len(OPERATIONS),),
    }
    shapes: dict[str, tuple[int, ...]] = {}
    for name in scene.output.observables:
        if name in TALLIES:
            shapes[name] = (samples, *wide.get(name, ()))
    if scene.output.fields is not None:
        shapes["field_mass"] = scene.output.fields
    return shapes


def gas_tally_shapes(scene: Scene, samples: int) -> dict[str, tuple[int, ...]]:
    """Shapes of what a lattice gas is asked for.

    populations: particles of each channel in each block of `output.fields` (one block by default), (samples, blocks
    along x, along y, b); whole numbers, but means if the scheme moves mean occupations. force_impulse: momentum along x
    given by the force to each row, since the start. h_function: sum of f ln f + (1 - f) ln(1 - f) over all channels.
    sites: states of the sites at the end, (rows, columns).
    """
    from crosscheck.scene.lattice_gas import gas_model

    gas, blocks = scene.lattice_gas, scene.output.fields or (1, 1)
    assert gas is not None
    shapes: dict[str, tuple[int, ...]] = {
        "populations": (samples, *blocks, gas_model(scene).channels),
        "force_impulse": (samples, gas.rows),
        "h_function": (samples,),
        "sites": (gas.rows, gas.columns),
    }
    return {name: shapes[name] for name in GAS_TALLIES if name in scene.output.observables}
