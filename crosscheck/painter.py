"""The content of a picture of particles: place, size and colour of each disk, the walls, and what is not shown.

The rules are the same for the report, which writes SVG itself, and for `simulate`, which draws with matplotlib: both
draw a `Painting` as it is. Particles come as in the record, a `figure.Snapshot` as a dictionary. The colour map is
viridis: perceptually uniform, and readable with colour blindness, since its lightness is monotonic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

#: Steps of the colour map.
LEVELS = 64
#: Numbers of this size or more count as not finite: axes of a picture cannot show them.
LARGEST = 1e150
#: Smallest radius of a drawn particle, smallest radius of one with an outline, and largest width of the outline; in
#: units of the drawing.
_SMALLEST, _OUTLINED, _OUTLINE = 0.5, 0.8, 0.6

#: Ends of a colour scale.
Limits = tuple[float, float]
#: x0, y0, x1, y1.
Segment = tuple[float, float, float, float]


class Extent(NamedTuple):
    """A rectangle. left, right, bottom, top: its sides, in the unit of the particles' positions."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def size(self) -> float:
        """The longer side."""
        return max(self.right - self.left, self.top - self.bottom)

    def holds(self, x: float, y: float) -> bool:
        """Whether the point (x, y) lies in it; one that is not finite does not."""
        return self.left <= x <= self.right and self.bottom <= y <= self.top

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """The point of the rectangle nearest to (x, y); NaN counts as infinity."""
        return (
            min(max(x, self.left), self.right) if x == x else self.right,
            min(max(y, self.bottom), self.top) if y == y else self.top,
        )


class Disk(NamedTuple):
    """A particle as it is drawn.

    x, y, radius: in the unit of the positions. outline: the width of its outline, inside the radius, in units of the
    drawing. level: of the colour map, 0 to LEVELS - 1; BLANK: it has no value where others have one; PLAIN: no particle
    has one.
    """

    x: float
    y: float
    radius: float
    outline: float
    level: int


#: Levels of disks without a value.
BLANK, PLAIN = -1, -2


@dataclass(frozen=True)
class Container:
    """The lines around the particles.

    walls: straight walls, drawn thick. sides: sides without a wall. circle: x, y, radius of a round wall; None: none.
    """

    walls: list[Segment]
    sides: list[Segment]
    circle: tuple[float, float, float] | None


@dataclass(frozen=True)
class Painting:
    """The picture of a snapshot.

    disks: in the order of the particles. lost: where a cross at the edge stands for a particle outside. limits: of the
    colour scale; None without a value to colour. beyond: how many values lie below and above it. blank: particles
    without a value, where others have one. enlarged: particles drawn larger than they are.
    """

    disks: list[Disk]
    lost: list[tuple[float, float]]
    limits: Limits | None
    beyond: tuple[int, int]
    blank: int
    enlarged: int

    @property
    def lost_remarks(self) -> list[str]:
        """The line of text that explains the crosses; none without crosses."""
        if not self.lost:
            return []
        return [f"× at the edge: {many(len(self.lost), 'particle')} outside the picture or not finite."]


# -- containers ----------------------------------------------------------------------------------------------


def bounds(container: dict[str, Any]) -> Extent:
    """The smallest rectangle around a container, a `Frame` or `RoundFrame` as a dictionary."""
    if container["shape"] == "drum":
        x, y, radius = container["x"], container["y"], container["radius"]
        return Extent(x - radius, x + radius, y - radius, y + radius)
    return Extent(container["left"], container["right"], container["bottom"], container["top"])


def outlines(container: dict[str, Any]) -> Container:
    """The lines of a container, a `Frame` or `RoundFrame` as a dictionary."""
    if container["shape"] == "drum":
        return Container([], [], (container["x"], container["y"], container["radius"]))
    left, right, bottom, top = bounds(container)
    corners = {
        "left": (left, bottom, left, top),
        "right": (right, bottom, right, top),
        "bottom": (left, bottom, right, bottom),
        "top": (left, top, right, top),
    }
    walls = [line for side, line in corners.items() if side in container["walls"]]
    return Container(walls, [line for side, line in corners.items() if side not in container["walls"]], None)


# -- colours -------------------------------------------------------------------------------------------------


