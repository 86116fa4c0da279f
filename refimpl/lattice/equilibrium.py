"""The equilibrium of Fermi and Dirac of any velocity set: the occupations that a density and a velocity have.

Units: lattice links, steps, particle masses. b channels with velocities c_i; d is the mean occupation of a channel, u
the mean velocity, f_i the mean occupations, with the channels on the last axis.

Literature: U. Frisch, D. d'Humieres, B. Hasslacher, P. Lallemand, Y. Pomeau and J.-P. Rivet, Complex Systems 1, 649
(1987); F. Bach, Electron. J. Stat. 4, 384 (2010) (the damping of Newton's method).
"""

from __future__ import annotations

from itertools import combinations
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from refimpl.lattice.velocities import VelocitySet

Floats: TypeAlias = NDArray[np.float64]


def _states(density: ArrayLike, velocity: ArrayLike) -> tuple[Floats, Floats]:
    """d (...) and u (..., 2), broadcast; 0 and 1 are mean occupations only of a gas at rest."""
    d, u = np.asarray(density, dtype=np.float64), np.asarray(velocity, dtype=np.float64)
    wrong = ~((d >= 0) & (d <= 1))
    if wrong.any():
        raise ValueError(f"the mean occupation must be between 0 and 1, got {d[wrong][0]}")
    if u.ndim == 0 or u.shape[-1] != 2:
        raise ValueError(f"a velocity has two components on the last axis, got an array of shape {u.shape}")
    shape = np.broadcast_shapes(d.shape, u.shape[:-1])
    d, u = np.broadcast_to(d, shape), np.broadcast_to(u, (*shape, 2))
    stuck = ((d == 0) | (d == 1)) & u.any(axis=-1)
    if stuck.any():
        raise ValueError(f"no occupations have mean {d[stuck][0]} and velocity {tuple(u[stuck][0].tolist())}")
    return d, u


def fermi_dirac(velocities: VelocitySet, density: ArrayLike, velocity: ArrayLike) -> Floats:
    """Equilibrium f_i = 1/(1 + exp(h + q.c_i)) with sum_i f_i = b d, sum_i f_i c_i = b d u; (..., b).

    velocities: the set. density: d (...). velocity: u (..., 2). The latter two are broadcast. The sums are met to about
    1e-15 b d. ValueError where d is not in [0, 1], and where no occupations between 0 and 1 have this density and
    this velocity.
    """
    d, u = _states(density, velocity)
    f = np.repeat(d[..., None], velocities.channels, axis=-1)
    moving = u.any(axis=-1)
    if moving.any():
        f[moving] = _moving_equilibrium(velocities, d[moving], u[moving])
    return f


#: Points that are solved at once: their arrays stay in the cache.
_BATCH = 4096
#: More than any point needs: far from the solution an exponent changes by about ln 2 a step.
_ITERATIONS = 500


def _moving_equilibrium(velocities: VelocitySet, d: Floats, u: Floats) -> Floats:
    """As `fermi_dirac`, d (n,) and u (n, 2), no u zero."""
    charges = np.vstack([np.ones(velocities.channels), np.array(velocities.integers, dtype=np.float64).T])
    pairs = np.array(list(combinations(range(velocities.channels), 2))).T
    normals = np.cross(charges[:, pairs[0]].T, charges[:, pairs[1]].T)
    # the sums that occupations in (0, 1) can have fill a convex body, whose faces are spanned by pairs of channels
    heights = normals @ charges
    low, high = np.minimum(heights, 0).sum(axis=1)[:, None], np.maximum(heights, 0).sum(axis=1)[:, None]
    f = np.empty((d.size, velocities.channels))
    for first in range(0, d.size, _BATCH):
        part = slice(first, first + _BATCH)
        density, velocity = d[part], u[part]
        targets = np.vstack([np.ones(density.size), (velocity / np.array(velocities.unit)).T])
        targets *= velocities.channels * density
        level = normals @ targets
        wrong = ~((level > low) & (level < high)).all(axis=0)
        if wrong.any():
            found = tuple(velocity[wrong][0].tolist())
            raise ValueError(f"no occupations have mean {density[wrong][0]} and velocity {found}")
        f[part] = _newton(charges, pairs, normals, density, targets).T
    return f


def _newton(charges: Floats, pairs: NDArray[np.int64], normals: Floats, d: Floats, targets: Floats) -> Floats:
    """f_i = w/(1 + w), w = d/(1 - d) exp(theta.a_i), sum_i a_i f_i = targets, a_i the columns of charges; (b, n).

    theta minimises sum_i ln(1 + w_i) - theta.targets. The Newton step is scaled by ln(1 + r)/r, r its largest change of
    an exponent: that decreases the function from any point, and converges quadratically in the end.
    """
    # the exponents are kept, not theta: near a face theta is large and an exponent the small sum of large terms
    exponents, unmoved = np.zeros((len(charges.T), d.size)), d / (1 - d)
    volumes = (charges.T @ normals.T) ** 2 / 3
    rounding = 8 * np.finfo(float).eps * len(charges.T)
    left = np.arange(d.size)
    for _ in range(_ITERATIONS):
        odds = unmoved[left] * np.exp(exponents[:, left])
        f = odds / (1 + odds)
        gap = (targets[:, left] - charges @ f) / d[left]
        # sum_i f_i (1 - f_i) a_i a_i^T is inverted by Cauchy and Binet's sums of positive terms: no cancellation
        weight = f / (1 + odds) / d[left]
        both = weight[pairs[0]] * weight[pairs[1]]
        determinant = (weight * (volumes @ both)).sum(axis=0)
        step = charges.T @ (normals.T @ (both * (normals @ gap)) / determinant)
        reach = np.abs(step).max(axis=0)
        exponents[:, left] += step * np.log1p(reach) / np.maximum(reach, np.finfo(float).tiny)
        left = left[(reach > 1e-8) & (np.abs(gap).max(axis=0) > rounding)]
        if left.size == 0:
            break
    else:
        raise ArithmeticError(f"no equilibrium found for the sums {targets[:, left[0]].tolist()}")
    odds = unmoved * np.exp(exponents)
    return np.asarray(odds / (1 + odds))
