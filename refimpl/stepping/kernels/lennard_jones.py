"""Sums over the pairs of a Lennard-Jones fluid: one neighbour against a tile of eight particles.

The particles of a tile lie in the lanes of a vector; each slot of the tile's list (`neighbours`, beside this module) is
broadcast to all lanes, and lanes beyond the cutoff are masked. Every pair is computed from both of its sides: that
costs less than adding to the partner's force in memory. The members of a tile are not in its list; a loop of their own
leaves out each particle's force on itself. Threads share the tiles by pieces, and no bit depends on how many there are.

With q = 1/r^2, A = 24 eps sigma^6 and B = 48 eps sigma^12: F/r = q^4 (B q^3 - A), one division and no square root a
pair; r F = q^3 (B q^3 - A) and phi = q^3 (B q^3/12 - A/6). In a mixture A and B are computed pair by pair.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from refimpl.compilation import compiled
from refimpl.stepping.kernels.compiled import at, inline_internal, inline_piece_of_work, internal
from refimpl.stepping.kernels.neighbours import (
    COORDINATES,
    DISTANCES,
    FURTHER,
    KIND,
    RESULT,
    share_of,
    tiles_of,
    work_on_lists,
)
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
from refimpl.team import (
    address,
    begin_round,
    doubles_at,
    join_team,
    next_piece,
    piece_done,
    wait_for_pieces,
    wait_for_round,
)

#: Kinds of work that threads share, beside those on lists.
FORCES, ENERGIES = FURTHER, FURTHER + 1

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
    shared = force.neighbours.shared
    pieces = len(shared.edges) - 1
    _share_out(force, FORCES, pieces + len(shared.shares), r, a)
    tests = 0
    for piece in range(pieces):
        tests += shared.found[piece, DISTANCES]
    return tests


@internal
def _share_out(force, kind, pieces, r, a):  # type: ignore[no-untyped-def]
    """The leader's part of a round, from its beginning until all is done; kind: FORCES or ENERGIES."""
    flags, task = force.neighbours.shared.flags, force.neighbours.shared.task
    task[KIND], task[COORDINATES], task[RESULT] = kind, address(r), address(a)
    begin_round(flags, pieces)
    piece = next_piece(flags)
    while piece >= 0:
        piece = _work(force, kind, piece, r, a)
    wait_for_pieces(flags, pieces)
    task[COORDINATES], task[RESULT] = 0, 0


@inline_piece_of_work
def _work(force, kind, piece, r, a):  # type: ignore[no-untyped-def]
    """Does a piece of a round of the kind FORCES or ENERGIES; returns the next one, or -1."""
    pieces = len(force.neighbours.shared.edges) - 1
    if kind == ENERGIES:
        _energies_of_tiles(force, piece)
    elif piece < pieces:
        _forces_of_tiles(force, piece)
    else:
        wait_for_pieces(force.neighbours.shared.flags, pieces)
        _accelerations_of_share(force, piece - pieces, r, a)
    piece_done(force.neighbours.shared.flags)
    return next_piece(force.neighbours.shared.flags)


@compiled(cache=True, nogil=True)
def serve(force):  # type: ignore[no-untyped-def]
    """A helper's part of all rounds of a `LennardJones` force and its lists, until the team's work ends."""
    shared, number = force.neighbours.shared, force.neighbours.offset.size
    join_team(shared.flags)
    last = 0
    while True:
        last = wait_for_round(shared.flags, last)
        if last == 0:
            return
        piece = next_piece(shared.flags)
        while piece >= 0:
            kind, r = shared.task[KIND], doubles_at(shared.task[COORDINATES], number)
            if kind < FURTHER:
                piece = work_on_lists(force.neighbours, kind, piece, r)
            else:
                piece = _work(force, kind, piece, r, doubles_at(shared.task[RESULT], number))


@inline_piece_of_work
def _forces_of_tiles(force, piece):  # type: ignore[no-untyped-def]
    """Forces on the particles of the tiles of a piece, tile after tile as their coordinates are."""
    neighbours, forces = force.neighbours, force.forces
    packed, tiles, entries = neighbours.packed, neighbours.tiles, neighbours.entries
    first, end, sides = neighbours.first, neighbours.end, neighbours.sides
    dimension, pairs = len(sides), _pairs(force)
    tests = 0
    first_tile, end_tile = tiles_of(neighbours.shared, piece)
    for tile in range(first_tile, end_tile):
        tests += WIDTH * (WIDTH + end[tile] - first[tile])
        members = _tile(tiles, dimension, pairs, tile)
        f = zeros(), zeros(), zeros()
        for lane in range(WIDTH):
            f = _add_force(packed, sides, pairs, members, tile * WIDTH + lane, float(lane), f)
        for entry in range(first[tile], end[tile]):
            f = _add_force(packed, sides, pairs, members, np.int64(entries[at(entry)]), None, f)
        for k in range(dimension):
            store(forces, (tile * dimension + k) * WIDTH, f[k])
    neighbours.shared.found[piece, DISTANCES] = tests


@inline_piece_of_work
def _accelerations_of_share(force, index, r, a):  # type: ignore[no-untyped-def]
    """Accelerations of a share of the particles, from the forces of the tiles and those of the walls."""
    neighbours, forces, mass, masses, walls = force.neighbours, force.forces, force.mass, force.masses, force.walls
    sides, place_of, lengths = neighbours.sides, neighbours.place_of, force.lengths
    dimension = len(sides)
    begin, end = share_of(index, len(place_of), len(neighbours.shared.shares))
    for particle in range(begin, end):
        place = np.int64(place_of[at(particle)])
        for k in range(dimension):
            wall = _wall_force(walls, sides, lengths, k, r[at(particle * dimension + k)])
            accelerated = _divide(forces[at(place + k * WIDTH)] + wall, mass, masses, particle)
            a[at(particle * dimension + k)] = accelerated


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
def tile_energy(force, r):  # type: ignore[no-untyped-def]
    """Potential energy and virial of the pairs of a `LennardJones` force, from lists that are valid for `r`, (N*d,)."""
    _share_out(force, ENERGIES, len(force.neighbours.shared.edges) - 1, r, r)
    energies = force.energies
    all_energy = all_work = 0.0
    for tile in range(len(energies)):
        all_energy += energies[tile, 0]
        all_work += energies[tile, 1]
    # Each pair was found from both sides.
    return 0.5 * all_energy, 0.5 * all_work


@inline_piece_of_work
def _energies_of_tiles(force, piece):  # type: ignore[no-untyped-def]
    """Energy and virial of the pairs of each tile of a piece."""
    neighbours, energies = force.neighbours, force.energies
    packed, tiles, entries = neighbours.packed, neighbours.tiles, neighbours.entries
    first, end, sides = neighbours.first, neighbours.end, neighbours.sides
    dimension, pairs = len(sides), _pairs(force)
    first_tile, end_tile = tiles_of(neighbours.shared, piece)
    for tile in range(first_tile, end_tile):
        members = _tile(tiles, dimension, pairs, tile)
        sums = zeros(), zeros()
        for lane in range(WIDTH):
            sums = _add_energy(packed, sides, pairs, members, tile * WIDTH + lane, float(lane), sums)
        for entry in range(first[tile], end[tile]):
            sums = _add_energy(packed, sides, pairs, members, np.int64(entries[entry]), None, sums)
        energies[tile, 0] = total(sums[0])
        energies[tile, 1] = total(sums[1])


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
