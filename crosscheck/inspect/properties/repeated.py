"""Repeated frames: particles that move are not in the same places, to the last bit, in two frames that follow."""

from __future__ import annotations

import numpy as np

from crosscheck.inspect.property import Collector, Property, Told, none_of
from crosscheck.inspect.setting import FEWEST, Setting
from crosscheck.inspect.view import View


class _Repeated(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._repeated: list[int] = []
        self._open: list[int] = []

    def add(self, view: View) -> None:
        if view.before is None or view.displacements.any():
            return
        (self._repeated if self._must_move(view) else self._open).append(view.index)

    def _must_move(self, view: View) -> bool:
        """Whether a particle moves by more than the file's rounding in this interval."""
        setting = self._setting
        if view.travelled is not None:
            positions = view.frame.positions[setting.moving]
            return bool((np.abs(view.travelled) > 2 * setting.source.rounding["positions"].of(positions)).any())
        if view.frame.velocities is not None:
            return bool(view.frame.velocities.any())
        return setting.ensemble != "none" and setting.number >= FEWEST

    def judge(self, once: float) -> Told:
        found = self._repeated
        note = f"frame {found[0]} (counted from 0) has the positions of the one before" if found else ""
        why = "a particle that moves changes its position by more than the file's rounding"
        said = []
        if self._open:
            said = [
                f"{len(self._open)} frames have the positions of the one before, such as frame {self._open[0]}: "
                "nothing in the file says whether the particles are at rest."
            ]
        return Told((none_of("frames with the positions of the one before", len(found), why, note),), tuple(said))


def _begin(setting: Setting) -> Collector | str:
    return _Repeated(setting) if len(setting.source) > 1 else "there is one frame"


PROPERTY = Property("repeated frames", "file", _begin)
