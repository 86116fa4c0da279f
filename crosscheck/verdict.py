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
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

from crosscheck.figure import Figure

Outcome = Literal["pass", "fail", "inconclusive", "skip", "error"]
Kind = Literal["round_off", "order", "statistical", "bound", "expected_failure"]

#: Probability that one statistical verdict is red although the code is right (two-sided, Student's t).
FALSE_ALARM = 1e-4


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


def worst(judgements: list[Judgement], note: str, figures: tuple[Figure, ...] | None = None) -> Judgement:
    """The worst of several judgements, with a note that gives every measured value, and the figures given, or of all.

    Red before undecided before green, then by deviation.
    """
    ranks = {"fail": 2, "inconclusive": 1}
    chosen = max(judgements, key=lambda j: (ranks.get(j.outcome, 0), j.deviation or 0.0))
    values = "; ".join(f"{j.quantity} {j.measured:.4g} (expected {j.expected:g})" for j in judgements)
    if figures is None:
        figures = tuple(figure for judgement in judgements for figure in judgement.figures)
    return replace(chosen, note=f"{values}; {note}", figures=figures)


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
