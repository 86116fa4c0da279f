"""Newton's gravity of many bodies: half of the matrix of pairs, eight at a time, in pieces that threads share.

`acceleration` has the arguments and the result of `plain_acceleration` in `refimpl.stepping.forces.gravity`, and a
work space; read that one for the physics. What makes this one fast:

* Eight consecutive bodies are a tile, in the lanes of a vector (`simd`). Of two tiles each pair is computed once, two
  bodies of the first against the eight of the second at a time, so that these are loaded and changed once for both.
  Within a tile each body meets all eight. Square root and division stay correctly rounded.
* One array per coordinate, which start a little more than a multiple of 4096 bytes apart: the processor compares the
  addresses of loads with those of earlier stores modulo 4096 first, and would wait for unrelated stores (a third of the
  speed at N = 1024).
* The tiles are dealt out to pieces, each with sums of its own, which are added up in order: threads share the pieces
  (`refimpl.team`), and no bit depends on how many there are.

The order of the sums depends on N alone; only where a processor cannot fuse a product and a sum may the last bits
differ from those on another one.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from refimpl.compilation import compiled
from refimpl.stepping.kernels.compiled import inline_internal, internal
from refimpl.stepping.kernels.simd import (
    WIDTH,
    lanes,
    load,
    load_splat,
    splat,
    square_root,
    store,
    total,
    where,
    zeros,
)
from refimpl.team import FLAGS, begin_round, join_team, next_piece, piece_done, wait_for_pieces, wait_for_round

# Sums may be reordered, products and sums fused. Operands may be NaN; division and root are not approximated.
_REORDER = {"reassoc", "contract", "nsz"}

_PAGE = 512  # doubles in 4096 bytes
_SHIFT = 72  # doubles: 9 cache lines, so that rows of a work array start far apart modulo a page
#: Position of the bodies without mass that fill up the last tile: its square is finite, its cube not, so that their
#: attraction is 0.
_FILLER = 1e150
#: A piece has so many bodies at least, and there are so many pieces at most: adding up their sums must cost little.
_LEAST, _MOST = 256, 32


class Work(NamedTuple):
    """What `acceleration` of N bodies works in.

    rows: x, y, z and mass of the bodies, filled up to whole tiles, (4, stride). sums: of the accelerations over G along
    x, y, z by each piece, (pieces, 3, stride). flags: of the team of threads that share the pieces.
    """

    rows: np.ndarray
    sums: np.ndarray
    flags: np.ndarray


def work(number: int) -> Work:
    """Work space for so many bodies."""
    stride = -(-number // _PAGE) * _PAGE + _SHIFT
    pieces = min(max(number // _LEAST, 1), _MOST)
    return Work(np.zeros((4, stride)), np.zeros((pieces, 3, stride)), np.zeros(FLAGS, dtype=np.int64))


@inline_internal
def _inverse_cube(dx, dy, dz, z, softening):  # type: ignore[no-untyped-def]
    """1/(r^2 + s^2)^(3/2), and in the plane without dz."""
    square = dx * dx + dy * dy
    if z is not None:
        square = square + dz * dz
    if softening is not None:
        square = square + splat(softening * softening)
    return splat(1.0) / (square * square_root(square))


@inline_internal
def _within_tile(rows, first, z, softening):  # type: ignore[no-untyped-def]
    """Sums of the forces on the bodies of the tile that begins with body `first` by each other."""
    x, y, z_row, m = rows[0], rows[1], rows[2], rows[3]
    xi, yi, zi = load(x, first), load(y, first), load(z_row, first)
    ax, ay, az = zeros(), zeros(), zeros()
    for lane in range(WIDTH):
        dx, dy, dz = load_splat(x, first + lane) - xi, load_splat(y, first + lane) - yi, zeros()
        if z is not None:
            dz = load_splat(z_row, first + lane) - zi
        # the distance of a body from itself is 0, and its inverse must not be infinite
        itself = lanes() == splat(float(lane))
        factor = _inverse_cube(where(itself, splat(1.0), dx), dy, dz, z, softening) * load_splat(m, first + lane)
        ax, ay, az = ax + factor * dx, ay + factor * dy, az + factor * dz
    return ax, ay, az


@inline_internal
def _add_to(sums, i, ax, ay, az, z):  # type: ignore[no-untyped-def]
    """sums[:, i : i + WIDTH] += (ax, ay, az)."""
    store(sums[0], i, load(sums[0], i) + ax)
    store(sums[1], i, load(sums[1], i) + ay)
    if z is not None:
        store(sums[2], i, load(sums[2], i) + az)


@internal
def _piece(rows, sums, piece, pieces, n, z, softening):  # type: ignore[no-untyped-def]
    """Sums over the pairs of each tile whose number is `piece` modulo `pieces` with itself and with all later ones."""
    x, y, z_row, m = rows[0], rows[1], rows[2], rows[3]
    own = sums[piece]
    ax_row, ay_row, az_row = own[0], own[1], own[2]
    end = (n + WIDTH - 1) // WIDTH * WIDTH
    first = piece * WIDTH
    own[:, first:end] = 0.0
    for tile in range(first, end, pieces * WIDTH):
        ax, ay, az = _within_tile(rows, tile, z, softening)
        _add_to(own, tile, ax, ay, az, z)
        for i in range(tile, tile + WIDTH, 2):
            x0, y0, z0, m0 = load_splat(x, i), load_splat(y, i), load_splat(z_row, i), load_splat(m, i)
            x1, y1, z1, m1 = load_splat(x, i + 1), load_splat(y, i + 1), load_splat(z_row, i + 1), load_splat(m, i + 1)
            ax0, ay0, az0, ax1, ay1, az1 = zeros(), zeros(), zeros(), zeros(), zeros(), zeros()
            for j in range(tile + WIDTH, end, WIDTH):
                xj, yj, zj, mj = load(x, j), load(y, j), load(z_row, j), load(m, j)
                ax, ay, az = load(ax_row, j), load(ay_row, j), load(az_row, j)
                dx, dy, dz = xj - x0, yj - y0, zj - z0
                inverse_cube = _inverse_cube(dx, dy, dz, z, softening)
                from_j, from_i = inverse_cube * mj, inverse_cube * m0
                ax0, ay0, az0 = ax0 + from_j * dx, ay0 + from_j * dy, az0 + from_j * dz
                ax, ay, az = ax - from_i * dx, ay - from_i * dy, az - from_i * dz
                dx, dy, dz = xj - x1, yj - y1, zj - z1
                inverse_cube = _inverse_cube(dx, dy, dz, z, softening)
                from_j, from_i = inverse_cube * mj, inverse_cube * m1
                ax1, ay1, az1 = ax1 + from_j * dx, ay1 + from_j * dy, az1 + from_j * dz
                ax, ay, az = ax - from_i * dx, ay - from_i * dy, az - from_i * dz
                store(ax_row, j, ax)
                store(ay_row, j, ay)
                if z is not None:
                    store(az_row, j, az)
            ax_row[i] += total(ax0)
            ay_row[i] += total(ay0)
            ax_row[i + 1] += total(ax1)
            ay_row[i + 1] += total(ay1)
            if z is not None:
                az_row[i] += total(az0)
                az_row[i + 1] += total(az1)


@internal
def _take_pieces(rows, sums, flags, n, z, softening):  # type: ignore[no-untyped-def]
    """Computes pieces until none is left."""
    piece = next_piece(flags)
    while piece >= 0:
        _piece(rows, sums, piece, len(sums), n, z, softening)
        piece_done(flags)
        piece = next_piece(flags)


@compiled(cache=True)
def acceleration(r, mass, z, G, softening, work):  # type: ignore[no-untyped-def]
    """a_i = -G sum_j m_j (r_i - r_j)/(r_ij^2 + s^2)^(3/2), shape (N*d,); see `plain_acceleration`. work: of N."""
    rows, sums, flags = work.rows, work.sums, work.flags
    n = mass.size
    d = 2 if z is None else 3
    for i in range(n):
        rows[0, i] = r[d * i]
        rows[1, i] = r[d * i + 1]
        if z is not None:
            rows[2, i] = r[d * i + z]
        rows[3, i] = mass[i]
    for i in range(n, (n + WIDTH - 1) // WIDTH * WIDTH):
        rows[0, i] = _FILLER * (1 + i - n)
    begin_round(flags, len(sums))
    _take_pieces(rows, sums, flags, n, z, softening)
    wait_for_pieces(flags, len(sums))
    a = np.zeros(d * n)
    for piece in range(len(sums)):
        # the sums of a piece begin with its first tile
        for i in range(piece * WIDTH, n):
            a[d * i] += sums[piece, 0, i]
            a[d * i + 1] += sums[piece, 1, i]
            if z is not None:
                a[d * i + z] += sums[piece, 2, i]
    for q in range(d * n):
        a[q] *= G
    return a


@compiled(cache=True, nogil=True)
def serve(n, z, softening, work):  # type: ignore[no-untyped-def]
    """A helper's part of all accelerations of n bodies, until the team's work ends. Other arguments as there."""
    join_team(work.flags)
    last = 0
    while True:
        last = wait_for_round(work.flags, last)
        if last == 0:
            return
        _take_pieces(work.rows, work.sums, work.flags, n, z, softening)


@compiled(cache=True)
def _work_rows(count: int, n: int) -> np.ndarray:
    """`count` uninitialised rows of at least `n` doubles, shape (count, stride)."""
    stride = (n + _PAGE - 1) // _PAGE * _PAGE + _SHIFT
    return np.empty((count, stride))


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
