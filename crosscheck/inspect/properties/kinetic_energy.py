"""The distribution of the total kinetic energy: Gamma(f/2, T) in the canonical ensemble, narrower at constant energy.

Literature: J. L. Lebowitz, J. K. Percus and L. Verlet, Phys. Rev. 153, 250 (1967), for its fluctuations at constant
energy; P. T. Merz and M. R. Shirts, PLoS ONE 13, e0202764 (2018), for tests of it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.samples import apart
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.statistics import Mean, correlated_mean, student_quantile
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import LEAST_FREEDOM, LEAST_SAMPLES, Judgement, bounded, by_chance, statistical

#: A kinetic energy that scatters less than this, relative, is constant.
_CONSTANT = 1e-9


class _KineticEnergy(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._values: list[float] = []

    def add(self, view: View) -> None:
        if view.index >= self._setting.begin:
            self._values.append(0.5 * float(view.kinetic.sum()))

    def judge(self, once: float) -> Told:
        values = np.array(self._values)
        if len(values) < 4 or not values.mean() > 0:
            return Told((), ("there are too few frames with motion.",))
        if float(np.ptp(values)) < _CONSTANT * float(values.mean()):
            if self._setting.ensemble == "nvt":
                why = "the kinetic energy of the canonical ensemble scatters"
                return Told((bounded("scatter of the kinetic energy, relative", 0.0, _CONSTANT, why, at_least=True),))
            return Told((), ("the kinetic energy is constant: it has no width to be judged.",))
        mean = correlated_mean(values)
        width = self._width(values, mean)
        if self._setting.ensemble != "nvt":
            return Told((self._no_wider(width, once),))
        if width.freedom < LEAST_FREEDOM:
            return Told(
                (), (f"its width is not judged: {width.independent:.0f} values are independent of each other.",)
            )
        why = "Gamma(f/2, T): the variance of the kinetic energy is 2/f of the square of its mean"
        quantity = "ln of the temperature from the width of K over that from its mean"
        doubt = 0.5 * self._setting.rotations / self._setting.freedoms
        if doubt:
            why += f"; the doubt is that {self._setting.rotations} degrees of freedom of rotation may not be thermal"
        judged = [statistical(quantity, width.value, width.error, 0.0, 0.0, why, samples=width, doubt=doubt, once=once)]
        temperature = self._setting.temperature
        if temperature is None:
            return Told(tuple(judged), ("the distribution itself needs a temperature (--temperature).",))
        if doubt:
            return Told(tuple(judged), ("the distribution itself is not judged: rotation may not be thermal.",))
        found = self._against_gamma(values, mean, temperature, once)
        return Told((*judged, found)) if isinstance(found, Judgement) else Told(tuple(judged), (found,))

    def _width(self, values: Floats, mean: Mean) -> Mean:
        """ln(T_width/T_mean), T_width = (2 var K/f)^(1/2), T_mean = 2 <K>/f, with the error of the variance."""
        squares = (values - mean.value) ** 2
        found = correlated_mean(squares)
        independent = min(mean.independent, found.independent)
        variance = found.value * independent / max(independent - 1, 1.0)
        ratio = variance * self._setting.freedoms / (2 * mean.value**2)
        error = found.error / (2 * found.value)
        return Mean(0.5 * math.log(ratio), error, independent, found.freedom)

    def _no_wider(self, width: Mean, once: float) -> Judgement:
        limit = student_quantile(2 * once, width.freedom) * width.error
        why = (
            "at constant energy the kinetic energy scatters less than in the canonical ensemble, where this is 0: the "
            f"limit is {student_quantile(2 * once, width.freedom):.2f} standard errors; false-alarm rate {once:.2g}"
        )
        quantity = "ln of the temperature from the width of K over that from its mean"
        judged = replace(bounded(quantity, width.value, limit, why), uncertainty=width.error, false_alarm=once)
        few = width.independent < LEAST_SAMPLES or width.freedom < LEAST_FREEDOM
        return replace(judged, outcome="inconclusive") if few and judged.outcome == "pass" else judged

    def _against_gamma(self, values: Floats, mean: Mean, temperature: float, once: float) -> Judgement | str:
        from scipy.stats import gamma, kstest, kstwo

        setting = self._setting
        chosen = values[:: apart(len(values), mean.independent)]
        if len(chosen) < LEAST_SAMPLES:
            return f"the distribution is not judged: {len(chosen)} frames are independent of each other."
        law = gamma(setting.freedoms / 2, scale=temperature)
        statistic = float(kstest(chosen, law.cdf).statistic)
        why = f"Kolmogorov and Smirnov, of {len(chosen)} decorrelated frames, f = {setting.freedoms}"
        quantity = "distance of the kinetic energies from Gamma(f/2, T)"
        return by_chance(quantity, statistic, kstwo(len(chosen)), why, once=once)


def _begin(setting: Setting) -> Collector | str:
    return setting.no_equilibrium() or _KineticEnergy(setting)


PROPERTY = Property("total kinetic energy", "velocities", _begin)
