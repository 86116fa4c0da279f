"""A run under judgement, and the bench on which further runs of its engine are made."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import Claims, Cost, Run
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EndedEarly
from crosscheck.scene import Floats, Lattice, Method, Output, Scene, State
from crosscheck.scene.observables import TABLE
from crosscheck.simulate.methods import Planned
from crosscheck.simulate.observables import Result
from crosscheck.simulate.progress import shown
from crosscheck.simulate.summary import length_unit

#: Way of a particle in a time step, in its size, beyond which it may fly through another one.
_FARTHEST = 0.5


@dataclass(frozen=True)
class Extra:
    """A run beside those that the user asked for.

    what: it is for, in words. scene, method: what is run. seconds: of computing time that it will take, roughly.
    """

    what: str
    scene: Scene
    method: Method
    seconds: float


@dataclass
class Bench:
    """Makes extra runs, each once, and says on stderr for what.

    pool: of the workers. planned: number of extra runs that were announced. made: number of those that were made.
    """

    pool: Pool
    planned: int = 0
    made: int = 0
    _known: dict[str, Run] = field(default_factory=dict)

    def run(self, one: Planned, extra: Extra) -> tuple[Run, bool]:
        """The run, and whether it is a new one. one: of the engine. Unsupported, EngineError: as `Worker.run`."""
        key = key_of(one, extra)
        if key in self._known:
            return self._known[key], False
        self.made += 1
        worker = self.pool.worker(one.engine)
        with shown(f"{one.label}, run {self.made} of {max(self.planned, self.made)}: {extra.what}", worker.progress):
            self._known[key] = worker.run(extra.scene, extra.method, worker.progress)
        return self._known[key], True


def key_of(one: Planned, extra: Extra) -> str:
    """The same for equal runs of one engine. one: of the engine. extra: the run."""
    text = "\n".join((one.engine, extra.scene.to_json(), extra.method.model_dump_json()))
    return hashlib.sha256(text.encode()).hexdigest()


@dataclass
class Trial:
    """A run under judgement.

    planned: engine, scene (with all that was recorded) and method, whose dt is given if it takes steps. result: of the
    run. bench: makes further ones. allowance: s of computing time that the further runs of one law may take. tolerance:
    to which results must not depend on dt, relative. cost: of extra runs. shared: what one law has found out, for
    others, by name. attempt: 0; 1 where what was suspicious is measured again, with other random numbers.
    """

    planned: Planned
    result: Result
    bench: Bench
    allowance: float
    tolerance: float
    cost: Cost = field(default_factory=Cost)
    shared: dict[str, Any] = field(default_factory=dict)
    attempt: int = 0

    @property
    def scene(self) -> Scene:
        """What was run, with all that was recorded."""
        return self.planned.scene

    @property
    def method(self) -> Method:
        """How it was run."""
        return self.planned.method

    @property
    def run(self) -> Run:
        """What the engine returned."""
        return self.result.run

    @cached_property
    def claims(self) -> Claims:
        """What the engine claims of the scheme."""
        return engine_class(self.planned.engine).schemes[self.method.scheme]

    @property
    def kind(self) -> str:
        """Of the scheme, see `crosscheck.engines.protocol.Kind`."""
        return self.claims.kind

    @property
    def event_driven(self) -> bool:
        """Whether the run goes from event to event, without time steps."""
        return self.kind == "event_driven"

    @property
    def seed(self) -> int | None:
        """Of the random numbers drawn during a run, for another initial state; None: nothing can be drawn."""
        initial = self.scene.initial
        if self.scene.seed is None and isinstance(initial, Lattice) and self.scene.hard_spheres is not None:
            return initial.seed
        return self.scene.seed

    @cached_property
    def broken(self) -> str:
        """Why nothing can be said of the run but that, or "": it did not go to its end, or its steps are no motion."""
        if self.run.diverged or self.run.stopped:
            return "the run ended before its time"
        if self.method.dt is None or self.scene.lennard_jones is None:
            return ""
        length, unit = length_unit(self.scene)
        way = float(np.linalg.norm(self.states[2], axis=2).max()) * self.method.dt / length
        return f"a particle flies {way:.2g} of the {unit} in a time step" if way > _FARTHEST else ""

    @cached_property
    def start(self) -> State:
        """The initial state."""
        return self.scene.own_start()

    @cached_property
    def free(self) -> Floats:
        """Which particles move, (N,)."""
        return ~self.scene.fixed()

    @cached_property
    def states(self) -> tuple[Floats, Floats, Floats]:
        """Times (S,), positions and velocities (S, N, d): of all samples where they were recorded, else start and end.

        The end that the engine has returned is the last of them.
        """
        start, run = self.start, self.run
        ends = (run["final_positions"], run["final_velocities"])
        if "positions" in run and "velocities" in run:
            times, r, v = run["time"], run["positions"], run["velocities"]
            if np.array_equal(r[-1], ends[0]) and np.array_equal(v[-1], ends[1]):
                return times, r, v
            end = self.end if times[-1] < self.end else times[-1]
            return np.append(times, end), np.concatenate([r, ends[0][None]]), np.concatenate([v, ends[1][None]])
        states = (np.array([start.positions, ends[0]]), np.array([start.velocities, ends[1]]))
        return np.array([0.0, self.end]), *states

    @property
    def room(self) -> float:
        """Volume (area, in the plane) of the box, or of what the particles fill at the start."""
        lengths = self.scene.lengths()
        return float(np.prod(np.ptp(self.start.positions, axis=0) if lengths is None else lengths))

    @property
    def end(self) -> float:
        """Time at the end of the run."""
        counted = self.scene.output.collisions is not None and np.isfinite(self.run["time"][-1])
        return float(self.run["time"][-1]) if counted else self.scene.duration

    @property
    def number_of_events(self) -> int:
        """Of all kinds in the run, or its time steps: how often numbers were rounded."""
        return max(self.run.cost.events, self.run.cost.steps, 1)

    def seconds(self, duration: float, steps_ratio: float = 1.0) -> float:
        """Computing time, s, of a run of this duration, with `steps_ratio` times as many steps in a time; roughly."""
        whole = self.scene.duration if self.end <= 0 else self.end
        return self.run.cost.cpu * (duration / whole if whole > 0 else 1.0) * steps_ratio

    def measures(self, name: str) -> bool:
        """Whether the engine can measure an observable in this scene; name: of it."""
        if name in self.run:
            return True
        asked = TABLE[name].asked
        more = {"trajectory": True} if asked == "trajectory" else {"observables": (name,)}
        output = Output.model_validate({"interval": self.scene.duration or 1.0, **more})
        return self.able(self.scene.model_copy(update={"output": output}))

    def able(self, scene: Scene) -> bool:
        """Whether the engine declares all that another scene, such as one with another output, needs."""
        return refusal(engine_class(self.planned.engine), scene, self.method) is None

    def make(self, extra: Extra) -> Run:
        """An extra run. EndedEarly if it does not go to its end; Unsupported, EngineError: as `Worker.run`."""
        run = self.make_any(extra)
        if run.diverged or run.stopped:
            how = "diverged" if run.diverged else f"stopped: {run.stopped}"
            raise EndedEarly(f"the extra run for {extra.what} {how}")
        return run

    def make_any(self, extra: Extra) -> Run:
        """An extra run, which may end early; errors as of `make`."""
        run, new = self.bench.run(self.planned, extra)
        if new:
            self.cost.add(run.cost)
        return run


#: Tells the user something before it happens.
Tell = Callable[[str], None]
