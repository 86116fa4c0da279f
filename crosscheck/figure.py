"""Figures of a verdict: curves and histograms, particles at one time, a field on a grid, or error against cost."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Series:
    """One curve. Units are those of the axis labels of its figure.

    label: its entry in the legend. x, y: (n,). error: (n,), the half-length of error bars. theory: an expected curve,
    drawn as a thin line without markers. ValueError if the lengths do not match.
    """

    label: str
    x: list[float]
    y: list[float]
    error: list[float] | None = None
    theory: bool = False

    def __post_init__(self) -> None:
        _check_lengths(self.label, len(self.y), len(self.x), self.error)


@dataclass(frozen=True)
class Histogram:
    """Heights over bins. Units are those of the axis labels of its figure.

    label: its entry in the legend. x: (n + 1,), the edges of the bins, rising. y: (n,), the heights. error: (n,), the
    half-length of error bars. theory: an expected histogram, drawn as a thin line. bins: always true; distinguishes it
    from a `Series` in the record. ValueError if the lengths do not match.
    """

    label: str
    x: list[float]
    y: list[float]
    error: list[float] | None = None
    theory: bool = False
    bins: Literal[True] = field(default=True, init=False)

    def __post_init__(self) -> None:
        _check_lengths(self.label, len(self.y), len(self.x) - 1, self.error)


def _check_lengths(label: str, values: int, places: int, error: list[float] | None) -> None:
    """ValueError unless there is a value for each place on the x axis, and an error bar for each value, if any."""
    if values != places or (error is not None and len(error) != values):
        raise ValueError(f"'{label}': {values} values do not match {places} places on the x axis or their error bars")


@dataclass(frozen=True)
class Frame:
    """A rectangular frame around particles or a field. Lengths in the unit of the axis labels of the figure.

    left, right, bottom, top: its sides. walls: the sides that are walls; the others (open, periodic) are drawn dashed.
    shape: always "box"; distinguishes it from a `RoundFrame` in the record. ValueError unless right > left and top >
    bottom, all finite.
    """

    left: float
    right: float
    bottom: float
    top: float
    walls: tuple[Literal["left", "right", "bottom", "top"], ...] = ("left", "right", "bottom", "top")
    shape: Literal["box"] = field(default="box", init=False)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.right - self.left) and math.isfinite(self.top - self.bottom)):
            raise ValueError("the sides of a frame must be finite")
        if not (self.right > self.left and self.top > self.bottom):
            raise ValueError(f"a frame of {self.right - self.left} by {self.top - self.bottom} has no inside")


@dataclass(frozen=True)
class RoundFrame:
    """A circular frame, a wall all around. Lengths in the unit of the axis labels of the figure.

    x, y: its centre. radius: of the circle. shape: always "drum"; distinguishes it from a `Frame` in the record.
    ValueError unless all are finite and the radius is positive.
    """

    x: float
    y: float
    radius: float
    shape: Literal["drum"] = field(default="drum", init=False)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x) and math.isfinite(self.y) and 0 < self.radius < math.inf):
            raise ValueError(f"a round frame needs a finite centre and a positive radius, got {self.radius}")


@dataclass(frozen=True)
class Snapshot:
    """N particles at one time, drawn as circles. Lengths in the unit of the axis labels of the figure.

    x, y: (N,), their centres. radius: one number, or (N,). container: the frame around them. value: (N,), the quantity
    that colours them (speed, temperature). value_label: name and unit of that quantity. limits: ends of the colour
    scale, by default the range of the values; values outside get the colour of the nearer end, values that are not
    finite none.

    Kept rounded: positions to 1e-4 of the container or finer, all else to four digits. ValueError if the lengths do
    not match, or the limits are not finite and rising.
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
        frame = self.container
        if isinstance(frame, RoundFrame):
            size = 2 * frame.radius
        else:
            size = max(frame.right - frame.left, frame.top - frame.bottom)
        places = 4 - math.floor(math.log10(size))
        object.__setattr__(self, "x", [round(float(v), places) for v in self.x])
        object.__setattr__(self, "y", [round(float(v), places) for v in self.y])
        radius = self.radius
        object.__setattr__(
            self, "radius", _four_digits(radius) if isinstance(radius, list) else _four_digits([radius])[0]
        )
        object.__setattr__(self, "value", None if self.value is None else _four_digits(self.value))


