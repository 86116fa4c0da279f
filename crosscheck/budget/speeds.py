"""How fast an engine is: seconds of a time step, an event or a site, measured with small scenes before a run.

What a step takes grows with the number of particles as the engine's algorithm does, and so does what a run takes before
its first step (a first search for collisions, lists of neighbours): both are measured for several sizes, up to what
takes a fraction of a second, and follow the last power law beyond.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from crosscheck.budget.loads import Load
from crosscheck.engines.capabilities import scheme_of
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing, UsageError
from crosscheck.references.hard_spheres import collision_rate, number_density
from crosscheck.scene import Contact, Gravity, HardSpheres, Method, Scene, Spring, explicit

#: Numbers of particles, or of sites, that are measured, by interaction: fewer, if they take too long.
SIZES = {
    "spring": (1, 16, 256),
    "gravity": (2, 16, 128),
    "lennard_jones": (32, 108, 500),
    "hard_spheres": (16, 128, 1000),
    "lattice_gas": (256, 4096, 65536),
}
#: Seconds that a measurement lasts, at least; and that the next larger size may be expected to take for one unit.
_LONG_ENOUGH, _TOO_LONG = 0.1, 0.3
#: By how much a run is made longer at a time, and units of the longest.
_LONGER, _MOST_UNITS = 16, 1 << 24
#: Runs of no duration: the shortest of them is what a call takes. Seconds of a run that is as short as they are, and by
#: how much a run must be longer to tell what a unit takes.
_CALLS, _NOTHING, _OVER_CALL = 3, 1e-9, 3.0
#: Powers of the size beyond the largest that was measured: no algorithm is better or worse.
_POWERS = (0.0, 3.0)
#: The fluids of the trials.
_PACKING, _DENSITY, _CUTOFF = 0.3, 0.6, 2.5
#: About a step of schemes that choose their own, for springs and bodies at 1e-6: units of time.
_SMOOTH_STEP = 0.1


class Trial(NamedTuple):
    """A `scene` to be timed, the `method` by which it is run, and how many `units` it has; see `Load` for these."""

    scene: Scene
    method: Method
    units: float


#: Makes a trial of a size and a number of steps or events.
_Maker = Callable[[int, int], Trial]


@dataclass(frozen=True)
class Speed:
    """What an engine takes for scenes of one interaction and kind.

    sizes: numbers of particles or sites, rising. calls: seconds of a run without steps, at each of these sizes. units:
    seconds of a step, an event, or a step of a site, at each of them.
    """

    sizes: tuple[int, ...]
    calls: tuple[float, ...]
    units: tuple[float, ...]

    def of(self, load: Load) -> float:
        """Seconds that `load` takes."""
        return load.runs * self._at(load.size, self.calls) + load.units * self._at(load.size, self.units)

    def _at(self, size: int, seconds: tuple[float, ...]) -> float:
        """Seconds for so many particles or sites: by power laws between the sizes measured, and beyond."""
        if size <= self.sizes[0] or len(self.sizes) == 1:
            return seconds[0]
        if size <= self.sizes[-1]:
            return float(np.exp(np.interp(np.log(size), np.log(self.sizes), np.log(seconds))))
        (small, large), (quick, slow) = self.sizes[-2:], seconds[-2:]
        power = min(max(math.log(slow / quick) / math.log(large / small), _POWERS[0]), _POWERS[1])
        return seconds[-1] * (size / large) ** power


def measured(engine: str, interaction: str, kind: str, time_limit: float) -> Speed | None:
    """How fast an engine is; None if that cannot be told: it is missing, fails, or runs none of the trials.

    engine: its name, or path.py:Class. interaction, kind: of the scenes. time_limit: seconds of one run.
    """
    scheme = scheme_of(engine_class(engine), interaction, kind)
    if scheme is None:
        return None
    worker = Worker(engine, time_limit=time_limit)
    try:
        maker = _accepted(worker, interaction, kind, scheme)
        return None if maker is None else _timed(worker, maker, SIZES[interaction])
    except (EngineError, EngineMissing, UsageError):
        return None
    finally:
        worker.close()


def _accepted(worker: Worker, interaction: str, kind: str, scheme: str) -> _Maker | None:
    """The first kind of trial that the engine runs."""
    for maker in _makers(interaction, kind, scheme):
        trial = maker(SIZES[interaction][0], 1)
        if worker.supports(trial.scene, trial.method) is None:
            return maker
    return None


def _timed(worker: Worker, maker: _Maker, sizes: tuple[int, ...]) -> Speed | None:
    done: list[int] = []
    calls: list[float] = []
    units: list[float] = []
    for size in sizes:
        trial = maker(size, 1)
        if worker.supports(trial.scene, trial.method) is not None:
            break
        if done:
            ratio = size / done[-1]
            if calls[-1] * ratio + units[-1] * trial.units * ratio**2 > _TOO_LONG:
                break
        _wall(worker, trial)  # imports, and compiles
        still = trial._replace(scene=trial.scene.changed(duration=0.0))
        calls.append(min(_wall(worker, still)[0] for _ in range(_CALLS)))
        units.append(_per_unit(worker, maker, size, calls[-1]))
        done.append(size)
    return Speed(tuple(done), tuple(calls), tuple(units)) if done else None


def _per_unit(worker: Worker, maker: _Maker, size: int, call: float) -> float:
    """Seconds of a unit, from a run that lasts long enough to tell; call: seconds of one without steps."""
    amount, enough = 1, max(_LONG_ENOUGH, _OVER_CALL * call)
    while True:
        trial = maker(size, amount)
        seconds, units = _wall(worker, trial)
        took = max(seconds - call, _NOTHING)
        if took >= enough or units >= _MOST_UNITS:
            return took / units
        amount = math.ceil(amount * min(max(1.5 * enough / took, 2), _LONGER))


def _wall(worker: Worker, trial: Trial) -> tuple[float, float]:
    """Seconds of a run, and its units: those of the trial, or the steps that the engine chose itself."""
    started = time.perf_counter()
    run = worker.run(trial.scene, trial.method)
    seconds = time.perf_counter() - started
    return seconds, trial.units if trial.method.tolerance is None else max(float(run.cost.steps), 1.0)


# -- scenes ------------------------------------------------------------------------------------------------------------


def _makers(interaction: str, kind: str, scheme: str) -> Iterator[_Maker]:
    """Kinds of trials, the first of which that an engine runs is taken."""
    if interaction == "spring":
        yield from (_springs(_smooth_method(kind, scheme), d) for d in (2, 3, 1))
    elif interaction == "gravity":
        yield from (_bodies(_smooth_method(kind, scheme), d) for d in (3, 2))
    elif interaction == "lennard_jones":
        forms = product((3, 2), ("periodic", "open"), ("truncated", "shifted", "force_shifted"))
        yield from (_fluid(scheme, *form) for form in forms)
    elif interaction == "lattice_gas":
        yield from (_gas(scheme, model) for model in ("hpp", "fhp1", "fhp2", "fhp3"))
    else:
        for d, boundary in product((3, 2), ("periodic", "hard", "open")):
            yield from (_spheres(d, boundary, method) for method in _methods(kind, scheme))


def _smooth_method(kind: str, scheme: str) -> Method:
    """How springs and bodies are run."""
    return Method(scheme=scheme, tolerance=1e-6) if kind == "adaptive" else Method(scheme=scheme, dt=1e-4)


def _springs(method: Method, dimension: int) -> _Maker:
    def make(size: int, amount: int) -> Trial:
        x = np.random.default_rng(size).normal(size=(size, dimension))
        return _trial(method, amount, dimension, spring=Spring(k=1.0), initial=explicit(x, 0 * x))

    return make


def _bodies(method: Method, dimension: int) -> _Maker:
    def make(size: int, amount: int) -> Trial:
        x, v = np.random.default_rng(size).normal(size=(2, size, dimension))
        entries = {"masses": 1 / size, "gravity": Gravity(), "initial": explicit(x, v)}
        return _trial(method, amount, dimension, **entries)

    return make


def _fluid(scheme: str, dimension: int, boundary: str, truncation: str) -> _Maker:
    def make(size: int, amount: int) -> Trial:
        # two cutoffs wide at least, for codes that look at nearest images only
        density = min(_DENSITY, size / (2.1 * _CUTOFF) ** dimension)
        entries = {
            "lennard_jones": {"cutoff": _CUTOFF, "truncation": truncation},
            "box": {"density": density, "boundaries": (boundary,) * dimension},
            "initial": _lattice(size, "fcc" if dimension == 3 else "square"),
        }
        return _trial(Method(scheme=scheme, dt=1e-3), amount, dimension, **entries)

    return make


def _methods(kind: str, scheme: str) -> list[Method]:
    """How hard spheres may be run."""
    if kind == "event_driven":
        return [Method(scheme=scheme)]
    if kind == "collision_search":
        return [Method(scheme=scheme, dt=1e-3)]
    contacts = (Contact(duration=0.02, friction="history"), Contact(duration=0.02, friction="dashpot"))
    return [Method(scheme=scheme, dt=1e-3, contact=contact) for contact in contacts]


def _spheres(dimension: int, boundary: str, method: Method) -> _Maker:
    rate = collision_rate(_PACKING, dimension).value

    def make(size: int, amount: int) -> Trial:
        entries = {
            "hard_spheres": HardSpheres(),
            "box": {"density": number_density(_PACKING, dimension), "boundaries": (boundary,) * dimension},
            "initial": _lattice(size, "sc" if dimension == 3 else "square"),
        }
        if method.dt is None:  # so many collisions
            entries["duration"] = 2 * amount / (size * rate)
        return _trial(method, amount, dimension, **entries)

    return make


def _gas(scheme: str, model: str) -> _Maker:
    def make(size: int, amount: int) -> Trial:
        side = round(size**0.5)
        entries = {
            "duration": amount,
            "lattice_gas": {"model": model, "rows": side, "columns": side},
            "initial": {"kind": "occupations", "density": 0.3, "seed": 1},
        }
        return _trial(Method(scheme=scheme), amount, 2, **entries)._replace(units=amount * side**2)

    return make


def _lattice(size: int, structure: str) -> dict[str, Any]:
    return {"kind": "lattice", "structure": structure, "number": size, "temperature": 1.0, "seed": 1}


def _trial(method: Method, amount: int, dimension: int, **entries: Any) -> Trial:
    """A trial of so many steps; entries: of its scene."""
    step = _SMOOTH_STEP if method.tolerance is not None else method.dt
    length = {} if step is None else {"duration": amount * step}
    scene = Scene.model_validate({"name": "trial", "dimension": dimension, **length, **entries})
    return Trial(scene, method, amount)
