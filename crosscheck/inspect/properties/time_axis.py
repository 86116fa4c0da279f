"""The time axis: frames are ordered, none is at the time of another, intervals are equal, times go with steps."""

from __future__ import annotations

import numpy as np

from crosscheck.compare.pairing import TIME_ROUNDING
from crosscheck.inspect.property import Collector, Property, Told, none_of
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement, within

#: Part of an interval up to which a unit of the last decimal counts as its rounding.
_SMALL = 0.3


class _TimeAxis(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting

    def add(self, view: View) -> None:
        return

    def judge(self, once: float) -> Told:
        clock, source = self._setting.clock, self._setting.source
        values = clock.values
        close = TIME_ROUNDING * np.maximum(np.abs(values[1:]), np.abs(values[:-1]))
        steps = np.diff(values)
        earlier, same = steps < -close, np.abs(steps) <= close
        judged = [
            none_of(
                "frames earlier than the one before",
                int(earlier.sum()),
                "frames follow each other in time",
                _first(earlier, f"frame {{}} (counted from 0) is at {clock.name} {{:.9g}}, after {{:.9g}}", values),
            ),
            none_of(
                "frames at the time of the one before",
                int(same.sum()),
                f"frames are of different times, within the rounding of times of 32 bits, {TIME_ROUNDING:.1e}",
                _first(same, f"frame {{}} (counted from 0) is at {clock.name} {{:.9g}}, as the one before", values),
            ),
        ]
        said = []
        if len(steps) > 1:
            spacing, sentence = self._spacing(values, steps, close, earlier | same)
            judged += spacing
            said += sentence
        if clock.name == "time" and source.steps is not None and len(values) > 2 and np.ptp(source.steps) > 0:
            judged.append(_linear(values, source.steps.astype(np.float64)))
        return Told(tuple(judged), tuple(said))

    def _spacing(
        self, values: Floats, steps: Floats, close: Floats, wrong: np.ndarray
    ) -> tuple[list[Judgement], list[str]]:
        """Whether intervals are equal, or as long as the scene says."""
        scene, clock = self._setting.scene, self._setting.clock
        middle = float(np.median(steps))
        allowed = 2 * close + _decimals(values, middle)
        equal = np.abs(steps - middle) <= allowed
        if np.count_nonzero(equal) <= len(steps) / 2:
            return [], [f"most intervals differ from each other ({clock.name}): no gap can be told."]
        said = [f"a frame every {middle:.6g} ({clock.name}), from {values[0]:.6g} to {values[-1]:.6g}."]
        odd = ~equal & ~wrong
        gap = _first(odd, f"frame {{}} (counted from 0) is at {clock.name} {{:.9g}}, after {{:.9g}}", values)
        in_order = middle > 0 and not wrong.any()
        missing = int(np.rint(steps[odd] / middle - 1).clip(min=0).sum()) if in_order else 0
        note = "; ".join(filter(None, (gap, f"{missing} frames are missing" if missing else "")))
        why = f"more than half of the intervals are {middle:.6g}, within the rounding of times"
        judged = [none_of("intervals that differ from the others", int(odd.sum()), why, note)]
        if scene is not None and scene.output.interval is not None and clock.name == "time":
            rounding = float(allowed.max()) + 4 * np.finfo(float).eps * middle
            why = "output.interval of the scene, within the rounding of times"
            judged.append(within("round_off", "interval of frames", middle, scene.output.interval, rounding, why))
        return judged, said


def _first(wrong: np.ndarray, text: str, values: Floats) -> str:
    """The sentence on the first interval that is wrong; "" if none is."""
    if not wrong.any():
        return ""
    at = int(np.flatnonzero(wrong)[0]) + 1
    return text.format(at, values[at], values[at - 1])


def _decimals(values: Floats, interval: float) -> float:
    """A unit of the last decimal that times are printed with, where it is a small part of their interval; else 0."""
    places = max(len(f"{value:.12f}".rstrip("0").partition(".")[2]) for value in values.tolist())
    unit = 10.0**-places
    return unit if places < 12 and unit < _SMALL * interval else 0.0


def _linear(times: Floats, steps: Floats) -> Judgement:
    """Whether times are proportional to steps: the line through the first and the last frame."""
    line = times[0] + (times[-1] - times[0]) * (steps - steps[0]) / (steps[-1] - steps[0] or 1.0)
    rounding = 3 * TIME_ROUNDING * float(np.abs(times).max()) or 1.0
    off = float(np.abs(times - line).max())
    why = "a constant time step, within the rounding of times of 32 bits"
    return within("round_off", "largest distance of a time from its step times dt", off, 0.0, rounding, why)


def _begin(setting: Setting) -> Collector | str:
    if setting.clock.name == "frame":
        return "the file states neither times nor steps"
    return _TimeAxis(setting) if len(setting.source) > 1 else "there is one frame"


PROPERTY = Property("time axis", "file", _begin)
