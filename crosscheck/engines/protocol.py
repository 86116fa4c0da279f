"""What an engine is: a small protocol, and the `Run` that it returns.

To add one: a class with these members, named by an entry point of group `crosscheck.engines` or by
`--engine path.py:Class`. Import heavy packages inside the methods: `name`, `schemes` and `capabilities` are read before
anything is run. What is returned is checked by `crosscheck.engines.workers.border`. See `docs/engines.md` and
`examples/`.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from crosscheck.engines.capabilities import Capability
from crosscheck.scene import AXES, Floats, Method, Scene
from crosscheck.scene.lattice_gas import gas_model
from crosscheck.scene.observables import OPERATIONS, lengths

#: How a scheme moves its scene: by time steps under forces; by time steps that it chooses itself, to a tolerance; from
#: event to event, without a step; by time steps, after each of which it looks for collisions of hard spheres; a lattice
#: gas, by whole steps of 1.
Kind = Literal["stepping", "adaptive", "event_driven", "collision_search", "lattice"]


@dataclass(frozen=True)
class Claims:
    """What an engine claims of one of its schemes; the checks hold it to that.

    order, order_damped: orders (position, velocity) of the global error, the powers of dt, for forces f(r) and f(r, v);
    None: no fixed order (an adaptive step), or forces f(r, v) are not supported. symplectic, reversible: whether the
    map from the initial to the final (r, v) is; None: nothing is claimed, and nothing is checked. kind: see `Kind`;
    checks choose schemes by it, not by their names.
    """

    order: tuple[int, int] | None = None
    order_damped: tuple[int, int] | None = None
    symplectic: bool | None = None
    reversible: bool | None = None
    kind: Kind = "stepping"

    @property
    def takes_dt(self) -> bool:
        """Whether the scheme takes time steps of the length `method.dt`."""
        return self.kind in ("stepping", "collision_search")

    @property
    def takes_tolerance(self) -> bool:
        """Whether the scheme chooses its own time steps, by `method.tolerance`."""
        return self.kind == "adaptive"


@dataclass
class Cost:
    """What a run cost.

    wall, cpu: elapsed and processor time of the integration alone, s. compile: elapsed time of compilation and set-up,
    s. steps: number of time steps. evaluations: number of evaluations of all forces. peak_bytes: largest memory of the
    worker process so far, bytes. events: number of events of all kinds.

    Exact numbers of operations, which tell what was done too often without a clock; None: not counted. pair_tests:
    distances of pairs computed for forces, a pair twice if it is looked at from both sides. list_builds, list_prunings:
    lists of neighbours made anew, or picked from a longer one; list_tests: distances computed for that. Event-driven:
    predictions: pairs looked at for an event; comparisons: of times, to find the next event; stale_events: events
    that were due but not valid any more; cell_crossings: events that moved a particle to another cell. site_updates:
    sites of a lattice computed; row_fetches: how often a row of it was fetched from memory, for a step or several.
    """

    wall: float = 0.0
    cpu: float = 0.0
    compile: float = 0.0
    steps: int = 0
    evaluations: int = 0
    peak_bytes: int = 0
    events: int = 0
    pair_tests: int | None = None
    list_builds: int | None = None
    list_prunings: int | None = None
    list_tests: int | None = None
    predictions: int | None = None
    comparisons: int | None = None
    stale_events: int | None = None
    cell_crossings: int | None = None
    site_updates: int | None = None
    row_fetches: int | None = None

    def add(self, other: Cost) -> None:
        """Adds the cost of another run; of the peak memory, the larger; what the other has not counted adds nothing."""
        for entry, value in vars(other).items():
            before = getattr(self, entry)
            if entry == "peak_bytes":
                setattr(self, entry, max(before, value))
            elif value is not None:
                setattr(self, entry, (before or 0) + value)

    def known(self) -> dict[str, float]:
        """The entries that were counted, by name."""
        return {entry: value for entry, value in vars(self).items() if value is not None}


class Run(dict[str, Floats]):
    """What an engine returns: arrays by the names of the table of observables, `run["kinetic_energy"]`.

    It holds what the scene asks for (`Scene.asked`), with the shapes of `shapes`. Sample 0 is the start; after a
    divergence or an early end, samples are NaN. KeyError for an observable that the scene did not ask for.

    arrays, named: the arrays, as one mapping or as keyword arguments, in the units of the scene. diverged: the run met
    a state that is not finite, or lost particles, and stopped there; a particle far from the origin is not lost.
    stopped: why the run ended before its time (inelastic collapse), or ""; the final state is then that at its end.
    cost: None: all zero. remarks: whole sentences on what a user must know of a run that went to its end, such as
    simultaneous events whose order decides the outcome.
    """

    def __init__(
        self,
        arrays: Mapping[str, Floats] | None = None,
        /,
        *,
        diverged: bool = False,
        stopped: str = "",
        cost: Cost | None = None,
        remarks: Sequence[str] = (),
        **named: Floats,
    ) -> None:
        if isinstance(remarks, str):
            raise TypeError("remarks of a run: give a list of sentences, not one text")
        super().__init__({**(arrays or {}), **named})
        self.diverged = diverged
        self.stopped = stopped
        self.cost = Cost() if cost is None else cost
        self.remarks = tuple(remarks)

    def __missing__(self, name: str) -> Floats:
        raise KeyError(f"the run holds no '{name}': the scene did not ask for it; it has {', '.join(self)}")


@runtime_checkable
class Engine(Protocol):
    """A program that simulates. Its attributes are those of the class; its methods run in a worker process.

    name: a short name. schemes: name of each scheme -> what it claims. capabilities: the scenes that it can run. The
    suite refuses scenes that no capability covers, before they reach the engine; `supports` refuses those that the
    declarations cannot tell apart. An engine may also have `promises`, see `crosscheck.engines.capabilities.Needs`.
    """

    name: str
    schemes: dict[str, Claims]
    capabilities: tuple[Capability, ...]

    def version(self) -> str:
        """Version of the engine. ImportError or OSError, with the reason, where it cannot run on this machine."""

    def supports(self, scene: Scene, method: Method) -> str | None:
        """None, or why the engine cannot run this scene with this method although it declares all of their words.

        scene: what to simulate. method: scheme and time step.
        """

    def run(self, scene: Scene, method: Method) -> Run:
        """Runs the scene from its initial state for its duration.

        scene: what to simulate, and what to record; `supports` has accepted it. method: the scheme, one of `schemes`;
        `dt`, in units of time, is given if and only if the scheme takes time steps, and `tolerance` if and only if
        it chooses them itself. Any exception is an error of the
        engine; a run that diverges is not: see `Run`.
        """


@runtime_checkable
class Restartable(Engine, Protocol):
    """An engine that can go on from where one of its runs ended: with the same bits as a run without a break."""

    def run_from(
        self, scene: Scene, method: Method, start: Mapping[str, Floats] | None
    ) -> tuple[Run, dict[str, Floats] | None]:
        """As `run`, but from the state `start`; with the run, the state at its end.

        scene, method: as for `run`. Of a run that goes on, `scene.initial` is that of the very first one; times, and
        observables that add up, count from where it goes on. start: arrays by name, the state that an earlier call
        returned for the same scene but for name, duration and output, with the same method; None: the run begins at
        `scene.initial`. UsageError if they do not fit. The state: all that decides what follows, such as lists,
        histories, clocks and counters of random numbers; None if the run has stopped or diverged, or such a scene
        cannot go on with the same bits.
        """


@contextmanager
def timed(cost: Cost) -> Iterator[None]:
    """Adds wall and CPU time, s, of the `with` block to `cost`, and sets its peak memory to that of the process."""
    wall, cpu = time.perf_counter(), time.process_time()
    yield
    cost.wall += time.perf_counter() - wall
    cost.cpu += time.process_time() - cpu
    cost.peak_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def strides(scene: Scene, method: Method) -> tuple[int, int]:
    """Number of steps of a run, and number of steps from one sample to the next.

    scene: gives duration and output interval. method: gives dt. UsageError if dt is missing, or does not divide both.
    """
    steps = scene.steps(method.step)
    return steps, scene.every(method.step) or max(steps, 1)


def sample_times(scene: Scene, method: Method) -> Floats:
    """Times (samples,) of the samples of a run of `scene`, in units of time.

    The start and every `output.interval`, as whole multiples of `method.dt`; without an interval, start and end. For a
    method without dt, `Scene.samples`. UsageError if dt does not divide duration and interval.
    """
    if method.dt is None:
        return scene.samples()
    steps, every = strides(scene, method)
    return np.arange(0, steps + 1, every) * method.dt


def face_names(scene: Scene) -> tuple[str, ...]:
    """Names of the faces of `scene` in the order of the observables `wall_...`: x-, x+, y-, y+ ..., last the cylinder.

    "cylinder" is there only if the scene has one.
    """
    plane = tuple(f"{axis}{side}" for axis in AXES[: scene.dimension] for side in "-+")
    return (*plane, "cylinder") if scene.across else plane


def shapes(scene: Scene, samples: int, events: int = 0) -> dict[str, tuple[int, ...]]:
    """Shapes, by name, of the arrays that a run of `scene` returns.

    samples: their number, the start included. events: the number of those in its trace, which the run decides.
    """
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
        "event": (events,),
        "partner": (2,),
    }
    if gas is not None:
        sizes |= {"channel": (gas_model(scene).channels,), "row": (gas.rows,), "column": (gas.columns,)}
    return {name: lengths(row.axes, sizes) for name, row in scene.asked().items()}
