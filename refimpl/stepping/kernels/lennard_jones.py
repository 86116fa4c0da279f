"""Sums over the pairs of a Lennard-Jones fluid: one neighbour against a tile of eight particles.

The particles of a tile lie in the lanes of a vector; each slot of the tile's list (`neighbours`, beside this module) is
broadcast to all lanes, and lanes beyond the cutoff are masked. Every pair is computed from both of its sides: that
costs less than adding to the partner's force in memory. The members of a tile are not in its list; a loop of their own
leaves out each particle's force on itself.

With q = 1/r^2, A = 24 eps sigma^6 and B = 48 eps sigma^12: F/r = q^4 (B q^3 - A), one division and no square root a
pair; r F = q^3 (B q^3 - A) and phi = q^3 (B q^3/12 - A/6). In a mixture A and B are computed pair by pair.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from refimpl.compilation import compiled
from refimpl.stepping.kernels.compiled import inline_internal
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

#: Squared distance that stands for that of a particle from itself: beyond every cutoff.
SELF = 1e300


class Pairs(NamedTuple):
    """What the equations of a pair need; absent features are None.

    epsilon, sigma: of the only species, or None. sizes, strengths: sigma/2 and sqrt(epsilon) of each slot in a mixture,
    or None. cutoff: of all pairs. shift_energy, shift_force: True, or None.
    """

    epsilon: Any
    sigma: Any
    sizes: Any
    strengths: Any
    cutoff: float
    shift_energy: Any
    shift_force: Any


class Tile(NamedTuple):
    """Of the eight particles of a tile, a vector each: coordinates, and in a mixture sigma/2 and sqrt(epsilon)."""

    x: Any
    y: Any
    z: Any
    size: Any
    strength: Any


@inline_internal
def _pairs(force):  # type: ignore[no-untyped-def]
    return Pairs(
        force.epsilon, force.sigma, force.slot_size, force.slot_strength, force.cutoff, force.shift_energy,
        force.shift_force,
    )  # fmt: skip


@inline_internal
def _tile(tiles, dimension, pairs, tile):  # type: ignore[no-untyped-def]
    """Tile number `tile`; two dimensions have y in place of z."""
    base = tile * WIDTH * dimension
    return Tile(
        load(tiles, base), load(tiles, base + WIDTH), load(tiles, base + (dimension - 1) * WIDTH),
        _lanes_of(pairs.sizes, tile), _lanes_of(pairs.strengths, tile),
    )  # fmt: skip


@inline_internal
def _lanes_of(slot_values, tile):  # type: ignore[no-untyped-def]
    if slot_values is not None:
        return load(slot_values, tile * WIDTH)
    return zeros()


@inline_internal
def _coefficients(pairs, tile, j):  # type: ignore[no-untyped-def]
    """A and B of the pairs of the tile with slot j; the same everywhere if there is one species."""
    return _coefficients_of(pairs.epsilon, pairs.sigma, pairs.sizes, pairs.strengths, tile.size, tile.strength, j)


@inline_internal
def _coefficients_of(epsilon, sigma, sizes, strengths, size, strength, j):  # type: ignore[no-untyped-def]
    attraction = zeros()
    repulsion = zeros()
    # numba leaves out a branch for an argument that is None, but not one for an argument that is not: so, two tests.
    if epsilon is not None:
        attraction = splat(24.0 * epsilon * sigma**6)
        repulsion = attraction * splat(2.0 * sigma**6)
    if sizes is not None:
        length = size + load_splat(sizes, j)
        length3 = length * length * length
        length6 = length3 * length3
        attraction = strength * load_splat(strengths, j) * splat(24.0) * length6
        repulsion = attraction * length6 * splat(2.0)
    return attraction, repulsion


@inline_internal
def _separation(packed, sides, tile, j, itself):  # type: ignore[no-untyped-def]
    """Vectors from slot j to the tile's particles, and their squares; `itself` marks the lane of j in the tile."""
    xi, yi, zi = tile.x, tile.y, tile.z
    if len(sides) == 3:
        dx = xi - load_splat(packed, 4 * j)
        dy = yi - load_splat(packed, 4 * j + 1)
        dz = zi - load_splat(packed, 4 * j + 2)
        r2 = dx * dx + dy * dy + dz * dz
    else:
        dx = xi - load_splat(packed, 2 * j)
        dy = yi - load_splat(packed, 2 * j + 1)
        dz = zi
        r2 = dx * dx + dy * dy
    if itself is not None:
        r2 = where(lanes() == splat(itself), splat(SELF), r2)
    return dx, dy, dz, r2


