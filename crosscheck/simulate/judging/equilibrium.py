"""Gases and fluids in equilibrium: which runs are, a run that is long enough for means, and what its velocities are.

At constant energy the scaled velocities sqrt(m_i) v_i are uniform on a sphere in f dimensions, the free ones; with
walls at one temperature they are Gaussian, and uniform at any given energy. So the shares y_i = m_i v_i^2/2K of single
particles have a beta distribution, whatever the interaction. Where the total momentum along an axis is conserved it is
taken out first, and a share has the factor 1 - m_i/M.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.errors import Unsupported
from crosscheck.references.hard_spheres import collision_rate, packing_fraction
from crosscheck.scene import Floats, Lattice, Output, Scene, explicit
from crosscheck.simulate.conserved import changes_energy, changes_momentum
from crosscheck.simulate.judging.recording import MOST_BYTES, in_steps, with_observables
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.statistics import Mean, correlated_mean, student_quantile
from crosscheck.verdict import DRIFTING, Judgement

#: Particles at least; and samples after the relaxation, wanted and at most.
FEWEST, WANTED, MOST = 20, 400, 1000
#: What means are taken of, as far as it is measured.
OBSERVABLES = (
    "trajectory", "kinetic_energy", "potential_energy", "rotational_energy", "virial", "collisions",
    "collisional_virial", "dissipated_energy", "wall_torque",
)  # fmt: skip
#: Collisions of each particle until a gas has forgotten its start, for particles of one mass.
_FORGETS = 10.0
#: The same of a Lennard-Jones fluid, in units of sigma sqrt(m/epsilon); and time between samples.
_MELTS, _BETWEEN = 5.0, 0.1
#: What is added to a seed where what was suspicious is measured again.
_OTHER = 7919
#: The boundaries within which a gas stays together.
_CLOSED = ("periodic", "hard", "wall")


def why_none(trial: Trial) -> str | None:
    """None, or why the particles of a run are in no equilibrium that is known. trial: the run."""
    scene = trial.scene
    if scene.lennard_jones is None and scene.hard_spheres is None:
        return f"[{scene.interaction}] knows no thermal equilibrium"
    if trial.broken:
        return trial.broken
    reasons = [word for word in changes_energy(scene, trial.method) if word != "box.faces.temperature"]
    if reasons:
        return f"not in equilibrium: {reasons[0]}"
    if scene.number < FEWEST:
        return f"{scene.number} particles are too few for a distribution"
    diameters = scene.diameters()
    if scene.hard_spheres is not None and (scene.hard_spheres.fixed or diameters is None or not (diameters > 0).all()):
        return "particles that are fixed, or points, exchange no energy among each other"
    temperatures = {face.temperature for face in scene.faces if face is not None and face.temperature is not None}
    if len(temperatures) > 1:
        return "walls of different temperatures: heat flows"
    return _open(scene)


def _open(scene: Scene) -> str | None:
    """None, or which axis lets particles go."""
    pull = scene.acceleration or (0.0,) * scene.dimension
    for axis, boundary in enumerate(scene.boundaries):
        below, above = scene.faces[2 * axis : 2 * axis + 2]
        if axis in scene.across:
            continue
        if boundary not in _CLOSED:
            return f"box.boundaries={boundary}: particles go away"
        if boundary == "periodic" and pull[axis] != 0:
            return "acceleration along a periodic axis: particles fall for ever"
        if boundary == "hard" and (below is None or above is None):
            held = (below is not None and pull[axis] < 0) or (above is not None and pull[axis] > 0)
            if not held:
                return "box.faces.open: particles go away"
    return None


def wall_temperature(scene: Scene) -> float | None:
    """The temperature of thermal walls; None: there are none. scene: whose walls have one temperature."""
    return next((face.temperature for face in scene.faces if face is not None and face.temperature is not None), None)


@dataclass(frozen=True)
class Equilibrium:
    """The part of a run after which it has forgotten its start.

    scene: what was run. run: it. first: its first sample. trial: whose scene it is.
    """

    trial: Trial
    scene: Scene
    run: Run
    first: int

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.run["time"]) - self.first

    @cached_property
    def conserved(self) -> Floats:
        """Along which axes the total momentum is conserved, (d,) of 0 and 1."""
        scene, method = self.scene, self.trial.method
        kept = [changes_momentum(scene, method, axis) is None for axis in range(scene.dimension)]
        return np.array([float(one and not _pulled(scene, axis)) for axis, one in enumerate(kept)])

    @cached_property
    def freedoms(self) -> float:
        """f: number of velocity components that are free."""
        return float(self.scene.number * self.scene.dimension - self.conserved.sum())

    @cached_property
    def velocities(self) -> Floats:
        """(samples, N, d), without the motion of all along the axes of `conserved`."""
        v, m = self.run["velocities"][self.first :], self.trial.start.masses
        mean = np.einsum("i,sij->sj", m, v) / m.sum()
        return np.asarray(v - (mean * self.conserved)[:, None, :])

    @cached_property
    def shares(self) -> Floats:
        """m_i v_ia^2/2K over 1 - m_i/M where the momentum is conserved, (samples, N, d): each 1/f on average."""
        m = self.trial.start.masses
        energy = m[:, None] * self.velocities**2
        whole = energy.sum(axis=(1, 2), keepdims=True)
        return np.asarray(energy / np.where(whole > 0, whole, 1.0) / (1 - np.outer(m / m.sum(), self.conserved)))

    @cached_property
    def kinetic(self) -> Floats:
        """Kinetic energy of the translation, without that of all together, (samples,)."""
        return np.asarray(0.5 * np.einsum("i,sij->s", self.trial.start.masses, self.velocities**2))

    @property
    def temperature(self) -> Floats:
        """2K/f, (samples,)."""
        return 2 * self.kinetic / self.freedoms

    @cached_property
    def groups(self) -> dict[str, Floats]:
        """Indices of the particles of each mass, by a name."""
        masses = self.trial.start.masses
        kinds = np.unique(masses)
        if kinds.size == 1:
            return {"": np.arange(masses.size)}
        return {f" of mass {mass:g}": np.flatnonzero(masses == mass) for mass in kinds} if kinds.size <= 5 else {}


def _pulled(scene: Scene, axis: int) -> bool:
    return scene.acceleration is not None and scene.acceleration[axis] != 0


# -- the run -----------------------------------------------------------------------------------------------------------


def _times(trial: Trial) -> tuple[float, float]:
    """The time until a start is forgotten, and the time between samples that are worth it."""
    scene, masses = trial.scene, trial.start.masses
    if scene.lennard_jones is not None:
        lj = scene.lennard_jones
        unit = float(np.max(lj.length)) * float((masses.max() / np.min(lj.epsilon)) ** 0.5)
        return _MELTS * unit, _BETWEEN * unit
    collisions = trial.run.get("collisions")
    counted = 0.0 if collisions is None else float(np.nanmax(collisions))
    if counted > 0:
        rate = 2 * counted / (scene.number * trial.end)
    else:
        diameter = float(np.mean(np.asarray(scene.diameters())))
        eta = min(0.4, packing_fraction(scene.number / trial.room, scene.dimension, diameter))
        kinetic = 0.5 * float((masses[:, None] * trial.states[2][-1] ** 2).sum())
        temperature = 2 * kinetic / (scene.dimension * scene.number)
        rate = collision_rate(eta, scene.dimension, temperature, float(masses.mean()), diameter).value
    # a pair of unlike masses exchanges the share 4 m M/(m + M)^2 of its energy
    return _FORGETS / rate * float(masses.max() / masses.min()), 1.0 / rate


def extra(trial: Trial) -> Extra | None:
    """A run for means, from the scene's start; None if the run itself is one. trial: the run."""
    relaxation, between = _times(trial)
    if trial.attempt == 0 and _is_enough(trial, relaxation):
        return None
    scene, d = trial.scene, trial.scene.dimension
    affordable = max(trial.end, trial.end * trial.allowance / max(trial.seconds(trial.end), 1e-9))
    most = int(min(MOST, max(50, MOST_BYTES / (16 * scene.number * d))))
    duration = min(affordable, relaxation + WANTED * between)
    steps = [] if trial.method.dt is None else [trial.method.step]
    fits = in_steps(duration, steps, min(most, max(50, int(duration / between))))
    if fits is None:
        return None
    duration, interval = fits
    base = _start_of(trial)
    output = with_observables(trial.planned.engine, base, trial.method, Output(interval=interval), OBSERVABLES)
    changed = base.model_copy(update={"duration": duration, "output": output})
    return Extra("means in equilibrium", changed, trial.method, trial.seconds(duration))


