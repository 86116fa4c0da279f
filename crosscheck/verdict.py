"""Judgements and verdicts: what was measured, what was expected, by which criterion they are compared, the outcome.

A criterion is one of five kinds:

round_off   |measured - expected| <= tolerance, the tolerance counted in rounding errors;
order       the same, for the fitted slope of log error against log step;
statistical |measured - expected| <= t u + doubt, with u the standard error of correlated data, t the two-sided quantile
            of Student's distribution for the rate `SUSPICIOUS`, and a doubt that is not random; a series that drifts is
            red. What is red so is measured again with other random numbers, and is red if it is so again: see `again`;
            what cannot be measured again has a level of its own;
bound       measured <= limit (or >=);
expected_failure  a deviation that the check must find: measured >= limit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from fnmatch import fnmatchcase
from typing import Any, Literal, TypeAlias, cast

from crosscheck.errors import UsageError
from crosscheck.figure import Figure
from crosscheck.statistics import Mean, Trend, seen_beyond, student_probability, student_quantile

Outcome = Literal["pass", "fail", "inconclusive", "skip", "error"]
Kind = Literal["round_off", "order", "statistical", "bound", "expected_failure"]
#: On which side of the expected value a measured one may lie.
Sense = Literal["both", "at_most", "at_least"]

#: Probability that one measurement of a right code deviates by more than the tolerance of a statistical judgement
#: (two-sided, Student's t), and that its series seems to drift.
SUSPICIOUS, DRIFTING = 1e-3, 2e-4
#: Probability that a statistical judgement of a right code is red: what is suspicious is measured again.
FALSE_ALARM = SUSPICIOUS**2
#: Probability that a run of the suite is red although the code is right: the sum over its statistical judgements.
FALSE_ALARM_OF_A_RUN = 1e-3
#: Probability with which a statistical judgement shows a deviation of the size of its sensitivity.
SEEN = 0.9

#: What the reason of a skip starts with, of a case that there was no time for.
LEFT_OUT = "left out by --budget"

#: A standard error of fewer degrees of freedom (quantile 6) decides nothing; and independent samples fewer than these.
LEAST_FREEDOM, LEAST_SAMPLES = 6.0, 10.0
#: More degrees of freedom make no difference.
_MOST_FREEDOM = 1e6
#: The largest believable deviation of the mean of a series, in standard deviations of its own values. Series as long as
#: their correlation time go further from the true mean with the probability 1e-4: found in 1e5 autoregressive ones.
LARGEST_IN_SPREADS = 12.0

#: What the sensitivity of a judgement is: in its docstring, in docs/record.md and in the report.
SENSITIVITY = (
    "the smallest deviation from the expected value that would have been red, as a share of that value (absolute where "
    "that is zero); of a number with a standard error, in 90 % of all runs; of a bound or a test statistic, how far "
    "the measured value was from turning red: |limit - measured|/|limit|"
)


@dataclass(frozen=True)
class Criterion:
    """How a measured value is compared with the expected one.

    kind: see the module. sense: on which side of the expected value the measured one may lie. tolerance: the allowed
    deviation in the unit of the measured value; of a bound, the limit. why: the reason for this tolerance.
    """

    kind: Kind
    sense: Sense
    tolerance: float
    why: str


@dataclass(frozen=True)
class Judgement:
    """One measured number compared with the expected one.

    outcome: "pass" is called green, "fail" red. quantity: name and unit of what was measured. measured, uncertainty: it
    and its standard error. expected, expected_uncertainty: the same of the reference. deviation: as a share of the
    tolerance, whatever the criterion: red above 1. sensitivity: the smallest deviation from the expected value that
    would have been red, as a share of that value (absolute where that is zero); of a number with a standard error, in
    90 % of all runs; of a bound or a test statistic, how far the measured value was from turning red: |limit -
    measured|/|limit|. criterion: how they were compared. sigmas: the deviation in standard errors, of a statistical
    judgement. freedom: degrees of freedom of that error. doubt: of the tolerance, what is systematic. p_value: the
    probability of a deviation as large as this one, beyond the doubt, of a right code. false_alarm: the probability of
    a red judgement of a right code. control: it checks the set-up of the simulation, and is shown only when it is not
    green. note: a remark on this number. figures: see `crosscheck.figure`.
    """

    outcome: Outcome
    quantity: str
    measured: float | None
    uncertainty: float | None
    expected: float | None
    expected_uncertainty: float | None
    deviation: float | None
    sensitivity: float | None
    criterion: Criterion
    sigmas: float | None = None
    freedom: float | None = None
    doubt: float | None = None
    p_value: float | None = None
    false_alarm: float | None = None
    control: bool = False
    note: str = ""
    figures: tuple[Figure, ...] = ()

    def as_record(self) -> dict[str, Any]:
        """All fields but the figures, which the record keeps once for a verdict; non-finite numbers become null."""
        fields = {name: value for name, value in asdict(self).items() if name != "figures"}
        return dict(_finite(fields))


@dataclass(frozen=True)
class Findings:
    """The result of a check for one variant.

    judgements: all of them, in an order that does not depend on the numbers. note: a remark on all of them. figures: of
    the variant.
    """

    judgements: tuple[Judgement, ...]
    note: str = ""
    figures: tuple[Figure, ...] = ()

    @property
    def worst(self) -> int:
        """Index of the judgement that decides, and is shown: red, else inconclusive, else green; then by deviation."""
        return max(range(len(self.judgements)), key=lambda i: _rank(self.judgements[i]))

    @property
    def shown(self) -> Judgement:
        """The judgement that decides."""
        return self.judgements[self.worst]

    @property
    def outcome(self) -> Outcome:
        """The outcome of the judgement that decides."""
        return self.shown.outcome


#: What a check may return: one number, or several.
Judged: TypeAlias = Judgement | Findings


def _rank(judgement: Judgement) -> tuple[int, bool, float]:
    """Key by which the judgement that decides is the largest; a green control is below all other judgements."""
    red = {"fail": 2, "inconclusive": 1}.get(judgement.outcome, 0)
    deviation = judgement.deviation
    return red, red > 0 or not judgement.control, 0.0 if deviation is None or math.isnan(deviation) else deviation


def findings(judged: Judged) -> Findings:
    """`judged`, what a check returned, as findings: of one judgement, with its note and figures, or as they are."""
    if isinstance(judged, Findings):
        return judged
    return Findings((replace(judged, note="", figures=()),), judged.note, judged.figures)


def worst(judged: Sequence[Judged], note: str = "", figures: tuple[Figure, ...] | None = None) -> Findings:
    """Several judgements as findings, whose outcome is that of the worst of them.

    judged: judgements and findings, in an order that does not depend on the numbers. note: a remark on all of them.
    figures: of the findings; None: those of all of them.
    """
    several = [findings(one) for one in judged]
    if figures is None:
        figures = tuple(figure for one in several for figure in one.figures)
    flat: list[Judgement] = []
    for one in several:
        alone = len(one.judgements) == 1
        flat += [replace(judgement, note=one.note if alone else judgement.note) for judgement in one.judgements]
    notes = [one.note for one in several if len(one.judgements) > 1 and one.note]
    return Findings(tuple(flat), "; ".join(dict.fromkeys(filter(None, (*notes, note)))), figures)


def controls(judged: Judged) -> Findings:
    """The judgements in `judged`, marked as controls of the set-up: see `Judgement`."""
    found = findings(judged)
    return replace(found, judgements=tuple(replace(one, control=True) for one in found.judgements))


@dataclass(frozen=True)
class Verdict:
    """The result of one case: of one variant of one check on one engine.

    check: name of the check. variant, engine: their names. outcome: that of the findings, or "skip" or "error".
    findings: None after a skip or an error. message: the reason for a skip or error, or "". cost: seconds of the whole
    case, and the fields of `Cost` summed over its runs. tier: of the variant. refused: number of scenes that the engine
    could not run, and that were left out.
    """

    check: str
    variant: str
    engine: str
    outcome: Outcome
    findings: Findings | None
    message: str
    cost: dict[str, float] = field(default_factory=dict)
    tier: str = "quick"
    refused: int = 0

    @property
    def name(self) -> str:
        """`group/phenomenon/variant`."""
        return f"{self.check}/{self.variant}"

    def as_record(self) -> dict[str, Any]:
        """The verdict as a line of the record; numbers that are not finite become null."""
        found = self.findings
        return {
            "check": self.check,
            "variant": self.variant,
            "engine": self.engine,
            "tier": self.tier,
            "outcome": self.outcome,
            "judgements": [] if found is None else [one.as_record() for one in found.judgements],
            "worst": None if found is None else found.worst,
            "note": "" if found is None else found.note,
            "figures": [] if found is None else _finite([asdict(figure) for figure in found.figures]),
            "message": self.message,
            "refused": self.refused,
            "cost": _finite(self.cost),
        }


def _finite(value: Any) -> Any:
    """The value as JSON can hold it: numpy's numbers and arrays as Python's, non-finite numbers as None."""
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
    """The deviation; infinity for NaN, so that NaN fails."""
    return math.inf if math.isnan(deviation) else deviation


def _relative(tolerance: float, expected: float) -> float:
    """The tolerance relative to the expected value; absolute where that is zero."""
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
    """The judgement |measured - expected| <= tolerance; NaN fails.

    kind: of the criterion. quantity: name and unit of what was measured. tolerance: in that unit. why: the reason for
    it. uncertainty: standard error of `measured`, for the record only. note, figures: see `Judgement`. ValueError
    unless the tolerance is positive.
    """
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
        _relative(tolerance, expected),
        Criterion(kind, "both", tolerance, why),
        note=note,
        figures=figures,
    )


def round_off(quantity: str, error: float, tolerance: float, why: str, **more: Any) -> Judgement:
    """The judgement |error| <= tolerance of an error that must be of the size of rounding errors.

    quantity, tolerance, why, more, ValueError: as in `within`.
    """
    return within("round_off", quantity, error, 0.0, tolerance, why, **more)


def order(quantity: str, slope: float, expected: float, tolerance: float, why: str, **more: Any) -> Judgement:
    """The judgement |slope - expected| <= tolerance of a fitted order of convergence.

    slope: of log error against log step. expected: the order of the scheme. quantity, tolerance, why, more, ValueError:
    as in `within`.
    """
    return within("order", quantity, slope, expected, tolerance, why, **more)


def bounded(
    quantity: str,
    measured: float,
    limit: float,
    why: str,
    *,
    at_least: bool = False,
    expected_failure: bool = False,
    control: bool = False,
    note: str = "",
    figures: tuple[Figure, ...] = (),
) -> Judgement:
    """The judgement measured <= limit, or >= with `at_least` or `expected_failure`; NaN fails.

    The deviation is measured/limit, or its inverse; where one of the two is not positive, 0 or infinite. quantity: name
    and unit of what was measured. limit: in that unit. why: the reason for it. control, note, figures: see `Judgement`.
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
        _relative(abs(limit - measured), limit),
        Criterion("expected_failure" if expected_failure else "bound", "at_least" if lower else "at_most", limit, why),
        control=control,
        note=note,
        figures=figures,
    )