@inline_internal
def _slope_at_cutoff(attraction, repulsion, cutoff):  # type: ignore[no-untyped-def]
    """phi'(cutoff)."""
    q3 = splat(1.0 / cutoff**6)
    return q3 * (attraction - repulsion * q3) * splat(1.0 / cutoff)


@inline_internal
def _with_shift(shift_force, f, attraction, repulsion, cutoff, q):  # type: ignore[no-untyped-def]
    """The force over the distance, less that at the cutoff where the truncation asks for it; q is 1/r^2."""
    if shift_force is not None:
        f = f + _slope_at_cutoff(attraction, repulsion, cutoff) * square_root(q)
    return f


@inline_internal
def _add_force(packed, sides, pairs, tile, j, itself, forces):  # type: ignore[no-untyped-def]
    """forces (x, y, z), with the forces of slot j on the particles of the tile."""
    fx, fy, fz = forces
    dx, dy, dz, r2 = _separation(packed, sides, tile, j, itself)
    attraction, repulsion = _coefficients(pairs, tile, j)
    cutoff = pairs.cutoff
    q = splat(1.0) / r2
    q2 = q * q
    f = q2 * q2 * (q2 * q * repulsion - attraction)
    f = _with_shift(pairs.shift_force, f, attraction, repulsion, cutoff, q)
    f = where(r2 < splat(cutoff * cutoff), f, zeros())
    if len(sides) == 3:
        fz = fz + f * dz
    return fx + f * dx, fy + f * dy, fz


@inline_internal
def _wall_force(walls, sides, lengths, k, x):  # type: ignore[no-untyped-def]
    """Force of the two walls across axis k on a particle at x, between them."""
    if walls is None:
        return 0.0
    if sides[k] > 0:
        return 0.0
    return _one_wall(walls, x) - _one_wall(walls, lengths[k] - x)


@inline_internal
def _one_wall(walls, s):  # type: ignore[no-untyped-def]
    if s >= walls.cutoff:
        return 0.0
    s6 = (walls.sigma / s) ** 6
    return 24.0 * walls.epsilon * s6 * (2.0 * s6 - 1.0) / s


@inline_internal
def _divide(force, mass, masses, particle):  # type: ignore[no-untyped-def]
    if masses is not None:
        return force / masses[particle]
    if mass is not None:
        return force / mass
    return force


@compiled(cache=True)
def tile_accelerations(force, r, a):  # type: ignore[no-untyped-def]
    """Accelerations `a` of the particles at the coordinates `r`, both of shape (N*d,), from valid lists.

    force: `LennardJones`. Returns the number of distances computed.
    """
    neighbours, mass, masses, walls, lengths = force.neighbours, force.mass, force.masses, force.walls, force.lengths
    packed, tiles, first, entries = neighbours.packed, neighbours.tiles, neighbours.first, neighbours.entries
    sides, order = neighbours.sides, neighbours.order
    dimension, pairs = len(sides), _pairs(force)
    forces = np.empty(3 * WIDTH)
    tests = 0
    for tile in range(len(first) - 1):
        tests += WIDTH * (WIDTH + first[tile + 1] - first[tile])
        members = _tile(tiles, dimension, pairs, tile)
        f = zeros(), zeros(), zeros()
        for lane in range(WIDTH):
            f = _add_force(packed, sides, pairs, members, tile * WIDTH + lane, float(lane), f)
        for entry in range(first[tile], first[tile + 1]):
            f = _add_force(packed, sides, pairs, members, np.int64(entries[entry]), None, f)
        store(forces, 0, f[0])
        store(forces, WIDTH, f[1])
        store(forces, 2 * WIDTH, f[2])
        for lane in range(min(WIDTH, len(order) - tile * WIDTH)):
            particle = order[tile * WIDTH + lane]
            for k in range(dimension):
                wall = _wall_force(walls, sides, lengths, k, r[particle * dimension + k])
                a[particle * dimension + k] = _divide(forces[k * WIDTH + lane] + wall, mass, masses, particle)
    return tests


