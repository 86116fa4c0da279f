"""Distances between neighbours in cells: for the start of a simulation, and to look at its state.

Compiled once for all models: positions at one time (N, 3), lengths (3,), the sizes of all particles.
"""

from typing import Any

import numpy as np

from refimpl.events.kernels.compiled import inline_internal, kernel


@kernel
def closest(radii: Any, fixed: Any, x: Any, cell_of: Any, cells: Any, counts: Any, wraps: Any, lengths: Any) -> Any:
    """Smallest gap between the surfaces of two particles, and which they are; fixed ones may overlap each other."""
    best, one, other = 1e300, -1, -1
    for i in range(x.shape[0]):
        for turn in range(27):
            cell, sx, sy, sz = _neighbour(cell_of, counts, wraps, i, turn)
            if cell >= 0:
                for slot in range(1, cells[cell, 0] + 1):
                    j = cells[cell, slot]
                    if j > i and not (fixed[i] and fixed[j]):
                        gap = _distance(x, lengths, i, j, sx, sy, sz) - radii[i] - radii[j]
                        if gap < best:
                            best, one, other = gap, i, j
    return best, one, other


@kernel
def find_bonds(
    radii: Any, factor: float, bonds: Any, x: Any, cell_of: Any, cells: Any, counts: Any, wraps: Any, lengths: Any
) -> bool:
    """Fills `bonds`, zeros (N, 1 + slots), with the partners within `factor` contact distances; False: no room."""
    for i in range(x.shape[0]):
        for turn in range(27):
            cell, sx, sy, sz = _neighbour(cell_of, counts, wraps, i, turn)
            if cell >= 0:
                for slot in range(1, cells[cell, 0] + 1):
                    j = cells[cell, slot]
                    if j != i and _distance(x, lengths, i, j, sx, sy, sz) < factor * (radii[i] + radii[j]):
                        if bonds[i, 0] + 1 >= bonds.shape[1]:
                            return False
                        bonds[i, 0] += 1
                        bonds[i, bonds[i, 0]] = j
    return True


@inline_internal
def _neighbour(cell_of: Any, counts: Any, wraps: Any, i: int, turn: int) -> tuple[int, int, int, int]:
    """The cell in one of 27 directions, -1 beyond a side that does not wrap, and how often it wraps along each axis."""
    nx, ny, nz = counts
    x = cell_of[i, 0] + turn % 3 - 1
    y = cell_of[i, 1] + turn // 3 % 3 - 1
    z = cell_of[i, 2] + turn // 9 - 1
    sx = -1 if x < 0 else (1 if x >= nx else 0)
    sy = -1 if y < 0 else (1 if y >= ny else 0)
    sz = -1 if z < 0 else (1 if z >= nz else 0)
    if (sx != 0 and not wraps[0]) or (sy != 0 and not wraps[1]) or (sz != 0 and not wraps[2]):
        return -1, 0, 0, 0
    return ((z - sz * nz) * ny + (y - sy * ny)) * nx + (x - sx * nx), sx, sy, sz


@inline_internal
def _distance(x: Any, lengths: Any, i: int, j: int, sx: int, sy: int, sz: int) -> float:
    a = x[j, 0] - x[i, 0] + sx * lengths[0]
    b = x[j, 1] - x[i, 1] + sy * lengths[1]
    c = x[j, 2] - x[i, 2] + sz * lengths[2]
    return np.sqrt(a * a + b * b + c * c)
