"""Equipartition: the same temperature along all axes, and of all species.

Velocities about the centre of mass have the weight 1 - m/M each, since its motion is taken out: of a species of mass
M_s and N_s particles N_s - M_s/M degrees of freedom along an axis are left. Shares of the kinetic energy then have
these means in the canonical ensemble as at constant energy.

Literature: W. W. Wood, in Physics of Simple Liquids (1968), and J. J. Erpenbeck and W. W. Wood, in Statistical
Mechanics B (1977), for the ensemble of molecular dynamics.
"""

from __future__ import annotations

import numpy as np

from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.samples import Samples
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.scene import AXES
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import statistical


class _Equipartition(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        species, masses = setting.species[setting.moving], setting.moving_masses
        number = len(setting.names)
        self._species = species
        self._weights = np.bincount(species, minlength=number) - np.bincount(species, masses, number) / masses.sum()
        self._samples = Samples(setting)
        self._axes: list[Floats] = []
        self._of_species: list[Floats] = []

    def add(self, view: View) -> None:
        if view.index < self._setting.begin or not view.kinetic.any():
            return
        self._samples.add(view)
        total = view.kinetic.sum()
        self._axes.append(view.kinetic / total * len(view.kinetic))
        if len(self._weights) > 1:
            of_species = np.bincount(self._species, view.peculiar.sum(axis=1), len(self._weights))
            self._of_species.append(of_species / total * (self._setting.number - 1))

    def judge(self, once: float) -> Told:
        if len(self._axes) < 4:
            return Told((), ("there are too few frames with motion.",))
        setting = self._setting
        axes, judged, said = np.array(self._axes), [], []
        why, doubt = "equipartition", setting.rotations / (setting.number - 1)
        if doubt:
            why += f"; the doubt is what {setting.rotations} degrees of freedom of rotation may take from one of them"
        total, one = setting.freedoms, setting.number - 1.0
        rows = [
            (f"temperature along {AXES[axis]} over the mean", axes[:, k], one) for k, axis in enumerate(setting.axes)
        ]
        if len(setting.axes) == 1:
            rows = []
        if setting.constraints:
            said.append("species are not compared: their constrained degrees of freedom are not known.")
        elif self._of_species:
            shares = np.array(self._of_species)
            for k, name in enumerate(setting.names):
                if self._weights[k] > 0:
                    share, part = shares[:, k] / self._weights[k], len(setting.axes) * float(self._weights[k])
                    rows.append((f"temperature of {name} over that of all", share, part))
        for quantity, values, part in rows:
            # a share of the kinetic energy has the beta distribution, by f_s of f degrees of freedom
            variance = 2 * max(total - part, 0.0) / (part * (total + 2))
            mean = self._samples.mean(values, variance)
            kept, reason = self._samples.doubt(variance, once)
            judged.append(
                statistical(
                    quantity,
                    mean.value,
                    mean.error,
                    1.0,
                    0.0,
                    why + reason,
                    samples=mean,
                    doubt=doubt + kept,
                    once=once,
                )
            )
        return Told(tuple(judged), tuple(said))


def _begin(setting: Setting) -> Collector | str:
    return setting.no_equilibrium() or _Equipartition(setting)


PROPERTY = Property("equipartition", "velocities", _begin)
