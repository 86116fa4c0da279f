"""Curves of what was measured in time, for figures."""

from __future__ import annotations

import numpy as np

from crosscheck.figure import Series
from crosscheck.inspect.setting import Setting
from crosscheck.trajectories.frames import Floats

#: Most points of a curve.
_POINTS = 400


def in_time(label: str, setting: Setting, values: Floats, *, theory: bool = False) -> Series:
    """A curve in time. label: of it. setting: has the clock. values: (F,), of the first frames. theory: see `Series`.

    Of many frames every n-th is drawn, and the one with the largest |value|.
    """
    every = max(1, -(-len(values) // _POINTS))
    chosen = np.unique([*range(0, len(values), every), int(np.argmax(np.abs(values))) if len(values) else 0])
    times = setting.clock.values[: len(values)]
    return Series(label, times[chosen].tolist(), values[chosen].tolist(), theory=theory)