@dataclass(frozen=True)
class FieldMap:
    """A field on a regular grid of equal cells that spans the container, or the square around a `RoundFrame`.

    values: values[row][column], rows from the bottom up, columns from left to right; a cell that is not finite is left
    blank. container: the frame around the field. value_label: name and unit of the values. limits: as in `Snapshot`.
    arrows: the two components u[row][column], v[row][column] of a vector field on a grid over the same container, as
    fine or coarser. arrow_label: name of the vector field. lines: curves over the field, in the coordinates of the
    container, as an expected boundary between two regions.

    Kept rounded to four digits. ValueError unless the rows of a grid are equally long, u and v have one shape, and the
    limits are finite and rising.
    """

    values: list[list[float]]
    container: Frame | RoundFrame
    value_label: str
    limits: tuple[float, float] | None = None
    arrows: tuple[list[list[float]], list[list[float]]] | None = None
    arrow_label: str = ""
    lines: tuple[Series, ...] = ()

    def __post_init__(self) -> None:
        _check_limits(self.limits)
        u, v = self.arrows or ([], [])
        if [len(row) for row in u] != [len(row) for row in v]:
            raise ValueError("the components of the arrows differ in shape")
        for grid in (self.values, u):
            if len({len(row) for row in grid}) > 1:
                raise ValueError("the rows of a grid must be equally long")
        object.__setattr__(self, "values", [_four_digits(row) for row in self.values])
        if self.arrows is not None:
            object.__setattr__(self, "arrows", ([_four_digits(row) for row in u], [_four_digits(row) for row in v]))


@dataclass(frozen=True)
class Ladder:
    """One method on a ladder of time steps, tolerances or durations: what each run cost, and how far it was off.

    label: of the method. family: of methods that move a scene alike; methods of one family are drawn in one colour.
    control: what is varied, as "dt". controls: (n,), its values, in the units of the scene. error: (n,), in the unit of
    the figure's y label; not finite where the run failed. uncertainty: (n,), of the error, by rounding or its standard
    error. cpu, cpu_low, cpu_high: (n,), median, least and largest CPU time of the repeats, s. count: (n,), what was
    counted in a run, or empty. count_label: of what, as "evaluations of the force". failures: (n,), why a run failed or
    means nothing, or "". ValueError if the lengths do not match.

    Kept rounded to six digits.
    """

    label: str
    family: str
    control: str
    controls: list[float]
    error: list[float]
    uncertainty: list[float]
    cpu: list[float]
    cpu_low: list[float]
    cpu_high: list[float]
    count: list[float]
    count_label: str
    failures: list[str]

    def __post_init__(self) -> None:
        numbers = [self.error, self.uncertainty, self.cpu, self.cpu_low, self.cpu_high]
        lengths = {len(self.failures), *map(len, [*numbers, self.count] if self.count else numbers)}
        if lengths != {len(self.controls)}:
            raise ValueError(f"'{self.label}': a ladder of {len(self.controls)} runs has lists of {sorted(lengths)}")
        for name in ("controls", "error", "uncertainty", "cpu", "cpu_low", "cpu_high", "count"):
            object.__setattr__(self, name, [float(f"{v:.6g}") for v in getattr(self, name)])


def _check_limits(limits: tuple[float, float] | None) -> None:
    if limits is not None and not -math.inf < limits[0] < limits[1] < math.inf:
        raise ValueError(f"the limits of a colour scale must be finite and rise, got {limits}")


def _four_digits(values: list[float]) -> list[float]:
    return [float(f"{v:.4g}") for v in values]


@dataclass(frozen=True)
class Figure:
    """A figure of a verdict: curves and histograms, or a snapshot, or a map.

    title: verdicts of one check whose figures have the same title share one set of axes for their curves; snapshots
    and maps are drawn each by itself, lengths on both axes to one scale, and ladders of one title in one large figure.
    x_label, y_label: what the axes show, with the unit. x_scale, y_scale: of the axes of curves. series, snapshot, map,
    ladder: the content, one of the four; ValueError if it is more than one.
    """

    title: str
    x_label: str
    y_label: str
    x_scale: Literal["linear", "log"] = "linear"
    y_scale: Literal["linear", "log"] = "linear"
    series: tuple[Series | Histogram, ...] = ()
    snapshot: Snapshot | None = None
    map: FieldMap | None = None
    ladder: Ladder | None = None

    def __post_init__(self) -> None:
        others = sum(one is not None for one in (self.snapshot, self.map, self.ladder))
        if bool(self.series) + others > 1:
            raise ValueError(f"figure '{self.title}' holds more than one of series, snapshot, map and ladder")
