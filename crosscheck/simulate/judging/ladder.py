"""The beginning of a run with ever smaller time steps, and a twin that starts a little off: what dt and rounding do.

Two runs with steps dt and dt/2 part by an amount of the order dt^p, which grows with time; where the motion is chaotic,
exponentially. As long as it is small beside the lengths of the scene it is proportional to dt^p, and shows the order.
The time until which this holds is the horizon. A twin, whose start is disturbed by a relative 1e-9, shows by how much a
rounding error has grown.

Literature: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927); E. Hairer, S. P. Norsett and G. Wanner, Solving
Ordinary Differential Equations I, 2nd ed., Springer (1993), section II.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from crosscheck.compare.twin import DISTURBANCE, disturbed
from crosscheck.engines.protocol import Run
from crosscheck.references import EPSILON
from crosscheck.references.lennard_jones import energy_of_the_cut
from crosscheck.scene import Floats, Output, Scene
from crosscheck.simulate.judging.recording import MOST_BYTES, in_steps, with_observables
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.simulate.summary import length_unit

#: Where runs with dt and dt/2 differ by more, relative to the length of the scene, the difference may not be
#: proportional to dt^p any more.
LINEAR = 2e-3
#: Runs of a ladder at first: three changes, so that two orders can be compared.
FIRST = 4
#: Halvings at most, and samples within the horizon at least.
MOST_HALVINGS, LEAST_SAMPLES = 6, 8
#: Particles of which each jump of the energy at a cutoff is taken out.
_FEW = 50
#: How often a beginning is made shorter until it is within the horizon.
_TRIES = 6
#: Samples of a beginning at most.
MOST_SAMPLES = 200
#: Differences below so many roundings tell no order.
ABOVE = 10.0
#: Steps between samples are whole multiples of so many, so that the step can be made as much larger.
_COARSER = 4


class Rung(NamedTuple):
    """One step of a ladder.

    step: dt. change, energy: what halving it changes positions and energy by, relative; None: it was not halved. order,
    energy_order: log2 of that over the same of dt/2, where both are beyond rounding. cpu: CPU time of the run, s.
    """

    step: float
    change: float | None
    order: float | None
    energy: float | None
    energy_order: float | None
    cpu: float


@dataclass(frozen=True)
class Ladder:
    """Runs of one scene with the steps dt, dt/2, dt/4 ...

    scene: what was run. steps: dt of each. runs: of each. changes: largest difference of positions between each run and
    the next until the horizon, relative to the length. energies: the same of the energy, relative to its largest size;
    empty if it was not recorded. rounding: what rounding may have made of positions, relative, at each sample. horizon:
    number of samples up to it. unit: the length, in words.
    """

    scene: Scene
    steps: tuple[float, ...]
    runs: tuple[Run, ...]
    changes: tuple[float, ...]
    energies: tuple[float, ...]
    rounding: Floats
    horizon: int
    unit: str

    @property
    def rungs(self) -> list[Rung]:
        """The ladder as a table, a row for each step, the largest first."""
        found = []
        for k, (step, run) in enumerate(zip(self.steps, self.runs, strict=True)):
            changes, energies = (list(values[k : k + 2]) for values in (self.changes, self.energies))
            orders = _with_order(changes, ABOVE * self.floor), _with_order(energies, ABOVE * EPSILON)
            found.append(Rung(step, *orders[0], *orders[1], run.cost.cpu))
        return found

    @property
    def until(self) -> float:
        """The time of the horizon."""
        return float(self.runs[0]["time"][self.horizon - 1])

    @property
    def floor(self) -> float:
        """What rounding may have made of positions until the horizon, relative."""
        return float(self.rounding[: self.horizon].max())

    @property
    def usable(self) -> list[int]:
        """Which changes are above rounding: consecutive, the coarsest first."""
        return [k for k, change in enumerate(self.changes) if change > ABOVE * self.floor]

    @property
    def orders(self) -> list[float]:
        """log2 of the ratio of each change to the next, of those above rounding."""
        used = [self.changes[k] for k in self.usable]
        return [float(np.log2(a / b)) for a, b in pairwise(used)]


def _with_order(changes: list[float], rounding: float) -> tuple[float | None, float | None]:
    """A change and its order, from it and the next one, as far as they are there and beyond rounding."""
    if len(changes) < 2 or not min(changes) > rounding:
        return (changes[0] if changes else None), None
    return changes[0], float(np.log2(changes[0] / changes[1]))


def first_extras(trial: Trial) -> list[Extra]:
    """The runs that a ladder begins with; trial: the run whose ladder it is."""
    scene = _scene(trial, trial.scene.duration)
    if scene is None:
        return []
    rungs = [_rung(trial, scene, k) for k in range(FIRST)]
    return [*rungs, twin_of(trial, scene)]


def ladder(trial: Trial) -> Ladder | None:
    """The ladder of a run with time steps (`trial`); None if its beginning has too few steps, or nothing moves.

    EngineError, Unsupported: as `Trial.make`.
    """
    if "ladder" not in trial.shared:
        trial.shared["ladder"] = _climbed(trial)
    found: Ladder | None = trial.shared["ladder"]
    return found


def _climbed(trial: Trial) -> Ladder | None:
    found = _with_horizon(trial)
    if found is None:
        return None
    scene, horizon = found
    length, unit = length_unit(scene)
    rounding = _rounding(trial, scene, length)
    numbers = list(range(FIRST))
    runs = [trial.make(_rung(trial, scene, k)) for k in numbers]

    def built() -> Ladder:
        pairs = list(pairwise(runs))
        return Ladder(
            scene,
            tuple(trial.method.step / 2**k for k in numbers),
            tuple(runs),
            tuple(float(apart(a, b)[:horizon].max()) / length for a, b in pairs),
            tuple(_energies_apart(scene, a, b, horizon) for a, b in pairs if "kinetic_energy" in a),
            rounding,
            horizon,
            unit,
        )

    now = built()
    while len(now.usable) < 2 and numbers[0] > -2 and _may_be_coarser(trial, scene, numbers[0] - 1):
        coarser = trial.make_any(_rung(trial, scene, numbers[0] - 1))
        if coarser.diverged or not apart(coarser, runs[0])[:horizon].max() <= LINEAR * length:
            break
        numbers.insert(0, numbers[0] - 1)
        runs.insert(0, coarser)
        now = built()
    spent = sum(run.cost.cpu for run in runs)
    while (
        numbers[-1] < MOST_HALVINGS
        and len(now.usable) == len(now.changes)
        and max(now.changes[-1], *now.energies[-1:]) > trial.tolerance
        and spent + 2 * runs[-1].cost.cpu <= trial.allowance
    ):
        numbers.append(numbers[-1] + 1)
        runs.append(trial.make(_rung(trial, scene, numbers[-1])))
        spent += runs[-1].cost.cpu
        now = built()
    return now


def _scene(trial: Trial, duration: float) -> Scene | None:
    """The beginning of the scene, of this duration at most, recorded; None if it has too few steps."""
    dt, whole = trial.method.step, trial.scene.duration
    share = trial.allowance / max(2**FIRST * trial.seconds(whole), 1e-9)
    longest = min(duration, max(whole * min(1.0, share), LEAST_SAMPLES * dt))
    samples = min(MOST_SAMPLES, max(LEAST_SAMPLES, int(MOST_BYTES / (16 * trial.scene.number * trial.scene.dimension))))
    coarse = _COARSER * dt
    fits = in_steps(longest, [coarse], samples) if longest >= 2 * LEAST_SAMPLES * coarse else None
    fits = fits or in_steps(longest, [dt], samples)
    if fits is None or round(fits[0] / fits[1]) < LEAST_SAMPLES / 2:
        return None
    return recorded(trial, *fits)


def recorded(trial: Trial, duration: float, interval: float, *, trajectory: bool = True) -> Scene:
    """The beginning of the trial's scene, recording energies and, with `trajectory`, states.

    duration: of the beginning. interval: between samples.
    """
    names = ("kinetic_energy", "potential_energy", *(["trajectory"] if trajectory else []))
    output = with_observables(trial.planned.engine, trial.scene, trial.method, Output(interval=interval), names)
    return trial.scene.model_copy(update={"duration": duration, "output": output})


def _rung(trial: Trial, scene: Scene, number: int) -> Extra:
    """The run with the step dt/2^number."""
    method = trial.method.model_copy(update={"dt": trial.method.step / 2**number})
    size = "dt" if number == 0 else f"dt/{2**number}" if number > 0 else f"{2**-number} dt"
    changed = scene.model_copy(update={"method": method})
    return Extra(f"the step {size}", changed, method, trial.seconds(scene.duration, 2.0**number))


def _may_be_coarser(trial: Trial, scene: Scene, number: int) -> bool:
    assert scene.output.interval is not None
    steps = scene.output.interval / trial.method.step * 2.0**number
    return abs(steps - round(steps)) < 1e-9 and steps > 0.5


def twin_of(trial: Trial, scene: Scene) -> Extra:
    """The run of `scene`, a beginning of the trial's, from a start that is a little off."""
    changed = scene.model_copy(update={"initial": disturbed(scene), "seed": trial.seed})
    return Extra("a twin from a disturbed start", changed, trial.method, trial.seconds(scene.duration))


