"""Fast twin of `refimpl.stepping.forces.lennard_jones.plain_forces`: one neighbour against a tile of eight particles.

The particles of a tile lie in the lanes of a vector; each slot of the tile's list (`neighbours`, beside this module) is
broadcast to all lanes, and lanes beyond the cutoff are masked. Every pair is computed from both of its sides: that
costs less than adding to the partner's force in memory. The members of a tile are not in its list; a loop of their own
leaves out each particle's force on itself.

With q = 1/r^2, A = 24 eps sigma^6 and B = 48 eps sigma^12: F/r = q^4 (B q^3 - A), one division and no square root a
pair; r F = q^3 (B q^3 - A) and phi = q^3 (B q^3/12 - A/6). In a mixture A and B are computed pair by pair.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from refimpl.stepping.kernels.compiled import inline_internal
from refimpl.stepping.kernels.neighbours import Neighbours
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


@inline_internal
def _lanes_of(slot_values, tile):  # type: ignore[no-untyped-def]
    if slot_values is not None:
        return load(slot_values, tile * WIDTH)
    return zeros()


@inline_internal
def _coefficients(epsilon, sigma, sizes, strengths, size, strength, j):  # type: ignore[no-untyped-def]
    """A and B of the pairs of the tile with slot j; the same everywhere if there is one species."""
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
def _separation(packed, sides, j, itself, xi, yi, zi):  # type: ignore[no-untyped-def]
    """Vectors from slot j to the tile's particles, and their squares; `itself` marks the lane of j in the tile."""
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
def _add_force(  # type: ignore[no-untyped-def]
    packed,
    sides,
    epsilon,
    sigma,
    sizes,
    strengths,
    cutoff,
    shift_force,
    size,
    strength,
    j,
    itself,
    xi,
    yi,
    zi,
    fx,
    fy,
    fz,
):
    """fx, fy, fz with the forces of slot j on the particles of the tile."""
    dx, dy, dz, r2 = _separation(packed, sides, j, itself, xi, yi, zi)
    attraction, repulsion = _coefficients(epsilon, sigma, sizes, strengths, size, strength, j)
    q = splat(1.0) / r2
    q2 = q * q
    f = q2 * q2 * (q2 * q * repulsion - attraction)
    if shift_force is not None:
        f = f + _slope_at_cutoff(attraction, repulsion, cutoff) * square_root(q)
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


@njit(cache=True, error_model="numpy")
def tile_accelerations(  # type: ignore[no-untyped-def]
    neighbours: Neighbours, epsilon, sigma, sizes, strengths, cutoff, shift_force, mass, masses, walls, lengths, r, a
) -> None:
    """Accelerations `a` of the particles, shape (N*d,), from valid lists.

    epsilon, sigma: of the only species, or None. sizes, strengths: sigma/2 and sqrt(epsilon) of each slot in a
    mixture, or None. Other absent features are None too: force shift, mass (1 then), masses, walls.
    """
    packed, tiles, first, entries = neighbours.packed, neighbours.tiles, neighbours.first, neighbours.entries
    sides, order = neighbours.sides, neighbours.order
    dimension = len(sides)
    forces = np.empty(3 * WIDTH)
    for tile in range(len(first) - 1):
        base = tile * WIDTH * dimension
        xi = load(tiles, base)
        yi = load(tiles, base + WIDTH)
        zi = load(tiles, base + (dimension - 1) * WIDTH)
        size = _lanes_of(sizes, tile)
        strength = _lanes_of(strengths, tile)
        fx = zeros()
        fy = zeros()
        fz = zeros()
        for lane in range(WIDTH):
            fx, fy, fz = _add_force(
                packed,
                sides,
                epsilon,
                sigma,
                sizes,
                strengths,
                cutoff,
                shift_force,
                size,
                strength,
                tile * WIDTH + lane,
                float(lane),
                xi,
                yi,
                zi,
                fx,
                fy,
                fz,
            )
        for entry in range(first[tile], first[tile + 1]):
            fx, fy, fz = _add_force(
                packed,
                sides,
                epsilon,
                sigma,
                sizes,
                strengths,
                cutoff,
                shift_force,
                size,
                strength,
                np.int64(entries[entry]),
                None,
                xi,
                yi,
                zi,
                fx,
                fy,
                fz,
            )
        store(forces, 0, fx)
        store(forces, WIDTH, fy)
        store(forces, 2 * WIDTH, fz)
        for lane in range(min(WIDTH, len(order) - tile * WIDTH)):
            particle = order[tile * WIDTH + lane]
            for k in range(dimension):
                wall = _wall_force(walls, sides, lengths, k, r[particle * dimension + k])
                a[particle * dimension + k] = _divide(forces[k * WIDTH + lane] + wall, mass, masses, particle)