def statistical(
    quantity: str,
    measured: float,
    uncertainty: float,
    expected: float,
    expected_uncertainty: float,
    why: str,
    *,
    samples: float | Mean | Sequence[Mean],
    doubt: float = 0.0,
    needed: float | None = None,
    once: float | None = None,
    note: str = "",
    figures: tuple[Figure, ...] = (),
) -> Judgement:
    """The judgement |measured - expected| <= t u + doubt, u^2 = uncertainty^2 + expected_uncertainty^2; NaN fails.

    t is the two-sided quantile of Student's distribution for `SUSPICIOUS`, and thereby the largest deviation that is
    believable, however few the samples. quantity: name and unit of what was measured. uncertainty,
    expected_uncertainty: standard errors, in that unit. why: the reason for what is expected. samples: number of
    independent samples of the smaller of the two data sets, t has one degree of freedom less; or the means of the
    correlated series that were measured, which know theirs: of one with an error of what is expected beside it, or of
    two that are compared, the sum has the degrees of freedom of B. L. Welch, Biometrika 34, 28 (1947). doubt: a bound
    on what is systematically wrong with what is expected or measured (a theory of lowest order, a finite grid), in that
    unit; it is not a standard error, and is added to t u once. A series that drifts is red, whatever its mean. Where
    the error itself is too uncertain (`LEAST_FREEDOM`, `LEAST_SAMPLES`), "inconclusive" takes the place of "pass".
    needed: the relative deviation that the check must be able to detect; where its sensitivity is less, the same. once:
    the probability that it is red although all is right, of data that cannot be measured again, mean and drift
    together; None: it is `SUSPICIOUS`, and what is red is measured again. note, figures: see `Judgement`. ValueError
    for a doubt that is negative or not finite.
    """
    if not 0 <= doubt < math.inf:
        raise ValueError(f"the doubt of '{quantity}' must be a number that is not negative, got {doubt}")
    means: Sequence[Mean] = ()
    if isinstance(samples, Mean):
        means = (samples,)
    elif isinstance(samples, Sequence):
        means = cast(Sequence[Mean], samples)  # a Mean is a sequence too, of numbers
    else:
        number, freedom = float(samples), float(samples) - 1
    if means:
        number, freedom = min(mean.independent for mean in means), min(mean.freedom for mean in means)
    few = number < LEAST_SAMPLES or freedom < LEAST_FREEDOM
    u = math.hypot(uncertainty, expected_uncertainty)
    if means:
        freedom = max(freedom, _freedom((uncertainty, expected_uncertainty), means))
    trends = [mean.trend for mean in means if mean.trend]
    level, drifting = SUSPICIOUS, DRIFTING
    if once is not None:
        drifting = once * DRIFTING / (SUSPICIOUS + DRIFTING) if trends else 0.0
        level = once - drifting
    quantile = student_quantile(level, freedom)
    if means:
        quantile = min(quantile, LARGEST_IN_SPREADS * math.sqrt(number))
    tolerance = quantile * u + doubt
    off = abs(measured - expected)
    known = math.isfinite(u) and math.isfinite(off)
    sigmas = (off / u if u > 0 else 0.0 if off == 0 else math.inf) if known else math.inf
    sensitivity = _relative(seen_beyond(quantile, freedom, SEEN if once else SEEN**0.5) * u + doubt, expected)
    outcome: Outcome = "pass" if known and off <= tolerance else "fail"
    if outcome == "pass" and (few or (needed is not None and sensitivity > needed)):
        outcome = "inconclusive"
    if known and few and u == 0:  # equal samples, too few to have shown that they scatter
        outcome = "inconclusive"
    deviation = off / tolerance if known and tolerance > 0 else 0.0 if off == 0 else math.inf
    p_value = student_probability(max(off - doubt, 0.0) / u, freedom) if known and u > 0 else float(known and off == 0)
    if trends:
        level += drifting
        limits = [student_quantile(drifting / len(trends), trend.freedom) for trend in trends]
        share, trend, limit = max(
            (trend.sigmas / limit, trend, limit) for trend, limit in zip(trends, limits, strict=True)
        )
        if share > 1:
            outcome, deviation = "fail", max(deviation, share)
            note = "; ".join(filter(None, (_drift(trend, limit), note)))
    beyond = f"{quantile:.2f} sigma" + (f" and the doubt {doubt:.3g}" if doubt else "")
    rate = level**2 if once is None else once
    reason = f"{why}; red beyond {beyond}{', twice' if once is None else ''}: false-alarm rate {rate:.2g}"
    return Judgement(
        outcome,
        quantity,
        measured,
        uncertainty,
        expected,
        expected_uncertainty,
        deviation,
        sensitivity,
        Criterion("statistical", "both", tolerance, reason),
        sigmas=sigmas,
        freedom=freedom,
        doubt=doubt,
        p_value=p_value,
        false_alarm=rate,
        note=note,
        figures=figures,
    )


