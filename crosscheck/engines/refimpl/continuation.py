"""From where a run goes on, and what it leaves for the next one."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError
from crosscheck.scene import Floats, Scene
from refimpl.snapshot import restore, snapshot


class Continuation:
    """The two ends of a run.

    start: arrays by name that an earlier run of the same scene left; None: the run begins at the scene's initial state.
    end: the arrays that this run leaves; None until it has come to its end.
    """

    def __init__(self, start: Mapping[str, NDArray[Any]] | None = None) -> None:
        self.start = start
        self.end: dict[str, NDArray[Any]] | None = None

    def restored(self, like: Any, growing: Collection[str] = ()) -> Any:
        """`like` with the values of `start`, see `refimpl.snapshot.restore`; `like` itself at the initial state.

        like, growing: as there. UsageError if the arrays do not fit.
        """
        if self.start is None:
            return like
        try:
            return restore(like, self.start, growing)
        except ValueError as error:
            raise misfit(error) from None

    def leave(self, state: Any) -> None:
        """Keeps copies of all that is in `state` for the next run, see `refimpl.snapshot.snapshot`."""
        self.end = snapshot(state)


def misfit(error: ValueError) -> UsageError:
    """The error of a state that does not fit. error: says which array."""
    return UsageError(f"the restart file does not fit: {error}; the run must record what the one before it recorded")


def absolute_times(scene: Scene, start: float) -> Floats:
    """Times (samples,) of the samples of a run that goes on from the time `start`, counted from the very first start.

    scene: of the run. If `start` is a sample too, they are those of a run without a break, to the last bit.
    """
    times = scene.samples()
    interval, end = scene.output.interval, start + scene.duration
    if start == 0 or interval is None:
        return start + times
    before = start / interval
    if abs(before - round(before)) > 1e-9 * max(1.0, before):
        return np.clip(start + times, start, end)
    return np.clip((round(before) + np.arange(times.size)) * interval, start, end)
