"""Jumps: no particle goes further from one frame to the next than its speed, or the others, make believable."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.inspect.outliers import of_maxima
from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.setting import FEWEST, NOT_IN_EQUILIBRIUM, Setting
from crosscheck.inspect.view import View
from crosscheck.verdict import by_chance

#: A particle that another one strikes leaves with twice the speed of this one at most.
_STRUCK = 2.0


class _Farthest(NamedTuple):
    """The farthest displacement of one frame from the one before.

    share: over what it is compared with. frame, particle: which. length: of it. unit: what it is compared with, length.
    """

    share: float
    frame: int
    particle: int
    length: float
    unit: float


class _Jumps(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._found: list[_Farthest] = []
        self._by_speed = setting.first.velocities is not None and setting.clock.same_unit

    def add(self, view: View) -> None:
        if view.before is None:
            return
        setting = self._setting
        moved = view.nearest if setting.source.wrapping == "wrapped" else view.displacements
        lengths = np.linalg.norm(moved, axis=1)
        weights = np.ones_like(lengths)
        if self._by_speed:
            here, there = view.frame.velocities, view.before.frame.velocities
            assert here is not None
            assert there is not None
            speed = max(float(np.linalg.norm(one, axis=1).max()) for one in (here, there))
            unit = speed * abs(view.interval)
        else:
            if setting.unequal_masses:  # what is heavier moves less
                weights = (setting.moving_masses / np.median(setting.moving_masses)) ** 0.5
            unit = float(np.median(weights * lengths))
        if unit == 0:
            return
        row = int(np.argmax(weights * lengths))
        share = float(weights[row] * lengths[row]) / unit
        self._found.append(_Farthest(share, view.index, int(view.ids[row]), float(lengths[row]), unit))

    def judge(self, once: float) -> Told:
        values = np.array([one.share for one in self._found])
        what = "largest speed of its frames, times the interval" if self._by_speed else "median of its frame"
        law = of_maxima(values, _STRUCK if self._by_speed else 0.0)
        if law is None:
            return Told((), ("jumps cannot be told: fewer than 20 intervals are independent of each other.",))
        worst = self._found[int(values.argmax())]
        least = law.isf(once) * float(np.median([one.unit for one in self._found]))
        note = (
            f"particle {worst.particle} moves by {worst.length:.4g} to frame {worst.frame} (counted from 0); a jump of "
            f"{least:.3g} would be red"
        )
        why = (
            f"the farthest displacements of {len(values)} intervals, each over the {what}, are maxima with Gumbel's "
            "law, whose scale follows from their quartiles"
        )
        if self._by_speed:
            why += "; a particle that is struck once may go twice as far as the fastest"
        quantity = f"farthest displacement over the {what}"
        return Told((by_chance(quantity, float(values.max()), law, why, once=once, note=note),))


def _begin(setting: Setting) -> Collector | str:
    if setting.first.velocities is not None and setting.clock.same_unit:
        return _Jumps(setting)
    if setting.ensemble == "none":
        return f"without velocities, displacements say something in equilibrium: {NOT_IN_EQUILIBRIUM}"
    if setting.number < FEWEST:
        return f"without velocities, displacements of {FEWEST} particles or more can be compared with each other"
    return _Jumps(setting)


PROPERTY = Property("jumps", "motion", _begin)
