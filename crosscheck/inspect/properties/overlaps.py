"""Overlaps: the smallest distance of two particles, over the sum of their radii where they are hard."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crosscheck.compare.pairs import Pairs, largest_reach, pairs_within
from crosscheck.inspect.property import Collector, Property, Told, none_of
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.trajectories.frames import Floats, Frame
from crosscheck.verdict import round_off

#: Two of N particles in a box are nearer than this many distances of neighbours: the densest packing.
_DENSEST = 1.13
#: Probability that two of many particles at random have one place in the digits of the file, which is no fault then.
_CHANCE = 1e-6
#: Roundings of the run's arithmetic in the distance of two particles that touch: of either position and its flight, and
#: of the time of the collision.
_ROUNDINGS = 16


class _Overlaps(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        # ratio (or length), frame, ids of both, and what rounding allows the ratio
        self._nearest: tuple[float, int, int, int, float] = (np.inf, 0, 0, 0, 0.0)
        self._coincident = 0
        self._frames = 0

    def add(self, view: View) -> None:
        setting, frame = self._setting, view.frame
        diameters = setting.diameters if frame.diameters is None or setting.scene is not None else frame.diameters
        reach = _DENSEST * setting.spacing
        if setting.hard and diameters is not None:
            reach = 1.01 * float(diameters.max())
        limit = largest_reach(frame)
        found = pairs_within(frame, min(reach, limit))
        if setting.scene is not None and not setting.moving.all():
            free = setting.moving[found.first] | setting.moving[found.second]
            found = _of(found, free)
        self._frames += 1
        if not found.distances.size:
            return
        values = found.distances
        if setting.hard and diameters is not None:
            contact = (diameters[found.first] + diameters[found.second]) / 2
            found = _of(found, contact > 0)
            contact = contact[contact > 0]
            if not contact.size:
                return
            values = found.distances / contact
        self._coincident += int(np.count_nonzero(found.distances == 0))
        at = int(values.argmin())
        if values[at] < self._nearest[0]:
            rows = int(found.first[at]), int(found.second[at])
            allowed = self._allowed(frame, rows)
            if setting.hard:
                allowed = allowed / float(contact[at]) + self._of_diameters(float(contact[at]))
            one, other = sorted(int(frame.ids[row]) for row in rows)
            self._nearest = (float(values[at]), view.index, one, other, allowed)

    def _allowed(self, frame: Frame, rows: tuple[int, int]) -> float:
        """What rounding of the file and of the run does to the distance of two particles, length."""
        setting = self._setting
        positions: Floats = frame.positions[list(rows)]
        far = float(np.abs(positions).max())
        if frame.box is not None:
            far += float(np.abs(frame.box.vectors).max())
        file = np.linalg.norm(setting.source.rounding["positions"].of(positions), axis=1).sum()
        return float(file) + _ROUNDINGS * setting.epsilon * far

    def _of_diameters(self, contact: float) -> float:
        """The same of the sum of two radii, relative."""
        if self._setting.scene is not None:
            return 2 * self._setting.epsilon
        return 2 * float(self._setting.source.rounding["diameters"].of(np.array([contact]))[0]) / contact

    def judge(self, once: float) -> Told:
        ratio, frame, first, second, allowed = self._nearest
        if not np.isfinite(ratio):
            far = "1.01 of the largest diameter" if self._setting.hard else f"{_DENSEST * self._setting.spacing:.4g}"
            return Told((), (f"no two particles come nearer to each other than {far}.",))
        where = f"particles {first} and {second} in frame {frame} (counted from 0)"
        if self._setting.hard:
            why = "hard particles do not overlap, but for the rounding of the file and of the run"
            quantity = "deepest overlap over the sum of the radii"
            judged = round_off(quantity, max(1 - ratio, 0.0), allowed, why, note=where if ratio < 1 else "")
            return Told((judged,), (f"the smallest distance over the sum of the radii is {ratio:.9g}, of {where}.",))
        said = (f"the smallest distance is {ratio:.6g}, of {where}.",)
        if self._by_chance() > _CHANCE:
            return Told((), (*said, "particles in one place are not judged: the file's digits are few."))
        why = "two particles are not in one place"
        return Told((none_of("pairs at distance 0", self._coincident, why, where if self._coincident else ""),), said)

    def _by_chance(self) -> float:
        """The expected number of pairs in one place, if particles were anywhere and knew nothing of each other."""
        setting = self._setting
        positions = setting.first.positions
        unit = 2 * setting.source.rounding["positions"].of(positions).max(initial=0.0)
        number = len(positions)
        share = (float(unit) / setting.spacing) ** len(setting.axes) / number
        return 0.5 * number**2 * share * self._frames


def _of(pairs: Pairs, chosen: NDArray[np.bool_]) -> Pairs:
    return Pairs(pairs.first[chosen], pairs.second[chosen], pairs.distances[chosen])


def _begin(setting: Setting) -> Collector | str:
    if len(setting.first.ids) < 2:
        return "there is one particle"
    if setting.hard and setting.diameters is not None:
        reach = 1.01 * float(setting.diameters.max())
        if reach == 0:
            return "all diameters are 0"
        if reach > largest_reach(setting.first):
            return "the box is smaller than two diameters: a particle is near several images of another"
    return _Overlaps(setting)


PROPERTY = Property("overlaps", "structure", _begin)
