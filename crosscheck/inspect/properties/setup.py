"""The set-up against the scene: masses, sizes, types and box of the first frame."""

from __future__ import annotations

import numpy as np

from crosscheck.compare.setup import different_setup
from crosscheck.inspect.property import Collector, Property, Told, none_of
from crosscheck.inspect.setting import Setting, box_of
from crosscheck.inspect.view import View
from crosscheck.trajectories.frames import DOUBLE, Frame


class _Setup(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting

    def add(self, view: View) -> None:
        return

    def judge(self, once: float) -> Told:
        setting = self._setting
        rounding = {name: (setting.source.rounding[name], DOUBLE) for name in ("masses", "diameters", "box")}
        found = different_setup(setting.first, _expected(setting), rounding)
        why = "masses, diameters, types and box of the scene, within the file's rounding; the file's come first"
        return Told((none_of("differences from the scene", len(found), why, "; ".join(found)),))


def _expected(setting: Setting) -> Frame:
    """The first frame as the scene has it, as far as the set-up goes."""
    scene, first = setting.scene, setting.first
    assert scene is not None
    types = None if scene.species is None else np.array(scene.species)
    masses = np.broadcast_to(np.asarray(scene.masses, dtype=np.float64), (len(first.ids),))
    return Frame(0.0, 0, first.ids, first.positions, None, None, types, masses, scene.diameters(), box_of(scene))


def _begin(setting: Setting) -> Collector | str:
    return _Setup(setting) if setting.scene is not None else "no scene is given (--scene)"


PROPERTY = Property("set-up", "file", _begin)
