"""Search for overlapping hard particles in k-d trees, one for each class of sizes, in a time of about order N.

Of a few particles all pairs are looked at, which is faster; and workers whose scenes are small need not import scipy,
which takes as long as the rest of their start.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[Any]

#: Up to this many particles, all pairs are looked at.
ALL_PAIRS = 200
#: About this many particles are searched first, before all of them.
_FEW = 1000


class Overlap(NamedTuple):
    """Particles i < j whose distance is less than their contact distance.

    i, j: their indices. distance: of their centres, length. contact: mean of their diameters, length.
    """

    i: int
    j: int
    distance: float
    contact: float


class _Class(NamedTuple):
    """Particles, all of them fixed or none, whose diameters (`least` to `largest`) are within a factor of two."""

    members: NDArray[np.int64]
    tree: Any
    least: float
    largest: float
    fixed: bool


def wrapped(positions: Floats, periods: Floats) -> Floats:
    """The positions, (N, d), length, with periodic coordinates mapped into [0, period), as k-d trees require.

    periods: (d,), length; 0 along axes that are not periodic, whose coordinates stay as they are.
    """
    inside = positions.copy()
    wraps = periods > 0
    inside[:, wraps] %= periods[wraps]
    # the remainder of a tiny negative number is rounded up to the period itself
    inside[:, wraps] = np.where(inside[:, wraps] < periods[wraps], inside[:, wraps], 0.0)
    return inside


def find_overlap(
    positions: Floats, diameters: Floats, fixed: NDArray[np.bool_], periods: Floats, rounding: float, soft: bool = False
) -> Overlap | None:
    """A pair of particles nearer than the mean of their diameters by more than `rounding`; None if there is none.

    positions: (N, d), length. diameters: (N,), length. fixed: (N,), particles that never move. periods: (d,), length, 0
    along axes that are not periodic. rounding: length. soft: particles may overlap by less than the smaller of their
    radii; found is a pair whose distance is not even the larger one. Two fixed particles, and two of diameter 0, may
    overlap. The period of an axis must exceed two contact distances.
    """
    inside = wrapped(positions, periods)
    if len(positions) <= ALL_PAIRS:
        return _among_all_pairs(inside, diameters, fixed, periods, rounding, soft)
    classes = _classes(inside, diameters, fixed, periods)
    for one, other in combinations_with_replacement(classes, 2):
        if (one.fixed and other.fixed) or one.largest + other.largest == 0:
            continue
        i, j, distances = _near(inside, one, other, rounding, soft)
        gaps = distances - _least_distance(diameters[i], diameters[j], soft)
        if gaps.size and gaps.min() < -rounding:
            worst = int(gaps.argmin())
            first, second = sorted((int(i[worst]), int(j[worst])))
            contact = 0.5 * float(diameters[first] + diameters[second])
            return Overlap(first, second, float(distances[worst]), contact)
    return None


def _among_all_pairs(
    positions: Floats, diameters: Floats, fixed: NDArray[np.bool_], periods: Floats, rounding: float, soft: bool
) -> Overlap | None:
    """The pair that overlaps most, see `find_overlap`; positions are wrapped."""
    i, j = np.triu_indices(len(positions), 1)
    matter = ~(fixed[i] & fixed[j]) & (diameters[i] + diameters[j] > 0)
    i, j = i[matter], j[matter]
    apart = positions[i] - positions[j]
    wraps = periods > 0
    apart[:, wraps] -= np.round(apart[:, wraps] / periods[wraps]) * periods[wraps]
    distances = np.sqrt(np.einsum("ij,ij->i", apart, apart))
    gaps = distances - _least_distance(diameters[i], diameters[j], soft)
    if gaps.size == 0 or gaps.min() >= -rounding:
        return None
    worst = int(gaps.argmin())
    first, second = int(i[worst]), int(j[worst])
    return Overlap(first, second, float(distances[worst]), 0.5 * float(diameters[first] + diameters[second]))


def _classes(positions: Floats, diameters: Floats, fixed: NDArray[np.bool_], periods: Floats) -> list[_Class]:
    from scipy.spatial import cKDTree

    # sizes in a class are similar, so particles that do not overlap have few neighbours within the largest contact
    # distance, and the search is cheap
    octaves = np.where(diameters > 0, np.frexp(diameters)[1], np.iinfo(np.int32).min)
    classes = []
    for octave in np.unique(octaves):
        for still in (False, True):
            members = np.flatnonzero((octaves == octave) & (fixed == still))
            if members.size:
                tree = cKDTree(positions[members], boxsize=periods, balanced_tree=False, compact_nodes=False)
                sizes = diameters[members]
                classes.append(_Class(members, tree, float(sizes.min()), float(sizes.max()), still))
    return classes


def _least_distance(one: Any, other: Any, soft: bool) -> Any:
    """The smallest distance that two particles of these diameters may have; it grows with both."""
    return 0.5 * (np.maximum(one, other) if soft else one + other)


def _near(positions: Floats, one: _Class, other: _Class, rounding: float, soft: bool) -> tuple[Any, Any, Any]:
    """Pairs i, j that may be nearer than allowed, and their distances.

    Nearest neighbours only, if those are too near already or if all least distances are equal; else all pairs within
    the largest of these.
    """
    least = float(_least_distance(one.least, other.least, soft))
    largest = float(_least_distance(one.largest, other.largest, soft))
    # a few first: where many particles lie at the same place, finding the nearest neighbours of all takes long
    for members in (one.members[:: one.members.size // _FEW + 1], one.members):
        i, j, distances = _nearest(positions, members, other, largest, one is other)
        if distances.size and distances.min() < least - rounding:
            return i, j, distances
    if distances.size == 0 or least == largest:
        return i, j, distances
    pairs = one.tree.sparse_distance_matrix(other.tree, largest, output_type="ndarray")
    pairs = pairs[one.members[pairs["i"]] != other.members[pairs["j"]]]
    return one.members[pairs["i"]], other.members[pairs["j"]], pairs["v"]


def _nearest(positions: Floats, members: Any, other: _Class, reach: float, same: bool) -> tuple[Any, Any, Any]:
    """Each member, its nearest neighbour of the other class and their distance, where that is less than `reach`."""
    distances, places = other.tree.query(positions[members], k=[1, 2] if same else [1], distance_upper_bound=reach)
    itself = 0
    if same:  # the nearest is the member itself, or another one at the same place
        itself = (other.members[np.minimum(places[:, 0], other.members.size - 1)] == members).astype(int)
    rows = np.arange(members.size)
    distances, places = distances[rows, itself], places[rows, itself]
    near = distances < reach
    return members[near], other.members[places[near]], distances[near]
