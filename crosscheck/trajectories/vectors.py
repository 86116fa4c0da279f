"""Vectors of particles and of boxes, as readers need them."""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.trajectories.frames import Floats


def in_space(vectors: Any) -> Floats:
    """Vectors (N, k), k <= 3, or components (N,), completed with zeros to (N, 3). vectors: of any type of number."""
    table = np.asarray(vectors, dtype=np.float64)
    table = table[:, None] if table.ndim == 1 else table
    return np.pad(table, ((0, 0), (0, 3 - table.shape[1])))


def moved(start: Floats, numbers: Any, vectors: Floats) -> Floats:
    """Positions moved by so many edges of a box, (N, 3).

    Summed up in LAMMPS's order, whose own unwrapped positions are then the same to the last bit. start: (N, 3), length.
    numbers: (N, 3). vectors: edges as rows, (3, 3), length.
    """
    found = np.array(start, dtype=np.float64)
    for count, edge in zip(np.asarray(numbers).T, vectors, strict=True):
        found += count[:, None] * edge
    return found


def from_cosines(lengths: Any, cosines: Any) -> Floats:
    """Edges of a box as rows, (3, 3), the first along x, the second in the plane of x and y.

    lengths: of the edges, (3,), length. cosines: of the angles alpha, beta, gamma between them, (3,). ValueError if no
    three edges have these angles.
    """
    a, b, c = map(float, lengths)
    alpha, beta, gamma = map(float, cosines)
    volume = 1 - alpha**2 - beta**2 - gamma**2 + 2 * alpha * beta * gamma
    if not (abs(gamma) < 1 and volume > 0):
        raise ValueError(f"no box has edges with the cosines {alpha:g}, {beta:g}, {gamma:g} between them")
    sine = np.sqrt(1 - gamma**2)
    return np.array(
        [[a, 0, 0], [b * gamma, b * sine, 0], [c * beta, c * (alpha - beta * gamma) / sine, c * np.sqrt(volume) / sine]]
    )
