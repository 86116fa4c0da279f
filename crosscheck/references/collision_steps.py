"""Smooth hard spheres that fly for a time step, and then collide where they overlap and approach.

By definition, in plain Python: x <- x + v dt for all; then each pair of nearest images with r = |x_i - x_j| < s, s the
sum of its radii, and g = (v_i - v_j).n < 0, n = (x_i - x_j)/r, gets the impulse J = -(1 + alpha) g/(1/m_i + 1/m_j)
along n.

Literature: H. Rein and S.-F. Liu, Astron. Astrophys. 537, A128 (2012).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Spheres(NamedTuple):
    """masses, diameters: (N,). restitution: alpha. periods: sides of the box, (d,), 0 along axes without a period."""

    masses: Sequence[float]
    diameters: Sequence[float]
    restitution: float
    periods: Sequence[float]


class Moved(NamedTuple):
    """positions, not wrapped, and velocities, (N, d). impulses: number of them; most: of those of one sphere. closest:
    distance of the nearest two that had one, length; infinite for none. crowded: whether one of them was on a sphere
    that overlapped with two others at that time: their order then decides what follows.
    """

    positions: Floats
    velocities: Floats
    impulses: int
    most: int
    closest: float
    crowded: bool


def after_steps(spheres: Spheres, positions: Floats, velocities: Floats, dt: float, steps: int) -> Moved:
    """The state of the spheres after so many steps of dt.

    spheres: what they are. positions, velocities: (N, d), length and length/time, in any consistent units. dt: time.
    steps: number.
    """
    x, v = positions.tolist(), velocities.tolist()
    axes, impulses, closest, crowded = range(positions.shape[1]), [0] * len(x), math.inf, False
    for _ in range(steps):
        for place, speed in zip(x, v, strict=True):
            for k in axes:
                place[k] += speed[k] * dt
        overlaps: dict[int, int] = {}
        hit: set[int] = set()
        for i, j in itertools.combinations(range(len(x)), 2):
            apart = [_nearest(x[i][k] - x[j][k], spheres.periods[k]) for k in axes]
            distance = math.hypot(*apart)
            if distance >= (spheres.diameters[i] + spheres.diameters[j]) / 2:
                continue
            for one in (i, j):
                overlaps[one] = overlaps.get(one, 0) + 1
            normal = [component / distance for component in apart]
            approach = sum((v[i][k] - v[j][k]) * normal[k] for k in axes)
            if approach >= 0:
                continue
            impulse = -(1 + spheres.restitution) * approach / (1 / spheres.masses[i] + 1 / spheres.masses[j])
            for k in axes:
                v[i][k] += impulse * normal[k] / spheres.masses[i]
                v[j][k] -= impulse * normal[k] / spheres.masses[j]
            impulses[i] += 1
            impulses[j] += 1
            closest = min(closest, distance)
            hit |= {i, j}
        crowded = crowded or any(overlaps[one] > 1 for one in hit)
    return Moved(np.array(x), np.array(v), sum(impulses) // 2, max(impulses), closest, crowded)


def _nearest(x: float, period: float) -> float:
    return x - period * round(x / period) if period > 0 else x
