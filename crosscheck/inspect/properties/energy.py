"""Energy: kinetic energy of particles that are free between collisions, or the sum with the scene's potential."""

from __future__ import annotations

import math

import numpy as np

from crosscheck.figure import Figure
from crosscheck.inspect.curves import in_time
from crosscheck.inspect.outliers import of_deviations
from crosscheck.inspect.potential import Potential, potential_of
from crosscheck.inspect.property import Collector, Property, Told, none_of
from crosscheck.inspect.rounding import bound_of_sum, furthest
from crosscheck.inspect.schemes import not_symplectic
from crosscheck.inspect.setting import FEWEST, Setting
from crosscheck.inspect.view import View
from crosscheck.references.lennard_jones import cut_diffusion
from crosscheck.statistics import correlated_mean
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement, by_chance, statistical

#: Frames to either side whose medians tell a step of the energy, of which single frames may be far off.
_AROUND = 8
#: Variance of the change along the straight line that fits a random walk, over that of the walk from end to end.
_LINE = 1.2
#: Roundings of a particle's energy as its velocity changes.
_ROUNDINGS = 4


class _Energy(Collector):
    def __init__(self, setting: Setting, potential: Potential | str) -> None:
        self._setting, self._potential = setting, potential
        self._kinetic: list[float] = []
        self._potentials: list[float] = []
        self._rounding: list[float] = []

    def add(self, view: View) -> None:
        setting = self._setting
        masses, v, rounding = setting.moving_masses, view.velocities, setting.source.rounding
        energies = masses[:, None] * v**2
        self._kinetic.append(0.5 * float(energies.sum()))
        off = masses[:, None] * np.abs(v) * rounding["velocities"].of(v)
        heavy = 0.5 * rounding["masses"].of(masses) * (v**2).sum(axis=1)
        self._rounding.append(float(np.hypot(bound_of_sum(off.ravel()), bound_of_sum(heavy))))
        if not isinstance(self._potential, str):
            self._potentials.append(self._potential(view.frame))

    def judge(self, once: float) -> Told:
        setting, conserved = self._setting, self._setting.conserved
        kinetic = np.array(self._kinetic)
        series = [in_time("kinetic", setting, kinetic)]
        total = kinetic
        if self._potentials:
            total = kinetic + np.array(self._potentials)
            series += [in_time("potential", setting, total - kinetic), in_time("total", setting, total)]
        series = [one for one in series if np.isfinite(one.y).all()]
        figure = Figure("Energies", setting.clock.name, "energy", series=tuple(series))
        said = [f"kinetic energy: {kinetic[0]:.6g} in the first frame, {kinetic[-1]:.6g} in the last."]
        judged: list[Judgement] = []
        if not conserved.kinetic_energy:
            judged = [self._to_rounding(kinetic)]
        elif isinstance(self._potential, str) or conserved.energy:
            reason = self._potential if isinstance(self._potential, str) else conserved.energy
            said.append(f"the energy is not judged: {conserved.energy or reason}.")
        elif setting.scene is not None and setting.scene.hard_spheres is not None:
            judged = [self._to_rounding(total)]
        elif not_symplectic(setting.scene):
            said.append(
                f"the energy changes by {_change(total, kinetic):.2e} of the kinetic energy, which is not judged: "
            )
            said[-1] += f"{not_symplectic(setting.scene)}, and its energy may drift."
        elif not np.isfinite(total).all():
            at = int(np.flatnonzero(~np.isfinite(total))[0])
            why = "the potential energy is infinite where two particles are in one place alone"
            note = f"frame {at} (counted from 0)"
            judged = [none_of("frames without a finite energy", int((~np.isfinite(total)).sum()), why, note)]
        else:
            told = self._of_steps(total, kinetic, once)
            judged, said = list(told.judgements), said + list(told.said)
        return Told(tuple(judged), tuple(said), (figure,))

    def _of_arithmetic(self) -> Floats:
        """What rounding of each particle's energy may sum up to, (F,): it may have one sign in all steps."""
        steps = np.array([self._setting.steps_to(index) for index in range(len(self._kinetic))])
        return np.asarray(_ROUNDINGS * self._setting.epsilon * steps * max(self._kinetic))

    def _to_rounding(self, energy: Floats) -> Judgement:
        """Exact dynamics: the energy is that of the first frame."""
        scale = float(np.mean(self._kinetic)) or 1.0
        file, change = np.array(self._rounding), energy - energy[0]
        allowed = np.hypot(file, file[0]) + self._of_arithmetic()
        if self._potentials and self._setting.scene is not None and self._setting.scene.acceleration is not None:
            allowed = allowed + 2 * self._in_field()
        why = (
            f"rounding of the file, what a sum exceeds with the probability 1e-9 (Hoeffding); and {_ROUNDINGS} of each "
            "particle's energy whenever its velocity changes: a step, or 1000 times a frame"
        )
        return furthest("change of the energy, over the kinetic energy", change, allowed, scale, why)

    def _in_field(self) -> float:
        """Rounding of the potential energy in a uniform field, from the positions of the first frame."""
        setting = self._setting
        scene, masses = setting.scene, setting.moving_masses
        assert scene is not None
        assert scene.acceleration is not None
        positions = setting.first.positions[setting.moving]
        off = setting.source.rounding["positions"].of(positions)[:, : scene.dimension]
        return float(bound_of_sum((masses[:, None] * np.abs(scene.acceleration) * off).ravel()))

    def _of_steps(self, total: Floats, kinetic: Floats, once: float) -> Told:
        """A symplectic scheme: the energy stays within the width of its oscillations, without drift and steps."""
        if len(total) < 2 * _AROUND or total.min() == total.max():
            return Told((), (f"a drift of the energy is told from {2 * _AROUND} frames on.",))
        setting, scale, mean = self._setting, float(kinetic.mean()), correlated_mean(total)
        judged: list[Judgement] = []
        if mean.trend is not None:
            line = mean.trend.change * np.linspace(-0.5, 0.5, len(total))
            width = float(np.std(total - line)) + float(self._of_arithmetic()[-1])
            error = math.hypot(mean.trend.error, self._by_the_cut())
            why = (
                f"a symplectic scheme keeps the energy within its oscillations, {width / scale:.2g} of the kinetic "
                "energy, which are taken from the file: the doubt; the error has in it what steps of the force at a "
                "cutoff do"
            )
            judged.append(
                statistical(
                    "drift of the energy from the first to the last frame, over the kinetic energy",
                    mean.trend.change / scale,
                    error / scale,
                    0.0,
                    0.0,
                    why,
                    samples=mean._replace(value=0.0, error=error, freedom=mean.trend.freedom, trend=None),
                    doubt=width / scale,
                    once=once,
                )
            )
        if setting.ensemble == "none" or setting.number < FEWEST:
            return Told(tuple(judged), ("steps of the energy are not told from the swings of regular motion.",))
        steps = _steps_of(total)
        law = of_deviations(steps, "laplace")
        if law is None:
            return Told(tuple(judged), ("steps of the energy are told from 20 independent frames on.",))
        at = int(np.abs(steps).argmax()) + _AROUND
        note = f"by {steps[at - _AROUND] / scale:.3g} of the kinetic energy at frame {at} (counted from 0)"
        why = (
            f"medians of {_AROUND} frames after and before each: their difference has tails no longer than Laplace's "
            f"law, whose scale follows from the median of {len(steps)} of them"
        )
        quantity = "largest step of the energy, over its usual change"
        ratio, unit = float(np.abs(steps).max()) / law.scale, law._replace(scale=1.0)
        judged.append(by_chance(quantity, ratio, unit, why, once=once, note=note))
        return Told(tuple(judged))

    def _by_the_cut(self) -> float:
        """Standard deviation of the change of the energy that follows from the step of the force at a cutoff."""
        setting = self._setting
        scene = setting.scene
        if scene is None or scene.lennard_jones is None or scene.box is None or not setting.freedoms:
            return 0.0
        values = setting.clock.values
        temperature = 2 * float(np.mean(self._kinetic)) / setting.freedoms
        per_time = cut_diffusion(scene, temperature, self._time_step(), scene.volume())
        return math.sqrt(_LINE * per_time * abs(float(values[len(self._kinetic) - 1] - values[0])))

    def _time_step(self) -> float:
        """The time step of the scene, else of the file, else that of 1000 a frame."""
        scene, values = self._setting.scene, self._setting.clock.values
        if scene is not None and scene.method is not None and scene.method.dt is not None:
            return scene.method.dt
        last = len(self._kinetic) - 1
        return abs(float(values[last] - values[0])) / self._setting.steps_to(last)


def _change(total: Floats, kinetic: Floats) -> float:
    return float(np.abs(total - total[0]).max() / (kinetic.mean() or 1.0))


def _steps_of(values: Floats) -> Floats:
    """Medians of the frames after each place less those of the frames before, (F - 2 around + 1,)."""
    windows = np.lib.stride_tricks.sliding_window_view(values, _AROUND)
    medians = np.median(windows, axis=1)
    return np.asarray(medians[_AROUND:] - medians[:-_AROUND])


def _begin(setting: Setting) -> Collector | str:
    reason = setting.no_velocities()
    if reason:
        return reason
    if setting.scene is None:
        return _Energy(setting, "the interaction is not known (--scene states it)")
    return _Energy(setting, potential_of(setting.scene))


PROPERTY = Property("energy", "conservation", _begin)
