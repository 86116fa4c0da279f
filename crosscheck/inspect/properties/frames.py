"""Whole frames: all of them can be read, all numbers are finite, and no particle is lost."""

from __future__ import annotations

from crosscheck.inspect.property import Collector, Property, Told, none_of
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.trajectories.frames import Cut


class _Frames(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting, self._seen = setting, 0
        self._reasons = [str(remark) for remark in setting.source.remarks if isinstance(remark, Cut)]

    def add(self, view: View) -> None:
        self._seen += 1

    def stopped(self, reason: str) -> None:
        self._reasons.append(reason)

    def judge(self, once: float) -> Told:
        why = "each frame must be complete, of finite numbers, and of the same particles as the first"
        count = len(self._setting.source)
        note = " ".join(self._reasons)
        judged = none_of("places where the file ends, or frames cannot be used", len(self._reasons), why, note)
        return Told((judged,), (f"{self._seen} of {count} frames of {len(self._setting.first.ids)} particles.",))


PROPERTY = Property("frames", "file", _Frames)
