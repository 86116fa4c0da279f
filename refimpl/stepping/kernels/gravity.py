"""Newton's gravity of many bodies: the half matrix of pairs, which LLVM turns into SIMD code row by row.

`acceleration` has the arguments and the result of `plain_acceleration` in `refimpl.stepping.forces.gravity`;
read that one for the physics. What makes this one fast:

* one array per coordinate, so that a row of pairs (i; j < i) is contiguous in memory;
* `error_model="numpy"` (a division that may raise cannot be vectorised) and leave to reorder sums. Square
  root and division stay correctly rounded;
* arrays that start a little more than a multiple of 4096 bytes apart: the processor compares the addresses
  of loads with those of earlier stores modulo 4096 first, and would wait for unrelated stores (a third of
  the speed at N = 1024).

The order of the sums depends on the vector length of the machine: results are the same bit for bit on one
machine, and to round-off between machines.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from refimpl.compilation import compiled

# Sums may be reordered, products and sums fused. Operands may be NaN; division and root are not approximated.
_REORDER = {"reassoc", "contract", "nsz"}

_PAGE = 512  # doubles in 4096 bytes
_SHIFT = 72  # doubles: 9 cache lines, so that the first seven rows of a work array start far apart modulo a page


@compiled(cache=True)
def _work_rows(count: int, n: int) -> np.ndarray:
    """`count` uninitialised rows of at least `n` doubles, shape (count, stride)."""
    stride = (n + _PAGE - 1) // _PAGE * _PAGE + _SHIFT
    return np.empty((count, stride))


@compiled(cache=True, fastmath=_REORDER)
def acceleration(r: np.ndarray, mass: np.ndarray, z: int | None, G: float, softening: float | None) -> np.ndarray:
    """a_i = -G sum_j m_j (r_i - r_j)/(r_ij^2 + s^2)^(3/2), shape (N*d,); see `plain_acceleration`."""
    n = mass.size
    d = 2 if z is None else 3
    rows = _work_rows(7, n)
    x_row, y_row, z_row, m_row, ax_row, ay_row, az_row = rows
    for i in range(n):
        x_row[i] = r[d * i]
        y_row[i] = r[d * i + 1]
        if z is not None:
            z_row[i] = r[d * i + z]
        m_row[i] = mass[i]

    for i in range(n):
        x_i, y_i, m_i = x_row[i], y_row[i], m_row[i]
        ax_i = ay_i = 0.0
        if z is not None:
            z_i, az_i = z_row[i], 0.0
        for j in range(i):
            dx = x_row[j] - x_i
            dy = y_row[j] - y_i
            square = dx * dx + dy * dy
            if z is not None:
                dz = z_row[j] - z_i
                square += dz * dz
            if softening is not None:
                square += softening * softening
            inverse_cube = 1.0 / (square * sqrt(square))
            from_j = inverse_cube * m_row[j]
            from_i = inverse_cube * m_i
            ax_i += from_j * dx
            ay_i += from_j * dy
            ax_row[j] -= from_i * dx
            ay_row[j] -= from_i * dy
            if z is not None:
                az_i += from_j * dz
                az_row[j] -= from_i * dz
        # the first use of these elements: later rows subtract from them
        ax_row[i] = ax_i
        ay_row[i] = ay_i
        if z is not None:
            az_row[i] = az_i

    a = np.empty(d * n)
    for i in range(n):
        a[d * i] = G * ax_row[i]
        a[d * i + 1] = G * ay_row[i]
        if z is not None:
            a[d * i + z] = G * az_row[i]
    return a


@compiled(cache=True, fastmath=_REORDER)
def energy_and_virial(
    r: np.ndarray, mass: np.ndarray, z: int | None, G: float, softening: float | None
) -> tuple[float, float]:
    """U = -G sum_{i<j} m_i m_j/rho and W = -G sum_{i<j} m_i m_j r_ij^2/rho^3, with rho^2 = r_ij^2 + s^2.

    W is the sum of r_ij . F_ij; it equals U if there is no softening. Arguments as for `plain_acceleration`.
    """
    n = mass.size
    d = 2 if z is None else 3
    x_row, y_row, z_row, m_row = _work_rows(4, n)
    for i in range(n):
        x_row[i] = r[d * i]
        y_row[i] = r[d * i + 1]
        if z is not None:
            z_row[i] = r[d * i + z]
        m_row[i] = mass[i]

    energy = virial = 0.0
    for i in range(n):
        x_i, y_i = x_row[i], y_row[i]
        if z is not None:
            z_i = z_row[i]
        energy_i = virial_i = 0.0
        for j in range(i):
            dx = x_row[j] - x_i
            dy = y_row[j] - y_i
            square = dx * dx + dy * dy
            if z is not None:
                dz = z_row[j] - z_i
                square += dz * dz
            if softening is None:
                energy_i += m_row[j] / sqrt(square)
            else:
                softened = square + softening * softening
                per_mass = m_row[j] / sqrt(softened)
                energy_i += per_mass
                virial_i += per_mass * (square / softened)
        energy += mass[i] * energy_i
        virial += mass[i] * virial_i
    if softening is None:
        virial = energy
    return -G * energy, -G * virial


@compiled(cache=True, fastmath=_REORDER)
def all_finite(a: np.ndarray) -> bool:
    """True if no element of `a` is infinite or NaN."""
    total = 0.0
    for q in range(a.size):
        total += 0.0 * a[q]  # NaN unless a[q] is finite
    return total == 0.0