def halved(trial: Trial, scene: Scene) -> Extra:
    """The run of `scene`, another one of the trial's, with half the time step."""
    return _rung(trial, scene, 1)


def looser(trial: Trial, scene: Scene) -> Extra:
    """The run of `scene`, another one of the trial's, with ten times the tolerance, of a scheme that takes one."""
    method = trial.method.model_copy(update={"tolerance": min(10 * trial.method.allowed, 0.5)})
    changed = scene.model_copy(update={"method": method})
    return Extra("ten times the tolerance", changed, method, trial.seconds(scene.duration))


def _with_horizon(trial: Trial) -> tuple[Scene, int] | None:
    """The beginning with enough samples within the horizon, and their number; None: too few steps, or no motion."""
    duration = trial.scene.duration
    for _ in range(_TRIES):
        scene = _scene(trial, duration)
        if scene is None or not {"positions"} <= set(scene.asked()):
            return None
        one, half = (trial.make(_rung(trial, scene, k)) for k in range(2))
        length, _ = length_unit(scene)
        away = np.maximum.accumulate(apart(one, half)) / length
        horizon = int((away <= LINEAR).sum())
        if horizon == len(away) or horizon >= LEAST_SAMPLES:
            return (scene, horizon) if np.abs(one["velocities"]).any() else None
        shorter = 1.25 * float(one["time"][max(horizon, 1)])
        if shorter >= scene.duration:
            return (scene, horizon) if horizon > 1 else None
        duration = shorter
    return None


