"""What a figure of a verdict holds: curves, histograms, particles at one time, or a field on a grid."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Series:
    """One curve: x, y, optional error bars; `theory` curves are drawn as thin lines without markers.

    bins: a histogram; x holds the n + 1 edges of its n bins, y their heights. ValueError if the lengths do not match.
    """

    label: str
    x: list[float]
    y: list[float]
    error: list[float] | None = None
    theory: bool = False
    bins: bool = False

    def __post_init__(self) -> None:
        if len(self.x) != len(self.y) + self.bins or (self.error is not None and len(self.error) != len(self.y)):
            raise ValueError(f"'{self.label}': {len(self.y)} values do not match {len(self.x)} x or their error bars")


@dataclass(frozen=True)
class Frame:
    """A rectangle. walls: its sides that are walls; the others (open, periodic) are drawn dashed."""

    left: float
    right: float
    bottom: float
    top: float
    walls: tuple[Literal["left", "right", "bottom", "top"], ...] = ("left", "right", "bottom", "top")
    shape: Literal["box"] = field(default="box", init=False)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.right - self.left) and math.isfinite(self.top - self.bottom)):
            raise ValueError("the sides of a box must be finite")
        if not (self.right > self.left and self.top > self.bottom):
            raise ValueError(f"a box of {self.right - self.left} by {self.top - self.bottom} has no inside")


@dataclass(frozen=True)
class RoundFrame:
    """A circular container about x, y."""

    x: float
    y: float
    radius: float
    shape: Literal["drum"] = field(default="drum", init=False)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x) and math.isfinite(self.y) and 0 < self.radius < math.inf):
            raise ValueError(f"a drum needs a finite centre and a positive radius, got {self.radius}")


@dataclass(frozen=True)
class Snapshot:
    """Particles at one time, drawn as circles of their radius (one number if it is the same for all).

    value: what colours them (speed, temperature), one number a particle, with its label. limits: ends of the colour
    scale, by default the range of the values; what lies outside gets the colour of the end, what is not finite none.
    Kept rounded: positions to 1e-4 of the container or finer, all else to four digits. ValueError if the lengths do
    not match.
    """

    x: list[float]
    y: list[float]
    radius: float | list[float]
    container: Frame | RoundFrame
    value: list[float] | None = None
    value_label: str = ""
    limits: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        number = len(self.x)
        lengths = [len(one) for one in (self.y, self.radius, self.value) if isinstance(one, list)]
        if any(length != number for length in lengths):
            raise ValueError(f"a snapshot of {number} particles has lists of {lengths}")
        _check_limits(self.limits)
        box = self.container
        size = 2 * box.radius if isinstance(box, RoundFrame) else max(box.right - box.left, box.top - box.bottom)
        places = 4 - math.floor(math.log10(size))
        object.__setattr__(self, "x", [round(float(v), places) for v in self.x])
        object.__setattr__(self, "y", [round(float(v), places) for v in self.y])
        radius = self.radius
        object.__setattr__(self, "radius", _short(radius) if isinstance(radius, list) else _short([radius])[0])
        object.__setattr__(self, "value", None if self.value is None else _short(self.value))


@dataclass(frozen=True)
class FieldMap:
    """A field on a regular grid of equal cells that spans the container (a drum: its bounding square).

    values[row][column]: rows from the bottom up, columns from left to right; a cell that is not finite is left blank.
    limits: as in `Snapshot`. arrows: the two components u[row][column], v[row][column] of a vector field on a grid
    over the same container, as fine or coarser. Kept rounded to four digits. ValueError unless the rows of a grid are
    equally long and u, v have one shape.
    """

    values: list[list[float]]
    container: Frame | RoundFrame
    value_label: str
    limits: tuple[float, float] | None = None
    arrows: tuple[list[list[float]], list[list[float]]] | None = None
    arrow_label: str = ""

    def __post_init__(self) -> None:
        _check_limits(self.limits)
        u, v = self.arrows or ([], [])
        if [len(row) for row in u] != [len(row) for row in v]:
            raise ValueError("the components of the arrows differ in shape")
        for grid in (self.values, u):
            if len({len(row) for row in grid}) > 1:
                raise ValueError("the rows of a grid must be equally long")
        object.__setattr__(self, "values", [_short(row) for row in self.values])
        if self.arrows is not None:
            object.__setattr__(self, "arrows", ([_short(row) for row in u], [_short(row) for row in v]))


def _check_limits(limits: tuple[float, float] | None) -> None:
    if limits is not None and not -math.inf < limits[0] < limits[1] < math.inf:
        raise ValueError(f"the limits of a colour scale must be finite and rise, got {limits}")


def _short(values: list[float]) -> list[float]:
    return [float(f"{v:.4g}") for v in values]


@dataclass(frozen=True)
class Figure:
    """A figure of a verdict: curves, or a snapshot, or a map (ValueError if it is more than one of them).

    Verdicts of one check whose figures have the same title share one set of axes for their curves; snapshots and maps
    are drawn each by itself, lengths on both axes to one scale.
    """

    title: str
    x_label: str
    y_label: str
    x_scale: Literal["linear", "log"] = "linear"
    y_scale: Literal["linear", "log"] = "linear"
    series: tuple[Series, ...] = ()
    snapshot: Snapshot | None = None
    map: FieldMap | None = None

    def __post_init__(self) -> None:
        if bool(self.series) + (self.snapshot is not None) + (self.map is not None) > 1:
            raise ValueError(f"figure '{self.title}' holds more than one of series, snapshot and map")
