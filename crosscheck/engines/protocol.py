"""What an engine is: a small protocol, and the `Run` that it returns.

To add one: a class with these members, named by an entry point of group `crosscheck.engines` or by
`--engine path.py:Class`. Import heavy packages inside the methods: the class itself is also looked at, for `name`,
`schemes` and `capabilities`, by the process that judges. See `docs/engines.md` and `examples/`.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from crosscheck.engines.capabilities import Capability
from crosscheck.scene import AXES, Floats, Method, Scene
from crosscheck.scene.lattice_gas import gas_model
from crosscheck.scene.observables import OPERATIONS, lengths

#: How a scheme moves its scene: by time steps under forces; from event to event, without a step; by time steps, after
#: each of which it looks for collisions of hard spheres; a lattice gas, by whole steps of 1.
Kind = Literal["stepping", "event_driven", "collision_search", "lattice"]


@dataclass(frozen=True)
class Claims:
    """What an engine says of one of its schemes.

    order, order_damped: global orders of the error (position, velocity) for f(r) and for f(r, v); None: no fixed order
    (adaptive), or velocity-dependent forces not supported. symplectic, reversible: of the map from the initial to the
    final (r, v); None: nothing is claimed, and nothing is checked. kind: see `Kind`; checks choose schemes by it,
    whatever their names.
    """

    order: tuple[int, int] | None = None
    order_damped: tuple[int, int] | None = None
    symplectic: bool | None = None
    reversible: bool | None = None
    kind: Kind = "stepping"

    @property
    def takes_dt(self) -> bool:
        """The scheme takes time steps whose length is the method's choice."""
        return self.kind in ("stepping", "collision_search")


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


class Run(dict[str, Floats]):
    """What an engine returns: arrays by the names of the table of observables, `run["kinetic_energy"]`.

    It holds what the scene asks for (`Scene.asked`), with the shapes of `shapes`. Sample 0 is the start; after a
    divergence or an early end, samples are NaN.

    diverged: the run met a state that is not finite, or lost particles, and stopped there. stopped: why the run ended
    before its time (inelastic collapse), or ""; the final state is that of the moment. cost: always there.
    """

    def __init__(
        self,
        arrays: Mapping[str, Floats] | None = None,
        /,
        *,
        diverged: bool = False,
        stopped: str = "",
        cost: Cost | None = None,
        **named: Floats,
    ) -> None:
        super().__init__({**(arrays or {}), **named})
        self.diverged = diverged
        self.stopped = stopped
        self.cost = Cost() if cost is None else cost

    def __missing__(self, name: str) -> Floats:
        raise KeyError(f"the run holds no '{name}': the scene did not ask for it; it has {', '.join(self)}")


@runtime_checkable
class Engine(Protocol):
    """WHO simulates. `name`, `schemes` and `capabilities` are class attributes; the methods run in a worker process.

    What no capability declares is refused by the suite, before the engine sees it; `supports` refuses what declarations
    cannot say.
    """

    name: str
    schemes: dict[str, Claims]
    capabilities: tuple[Capability, ...]

    def version(self) -> str:
        """Version of the engine; raises ImportError or OSError, with the reason, where it cannot run."""

    def supports(self, scene: Scene, method: Method) -> str | None:
        """None, or the reason why this scene, made of declared parts, still cannot be run with this method."""

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


def face_names(scene: Scene) -> tuple[str, ...]:
    """Faces in the order of the wall tallies: x-, x+, y-, y+ ..., and the cylinder last, if there is one."""
    plane = tuple(f"{axis}{side}" for axis in AXES[: scene.dimension] for side in "-+")
    return (*plane, "cylinder") if scene.across else plane


def shapes(scene: Scene, samples: int) -> dict[str, tuple[int, ...]]:
    """Shapes of the arrays that a run of this scene returns, by name; samples: their number."""
    gas, cells = scene.lattice_gas, scene.output.fields
    sizes: dict[str, tuple[int, ...]] = {
        "sample": (samples,),
        "particle": (scene.number,),
        "axis": (scene.dimension,),
        "spin": (scene.spin_dimension,),
        "face": (len(face_names(scene)),),
        "operation": (len(OPERATIONS),),
        "grid": cells or (),
        "block": cells or (1, 1),
    }
    if gas is not None:
        sizes |= {"channel": (gas_model(scene).channels,), "row": (gas.rows,), "column": (gas.columns,)}
    return {name: lengths(row.axes, sizes) for name, row in scene.asked().items()}