def _freedom(errors: tuple[float, float], means: Sequence[Mean]) -> float:
    """Degrees of freedom of the sum of the squares of two errors, of which those of `means` are the first.

    An error without a mean is known. 0 where the errors are not those of the means, but derived from them.
    """
    total = math.hypot(*errors)
    if len(means) > 2 or not 0 < total < math.inf or any(m.error != e for m, e in zip(means, errors, strict=False)):
        return 0.0
    parts = sum((mean.error / total) ** 4 / mean.freedom for mean in means)
    return min(1 / parts, _MOST_FREEDOM) if parts > 0 else 0.0


def by_chance(
    quantity: str,
    statistic: float,
    law: Any,
    why: str,
    *,
    once: float | None = None,
    note: str = "",
    figures: tuple[Figure, ...] = (),
) -> Judgement:
    """The judgement that a test statistic (Kolmogorov-Smirnov, chi^2) is no larger than chance explains; NaN fails.

    quantity: name of the statistic, and what it compares. statistic: it. law: its distribution if the code is right,
    with the methods `isf` and `sf` of those of scipy.stats. why: what the distribution follows from. The limit is
    exceeded with the probability `SUSPICIOUS`; see `again`. once: that probability, of data that cannot be measured
    again. note, figures: see `Judgement`.
    """
    from scipy.stats import norm

    limit, p_value = float(law.isf(once or SUSPICIOUS)), float(law.sf(statistic))
    rate = once or FALSE_ALARM
    good = statistic <= limit
    return Judgement(
        "pass" if good else "fail",
        quantity,
        statistic,
        None,
        limit,
        None,
        _not_nan(statistic / limit),
        _relative(abs(limit - statistic), limit),
        Criterion(
            "statistical",
            "at_most",
            limit,
            f"{why}; red beyond it{'' if once else ', twice'}: false-alarm rate {rate:.2g}",
        ),
        sigmas=_not_nan(float(norm.isf(max(p_value, 1e-300) / 2))),
        p_value=p_value,
        false_alarm=rate,
        note=note,
        figures=figures,
    )


