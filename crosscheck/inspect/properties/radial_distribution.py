"""The radial distribution function g(r): 1 far from a particle of a homogeneous system.

Normalised by the N - 1 others, so that its integral over the box is that of 1: what pairs lack near each other is
spread over the rest of the box.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from crosscheck.compare.pairs import largest_reach, pairs_within
from crosscheck.figure import Figure, Series
from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.statistics import correlated_mean, student_quantile
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import LEAST_FREEDOM, LEAST_SAMPLES, Judgement, bounded

#: Part of the largest reach that the box of the first frame allows: boxes at constant pressure change.
_ROOM = 0.95
#: Reach, in distances of neighbours; shells; part of the reach that counts as far; most frames that are looked at, and
#: most particles whose pairs are counted in one; length of the waves of g(r), in distances of neighbours.
_REACH, _SHELLS, _FAR, _FRAMES, _PARTICLES, _WAVE = 5.0, 100, 0.7, 100, 500, 1.1


class _RadialDistribution(Collector):
    def __init__(self, setting: Setting, reach: float) -> None:
        self._setting, self._reach = setting, reach
        count = len(setting.source) - setting.begin
        self._every = max(1, -(-count // _FRAMES))
        self._found: list[Floats] = []
        self._small = 0
        dimension = len(setting.axes)
        self._edges = np.linspace(0.0, reach, _SHELLS + 1)
        ball = math.pi if dimension == 2 else 4 / 3 * math.pi
        self._volumes = ball * np.diff(self._edges**dimension)
        far = np.where(self._edges[:-1] >= _FAR * reach, self._volumes, 0.0)
        self._weights = far / far.sum()

    def add(self, view: View) -> None:
        setting, frame = self._setting, view.frame
        if view.index < setting.begin or (view.index - setting.begin) % self._every:
            return
        if largest_reach(frame) < self._reach:
            self._small += 1
            return
        number = len(frame.ids)
        chosen = np.arange(0, number, -(-number // _PARTICLES))
        counts = np.histogram(pairs_within(frame, self._reach, chosen).distances, self._edges)[0]
        assert frame.box is not None
        volume = float(np.prod(np.linalg.norm(frame.box.vectors, axis=1)[list(setting.axes)]))
        if len(setting.axes) == 3:
            volume = abs(float(np.linalg.det(frame.box.vectors)))
        self._found.append(counts / (len(chosen) * (number - 1) / volume * self._volumes))

    def judge(self, once: float) -> Told:
        if not self._found:
            return Told((), ("there are too few frames.",))
        g = np.array(self._found)
        mean, middle = g.mean(axis=0), (self._edges[1:] + self._edges[:-1]) / 2
        said = [self._first_peak(mean, middle)]
        if self._small:
            said.append(f"{self._small} frames are left out, whose box is smaller than that of the first by far.")
        curve = Series("g(r)", middle.tolist(), mean.tolist())
        uniform = Series("uniform", [0.0, self._reach], [1.0, 1.0], theory=True)
        figure = Figure("Radial distribution function", "r", "g(r)", series=(curve, uniform))
        judged: tuple[Judgement, ...] = ()
        if len(g) < 4:
            said.append("its tail is not judged: there are fewer than 4 frames.")
        elif self._setting.homogeneous:
            judged = (self._tail(g, mean, once),)
        else:
            tail = float(mean @ self._weights)
            said.append(f"its mean from r = {_FAR * self._reach:.4g} on is {tail:.4g}; --homogeneous asks for 1.")
        return Told(judged, tuple(said), (figure,))

    def _first_peak(self, mean: Floats, middle: Floats) -> str:
        """The first of the largest maxima, and where g begins."""
        begins = int(np.flatnonzero(mean > 0)[0]) if mean.any() else 0
        high = np.flatnonzero(mean[begins:] >= 0.5 + 0.5 * mean.max()) + begins
        if not high.size:
            return "g(r) is 0."
        last = int(high[0])
        while last + 1 < len(mean) and mean[last + 1] > mean[last]:
            last += 1
        return (
            f"g(r) is 0 up to r = {self._edges[begins]:.4g}; first peak {mean[last]:.4g} at r = {middle[last]:.4g}, in "
            f"shells of {self._edges[1]:.2g}."
        )

    def _tail(self, g: Floats, mean: Floats, once: float) -> Judgement:
        """The mean of the tail; where this is longer than a wave, the line through it, at either end."""
        number = len(self._setting.first.ids)
        found = []
        for weights in self._line():
            series = correlated_mean(g @ weights)
            quantile = student_quantile(once / len(self._line()), series.freedom)
            found.append((series.value - 1, quantile * series.error, series))
        noise = float(np.sum(self._weights * g.var(axis=0) / len(g)))
        waves = max(float(np.sum(self._weights * (mean - self._fitted(mean)) ** 2)) - noise, 0.0) ** 0.5
        # a core takes up to one pair of N - 1 from contact, which the rest of the box has more of
        doubt = 1 / number + waves
        off, allowed, series = max(found, key=lambda one: abs(one[0]) / (one[1] + doubt))
        why = (
            f"a homogeneous system, from r = {_FAR * self._reach:.4g} to {self._reach:.4g}: the limit is {allowed:.2g} "
            f"of statistics, and a doubt of {doubt:.2g}, by which g(r) still varies there, with one pair of {number} "
            f"that a core displaces; false-alarm rate {once:.2g}"
        )
        what = "mean of g(r) far away" if len(found) == 1 else "line through g(r) far away, at its worse end"
        judged = replace(bounded(f"|{what}, less 1|", abs(off), allowed + doubt, why), false_alarm=once)
        few = series.independent < LEAST_SAMPLES or series.freedom < LEAST_FREEDOM
        return replace(judged, outcome="inconclusive") if few and judged.outcome == "pass" else judged

    def _columns(self) -> Floats:
        """1, and in a tail that is longer than a wave of g(r) the distance from its middle, over half of its length."""
        middle, length = (self._edges[1:] + self._edges[:-1]) / 2, (1 - _FAR) * self._reach
        columns = [np.ones_like(middle)]
        if length > _WAVE * self._setting.spacing:
            columns.append((middle - (1 + _FAR) / 2 * self._reach) / (length / 2))
        return np.stack(columns, axis=1)

    def _line(self) -> list[Floats]:
        """Weights with which g(r) gives the value of its least-squares line at either end; or that of its mean."""
        columns = self._columns()
        weighted = self._weights[:, None] * columns
        solved = weighted @ np.linalg.inv(weighted.T @ columns)
        ends = [[1.0]] if columns.shape[1] == 1 else [[1.0, -1.0], [1.0, 1.0]]
        return [np.asarray(solved @ end) for end in ends]

    def _fitted(self, mean: Floats) -> Floats:
        """The line, or the mean, at all distances."""
        columns = self._columns()
        weighted = self._weights[:, None] * columns
        return np.asarray(columns @ (np.linalg.inv(weighted.T @ columns) @ (weighted.T @ mean)))


def _begin(setting: Setting) -> Collector | str:
    box = setting.first.box
    if box is None:
        return "there is no box to fill"
    if len(setting.axes) < 2 or len(setting.first.ids) < 2:
        return "it is of particles in a plane or in space"
    if not box.periodic[list(setting.axes)].all():
        return "the box is not periodic along all axes, and walls change it"
    reach = min(_ROOM * largest_reach(setting.first), _REACH * setting.spacing)
    if not reach > 0:
        return "the first frame has positions that are not finite"
    return _RadialDistribution(setting, reach)


PROPERTY = Property("radial distribution", "structure", _begin)
