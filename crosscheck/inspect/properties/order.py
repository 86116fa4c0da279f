"""The order of frames: all particles together keep their pace, and do not turn back, from one interval to the next.

Frames that were exchanged or left out show so, also where their times were written anew. Of two displacements that
follow each other the cosine of the angle, in the space of all coordinates, is near 1 where frames are close in time,
and near 0 where particles have forgotten their velocities; where two frames are exchanged it is -1, or -0.7.
"""

from __future__ import annotations

import math

import numpy as np

from crosscheck.inspect.outliers import of_deviations
from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.setting import FEWEST, NOT_IN_EQUILIBRIUM, Setting
from crosscheck.inspect.view import View
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement, by_chance

#: Intervals to either side with which one is compared.
_AROUND = 2
#: Half of the smallest change of ln of a pace that one frame which was left out makes, that of diffusion; and what a
#: few of N particles that collide in one interval make of it, times N^(1/2).
_LEFT_OUT, _FEW = 0.25 * math.log(2), 2.0


class _Order(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._before: Floats | None = None
        # frame at the end of an interval, and ln of the pace; frame between two intervals, and the cosine
        self._paces: list[tuple[int, float]] = []
        self._cosines: list[tuple[int, float]] = []

    def add(self, view: View) -> None:
        if view.before is None or view.index <= self._setting.begin:
            return
        moved = view.nearest if self._setting.source.wrapping == "wrapped" else view.displacements
        square = float(np.mean(np.sum(moved**2, axis=1)))
        if square == 0 or view.interval == 0:
            return
        self._paces.append((view.index, 0.5 * math.log(square) - math.log(abs(view.interval))))
        if self._before is not None:
            product = float(np.sum(moved * self._before))
            self._cosines.append(
                (view.index - 1, product / float(np.linalg.norm(moved) * np.linalg.norm(self._before)))
            )
        self._before = moved

    def judge(self, once: float) -> Told:
        if len(self._paces) <= 2 * _AROUND:
            return Told((), ("there are too few intervals.",))
        judged = [one for one in (self._turns(once), self._pace(once)) if one is not None]
        said = () if len(judged) == 2 else ("not all of it can be told: fewer than 20 intervals are independent.",)
        return Told(tuple(judged), said)

    def _turns(self, once: float) -> Judgement | None:
        values = np.array([cosine for _, cosine in self._cosines])
        if len(values) <= 2 * _AROUND:
            return None
        around, usual = _medians_around(values), float(np.median(values))
        back = (around - values)[_AROUND:-_AROUND]
        # particles that collide seldom go straight on in most intervals: only what turns back is wrong
        law = of_deviations(back, "normal", floor=max(usual, 0.0))
        if law is None:
            return None
        worst = int(back.argmax())
        frame = self._cosines[worst + _AROUND][0]
        note = f"at frame {frame} (counted from 0) the cosine is {values[worst + _AROUND]:.3g}, usually {usual:.3g}"
        why = (
            f"cosines of {len(values)} pairs of displacements are means of many particles, and normal; they are wrong "
            "below 0 alone"
        )
        quantity = "cosine of displacements below those around"
        return by_chance(quantity, float(back[worst]), law, why, once=once, note=note)

    def _pace(self, once: float) -> Judgement | None:
        logs = np.array([pace for _, pace in self._paces])
        off = (logs - _medians_around(logs))[_AROUND:-_AROUND]
        # the pace of particles that meet seldom is even, and changes where a few of them do: nothing to be told
        law = of_deviations(off, "normal", floor=max(_LEFT_OUT, _FEW / self._setting.number**0.5))
        if law is None:
            return None
        worst = int(np.abs(off).argmax())
        frame = self._paces[worst + _AROUND][0]
        note = (
            f"from frame {frame - 1} to {frame} (counted from 0) particles move {math.exp(off[worst]):.3g} times as "
            "fast as around"
        )
        why = (
            f"ln of the root mean square displacement over the interval, less the median of the {2 * _AROUND} "
            "intervals around, is a mean of many particles, and normal"
        )
        quantity = "largest |ln(pace of an interval over those around)|"
        return by_chance(quantity, float(np.abs(off).max()), law, why, once=once, note=note)


def _medians_around(values: Floats) -> Floats:
    """Medians of the values to either side of each one, without it, (F,); at the ends of no meaning."""
    around = [np.roll(values, k) for k in range(-_AROUND, _AROUND + 1) if k]
    return np.asarray(np.median(around, axis=0))


def _begin(setting: Setting) -> Collector | str:
    if setting.ensemble == "none":
        return f"motion that is driven may turn, and need not keep its pace: {NOT_IN_EQUILIBRIUM}"
    if setting.number < FEWEST:
        return f"{setting.number} particles move, and an even pace is that of {FEWEST} or more"
    return _Order(setting)


PROPERTY = Property("order of frames", "motion", _begin)