def apart(one: Run, other: Run) -> Floats:
    """Largest distance of a particle from itself in another run, (samples,), length. one, other: with trajectories."""
    return np.asarray(np.linalg.norm(one["positions"] - other["positions"], axis=2).max(axis=1))


def energy_of(run: Run) -> Floats:
    """Kinetic and potential energy of a run that recorded them, (samples,)."""
    return np.asarray(run["kinetic_energy"] + run.get("potential_energy", 0.0))


def is_cut(scene: Scene) -> bool:
    """Whether the potential energy jumps at a cutoff; scene: what is run."""
    return scene.lennard_jones is not None and scene.lennard_jones.truncation == "truncated"


def continuous_energy(scene: Scene, run: Run) -> Floats:
    """The energy, (samples,), without the jumps of a potential that is cut off: as if it were shifted to 0 there.

    scene: what was run. run: with energies, and with a trajectory where `is_cut`.
    """
    energy = energy_of(run)
    if not is_cut(scene):
        return energy
    return energy - np.array([energy_of_the_cut(scene, x) for x in run["positions"]])


def _energies_apart(scene: Scene, one: Run, other: Run, horizon: int) -> float:
    parts: list[Any] = [one["kinetic_energy"], one.get("potential_energy", np.zeros(1))]
    scale = max(float(np.abs(part).max()) for part in parts)
    # of many particles a jump is small, and to find it takes long
    energy = energy_of if scene.number > _FEW else partial(continuous_energy, scene)
    return float(np.abs(energy(one)[:horizon] - energy(other)[:horizon]).max()) / (scale or 1.0)


def _rounding(trial: Trial, scene: Scene, length: float) -> Floats:
    """What rounding may make of positions, relative to `length`, at each sample: see `rounding_growth`."""
    run = trial.make(_rung(trial, scene, 0))
    return rounding_growth(trial, run, trial.make(twin_of(trial, scene))) / length


def rounding_growth(trial: Trial, run: Run, twin: Run) -> Floats:
    """How far rounding may have moved a particle at each sample, (samples,), length.

    A rounding at each step or event, of a relative size EPSILON, grows no faster than the disturbance of the twin,
    whose relative size is `DISTURBANCE`. trial: of the engine. run, twin: with trajectories.
    """
    grown = np.maximum.accumulate(apart(run, twin)) / DISTURBANCE
    steps = np.linspace(0, max(run.cost.events, run.cost.steps), len(grown))
    size = float(np.abs(run["positions"]).max())
    return np.asarray(EPSILON * ((1 + steps) * grown + 8 * (1 + np.sqrt(steps)) * size))
