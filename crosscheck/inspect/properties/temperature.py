"""The kinetic temperature about the centre of mass: stationary, and that of the bath where one is known."""

from __future__ import annotations

from math import inf

import numpy as np

from crosscheck.figure import Figure, Series
from crosscheck.inspect.curves import in_time
from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.samples import Samples
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.statistics import Mean, correlated_mean, student_quantile
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement, statistical

#: Relative rounding of a temperature that is constant: its drift is no drift.
_ROUNDING = 1e-9


class _Temperature(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._samples = Samples(setting)
        self._values: list[float] = []

    def add(self, view: View) -> None:
        self._values.append(float(view.kinetic.sum()) / self._setting.freedoms)
        if view.index >= self._setting.begin:
            self._samples.add(view)

    def judge(self, once: float) -> Told:
        setting = self._setting
        values = np.array(self._values)
        series = [in_time("kinetic temperature", setting, values)]
        if setting.temperature is not None:
            times = series[0].x
            series.append(Series("bath", [times[0], times[-1]], [setting.temperature] * 2, theory=True))
        figures = (Figure("Kinetic temperature", setting.clock.name, "k_B T", series=tuple(series)),)
        reason, later = setting.no_equilibrium(), values[setting.begin :]
        if reason or len(later) < 4:
            said = f"k_B T is {values[0]:.6g} in the first frame and {values[-1]:.6g} in the last; not judged: "
            return Told((), (said + (reason or "too few frames") + ".",), figures)
        mean = correlated_mean(later)
        constant = float(np.ptp(later)) < _ROUNDING * abs(mean.value)
        said = f"k_B T = {mean.value:.6g} of {setting.freedoms} degrees of freedom, and constant; "
        if constant:
            mean = mean._replace(trend=None)
        else:
            said = (
                f"k_B T = {mean.value:.6g} +- {mean.error:.2g} of {setting.freedoms} degrees of freedom, "
                f"{mean.independent:.0f} independent values; "
            )
        said += f"the first {setting.begin} frames are left out."
        if setting.temperature is not None:
            return Told((self._of_the_bath(later, mean, constant, once),), (said,), figures)
        if mean.trend is None:
            return Told((), (said,), figures)
        return Told((self._drift(mean, once),), (said,), figures)

    def _of_the_bath(self, values: Floats, mean: Mean, constant: bool, once: float) -> Judgement:
        """Against the temperature that it should have, by the scatter of the file or of the canonical ensemble."""
        setting = self._setting
        assert setting.temperature is not None
        why, doubt = "equipartition at the temperature of the bath", 0.0
        thermal = setting.temperature * (2 / setting.freedoms) ** 0.5
        if setting.ensemble == "nvt":
            mean = self._samples.mean(values, thermal**2)
        elif constant or self._samples.one:
            doubt = thermal * student_quantile(once, inf)
            why += "; the doubt is the scatter of the canonical ensemble, of which this is one sample"
        if setting.rotations:
            doubt += setting.temperature * setting.rotations / setting.freedoms
            why += f"; the doubt has in it that {setting.rotations} degrees of freedom of rotation may not be thermal"
        return statistical(
            "kinetic temperature",
            mean.value,
            mean.error,
            setting.temperature,
            0.0,
            why,
            samples=mean,
            doubt=doubt,
            once=once,
        )

    def _drift(self, mean: Mean, once: float) -> Judgement:
        """The straight line through the series; of one sample of the velocities, also what two of them scatter."""
        assert mean.trend is not None
        why, doubt = "in equilibrium the temperature has no drift", 0.0
        if self._samples.one:
            doubt = student_quantile(once, inf) * (4 / self._setting.freedoms) ** 0.5
            why += "; the doubt is the scatter of two values, of a file that holds one sample of the velocities"
        return statistical(
            "drift of the kinetic temperature, relative",
            mean.trend.change / mean.value,
            mean.trend.error / mean.value,
            0.0,
            0.0,
            why,
            samples=mean._replace(value=0.0, error=mean.trend.error, freedom=mean.trend.freedom, trend=None),
            doubt=doubt,
            once=once,
        )


def _begin(setting: Setting) -> Collector | str:
    reason = setting.no_velocities()
    if reason:
        return reason
    return _Temperature(setting) if setting.freedoms > 0 else "nothing moves about the centre of mass"


PROPERTY = Property("temperature", "velocities", _begin)