def again(first: Findings, second: Findings) -> Findings:
    """The findings of a case in which statistical judgements alone were red, and which was run again.

    A statistical judgement is red if both runs are: of a right code with the square of the probability of one. Where
    the first was red, the second decides; where it was not, the first stays. The others must hold in both runs.
    Numbers that come out the same to the last digit were not measured again: beyond the rate `FALSE_ALARM` they are
    red, else inconclusive. first, second: of the two runs, with other random numbers. ValueError unless they judge the
    same quantities.
    """
    if len(first.judgements) != len(second.judgements):
        raise ValueError(f"{len(first.judgements)} judgements, and {len(second.judgements)} in the run that repeats it")
    judged = tuple(_of_two(one, two) for one, two in zip(first.judgements, second.judgements, strict=True))
    return replace(second, judgements=judged)


def unrepeated(found: Findings) -> Findings:
    """Findings that are suspicious, and that nobody has measured again: what is red is undecided. found: of one run."""
    note = "suspicious, and not run again: the time was over"
    judged = tuple(
        replace(one, outcome="inconclusive", note="; ".join(filter(None, (one.note, note))))
        if one.outcome == "fail"
        else one
        for one in found.judgements
    )
    return replace(found, judgements=judged)


def less_certain(found: Findings, needed: Mapping[str, float] | float) -> Findings:
    """Findings in which what is green is undecided where a smaller deviation than the sensitivity must be seen.

    found: of a case. needed: the relative deviation that must be seen, of all quantities; or by their names, or
    patterns of these (`fnmatch`). Bounds and test statistics have no sensitivity in this sense, and stay. UsageError
    for a name that no other quantity has: it would be needed, and not be judged.
    """
    able = [one for one in found.judgements if _sees_deviations(one)]
    patterns = needed if isinstance(needed, Mapping) else {"*": needed} if able else {}
    for pattern in patterns:
        if not any(_is_called(one, pattern) for one in able):
            names = "; ".join(dict.fromkeys(one.quantity for one in able)) or "none"
            raise UsageError(f"needed: no quantity with a sensitivity is called '{pattern}'; there are: {names}")

    def judged(one: Judgement) -> Judgement:
        limits = [limit for pattern, limit in patterns.items() if one in able and _is_called(one, pattern)]
        sensitivity = math.inf if one.sensitivity is None else one.sensitivity
        if one.outcome != "pass" or not limits or sensitivity <= min(limits):
            return one
        note = f"a deviation of {min(limits):g} must be seen, and {sensitivity:.2g} would be"
        return replace(one, outcome="inconclusive", note="; ".join(filter(None, (one.note, note))))

    return replace(found, judgements=tuple(judged(one) for one in found.judgements))


