"""Images of a periodic box: a wrapped file has all positions inside, an unwrapped one has no jumps by an edge."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.inspect.property import Collector, Property, Told, none_of
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.scene import AXES
from crosscheck.trajectories.frames import DOUBLE, Box, Floats
from crosscheck.verdict import bounded

#: Share of an edge up to which the usual displacement from frame to frame may go, so that half an edge is unusual: the
#: median of normal displacements is 0.67 standard deviations, and 6.5 of these are exceeded once in 1e10.
_USUAL = 0.5 * 0.6745 / 6.5


class _Jump(NamedTuple):
    """A particle that moves by an edge of the box. frame, particle, axis: where. by: the displacement."""

    frame: int
    particle: int
    axis: int
    by: float


class _Wrapping(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._outside = 0
        self._largest = (0.0, 0, 0)
        self._jumps = 0
        self._first: _Jump | None = None
        self._usual = np.zeros(3)

    def add(self, view: View) -> None:
        box = view.frame.box
        if box is None:
            return
        rounding = self._setting.source.rounding["positions"].of(view.frame.positions).max(initial=0.0)
        beyond = _beyond(view.frame.positions, box)
        out = beyond > 2 * rounding + 4 * DOUBLE.relative * np.abs(box.vectors).sum()
        if out.any():
            self._outside += 1
            worst = int(beyond.argmax())
            self._largest = max(self._largest, (float(beyond.max()), view.index, int(view.frame.ids[worst])))
        if view.before is None:
            return
        edges = np.linalg.norm(box.vectors, axis=1)
        moved = np.abs(_along_edges(view.nearest, box)) * edges
        if len(moved):
            self._usual = np.maximum(self._usual, np.median(moved, axis=0))
        images = np.rint(_along_edges(view.displacements - view.nearest, box)).astype(int)
        if images.any():
            self._take_jumps(view, images)

    def _take_jumps(self, view: View, images: NDArray[np.int64]) -> None:
        """Counts particles whose displacement is nearest to an edge, unless their velocities say that they moved so."""
        wrong = images.any(axis=1)
        if view.travelled is not None:
            off = [np.linalg.norm(one - view.travelled, axis=1) for one in (view.displacements, view.nearest)]
            wrong &= off[0] > off[1]
        rows = np.flatnonzero(wrong)
        self._jumps += rows.size
        if rows.size and self._first is None:
            row = int(rows[0])
            axis = int(np.flatnonzero(images[row])[0])
            self._first = _Jump(view.index, int(view.ids[row]), axis, float(view.displacements[row, axis]))

    def judge(self, once: float) -> Told:
        box = self._setting.first.box
        assert box is not None
        beyond, frame, particle = self._largest
        where = f"particle {particle} in frame {frame} (counted from 0)" if self._outside else ""
        if not self._outside:
            return self._all_inside()
        if self._setting.source.wrapping == "unwrapped" or not self._jumps:
            return self._unwrapped(box)
        why = (
            "some particles leave the box and some return to it by an edge: a code that returns them from time to "
            "time, with its lists of neighbours, does so before they have gone as far as the distance of neighbours"
        )
        judged = bounded("largest distance of a position from the box", beyond, self._setting.spacing, why, note=where)
        return Told(
            (judged,), (f"positions are wrapped into the box, and in {self._outside} frames some are outside.",)
        )

    def _all_inside(self) -> Told:
        why = "a wrapped file has all positions inside the box, within its rounding"
        judged = none_of("frames with positions outside the box", 0, why)
        if self._setting.source.wrapping == "unwrapped" and self._jumps:
            return self._unwrapped(self._setting.first.box)
        return Told((judged,), ("all positions are inside the box.",))

    def _unwrapped(self, box: Box | None) -> Told:
        """Positions go on and on."""
        assert box is not None
        edges = np.linalg.norm(box.vectors, axis=1)
        far = [AXES[axis] for axis in np.flatnonzero(box.around) if self._usual[axis] > _USUAL * edges[axis]]
        if far:
            return Told((), (f"jumps by an edge cannot be told: particles go far between frames, along {far[0]}.",))
        note = ""
        if self._first is not None:
            one = self._first
            note = f"particle {one.particle} moves by {one.by:.6g} along {AXES[one.axis]} to frame {one.frame}"
        why = "positions are not wrapped, so no particle moves by an edge of the box from frame to frame"
        return Told((none_of("jumps by an edge of the box", self._jumps, why, note),), ("positions are not wrapped.",))


def _along_edges(vectors: Floats, box: Box) -> Floats:
    """Vectors (n, 3) as multiples of the edges of a box; 0 along those that are not periodic."""
    return np.asarray(vectors @ box.shares * box.around)


def _beyond(positions: Floats, box: Box) -> Floats:
    """How far each particle is outside the box along its periodic axes, (N,), length; 0 inside."""
    shares = _along_edges(positions - box.lower, box)
    out = np.maximum(np.maximum(-shares, shares - 1), 0) * np.linalg.norm(box.vectors, axis=1)
    return np.asarray(out.max(axis=1, initial=0.0))


def _begin(setting: Setting) -> Collector | str:
    box = setting.first.box
    if box is None or not box.around.any():
        return "no axis of a box is periodic"
    return _Wrapping(setting)


PROPERTY = Property("images of the box", "motion", _begin)
