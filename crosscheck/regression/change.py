"""Whether a number differs from that of another run by more than two right runs do. Derived in docs/regression.md."""

from __future__ import annotations

import math

from crosscheck.regression.results import Number
from crosscheck.statistics import student_quantile
from crosscheck.verdict import FALSE_ALARM_OF_A_RUN, LEAST_FREEDOM

#: Probability that two right runs, with other random numbers, seem to differ in a statistical number, of all together.
FALSE_ALARM = FALSE_ALARM_OF_A_RUN
#: The share of its tolerance by which a number that is not statistical may move. Right codes move by less than 0.24 of
#: it in 38820 pairs of judgements with other seeds; the shares fall off as exp(-26 share), to 1e-4 a comparison here.
MOVED = 0.5
#: A bound that is red in both runs counts as another failure above this multiple of its share of the limit: the same
#: half, of itself, since nothing says how far it scatters.
WORSE = 1 + MOVED
#: What is expected is the same in both runs if it differs by no more than this share of its standard error, to which a
#: baseline keeps it.
_SAME = 0.05
#: Relative rounding of numbers that do not scatter.
_ROUNDING = 1e-9


def statistical(old: Number, new: Number) -> bool:
    """Whether the numbers of an old and a new run have standard errors by which they can be compared."""
    return all(one.kind == "statistical" and one.sense == "both" for one in (old, new)) and all(
        None not in (one.off, one.uncertainty) for one in (old, new)
    )


def change(old: Number, new: Number, level: float, same_seed: bool) -> float | None:
    """How far a number has moved, as a share of what two right runs may differ by: it has changed above 1.

    Statistical: |x - y| over t (u_x^2 + u_y^2)^1/2, with x, y the deviations from what is expected, u_x, u_y their
    standard errors and t the two-sided quantile of Student's distribution for `level`, with the degrees of freedom of
    the sum (B. L. Welch, Biometrika 34, 28 (1947)). By a tolerance: |x - y| over `MOVED` of it; of two red numbers of
    runs with other seeds, which are of other scenes, over the first deviation itself if that is larger. Of a bound: no
    change where one of the two is not red, for a bound says nothing of how far right numbers are apart; of two red
    ones, the share of the limit over `WORSE` times the first.

    old, new: of the first run and the second. level: probability of a false alarm for this number alone. same_seed:
    whether the runs had the same seed. None: it cannot be told, as where the criterion is another one.
    """
    if (old.kind, old.sense) != (new.kind, new.sense):
        return None
    red = old.outcome == new.outcome == "fail"
    if old.measured is None or new.measured is None:
        return math.inf if (old.measured is None) != (new.measured is None) else None
    if new.sense != "both":
        return _of_bounds(old, new) if red else None
    if old.off is None or new.off is None:
        return None
    moved = abs(new.off - old.off)
    if statistical(old, new):
        return _of_errors(old, new, moved, level)
    if old.tolerance is None or new.tolerance is None:
        return None
    allowed = MOVED * max(old.tolerance, new.tolerance)
    return moved / (max(allowed, abs(old.off)) if red and not same_seed else allowed)


def _of_bounds(old: Number, new: Number) -> float | None:
    """The change of a bound that is red in both runs: its share of the limit, or what was measured if that is 0."""
    if math.isfinite(old.share):
        return new.share / (WORSE * old.share)
    assert old.measured is not None
    assert new.measured is not None
    if new.sense == "at_most" and old.measured > 0:
        return new.measured / (WORSE * old.measured)
    return None


def _of_errors(old: Number, new: Number, moved: float, level: float) -> float:
    """The change of a number with a standard error."""
    errors = [one.expected_uncertainty or 0.0 for one in (old, new)]
    assert old.expected is not None
    assert new.expected is not None
    # an error of what is expected, which is the same in both runs, has moved both numbers alike
    shared = abs(new.expected - old.expected) <= _SAME * max(errors)
    parts = [_error(one, shared) for one in (old, new)]
    total = math.hypot(*(error for error, _ in parts))
    if not total:
        assert new.measured is not None
        return 0.0 if moved <= _ROUNDING * abs(new.measured) else math.inf
    freedom = 1 / sum((error / total) ** 4 / known for error, known in parts)
    return moved / (student_quantile(level, freedom) * total)


def _error(number: Number, shared: bool) -> tuple[float, float]:
    """The standard error of a deviation, and its degrees of freedom, or fewer.

    shared: that of what is expected does not count. The degrees of freedom in a record are those of both errors; of the
    measured value's own, u of the total s, they are at least (u/s)^4 of them, by Welch's sum; and at least
    `LEAST_FREEDOM` where the judgement was green, which it is not with fewer.
    """
    u, e = number.uncertainty or 0.0, number.expected_uncertainty or 0.0
    total = math.hypot(u, e)
    freedom = LEAST_FREEDOM if number.freedom is None else number.freedom
    if shared and total:
        least = LEAST_FREEDOM if number.outcome == "pass" else 1.0
        return u, max(freedom * (u / total) ** 4, least)
    return total, max(freedom, 1.0)