@cache
def colours() -> tuple[str, ...]:
    """The colour map, from the lowest level to the highest."""
    import matplotlib
    from matplotlib.colors import to_hex

    return tuple(to_hex(colour) for colour in matplotlib.colormaps["viridis"](range(0, 256, 256 // LEVELS)))


def number(value: float | None) -> float:
    """`value`, a number of a record, as a float; NaN for null, a number that is not finite, and from LARGEST on."""
    return math.nan if value is None or not abs(value) < LARGEST else float(value)


def limits_of(given: Sequence[float] | None, values: list[float]) -> Limits | None:
    """Ends of the colour scale: those given, or the range of the finite values; None if no value is finite."""
    finite = [value for value in values if math.isfinite(value)]
    if not finite:
        return None
    if given is not None:
        return given[0], given[1]
    low, high = min(finite), max(finite)
    if low == high:
        around = 0.5 * abs(low) or 0.5
        return low - around, high + around
    return low, high


def level_of(value: float, limits: Limits) -> int:
    """The level, 0 to LEVELS - 1, of the colour map for a finite value; beyond the limits, that of the end."""
    low, high = limits
    if not low < value < high:
        return LEVELS - 1 if value >= high else 0
    return min(LEVELS - 1, math.floor(LEVELS * ((value - low) / (high - low))))


def beyond(values: list[float], limits: Limits | None) -> tuple[int, int]:
    """Numbers of the values that lie below and above the limits; 0 without limits."""
    if limits is None:
        return 0, 0
    return sum(value < limits[0] for value in values), sum(value > limits[1] for value in values)


# -- particles -----------------------------------------------------------------------------------------------


def radii(snapshot: dict[str, Any]) -> list[float]:
    """The radius of every particle of a snapshot."""
    radius = snapshot["radius"]
    if isinstance(radius, list):
        return [number(one) for one in radius]
    return [number(radius)] * len(snapshot["x"])


def colour_limits(snapshot: dict[str, Any]) -> Limits | None:
    """Ends of the colour scale of a snapshot; None without a value to colour."""
    return limits_of(snapshot["limits"], [number(value) for value in snapshot["value"] or ()])


def paint(snapshot: dict[str, Any], view: Extent, scale: float, periods: tuple[float, float] = (0.0, 0.0)) -> Painting:
    """The picture of the part of a snapshot in the rectangle `view`.

    snapshot: a `figure.Snapshot` as a dictionary. scale: units of the drawing per unit of length. periods: sides of the
    container along x and y where it is periodic, 0 along the other axes: particles that cross a periodic edge are drawn
    on both sides.
    """
    values = [number(value) for value in snapshot["value"] or ()]
    limits = limits_of(snapshot["limits"], values)
    disks: list[Disk] = []
    lost: list[tuple[float, float]] = []
    blank = enlarged = 0
    for i, (x, y, radius) in enumerate(zip(snapshot["x"], snapshot["y"], radii(snapshot), strict=True)):
        x, y = number(x), number(y)
        if not view.holds(x, y):
            lost.append(view.nearest(x, y))
            continue
        true = radius * scale
        seen = true if true >= _SMALLEST else _SMALLEST
        enlarged += not true >= _SMALLEST
        outline = min(_OUTLINE, 0.25 * seen) if seen >= _OUTLINED else 0.0
        level = PLAIN
        if values:
            valued = limits is not None and math.isfinite(values[i])
            level = level_of(values[i], limits) if limits is not None and valued else BLANK
            blank += not valued
        size = radius if true >= _SMALLEST else _SMALLEST / scale
        disks += [Disk(px, py, size, outline, level) for px, py in _copies(x, y, size, view, periods)]
    return Painting(disks, lost, limits, beyond(values, limits), blank, enlarged)


def _copies(x: float, y: float, radius: float, view: Extent, periods: tuple[float, float]) -> list[tuple[float, float]]:
    """The centres at which a disk at x, y is drawn: its own, and those of periodic images that reach into the view."""
    left, right, bottom, top = view
    places = [(x, y)]
    for axis, (period, low, high) in enumerate(zip(periods, (left, bottom), (right, top), strict=True)):
        if period:
            for place in list(places):
                for shift in (-period, period):
                    at = place[axis] + shift
                    if low < at + radius and at - radius < high:
                        places.append((at, place[1]) if axis == 0 else (place[0], at))
    return places


# -- words ---------------------------------------------------------------------------------------------------


def many(count: int, what: str) -> str:
    """The number `count` with the noun `what`: "1 particle", "2 particles"."""
    return f"{count} {what}{'s' if count > 1 else ''}"