def _is_enough(trial: Trial, relaxation: float) -> bool:
    run, output = trial.run, trial.scene.output
    if output.interval is None or "velocities" not in run:
        return False
    # another attempt measures the same
    if with_observables(trial.planned.engine, trial.scene, trial.method, output, OBSERVABLES) != output:
        return False
    return int((run["time"] >= relaxation).sum()) >= WANTED


def _start_of(trial: Trial) -> Scene:
    """The scene with its own start; of another attempt, with other random numbers, or from where the run ended."""
    scene, initial = trial.scene, trial.scene.initial
    if trial.attempt == 0:
        return scene
    if isinstance(initial, Lattice):
        other = initial.model_copy(update={"seed": initial.seed + _OTHER * trial.attempt})
        drawn = None if scene.seed is None else scene.seed + _OTHER * trial.attempt
        return scene.model_copy(update={"initial": other, "seed": drawn})
    run = trial.run
    last = explicit(run["final_positions"], run["final_velocities"], run.get("final_angular_velocities"))
    return scene.model_copy(update={"initial": last, "seed": trial.seed})


def equilibrium(trial: Trial) -> Equilibrium:
    """The run for means, from where it has forgotten its start; at least its second half.

    trial: for which `why_none` is None. EngineError, Unsupported: as `Trial.make`.
    """
    key = f"equilibrium {trial.attempt}"
    if key not in trial.shared:
        more, (relaxation, _) = extra(trial), _times(trial)
        scene, run = (trial.scene, trial.run) if more is None else (more.scene, trial.make(more))
        if "velocities" not in run:
            raise Unsupported(f"{trial.planned.label}: velocities of so many particles were not recorded")
        first = int((run["time"] < relaxation).sum())
        trial.shared[key] = Equilibrium(trial, scene, run, min(max(first, 1), len(run["time"]) // 2))
    found: Equilibrium = trial.shared[key]
    return found


def extras(trial: Trial) -> list[Extra]:
    """The run for means as a list, of none or one; trial: the run."""
    more = extra(trial)
    return [] if more is None else [more]


# -- what is not in equilibrium ----------------------------------------------------------------------------------------


def drifts(found: Equilibrium) -> str:
    """Why the run is not stationary after all, or "": its kinetic energy has a trend. found: of the run."""
    if found.samples < 20:
        return ""
    mean = correlated_mean(found.kinetic)
    trend = mean.trend
    if trend is None or trend.sigmas <= student_quantile(DRIFTING, trend.freedom):
        return ""
    return f"the kinetic energy still changes, by {trend.change / mean.value:.2g} of it"


def settled(found: Equilibrium, judged: Judgement) -> Judgement:
    """The judgement, which is not red where the run may not have reached equilibrium.

    found: of the run. judged: of a mean or a distribution in it.
    """
    if judged.outcome != "fail":
        return judged
    reason = drifts(found) or _strange_start(found)
    if not reason:
        return judged
    note = "; ".join(filter(None, (judged.note, f"may not be in equilibrium: {reason}")))
    return replace(judged, outcome="inconclusive", note=note)


def _strange_start(found: Equilibrium) -> str:
    """Why the start may take longer to be forgotten than the run, or "": it has flows, or one of few speeds."""
    initial = found.scene.initial
    if isinstance(initial, Lattice):
        return ""
    v, m = found.trial.start.velocities, found.trial.start.masses
    energy = m[:, None] * v**2
    shares = energy.sum(axis=0) / max(float(energy.sum()), 1e-300)
    d, number = v.shape[1], len(m)
    spread = 5 * (2 * (d - 1) / (d**2 * d * number)) ** 0.5
    square = energy.sum(axis=1)
    ratio = float((square**2).mean() / max(float(square.mean()) ** 2, 1e-300))
    if np.abs(shares - 1 / d).max() > spread or abs(ratio - (1 + 2 / d)) > 5 * (8 * (d + 2) / (d**3 * number)) ** 0.5:
        return "the velocities of the start are not those of equilibrium"
    return ""


def mean_of(series: Floats) -> Mean:
    """The mean of a series (n,) with its error; one of fewer than 4 values has none, and decides nothing."""
    if len(series) >= 4:
        return correlated_mean(series)
    return Mean(float(np.mean(series)), float(np.std(series)), 1.0, 1.0)
