"""How a separation of two runs grows, and whether rounding alone explains it.

Two runs of one chaotic system that differ by rounding part as s(t) = s0 exp(lambda t), until they are as far apart as
unrelated runs. lambda, its scatter and s0 follow from the separation itself: what is looked at is where s is above the
rounding of the files and below a share of the distance of neighbours. Rounding explains s if s0 is no larger than what
the arithmetic of both runs can make of it, and if s has made no step that is too large for lambda.

In regular motion s grows as a power of time. Rounding then explains up to eps X n^3/2 after n steps: errors of the
energy walk at random, and the phase sums them up.

Literature: G. Benettin, L. Galgani and J.-M. Strelcyn, Phys. Rev. A 14, 2338 (1976) (growth of separations); D.
Brouwer, Astron. J. 46, 149 (1937) (rounding errors of regular motion grow as n^3/2).
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.statistics import student_quantile
from crosscheck.trajectories.frames import Floats, Integers

#: What the growth of a separation says of the two runs.
Kind = Literal["rounding", "chaos", "early", "jump", "velocities", "momentum", "unclear"]
#: Distance from one number to the next, relative, of the arithmetic of a run.
EPSILON = {"double": 2.0**-52, "single": 2.0**-23}
#: Where s is looked at: above this many times the rounding of the files, ...
_ABOVE = 2.0
#: ... and below this share of the distance of neighbours, where growth is still that of small separations.
_BELOW = 0.1
#: Fewest steps from frame to frame, and smallest growth, from which a rate is told.
_FEWEST, _LEAST_GROWTH = 4, math.log(10.0)
#: Steps in which a separation grows e-fold, where the file does not tell the time step: one that resolves the motion.
_STEPS = 1000.0
#: Probability that runs that differ by rounding alone are taken for different ones, of each of the two tests; and that
#: they are left open by the second one.
LEVEL, _OPEN = 1e-5, 1e-2
#: Pairs that a particle has within reach of forces: of those, two runs may find one to be inside a cutoff in another
#: step, or to hit each other in one run alone.
_PAIRS = 100.0
#: A growth is measured if a start of half the digits of the arithmetic, in distances of neighbours, is told from it by
#: this many standard errors.
_CERTAIN = 3.0


class Rate(NamedTuple):
    """A rate of growth. value: of ln s, 1/time. scatter: of ln s about it, per square root of time. freedom: degrees of
    freedom of the scatter."""

    value: float
    scatter: float
    freedom: float


class Law(NamedTuple):
    """Exponential growth of a separation, s0 exp(rate t).

    rate, error: of growth and its standard error, 1/time; the error is None where the rate was measured by other runs.
    start, factor: s0, and the factor of its uncertainty (one standard error). limit: the largest s0 that rounding
    explains, length. frames: first and last from which the rate follows, None: other runs. horizon: time at which
    rounding alone would have grown to the distance of neighbours.
    """

    rate: float
    error: float | None
    start: float
    factor: float
    limit: float
    frames: tuple[int, int] | None
    horizon: float


class Parting(NamedTuple):
    """Where two runs part. frame: its number. expected: the largest separation there that rounding and chaos explain,
    length."""

    frame: int
    expected: float


class Growth(NamedTuple):
    """What the separation of two runs says.

    kind: "rounding": rounding explains it without chaos; "chaos": it grows from rounding at the system's own rate;
    "early": it would have begun from more than rounding; "jump": it grew by too much from one frame to the next;
    "velocities": rounding and chaos explain positions, but not how far velocities are apart; "momentum": one run does
    not keep its total momentum, the other does;
    "unclear": too few frames show its growth. law: of the growth, where it was measured. parting: where the dynamics
    part, if they do.
    """

    kind: Kind
    law: Law | None = None
    parting: Parting | None = None


class Separation(NamedTuple):
    """The separation of two runs.

    times: (K,). values: root mean square distance of a particle from itself, (K,), length. floor: what the files'
    rounding makes of it at most, (K,). velocities, velocity_floor: the same of velocities, length/time; None: they are
    not in both files. number: of particles. speed: their root mean square speed; None: not known. extent: largest
    |coordinate|, length. spacing: distance of neighbours, length. step: the time step; None: not known. origin: time at
    which both runs started. start_velocity: root mean square difference of the velocities at the start, beyond the
    files' rounding. arithmetic: "double" or "single".
    """

    times: Floats
    values: Floats
    floor: Floats
    velocities: Floats | None
    velocity_floor: Floats | None
    number: int
    speed: float | None
    extent: float
    spacing: float
    step: float | None
    origin: float
    start_velocity: float = 0.0
    arithmetic: str = "double"


def growth(separation: Separation, rate: Rate | None = None) -> Growth:
    """What the growth of a separation says; see the module.

    rate: lambda, where it was measured by other runs of the system (a disturbed twin); None: it follows from the
    separation itself.
    """
    found = _of_positions(separation, rate)
    if found.kind in ("rounding", "chaos"):
        apart = _velocities_apart(separation)
        if apart is not None:
            return found._replace(kind="velocities", parting=apart)
    return found


def _of_positions(separation: Separation, rate: Rate | None) -> Growth:
    s, floor = separation.values, separation.floor
    if _explained_without_chaos(separation):
        return Growth("rounding")
    window = _window(s, floor, separation.spacing)
    used = rate or _rate(separation.times, s, window)
    if used is None:
        return _without_rate(separation, window)
    dt = separation.step
    folds = 1 / (used.value * dt) if dt else _STEPS
    limit = EPSILON[separation.arithmetic] * separation.extent * max(folds, 1.0)
    limit += max(float(s[0] - floor[0]), 0.0) * (separation.times[0] == separation.origin)
    limit = max(limit + separation.start_velocity / used.value, float(np.finfo(np.float64).tiny))
    begin = _begin(separation, window)
    elapsed = float(separation.times[begin] - separation.origin)
    excess = math.log(s[begin] / limit) - used.value * elapsed
    telling = window if rate is None else window[:0]  # frames whose steps tell the rate
    error: float | None = None
    span: tuple[int, int] | None = None
    if rate is None:
        error = used.scatter / math.sqrt(separation.times[window[-1]] - separation.times[window[0]])
        span = (int(window[0]), int(window[-1]))
    spread = math.hypot(used.scatter * math.sqrt(elapsed), (error or 0.0) * elapsed)
    horizon = separation.origin + max(math.log(separation.spacing * _BELOW / limit) / used.value, 0.0)
    law = Law(used.value, error, limit * math.exp(excess), math.exp(min(spread, 700.0)), limit, span, horizon)
    jump = _jump(separation, used, telling, LEVEL)
    if jump is not None:
        return Growth("early" if jump.frame == 1 else "jump", law, jump)
    if excess > student_quantile(2 * LEVEL, used.freedom) * spread:
        return Growth("early", law, Parting(begin, limit * math.exp(min(used.value * elapsed, 700.0))))
    half = EPSILON[separation.arithmetic] ** 0.5 * separation.spacing
    told = math.log(half / limit) - excess > _CERTAIN * spread
    if excess > 0 or not told or _jump(separation, used, telling, _OPEN):
        return Growth("unclear", law)
    return Growth("chaos", law)


def _velocities_apart(separation: Separation) -> Parting | None:
    """The first frame at which velocities are further apart than the distance of positions explains.

    What oscillates with the frequency w has velocities w times as far apart as positions, and explicit schemes are
    stable for w dt < 2 alone. Without a time step nothing is said: velocities jump in collisions.
    """
    if separation.velocities is None or separation.velocity_floor is None:
        return None
    dt = separation.step
    if dt is None:
        return None
    positions = separation.values + separation.floor + EPSILON[separation.arithmetic] * separation.extent
    most = separation.velocity_floor + separation.start_velocity + 2 / dt * positions
    wrong = np.flatnonzero(separation.velocities > most)
    return Parting(int(wrong[0]), float(most[wrong[0]])) if wrong.size else None


def measured_rate(times: Floats, values: Floats, floor: float, spacing: float) -> Rate | None:
    """The rate of growth of a separation of two runs of one system; None if it shows none.

    times: (K,). values: the separation, (K,), length. floor: above twice this, length, it counts. spacing: distance of
    neighbours, length.
    """
    return _rate(times, values, _window(values, np.full(len(values), floor), spacing))


def chaos_line(separation: Separation, found: Growth) -> Floats | None:
    """The largest separation, (K,), that rounding and chaos explain; None if no rate was measured.

    separation: of two runs. found: what its growth says.
    """
    if found.law is None:
        return None
    exponent = np.minimum(found.law.rate * (separation.times - separation.origin), 700.0)
    return np.asarray(found.law.limit * np.exp(exponent) + separation.floor)


def _explained_without_chaos(separation: Separation) -> bool:
    """Whether rounding explains every frame: that of the files, and what it grows to in regular motion."""
    return bool((separation.values <= separation.floor + _regular(separation)).all())


def _regular(separation: Separation) -> Floats:
    """eps X n^3/2 after n steps, (K,)."""
    times = separation.times - separation.origin
    if not separation.step:
        return np.zeros_like(times)
    return np.asarray(EPSILON[separation.arithmetic] * separation.extent * (times / separation.step) ** 1.5)


def _window(s: Floats, floor: Floats, spacing: float) -> Integers:
    """Numbers of the frames between the rounding of the files and the distance of neighbours, before it is reached."""
    large = np.flatnonzero(s > _BELOW * spacing)
    end = int(large[0]) if large.size else len(s)
    return np.flatnonzero((s[:end] > _ABOVE * floor[:end]) & (s[:end] > 0))


def _begin(separation: Separation, window: Integers) -> int:
    """The first frame that shows a separation: of the window, or the one that is beyond it at once."""
    if len(window):
        return int(window[0])
    shown = np.flatnonzero(separation.values > _ABOVE * separation.floor)
    return int(shown[0]) if len(shown) else int(np.argmax(separation.values))


def _rate(times: Floats, values: Floats, window: Integers) -> Rate | None:
    """lambda, from the mean of the increments of ln s in the frames of the window, whose scatter is that of a walk.

    None if too few frames show it, or it does not grow.
    """
    if len(window) <= _FEWEST:
        return None
    logs, shown = np.log(values[window]), times[window]
    total, duration = float(logs[-1] - logs[0]), float(shown[-1] - shown[0])
    if duration <= 0 or total < _LEAST_GROWTH:
        return None
    return _walk(np.diff(logs), np.diff(shown))


def _walk(steps: Floats, spans: Floats) -> Rate:
    """The drift of a walk with these steps in these spans of time, its scatter and the degrees of freedom of that."""
    value = float(np.sum(steps) / np.sum(spans))
    freedom = len(steps) - 1.0
    scatter = float(np.sqrt(np.sum((steps - value * spans) ** 2 / spans) / freedom))
    return Rate(value, scatter, freedom)


def _jump(separation: Separation, rate: Rate, window: Integers, level: float) -> Parting | None:
    """The first frame at which s is larger than the one before, chaos and rounding explain; and what they explain.

    Growth from frame to frame has a tail that falls exponentially: two particles that hardly hit each other part by far
    more than most. Its scale is the scatter of the other steps within the window, raised where they are few, up to that
    of growth which is itself exponentially distributed. rate: of all steps. window: frames whose steps tell the rate;
    empty: other runs told it. level: probability that one of the frames is taken for a jump, and is none.
    """
    s, floor, times = separation.values, separation.floor, separation.times
    rounding = EPSILON[separation.arithmetic] * separation.extent
    inner = [int(k) for k in window[1:] if k - 1 in window]
    steps = np.array([math.log(s[k] / s[k - 1]) for k in inner])
    spans = np.array([times[k] - times[k - 1] for k in inner])
    tail = math.log(len(s) / level)
    for k in range(1, len(s)):
        if s[k] <= _ABOVE * floor[k]:
            continue
        span = float(times[k] - times[k - 1])
        others = np.array(inner) != k
        used = _walk(steps[others], spans[others]) if others.sum() >= _FEWEST - 1 else rate
        raised = used.scatter
        if level == LEVEL:
            raised *= math.sqrt(used.freedom / _low_quantile(used.freedom))
        scatter = min(raised, max(used.scatter, math.sqrt(used.value)))
        rounded = rounding * max(span / separation.step if separation.step else _STEPS, 1.0)
        before = s[k - 1] + floor[k - 1] + rounded + separation.start_velocity * span
        largest = before * math.exp(min(used.value * span + tail * scatter * math.sqrt(span), 700.0))
        largest += _discontinuity(separation, before, span, level) * math.exp(min(used.value * span, 700.0))
        if s[k] > largest + _ABOVE * floor[k]:
            return Parting(k, float(largest))
    return None


def _discontinuity(separation: Separation, before: float, span: float, level: float) -> float:
    """By how much forces that jump, as at a cutoff, may part two runs in a span of time, root mean square, length.

    One run finds a pair inside the cutoff a step earlier than the other if it is within `before` of it. Where that is
    to be expected, two particles are apart by no more than what the mean acceleration moves them in a step. Without
    time steps it may be a collision that happens in one run alone: then two particles are apart by anything up to the
    distance of neighbours, and nothing larger than that is ever called a jump; it is left open. before: separation.
    span: time. level: as in `_jump`.
    """
    step = separation.step
    expected = separation.number * _PAIRS * max(span / step if step else 1.0, 1.0) * before / separation.spacing
    if expected < LEVEL:
        return 0.0
    pair = math.sqrt(2 / separation.number)
    if step is None or separation.speed is None:
        return math.inf if level == LEVEL else separation.spacing * pair
    return 2 * separation.speed / span * step**2 * pair


def _low_quantile(freedom: float) -> float:
    """What chi^2 with these degrees of freedom exceeds with the probability 0.999."""
    from scipy.stats import chi2

    return float(chi2.ppf(1e-3, max(freedom, 1.0)))


def _without_rate(separation: Separation, window: Integers) -> Growth:
    """What can be said if no rate was measured: whether what is seen began from more than rounding at any rate."""
    s = separation.values
    if not separation.step or len(window) <= _FEWEST:
        return Growth("unclear")
    begin = int(window[0])
    drift = _walk(np.diff(np.log(s[window])), np.diff(separation.times[window]))
    elapsed = float(separation.times[begin] - separation.origin)
    error = drift.scatter / math.sqrt(separation.times[window[-1]] - separation.times[begin])
    most = max(drift.value, 0.0) + student_quantile(2 * LEVEL, drift.freedom) * error
    explained = float(_regular(separation)[begin] + separation.floor[begin])
    if math.log(s[begin]) - most * elapsed > math.log(explained):
        return Growth("early", None, Parting(begin, explained))
    return Growth("unclear")
