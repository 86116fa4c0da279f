"""Judgements and verdicts: what was measured, against what, by which criterion, and what came of it.

A criterion is one of five kinds:

round_off   |measured - expected| <= tolerance, the tolerance counted in rounding errors;
order       the same, for the fitted slope of log error against log step;
statistical |measured - expected| <= z u, with u the standard error of correlated data and z the two-sided quantile for
            the false-alarm rate `FALSE_ALARM` of one verdict;
bound       measured <= limit (or >=);
expected_failure  the thing must be *found* wrong: measured >= limit.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Outcome = Literal["pass", "fail", "inconclusive", "skip", "error"]
Kind = Literal["round_off", "order", "statistical", "bound", "expected_failure"]

#: Probability that one statistical verdict is red although the code is right (two-sided, Student's t).
FALSE_ALARM = 1e-4


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
class Box:
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
class Drum:
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
    container: Box | Drum
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
        size = 2 * box.radius if isinstance(box, Drum) else max(box.right - box.left, box.top - box.bottom)
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
    container: Box | Drum
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


@dataclass(frozen=True)
class Criterion:
    """kind, the allowed deviation in the unit of `measured`, and where that tolerance comes from."""

    kind: Kind
    tolerance: float
    why: str


@dataclass(frozen=True)
class Judgement:
    """What a check says.

    deviation: in units of the tolerance (round_off, order, bound, expected_failure: red above 1) or of sigma
    (statistical). sensitivity: smallest relative deviation from `expected` that would have been red (absolute where
    `expected` is zero). note: one sentence for the reader.
    """

    outcome: Outcome
    quantity: str
    measured: float | None
    uncertainty: float | None
    expected: float | None
    expected_uncertainty: float | None
    deviation: float | None
    deviation_unit: Literal["tolerance", "sigma"]
    sensitivity: float | None
    criterion: Criterion
    note: str = ""
    figures: tuple[Figure, ...] = ()


@dataclass(frozen=True)
class Verdict:
    """A judgement (absent after a skip or an error) of one variant of one check on one engine, with its cost."""

    check: str
    engine: str
    outcome: Outcome
    judgement: Judgement | None
    message: str
    cost: dict[str, float] = field(default_factory=dict)

    def as_record(self) -> dict[str, Any]:
        """Flat dictionary for the record; numbers that are not finite become null."""
        inner = asdict(self.judgement) if self.judgement else dict.fromkeys(_JUDGEMENT_KEYS)
        inner.pop("outcome", None)
        flat = {"check": self.check, "engine": self.engine, "outcome": self.outcome}
        return {**flat, **_finite(inner), "message": self.message, "cost": _finite(self.cost)}


_JUDGEMENT_KEYS = tuple(key for key in Judgement.__dataclass_fields__ if key != "outcome")


def _finite(value: Any) -> Any:
    if hasattr(value, "tolist"):  # numpy's numbers and arrays
        value = value.tolist()
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _not_nan(deviation: float) -> float:
    """Infinite where it is not a number: nothing is further off."""
    return math.inf if math.isnan(deviation) else deviation


def _relative(tolerance: float, expected: float) -> float:
    return tolerance / abs(expected) if expected else tolerance


def within(
    kind: Literal["round_off", "order"],
    quantity: str,
    measured: float,
    expected: float,
    tolerance: float,
    why: str,
    *,
    uncertainty: float | None = None,
    note: str = "",
    figures: tuple[Figure, ...] = (),
) -> Judgement:
    """|measured - expected| <= tolerance; not a number fails. ValueError unless the tolerance is positive."""
    if not tolerance > 0:
        raise ValueError(f"the tolerance of '{quantity}' must be positive, got {tolerance}")
    deviation = _not_nan(abs(measured - expected) / tolerance)
    return Judgement(
        "pass" if deviation <= 1 else "fail",
        quantity,
        measured,
        uncertainty,
        expected,
        None,
        deviation,
        "tolerance",
        _relative(tolerance, expected),
        Criterion(kind, tolerance, why),
        note,
        figures,
    )


def round_off(quantity: str, error: float, tolerance: float, why: str, **more: Any) -> Judgement:
    """An error that must be of the size of rounding: expected 0."""
    return within("round_off", quantity, error, 0.0, tolerance, why, **more)


def order(quantity: str, slope: float, expected: float, tolerance: float, why: str, **more: Any) -> Judgement:
    """A fitted order of convergence against the nominal one."""
    return within("order", quantity, slope, expected, tolerance, why, **more)


def bounded(
    quantity: str,
    measured: float,
    limit: float,
    why: str,
    *,
    at_least: bool = False,
    expected_failure: bool = False,
    note: str = "",
    figures: tuple[Figure, ...] = (),
) -> Judgement:
    """measured <= limit (or >= with `at_least` or `expected_failure`); not a number fails.

    The deviation is measured/limit, or its inverse: red above 1. Where one of them is not positive, 0 or infinite.
    """
    lower = at_least or expected_failure
    good = measured >= limit if lower else measured <= limit
    ratio = 0.0 if good else math.inf
    if measured > 0 and limit > 0:
        ratio = limit / measured if lower else measured / limit
    return Judgement(
        "pass" if good else "fail",
        quantity,
        measured,
        None,
        limit,
        None,
        ratio,
        "tolerance",
        abs(limit),
        Criterion("expected_failure" if expected_failure else "bound", limit, why),
        note,
        figures,
    )


def statistical(
    quantity: str,
    measured: float,
    uncertainty: float,
    expected: float,
    expected_uncertainty: float,
    why: str,
    *,
    samples: float,
    needed: float | None = None,
    note: str = "",
    figures: tuple[Figure, ...] = (),
) -> Judgement:
    """measured +- u against expected +- u, by Student's t with `samples` - 1 degrees of freedom.

    samples: number of independent samples behind the smaller of the two data sets; fewer than 10 do not give an error
    bar to trust: "inconclusive". needed: the relative deviation that the check is meant to see; a green outcome that
    could not have seen it is "inconclusive". Not a number fails.
    """
    from scipy.stats import t

    u = math.hypot(uncertainty, expected_uncertainty)
    quantile = float(t.isf(FALSE_ALARM / 2, max(samples - 1, 1)))
    tolerance = quantile * u
    known = math.isfinite(u) and math.isfinite(measured - expected)
    deviation = math.inf
    if known and (u > 0 or measured == expected):
        deviation = abs(measured - expected) / u if u > 0 else 0.0
    sensitivity = _relative(tolerance, expected)
    outcome: Outcome = "pass" if deviation <= quantile else "fail"
    blunt = needed is not None and sensitivity > needed
    if (known and samples < 10) or (outcome == "pass" and blunt):
        outcome = "inconclusive"
    reason = f"{why}; red beyond {quantile:.2f} sigma, false-alarm rate {FALSE_ALARM:g}"
    return Judgement(
        outcome,
        quantity,
        measured,
        uncertainty,
        expected,
        expected_uncertainty,
        deviation,
        "sigma",
        sensitivity,
        Criterion("statistical", tolerance, reason),
        note,
        figures,
    )
