"""Orders of convergence, with their asymptotic window, and extrapolation to a vanishing step.

Literature: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927); E. Hairer, S. P. Norsett and G. Wanner, Solving
Ordinary Differential Equations I, 2nd ed., Springer (1993), section II.9; P. J. Roache, J. Fluids Eng. 116, 405 (1994),
on observed orders and their asymptotic range.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.statistics import student_quantile

Floats = NDArray[np.float64]

#: Orders are whole numbers: a quarter keeps the neighbouring orders three tolerances away.
ORDER_TOLERANCE = 0.25
WHY_ORDER = "orders are whole numbers; a quarter keeps the neighbouring ones three tolerances away"
#: Level of the interval of an observed order; half its width beyond which two whole numbers are within it.
LEVEL = 0.95
WIDEST = 0.5
#: Runs in a window: an order, a scatter and a bend have to be told apart.
FEWEST = 4
#: An error that is not so many times its floor, or its own standard error, is left out.
CLEAR = 3.0
#: Of the error h^p (1 + D h), on four runs of halved steps: how far the slope is from p, over its difference from that
#: of the finer half: 23/8. Less for longer windows and higher second terms.
_BEND = 3.0
WINDOW = (
    f"the window starts at the smallest step whose error is {CLEAR:g} times its floor, and reaches as far up as makes "
    f"the {LEVEL:.0%} interval narrowest"
)


class Slope(NamedTuple):
    """A fitted slope d ln y/d ln x. value: the slope. error: see `fitted_order`. used: number of points used."""

    value: float
    error: float
    used: int


def fitted_order(steps: ArrayLike, errors: ArrayLike, floor: float) -> Slope:
    """Order of convergence of a short ladder: slope of ln(error) against ln(step) at its three smallest steps.

    For ladders of three or four runs, whose steps are chosen well inside the asymptotic range; `observed_order` finds
    the range itself, and tells scatter from bend, which takes four runs in it and is worth more. The three smallest
    steps whose errors are above the rounding errors are taken: there, terms of higher order are smallest. The error of
    the slope is the largest difference of the slope between neighbouring points from it. steps,
    errors: (n,). floor: errors at or below it are rounding errors, and left out. Where fewer than 3 points remain: NaN
    if an error is not finite, since a run has diverged, else ValueError.
    """
    x, y = np.asarray(steps, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    good = np.isfinite(y) & (y > floor)
    diverged = not np.isfinite(y).all()
    x, y = x[good], y[good]
    if x.size < 3 and diverged:
        return Slope(np.nan, np.inf, x.size)
    if x.size < 3:
        raise ValueError(f"an order needs 3 points above the rounding floor {floor:g}, found {x.size}")
    window = np.argsort(x)[:3]
    lx, ly = np.log(x[window]), np.log(y[window])
    slope = float(np.polyfit(lx, ly, 1)[0])
    local = np.diff(ly) / np.diff(lx)
    return Slope(slope, float(np.abs(local - slope).max()), 3)


class Observed(NamedTuple):
    """An order of convergence with its asymptotic window.

    value: d ln(error)/d ln(step). half: half the width of its `LEVEL` interval. used: indices of the runs in the
    window, smallest step first; empty if there is none, value and half are then NaN. reason: why there is none, or "".
    finer, coarser: the slope in the two halves of the window.
    """

    value: float
    half: float
    used: tuple[int, ...]
    reason: str = ""
    finer: float = np.nan
    coarser: float = np.nan

    @property
    def interval(self) -> tuple[float, float]:
        """The ends of the interval."""
        return self.value - self.half, self.value + self.half

    def leaves(self, order: float) -> bool:
        """Whether the slope goes away from an order towards small steps, and is further than `WIDEST` from it there.

        Terms of higher order go the other way: an error that does so has a part that does not vanish with the step.
        order: the expected one.
        """
        return abs(self.finer - order) > max(WIDEST, abs(self.coarser - order))


def observed_order(
    steps: ArrayLike,
    errors: ArrayLike,
    floors: ArrayLike = 0.0,
    uncertainties: ArrayLike = 0.0,
    ceiling: float = np.inf,
) -> Observed:
    """The order of convergence on a ladder of steps, from a window that is chosen by what the errors show.

    For small steps h, error = C h^p (1 + D h^q + ...), q >= 1, beside a floor of rounding. The line ln(error) = ln C +
    p ln h is fitted by least squares to a window of `FEWEST` or more neighbouring runs. It starts at the smallest step
    whose error is at least `CLEAR` times its floor and its standard error, for there D h^q is smallest. A longer window
    lessens what scatter does to the slope, and adds to the bend. Both are in the half-width of the interval: (t s)^2 +
    (z u)^2 squared and summed, with Student's t of the scatter s about the line, z of the known errors u; and, added,
    the largest difference of the slope in the finer and in the coarser half of the window from that in the whole. The
    window with the narrowest interval is taken.

    steps: (n,), or any measure of them such as 1/evaluations; in any order. errors: (n,), not negative; infinite or NaN
    where a run has failed. floors: scalar or (n,), what rounding, or the reference, may make of an error.
    uncertainties: scalar or (n,), standard errors of the errors. ceiling: errors from here on say nothing: what is
    computed is no larger. ValueError for steps that are not positive or occur twice.
    """
    h, e = np.asarray(steps, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    floor, u = (np.broadcast_to(np.asarray(one, dtype=np.float64), e.shape) for one in (floors, uncertainties))
    if not (h > 0).all() or np.unique(h).size < h.size:
        raise ValueError("an order needs steps that are positive, and differ from each other")
    clear = np.isfinite(e) & (e > 0) & (e < ceiling) & (e >= CLEAR * floor) & (e >= CLEAR * u)
    rising = np.argsort(h)
    first = next((k for k in range(h.size) if clear[rising[k]]), h.size)
    last = next((k for k in range(first, h.size) if not clear[rising[k]]), h.size)
    if last - first < FEWEST:
        reason = f"{last - first} neighbouring runs have an error between {CLEAR:g} times its floor and "
        reason += f"the size of what is computed; {FEWEST} are needed"
        return Observed(np.nan, np.nan, (), reason)
    candidates = [rising[first:end] for end in range(first + FEWEST, last + 1)]
    unknown = np.hypot(u, floor / 3**0.5)  # a floor may add anything up to itself
    found = [_slope(np.log(h[one]), np.log(e[one]), unknown[one] / e[one], one.tolist()) for one in candidates]
    return min(found, key=lambda one: one.half)


def _slope(x: Floats, y: Floats, u: Floats, window: list[int]) -> Observed:
    """The order from the points of a window, smallest step first; u: standard errors of y. (n,) each."""
    value, weights = _line(x, y)
    left = (y - y.mean()) - value * (x - x.mean())
    scatter = float(np.sqrt((left**2).sum() / (x.size - 2) * (weights**2).sum()))
    known = float(np.sqrt((weights**2 * u**2).sum()))
    middle = x.size // 2
    finer, coarser = (
        _line(x[part], y[part])[0] for part in (slice(None, middle + 1), slice(x.size - middle - 1, None))
    )
    bend = _BEND * max(abs(finer - value), abs(coarser - value))
    normal = student_quantile(1 - LEVEL, 1e6)
    half = float(np.hypot(student_quantile(1 - LEVEL, x.size - 2) * scatter, normal * known) + bend)
    return Observed(value, half, tuple(window), finer=finer, coarser=coarser)


def _line(x: Floats, y: Floats) -> tuple[float, Floats]:
    """The slope of the least-squares line through points, and its weights: slope = weights . y."""
    centred = x - x.mean()
    weights = centred / (centred**2).sum()
    return float(weights @ y), weights


class Limit(NamedTuple):
    """An extrapolation to step 0. value: (...). error: its estimated error, the largest of all components. weights:
    (runs,), of the runs in the value; their rounding errors are multiplied by these.
    """

    value: Floats
    error: float
    weights: Floats


def extrapolate(steps: ArrayLike, values: ArrayLike) -> Limit:
    """Results of a symmetric scheme, extrapolated to step 0.

    The error of a symmetric scheme has even powers of the step only, so the values lie on a polynomial in dt^2 (Hairer,
    Norsett and Wanner). steps: (runs,), coarsest first. values: (runs, ...). The estimated error is the largest change
    of the value when the coarsest run is left out. ValueError for fewer than 3 runs.
    """
    x, y = np.asarray(steps, dtype=np.float64) ** 2, np.asarray(values, dtype=np.float64)
    if x.size < 3:
        raise ValueError(f"an extrapolation with an error needs at least 3 runs, got {x.size}")
    weights, fewer = _at_zero(x), _at_zero(x[1:])
    value = np.tensordot(weights, y, 1)
    return Limit(value, float(abs(value - np.tensordot(fewer, y[1:], 1)).max()), weights)


def _at_zero(x: Floats) -> Floats:
    """Weights of Lagrange's polynomial through the points x, at 0."""
    apart = x[None, :] - x[:, None]
    np.fill_diagonal(apart, 1.0)
    factors = x[None, :] / apart
    np.fill_diagonal(factors, 1.0)
    return np.asarray(factors.prod(1))
