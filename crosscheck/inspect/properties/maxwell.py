"""Maxwell's distribution of the velocity components, of each species along each axis: its shape, whatever the energy.

Velocities about the centre of mass, times m^(1/2), are a vector in n - 1 dimensions along an axis, whose direction is
uniform: in the canonical ensemble as at constant energy. A component x_i of it, over (1 - m_i/M)^(1/2) and the root
mean square of the frame, y = x_i ((n - 1)/(1 - m_i/M))^(1/2)/|x|, is one coordinate of a point on a sphere. So y ((f -
1)/(f - y^2))^(1/2), f = n - 1, has Student's distribution with f - 1 degrees of freedom, and <y^4> = 3 f/(f + 2),
without a temperature that must be estimated.

Literature: J. C. Maxwell, Phil. Mag. 19, 19 (1860); P. T. Merz and M. R. Shirts, PLoS ONE 13, e0202764 (2018), for
tests of kinetic energies on decorrelated frames.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.figure import Figure, Histogram, Series
from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.samples import Samples, apart
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.references.speeds import maxwell_density
from crosscheck.scene import AXES
from crosscheck.statistics import Mean
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement, by_chance, statistical

#: Bins of equal probability of a component, and bins of the speed up to `_FASTEST` times (T/m)^(1/2), for the figure.
_BINS, _SPEEDS, _FASTEST = 12, 40, 5.0
#: Fewest expected counts of a bin, for chi^2 to have its distribution (W. G. Cochran, Ann. Math. Stat. 23, 315 (1952)).
_EXPECTED = 10


class _Maxwell(Collector):
    def __init__(self, setting: Setting) -> None:
        from scipy.stats import t

        self._setting = setting
        masses = setting.moving_masses
        self._species = setting.species[setting.moving]
        self._numbers = np.bincount(self._species, minlength=len(setting.names))
        self._left = 1 - masses / masses.sum()
        freedom = setting.number - 1
        edges = t.ppf(np.arange(1, _BINS) / _BINS, freedom - 1)
        self._edges = edges * np.sqrt(freedom / (freedom - 1 + edges**2))
        # of each frame, species and axis
        self._fourth: list[Floats] = []
        self._second: list[Floats] = []
        self._counts: list[Any] = []
        self._samples = Samples(setting)
        self._speeds = np.zeros(_SPEEDS)
        self._frames = 0

    def add(self, view: View) -> None:
        if view.index < self._setting.begin or not (view.kinetic > 0).all():
            return
        self._samples.add(view)
        setting, left = self._setting, self._left[:, None]
        masses = setting.moving_masses[:, None]
        scale = np.sqrt(masses / left * (setting.number - 1) / view.kinetic)
        y = view.relative * scale
        kinds, axes = len(self._numbers), y.shape[1]
        cell = (self._species[:, None] * axes + np.arange(axes)).ravel()
        size = kinds * axes
        for power, found in ((4, self._fourth), (2, self._second)):
            found.append(np.asarray(np.bincount(cell, (y**power).ravel(), size).reshape(kinds, axes), dtype=np.float64))
        bins = np.searchsorted(self._edges, y).ravel()
        counts = np.bincount(cell * _BINS + bins, minlength=size * _BINS)
        self._counts.append(counts.reshape(kinds, axes, _BINS).astype(np.uint32))
        speeds = np.linalg.norm(y, axis=1)
        self._speeds += np.histogram(speeds, _SPEEDS, (0.0, _FASTEST))[0]
        self._frames += 1

    def judge(self, once: float) -> Told:
        if self._frames < 4:
            return Told((), ("there are too few frames with motion.",))
        setting, judged, said = self._setting, [], []
        numbers = np.maximum(self._numbers, 1)[:, None]
        fourth, second = np.array(self._fourth) / numbers, np.array(self._second) / numbers
        counts = np.array(self._counts)
        for kind, name in enumerate(setting.names):
            if self._numbers[kind] == 0:
                continue
            of = "" if len(setting.names) == 1 else f" of {name}"
            for column, axis in enumerate(setting.axes):
                what = f"v_{AXES[axis]}{of}"
                number = int(self._numbers[kind])
                variance = _variance(number)
                mean = _kurtosis(self._samples, fourth[:, kind, column], second[:, kind, column], variance)
                judged.append(self._of_moment(what, mean, self._samples.doubt(variance, once), once))
                if setting.constraints + setting.rotations:
                    continue
                found = self._by_bins(what, counts[:, kind, column], mean.independent, once)
                if isinstance(found, str):
                    said.append(found)
                else:
                    judged.append(found)
        return Told(tuple(judged), tuple(said), self._figures())

    def _of_moment(self, what: str, mean: Mean, kept: tuple[float, str], once: float) -> Judgement:
        """<v^4>/<v^2>^2 of a component. kept: the doubt of waves that keep their energies."""
        setting = self._setting
        freedom = setting.number - 1
        doubt, more = kept
        why = f"a component of a vector whose direction is uniform, 3 f/(f + 2), f = n - 1{more}"
        taken = setting.constraints + setting.rotations
        if taken:  # as many directions of the sphere, and their share of the fourth moment
            doubt += 3 * min(taken / freedom, 1.0)
            why += f"; the doubt is that of {taken} directions that rotation or constraints take"
        return statistical(
            f"<{what}^4>/<{what}^2>^2",
            mean.value,
            mean.error,
            3 * freedom / (freedom + 2),
            0.0,
            why,
            samples=mean,
            doubt=doubt,
            once=once,
        )

    def _by_bins(self, what: str, counts: Any, frames: float, once: float) -> Judgement | str:
        """chi^2 of the counts (F, bins) of frames that are independent; or why not.

        Even functions of a velocity forget themselves faster than odd ones: the number of independent frames is that
        of the fourth moment, `frames`, or that of the signs, whichever is smaller.
        """
        from scipy.stats import chi2

        signs = counts[:, _BINS // 2 :].sum(axis=1).astype(np.float64) - counts[:, : _BINS // 2].sum(axis=1)
        least = min(frames, self._samples.independent(signs))
        chosen = counts[:: apart(len(counts), least)]
        total = chosen.sum(axis=0).astype(np.float64)
        expected = total.sum() / _BINS
        if expected < _EXPECTED:
            frames_left = f"{len(chosen)} independent frames, {expected:.3g} expected a bin"
            return f"the histogram of {what} is not judged: {frames_left}."
        statistic = float(np.sum((total - expected) ** 2) / expected)
        why = (
            f"chi^2 of {_BINS - 1} degrees of freedom, of {len(chosen)} decorrelated frames; that the energy and the "
            "momentum of a frame are given makes it smaller"
        )
        quantity = f"chi^2 of the histogram of {what} against Maxwell's"
        return by_chance(quantity, statistic, chi2(_BINS - 1), why, once=once)

    def _figures(self) -> tuple[Figure, ...]:
        dimension = len(self._setting.axes)
        if dimension == 1:
            return ()
        edges = np.linspace(0.0, _FASTEST, _SPEEDS + 1)
        heights = self._speeds / (self._frames * self._setting.number * np.diff(edges))
        speeds = np.linspace(0.0, _FASTEST, 200)
        theory = maxwell_density(speeds, dimension)
        series = (
            Histogram("speeds", edges.tolist(), heights.tolist()),
            Series("Maxwell", speeds.tolist(), theory.tolist(), theory=True),
        )
        return (Figure("Speeds", "v / (T/m)^(1/2)", "probability density", series=series),)


def _variance(n: int) -> float:
    """Of <y^4>/<y^2>^2 of one frame of n normal components: 24 n (n - 2) (n - 3)/((n + 1)^2 (n + 3) (n + 5)).

    R. A. Fisher, Proc. London Math. Soc. 30, 199 (1930).
    """
    return 24 * n * (n - 2) * (n - 3) / ((n + 1) ** 2 * (n + 3) * (n + 5)) if n > 3 else 0.0


def _kurtosis(samples: Samples, fourth: Floats, second: Floats, variance: float) -> Mean:
    """<y^4>/<y^2>^2 of a series of means (F,) of y^4 and of y^2, with the error of that of its linearised series.

    variance: of one frame, if all is right.
    """
    a, b = float(fourth.mean()), float(second.mean())
    linear = fourth / b**2 - 2 * a * second / b**3
    return samples.mean(linear, variance)._replace(value=a / b**2)


def _begin(setting: Setting) -> Collector | str:
    return setting.no_equilibrium() or _Maxwell(setting)


PROPERTY = Property("Maxwell's distribution", "velocities", _begin)
