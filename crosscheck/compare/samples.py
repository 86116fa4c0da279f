"""Whether two trajectories are samples of the same statistics: two-sample tests on frames, whose correlation counts.

Of each frame some numbers are computed (moments of the velocities of each type along each axis, counts of pairs by
distance) and of each pair of frames others (displacements and velocity correlations over a lag). Their means are
compared with the standard errors of correlated series, by Welch's test; the level is that of the whole family, by
Holm's method.

Literature: B. L. Welch, Biometrika 34, 28 (1947); S. Holm, Scand. J. Stat. 6, 65 (1979).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from crosscheck.compare.differences import converted, frames_of, informed, nearest_image, spacing
from crosscheck.compare.pairing import Pairing
from crosscheck.compare.pairs import largest_reach, pairs_within
from crosscheck.statistics import Mean, correlated_mean, seen_beyond, student_probability, student_quantile
from crosscheck.trajectories.frames import Floats, Frame, Source

#: Probability that two samples of the same statistics are called different, of all quantities together.
LEVEL = 1e-4
#: Fewest independent samples of a series whose mean is compared, and probability of seeing a stated deviation.
_INDEPENDENT, _SEEN = 8.0, 0.9
#: A series whose mean is known to this, relative, is that of a conserved quantity: its scatter is rounding.
_CONSTANT = 1e-12
#: Lags, in frames, of displacements and velocity correlations.
_LAGS = (1, 4, 16)
#: Shells of distances of pairs, up to `_REACH` times the distance of neighbours, and most pairs of a frame that are
#: looked at: those of all particles, or of as many as that allows, but ten.
_SHELLS, _REACH, _PAIRS, _CHOSEN = 12, 3.0, 2e5, 10
#: Fewest frames, or rows, whose statistics are looked at.
FEWEST = 24
#: Share of the run at its start that is left out: what both runs have of their common start.
START = 0.2


class Tested(NamedTuple):
    """One quantity of both samples.

    name: of the quantity. first, second: its means. error: standard error of their difference. freedom: degrees of
    freedom of it. probability: of a difference as large as this one, or larger, if there is none. sensitivity: the
    smallest difference that is seen in 90 % of all pairs of runs, as a share of the first mean (absolute where that is
    0). independent: number of independent samples of the shorter series. outcome: "same", "different", or "unclear" if
    there are too few of them.
    """

    name: str
    first: float
    second: float
    error: float
    freedom: float
    probability: float
    sensitivity: float
    independent: float
    outcome: str


def compare_samples(one: Source, other: Source, pairing: Pairing, begin: float) -> list[Tested]:
    """Compares the statistics of two trajectories in the frames that both have.

    one, other: the trajectories. pairing: of their frames. begin: share of the frames at the start that is left out.
    """
    begins = int(np.ceil(begin * len(pairing.first)))
    first, second = frames_of(one, other, pairing, 0)
    edges = shell_edges(first)
    frames = (informed(one.read(int(k)), second.box) for k in pairing.first[begins:])
    mine = series_of(frames, one.wrapping == "wrapped", edges)
    others = (informed(converted(other.read(int(k)), pairing), first.box) for k in pairing.second[begins:])
    yours = series_of(others, other.wrapping == "wrapped", edges)
    return compare_series(mine, yours)


def compare_series(mine: dict[str, Floats], yours: dict[str, Floats]) -> list[Tested]:
    """Compares the means of quantities of two runs. mine, yours: name -> values in time, at equal distances."""
    tested = []
    for name in mine:
        if name in yours:
            found = _test(name, mine[name], yours[name])
            if found is not None:
                tested.append(found)
    judged = sorted((one for one in tested if one.outcome == "same"), key=lambda one: one.probability)
    differ = 0  # Holm: the least probable at LEVEL/m, the next at LEVEL/(m - 1) ..., until one is not
    while differ < len(judged) and judged[differ].probability <= LEVEL / (len(judged) - differ):
        differ += 1
    names = {one.name for one in judged[:differ]}
    level = LEVEL / max(len(judged), 1)
    return [
        one._replace(sensitivity=_seen(one, level), outcome="different" if one.name in names else one.outcome)
        for one in tested
    ]


def _seen(one: Tested, level: float) -> float:
    """The smallest difference that is seen at this level in 90 % of all pairs of runs, as `Tested.sensitivity`."""
    if one.outcome == "unclear":
        return float("nan")
    seen = seen_beyond(student_quantile(level, one.freedom), one.freedom, _SEEN) * one.error
    return seen / abs(one.first) if one.first else seen


def _test(name: str, mine: Floats, yours: Floats) -> Tested | None:
    means: list[Mean] = []
    for values in (mine, yours):
        finite = values[np.isfinite(values)]
        if finite.size < 4 or finite.size < values.size:
            return None
        means.append(correlated_mean(finite))
    first, second = means
    difference = abs(first.value - second.value)
    error = float(np.hypot(first.error, second.error))
    independent = min(first.independent, second.independent)
    if error == 0 or first.error <= _CONSTANT * abs(first.value):
        return None  # conserved: a matter of dynamics
    freedom = error**4 / (first.error**4 / first.freedom + second.error**4 / second.freedom)
    probability = student_probability(difference / error, freedom)
    outcome = "same" if independent >= _INDEPENDENT else "unclear"
    return Tested(name, first.value, second.value, error, freedom, probability, float("nan"), independent, outcome)


# -- quantities of a trajectory ------------------------------------------------------------------------------


def series_of(frames: Iterable[Frame], wrapped: bool, edges: Floats) -> dict[str, Floats]:
    """Quantities of a trajectory in time, by name: see the module.

    frames: of the trajectory. wrapped: positions return into a periodic box, so displacements from one frame to the
    next are those to the nearest image. edges: of the shells, see `shell_edges`.
    """
    found: dict[str, list[float]] = {}
    past: list[tuple[Floats, Floats | None]] = []
    unwrapped: Floats | None = None
    for frame in frames:
        for name, value in _of_one(frame, edges):
            found.setdefault(name, []).append(value)
        positions = frame.positions
        if past and len(positions) != len(past[-1][0]):
            past, unwrapped = [], None  # particles came or went: lags begin anew
        if wrapped and frame.box is not None and unwrapped is not None:
            positions = unwrapped + nearest_image(positions - unwrapped, frame.box)
        unwrapped = positions
        past.append((positions, frame.velocities))
        past = past[-max(_LAGS) - 1 :]
        for lag in _LAGS:
            if len(past) > lag:
                before, speeds = past[-1 - lag]
                moved = positions - before
                moved = moved - moved.mean(axis=0)
                found.setdefault(f"mean square displacement over {lag} frames", []).append(
                    float(np.mean(np.sum(moved**2, axis=1)))
                )
                if speeds is not None and frame.velocities is not None:
                    product = np.sum(speeds * frame.velocities, axis=1)
                    found.setdefault(f"velocity autocorrelation over {lag} frames", []).append(float(product.mean()))
    return {name: np.array(values) for name, values in found.items()}


def _of_one(frame: Frame, edges: Floats) -> Iterator[tuple[str, float]]:
    velocities = frame.velocities
    if velocities is not None and len(velocities):
        types: Any = np.zeros(len(velocities)) if frame.types is None else frame.types
        kinds = np.unique(types)
        for number, kind in enumerate(kinds):
            squares = velocities[types == kind] ** 2
            suffix = "" if len(kinds) == 1 else f" of type {number + 1}"
            yield f"mean v^2{suffix}", float(np.sum(squares, axis=1).mean())
            active = [axis for axis in range(3) if squares[:, axis].any()]
            for axis in active:
                yield f"mean v_{'xyz'[axis]}^2{suffix}", float(squares[:, axis].mean())
            yield f"mean v^4{suffix}", float((np.sum(squares, axis=1) ** 2).mean())
    yield from _shells(frame, edges)


def shell_edges(frame: Frame) -> Floats:
    """Distances that bound the shells in which neighbours are counted, length; the same for all frames of both runs.

    frame: the first of the first run. Up to three distances of neighbours, and less than half of a periodic box.
    """
    largest = min(_REACH * spacing(frame), largest_reach(frame))
    return np.linspace(0.0, largest, _SHELLS + 1)


def _shells(frame: Frame, edges: Floats) -> Iterator[tuple[str, float]]:
    """Number of neighbours of a particle in shells of distance."""
    number, largest = len(frame.ids), float(edges[-1])
    if number < 2 or largest == 0:
        return
    chosen = np.arange(0, number, max(1, min(math.ceil(number**2 / _PAIRS), number // _CHOSEN)))
    counts, _ = np.histogram(pairs_within(frame, largest, chosen).distances, edges)
    for count, low, high in zip(counts, edges[:-1], edges[1:], strict=True):
        yield f"neighbours at distances {low:.3g} to {high:.3g}", float(count) / len(chosen)


def different(tested: Sequence[Tested]) -> list[Tested]:
    """Those that are different, the least probable first. tested: of `compare_samples`."""
    return sorted((one for one in tested if one.outcome == "different"), key=lambda one: one.probability)