def _sees_deviations(one: Judgement) -> bool:
    """Whether the sensitivity of a judgement is a deviation from what is expected."""
    return one.criterion.kind in ("round_off", "order") or (
        one.criterion.kind == "statistical" and one.criterion.sense == "both"
    )


def _is_called(one: Judgement, pattern: str) -> bool:
    return one.quantity == pattern or fnmatchcase(one.quantity, pattern)


def suspicious(found: Findings) -> bool:
    """Whether statistical judgements of finite numbers alone are red, which another run may refute; found: of one."""
    red = [one for one in found.judgements if one.outcome == "fail"]
    return bool(red) and all(one.criterion.kind == "statistical" and _is_number(one.sigmas) for one in red)


def _is_number(value: float | None) -> bool:
    return value is not None and math.isfinite(value)


def _of_two(first: Judgement, second: Judgement) -> Judgement:
    """The judgement of two runs: see `again`."""
    if first.criterion.kind != "statistical":
        return max(first, second, key=_rank)
    if first.outcome != "fail":
        return first
    before = f"run again: at first {first.measured:.6g}, {first.sigmas:.3g} sigma"
    outcome = second.outcome
    if first.measured == second.measured:
        before = "run again, to the same number: not random"
        certain = first.p_value is not None and first.p_value <= FALSE_ALARM
        outcome = "fail" if certain else "inconclusive"
    return replace(second, outcome=outcome, note="; ".join(filter(None, (second.note, before))))


def _drift(trend: Trend, limit: float) -> str:
    """The remark on a series that is not stationary; limit: of the trend, in standard errors."""
    return (
        f"drifts: by {trend.change:.4g} from the first to the last value of the series, {trend.sigmas:.3g} standard "
        f"errors, red beyond {limit:.3g}; a mean of it has no meaning"
    )
