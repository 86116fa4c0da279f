"""Random outcomes of the sites of a lattice gas, compared with their probabilities: how often each, and in which order.

What is found is told as the size of a standard normal variable: 4 is what chance does once in 16 000 runs.

Serial correlation: the outcome of a site is given a number z, scaled to mean 0 and variance 1 under the stated
probabilities: its rank among the outcomes of the state; or how many places it is behind the arrived state in the circle
of states that turn into each other. Codes choose by either, so a random number that is used twice gives equal z of one
kind also where the states differ. Over the n pairs of sites at a distance (in time, rows and columns) the sum of z z'
has mean 0 and variance n, whatever the gas has done before, if the later one's random number is new. One transform
gives it for all distances at once, so a repeat shows wherever it is.

Literature: D. E. Knuth, The Art of Computer Programming 2, 3.3 (chi-square, serial correlation); Z. Sidak, J. Am. Stat.
Assoc. 62, 626 (1967) (the largest of many).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.references.lattice_audit import Motion

Floats = NDArray[np.float64]

#: Outcomes expected less often share a bin: beyond, the distribution of chi^2 is the continuous one far into its tail.
_LEAST_EXPECTED = 20.0
#: Pairs of sites, at least, of a distance that is judged. The sum of so many products of bounded numbers has no heavier
#: tail than a normal variable where outcomes are equally likely, and e times its probability at 6 where one is twice as
#: likely as the other.
_LEAST_PAIRS = 100
#: Of all smaller ones the normal variable is the same, and finite.
_LEAST_PROBABILITY = 1e-300


class Frequencies(NamedTuple):
    """total: chi^2 of all states together, as a normal variable. worst: that of the state that is furthest off, as the
    largest of many.

    draws: number of random outcomes. state: the worst one.
    """

    total: float
    worst: float
    draws: int
    state: int


def frequencies(counts: Floats, probabilities: Floats) -> Frequencies:
    """Outcomes of each state against their probabilities.

    counts: (states, states), how often s became t. probabilities: M_st, the same shape; counts where it is 0 are not
    looked at. ValueError if no state was seen often enough.
    """
    from scipy.special import chdtrc

    squares, freedoms, seen = [], [], []
    for s in range(len(counts)):
        possible = probabilities[s] > 0
        expected = probabilities[s][possible] * counts[s][possible].sum()
        square, freedom = _chi_square(counts[s][possible], expected)
        if freedom:
            squares.append(square)
            freedoms.append(freedom)
            seen.append(s)
    if not seen:
        raise ValueError("no state has two outcomes and was seen often enough")
    each = [float(chdtrc(freedom, square)) for square, freedom in zip(squares, freedoms, strict=True)]
    worst = int(np.argmin(each))
    return Frequencies(
        as_normal(float(chdtrc(sum(freedoms), sum(squares)))),
        as_normal(each[worst], len(each)),
        int(counts[seen].sum()),
        seen[worst],
    )


def _chi_square(counts: Floats, expected: Floats) -> tuple[float, int]:
    """chi^2 and its degrees of freedom; rare outcomes share a bin, and 0 degrees are left where there is one bin."""
    rare = expected < _LEAST_EXPECTED
    if rare.any():
        counts = np.append(counts[~rare], counts[rare].sum())
        expected = np.append(expected[~rare], expected[rare].sum())
        if expected[-1] < _LEAST_EXPECTED:
            counts, expected = counts[:-1], expected[:-1]
            if len(expected):  # the rare ones are left out, and the others share what is left
                expected = expected * (counts.sum() / expected.sum())
    if len(expected) < 2:
        return 0.0, 0
    return float(((counts - expected) ** 2 / expected).sum()), len(expected) - 1


def as_normal(probability: float, number: int = 1) -> float:
    """The size of a standard normal variable that is exceeded with the probability of the least one of `number`.

    probability: the least of so many independent ones, each uniform between 0 and 1 where chance alone is at work.
    """
    from scipy.special import ndtri

    any_less = -np.expm1(number * np.log1p(-probability)) if probability < 1 else 1.0
    return -float(ndtri(max(any_less / 2, _LEAST_PROBABILITY)))


class Serial(NamedTuple):
    """largest: the largest correlation of two draws at any distance, as a normal variable.

    distance: where, in steps, rows and columns. distances: how many were looked at.
    """

    largest: float
    distance: tuple[int, int, int]
    distances: int


def serial(one: Motion, probabilities: Floats, other: Motion | None = None) -> Serial:
    """Correlation of the random outcomes of two sites, at all distances in time and, periodic, in the plane.

    one: steps of a gas. probabilities: M_st of every site, uniform among the outcomes. other: steps of the same gas
    with another seed, with which `one` is compared in place of itself. ValueError if no distance has enough pairs.
    """
    drawn = (probabilities > 0) & ((probabilities > 0).sum(axis=1, keepdims=True) > 1)
    best = None
    for scores in _scores(probabilities):
        gases = [
            (scores[gas.arrived, gas.after], drawn[gas.arrived, gas.after].astype(np.float64))
            for gas in (one, other)
            if gas is not None
        ]
        found = largest_correlation(*(part for gas in gases for part in gas))
        best = found if best is None or found.largest > best.largest else best
    assert best is not None
    return best._replace(largest=as_normal(math.erfc(best.largest / math.sqrt(2)), 2), distances=2 * best.distances)


def largest_correlation(
    scores: Floats, drawn: Floats, other_scores: Floats | None = None, other_drawn: Floats | None = None
) -> Serial:
    """The largest correlation of independent variables z of mean 0 and variance 1, at any distance.

    scores: z, (steps, rows, columns), 0 where there is none; periodic along rows and columns. drawn: 1 where there is a
    z, else 0. other_scores, other_drawn: the same of others, with which they are compared in place of themselves.
    ValueError if no distance has enough pairs.
    """
    steps, rows, columns = scores.shape
    shape = (2 * steps, rows, columns)  # steps are not periodic: as many empty ones behind them
    correlations = []
    for one, other in ((scores, other_scores), (drawn, other_drawn)):
        first = np.fft.rfftn(one, shape, axes=(0, 1, 2))
        second = first if other is None else np.fft.rfftn(other, shape, axes=(0, 1, 2))
        correlations.append(np.fft.irfftn(first.conj() * second, shape, axes=(0, 1, 2)))
    sums, pairs = correlations[0], np.rint(correlations[1])
    if other_scores is None:  # each pair is there twice, as a distance and its opposite
        pairs[0, 0, 0] = 0
        pairs[steps:] = 0
    enough = pairs >= _LEAST_PAIRS
    number = int(enough.sum())
    if not number:
        raise ValueError("too few pairs of random outcomes")
    found = np.where(enough, sums / np.sqrt(np.maximum(pairs, 1)), 0.0)
    step, row, column = (int(k) for k in np.unravel_index(np.abs(found).argmax(), shape))
    largest = as_normal(math.erfc(abs(found[step, row, column]) / math.sqrt(2)), number)
    return Serial(largest, (step if step < steps else step - 2 * steps, row, column), number)


def _scores(probabilities: Floats) -> tuple[Floats, Floats]:
    """z of the outcome t of each state s, (states, states), by its rank and by its place in the circle.

    0 where s has one outcome.
    """
    by_rank, in_circle = np.zeros_like(probabilities), np.zeros_like(probabilities)
    for s, row in enumerate(probabilities):
        possible = np.flatnonzero(row > 0)
        if len(possible) < 2:
            continue
        circle = np.union1d(possible, [s])
        behind = (np.searchsorted(circle, possible) - np.searchsorted(circle, s)) % len(circle)
        for found, place in ((by_rank, np.arange(len(possible))), (in_circle, behind)):
            mean = row[possible] @ place
            found[s, possible] = (place - mean) / np.sqrt(row[possible] @ (place - mean) ** 2)
    return by_rank, in_circle
