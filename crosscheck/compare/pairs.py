"""Pairs of particles that are near each other: MDAnalysis finds them, in 32 bits; distances are those of 64 bits."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.compare.differences import flat_axes, nearest_image
from crosscheck.trajectories.frames import SINGLE, Floats, Frame, Integers

#: Fewer pairs are all looked at sooner than cells are filled.
_FEW = 3e6


class Pairs(NamedTuple):
    """Pairs of particles. first, second: their rows in the frame, (P,). distances: (P,), length."""

    first: Integers
    second: Integers
    distances: Floats


def pairs_within(frame: Frame, reach: float, chosen: Integers | None = None) -> Pairs:
    """Pairs of a frame nearer than `reach`, each once; or of `chosen` rows with all others, each from every chosen row.

    frame: of them. reach: length; beyond `largest_reach` pairs are missed. chosen: rows; None: all.
    """
    from MDAnalysis.lib.distances import capped_distance, self_capped_distance

    if len(frame.ids) < 2:
        return Pairs(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0))
    # lengths in units of the reach: it takes edges below 1e-7, as of atoms in metres, for none
    positions, dimensions = _for_mdanalysis(frame, reach)
    cutoff = min(reach + _margin(frame), _half(frame) * (1 - 4 * SINGLE.relative)) / reach
    # its cells are ten times as fast as the trees that it would choose for many particles
    asked: Any = {"box": dimensions, "return_distances": False}
    if chosen is None:
        found: Any = self_capped_distance(positions, cutoff, method="nsgrid", **asked)
    else:
        method = "bruteforce" if len(chosen) * len(positions) < _FEW else "nsgrid"
        found = capped_distance(positions[chosen], positions, cutoff, method=method, **asked)
    found = np.asarray(found, dtype=np.int64).reshape(-1, 2)
    first, second = found[:, 0] if chosen is None else chosen[found[:, 0]], found[:, 1]
    apart = frame.positions[first] - frame.positions[second]
    if frame.box is not None:
        apart = nearest_image(apart, frame.box)
    distances = np.linalg.norm(apart, axis=1)
    near = (distances < reach) & (first != second)
    return Pairs(first[near], second[near], distances[near])


def largest_reach(frame: Frame) -> float:
    """Half of the smallest distance of opposite faces of a periodic box: nearer pairs have one image; inf: no box.

    Less what 32 bits of the coordinates may hide. Along axes in which all particles are in one plane there are no
    images. frame: with the box.
    """
    return _half(frame) - _margin(frame)


def _half(frame: Frame) -> float:
    if frame.box is None:
        return float("inf")
    heights = 1 / np.linalg.norm(frame.box.shares, axis=0)
    return float(heights[_around(frame)].min(initial=np.inf)) / 2


def _around(frame: Frame) -> NDArray[np.bool_]:
    """Axes along which a frame has images that particles may be near to, (3,)."""
    return np.zeros(3, dtype=bool) if frame.box is None else frame.box.around & ~flat_axes(frame.positions)


def _margin(frame: Frame) -> float:
    """What 32 bits of coordinates within the box, or of an extent without images, may hide of a distance, length."""
    extent = np.ptp(frame.positions, axis=0)[~_around(frame)].sum()
    edges = 0.0 if frame.box is None else np.abs(frame.box.vectors).sum()
    return 16 * SINGLE.relative * float(extent + edges)


def _for_mdanalysis(frame: Frame, reach: float) -> tuple[Any, Any]:
    """Positions of 32 bits in a box that is periodic along all axes, so wide along some that no image is near.

    In units of the reach.
    """
    from MDAnalysis.lib.mdamath import triclinic_box

    around, positions = _around(frame), frame.positions
    vectors = np.diag(np.ptp(positions, axis=0) + 4 * reach)
    if frame.box is not None:
        vectors = np.where(around[:, None], frame.box.vectors, vectors)
        positions = positions - frame.box.lower
        positions = positions - (np.floor(positions @ np.linalg.inv(vectors)) * around) @ vectors
    positions = positions - np.where(around, 0.0, positions.min(axis=0))
    return np.asarray(positions / reach, dtype=np.float32), triclinic_box(*(vectors / reach))