@inline_internal
def _energy_shift(shift_energy, u, attraction, repulsion, cutoff):  # type: ignore[no-untyped-def]
    """phi(r), less phi(cutoff) where the truncation asks for it."""
    if shift_energy is not None:
        c3 = splat(1.0 / cutoff**6)
        u = u - c3 * (c3 * repulsion * splat(1 / 12) - attraction * splat(1 / 6))
    return u


@inline_internal
def _slope_shift(shift_force, u, w, r2, attraction, repulsion, cutoff):  # type: ignore[no-untyped-def]
    """phi and r F, with the linear term of the force-shifted potential where the truncation asks for it."""
    if shift_force is not None:
        distance = square_root(r2)
        slope = _slope_at_cutoff(attraction, repulsion, cutoff)
        u = u - (distance - splat(cutoff)) * slope
        w = w + distance * slope
    return u, w


@inline_internal
def _add_energy(packed, sides, pairs, tile, j, itself, sums):  # type: ignore[no-untyped-def]
    """sums (energy, work), with phi and r F of slot j with each particle of the tile."""
    energy, work = sums
    _, _, _, r2 = _separation(packed, sides, tile, j, itself)
    attraction, repulsion = _coefficients(pairs, tile, j)
    cutoff = pairs.cutoff
    q = splat(1.0) / r2
    q3 = q * q * q
    u = q3 * (q3 * repulsion * splat(1 / 12) - attraction * splat(1 / 6))
    w = q3 * (q3 * repulsion - attraction)
    u = _energy_shift(pairs.shift_energy, u, attraction, repulsion, cutoff)
    u, w = _slope_shift(pairs.shift_force, u, w, r2, attraction, repulsion, cutoff)
    within = r2 < splat(cutoff * cutoff)
    return energy + where(within, u, zeros()), work + where(within, w, zeros())


@compiled(cache=True)
def tile_energy(force):  # type: ignore[no-untyped-def]
    """Potential energy and virial of the pairs of a `LennardJones` force, from valid lists."""
    neighbours = force.neighbours
    packed, tiles, first, entries = neighbours.packed, neighbours.tiles, neighbours.first, neighbours.entries
    sides = neighbours.sides
    dimension, pairs = len(sides), _pairs(force)
    all_energy = 0.0
    all_work = 0.0
    for tile in range(len(first) - 1):
        members = _tile(tiles, dimension, pairs, tile)
        sums = zeros(), zeros()
        for lane in range(WIDTH):
            sums = _add_energy(packed, sides, pairs, members, tile * WIDTH + lane, float(lane), sums)
        for entry in range(first[tile], first[tile + 1]):
            sums = _add_energy(packed, sides, pairs, members, np.int64(entries[entry]), None, sums)
        all_energy += total(sums[0])
        all_work += total(sums[1])
    # Each pair was found from both sides.
    return 0.5 * all_energy, 0.5 * all_work


@compiled(cache=True)
def wall_energy(walls, sides, lengths, r):  # type: ignore[no-untyped-def]
    """Energy of particles between the walls, 0 at the walls' cutoff."""
    energy = 0.0
    at_cutoff = (walls.sigma / walls.cutoff) ** 6
    for k in range(len(sides)):
        if sides[k] > 0:
            continue
        for x in r[k :: len(sides)]:
            for s in (x, lengths[k] - x):
                if s < walls.cutoff:
                    s6 = (walls.sigma / s) ** 6
                    energy += 4.0 * walls.epsilon * (s6 * (s6 - 1.0) - at_cutoff * (at_cutoff - 1.0))
    return energy


@compiled(cache=True)
def between_walls(sides, lengths, r):  # type: ignore[no-untyped-def]
    """True if every particle is strictly between the faces 0 and lengths[k] of each axis k that is not periodic."""
    inside = True
    for k in range(len(sides)):
        if sides[k] == 0:
            for x in r[k :: len(sides)]:
                inside &= 0 < x < lengths[k]
    return inside
