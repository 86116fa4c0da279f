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

from crosscheck.scene import Floats, Method, Scene


@dataclass(frozen=True)
class Claims:
    """What an engine says of one of its schemes.

    order, order_damped: global orders of the error (position, velocity) for f(r) and for f(r, v); None: no fixed order
    (adaptive), or velocity-dependent forces not supported. symplectic, reversible: of the map from the initial to the
    final (r, v); None: nothing is claimed, and nothing is checked.
    """

    order: tuple[int, int] | None
    order_damped: tuple[int, int] | None = None
    symplectic: bool | None = None
    reversible: bool | None = None


@dataclass
class Cost:
    """Of one run. wall, cpu, compile: seconds (compile apart from the others); evaluations: of the force."""

    wall: float = 0.0
    cpu: float = 0.0
    compile: float = 0.0
    steps: int = 0
    evaluations: int = 0
    peak_bytes: int = 0


@dataclass
class Run:
    """What an engine returns.

    time: (samples,), the start included. Arrays that the scene did not ask for are None.
    positions, velocities: (samples, N, d), unwrapped, in the scene's order of particles.
    kinetic_energy, potential_energy, virial: (samples,), totals; the virial is sum over pairs of r_ij . F_ij; the
    potential energy is that of the truncation asked for, without tail corrections (the suite adds those).
    final_positions, final_velocities: (N, d), always. forces: (N, d), at the end.
    diverged: the run met a state that is not finite, or lost particles, and stopped there; samples after it are NaN.
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
    diverged: bool = False
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


def sample_times(scene: Scene, method: Method) -> Floats:
    """Times of the samples, from whole numbers of steps: the start and every `output.interval`; or start and end."""
    steps, every = scene.steps(method.dt), scene.every(method.dt)
    every = every or max(steps, 1)
    return np.arange(0, steps + 1, every) * method.dt