@inline_internal
def _add_energy(  # type: ignore[no-untyped-def]
    packed,
    sides,
    epsilon,
    sigma,
    sizes,
    strengths,
    cutoff,
    shift_energy,
    shift_force,
    size,
    strength,
    j,
    itself,
    xi,
    yi,
    zi,
    energy,
    work,
):
    """energy and work with phi and r F of slot j with each particle of the tile."""
    _, _, _, r2 = _separation(packed, sides, j, itself, xi, yi, zi)
    attraction, repulsion = _coefficients(epsilon, sigma, sizes, strengths, size, strength, j)
    q = splat(1.0) / r2
    q3 = q * q * q
    u = q3 * (q3 * repulsion * splat(1 / 12) - attraction * splat(1 / 6))
    w = q3 * (q3 * repulsion - attraction)
    if shift_energy is not None:
        c3 = splat(1.0 / cutoff**6)
        u = u - c3 * (c3 * repulsion * splat(1 / 12) - attraction * splat(1 / 6))
    if shift_force is not None:
        distance = square_root(r2)
        slope = _slope_at_cutoff(attraction, repulsion, cutoff)
        u = u - (distance - splat(cutoff)) * slope
        w = w + distance * slope
    within = r2 < splat(cutoff * cutoff)
    return energy + where(within, u, zeros()), work + where(within, w, zeros())


@njit(cache=True, error_model="numpy")
def tile_energy(  # type: ignore[no-untyped-def]
    neighbours: Neighbours, epsilon, sigma, sizes, strengths, cutoff, shift_energy, shift_force
) -> tuple[float, float]:
    """Potential energy and virial of the pairs, from valid lists; arguments as `tile_accelerations`."""
    packed, tiles, first, entries = neighbours.packed, neighbours.tiles, neighbours.first, neighbours.entries
    sides = neighbours.sides
    dimension = len(sides)
    all_energy = 0.0
    all_work = 0.0
    for tile in range(len(first) - 1):
        base = tile * WIDTH * dimension
        xi = load(tiles, base)
        yi = load(tiles, base + WIDTH)
        zi = load(tiles, base + (dimension - 1) * WIDTH)
        size = _lanes_of(sizes, tile)
        strength = _lanes_of(strengths, tile)
        energy = zeros()
        work = zeros()
        for lane in range(WIDTH):
            energy, work = _add_energy(
                packed,
                sides,
                epsilon,
                sigma,
                sizes,
                strengths,
                cutoff,
                shift_energy,
                shift_force,
                size,
                strength,
                tile * WIDTH + lane,
                float(lane),
                xi,
                yi,
                zi,
                energy,
                work,
            )
        for entry in range(first[tile], first[tile + 1]):
            energy, work = _add_energy(
                packed,
                sides,
                epsilon,
                sigma,
                sizes,
                strengths,
                cutoff,
                shift_energy,
                shift_force,
                size,
                strength,
                np.int64(entries[entry]),
                None,
                xi,
                yi,
                zi,
                energy,
                work,
            )
        all_energy += total(energy)
        all_work += total(work)
    # Each pair was found from both sides.
    return 0.5 * all_energy, 0.5 * all_work


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def between_walls(sides, lengths, r):  # type: ignore[no-untyped-def]
    """True if every particle is strictly between the faces 0 and lengths[k] of each axis k that is not periodic."""
    inside = True
    for k in range(len(sides)):
        if sides[k] == 0:
            for x in r[k :: len(sides)]:
                inside &= 0 < x < lengths[k]
    return inside
