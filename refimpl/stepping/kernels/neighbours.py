"""Verlet lists of particles within a radius of each other, from cells and periodic images, rebuilt by displacement.

A list of the pairs closer than cutoff + skin when it was made holds every pair closer than the cutoff until two
particles together have moved by the skin (Verlet 1967). There are two such lists: a wide one, costly to build and
seldom built, and a close one with a quarter of its skin, picked from the wide one, that the force kernels run through
(dual lists, Pall et al. 2020). `update` renews each as soon as twice the largest displacement could exceed what it
allows.

Particles are sorted along a snaking path through columns of cells; the place of a particle in that order is its
*slot*. Eight consecutive slots form a *tile*: a compact group that shares one list of neighbours, the union of the
lists of its members, so that a force kernel takes one neighbour against eight particles at a time in the lanes of a
vector (cluster lists, Pall & Hess 2013). The list is full: each pair is found from both of its sides, and no force is
scattered. Images of the columns within the list radius of a periodic face follow the particles as further slots, at
positions shifted by multiples of the box side, so that no force kernel needs boundary conditions. A side may be shorter
than the list radius: then a column has images in several shells, and a particle is a neighbour of its own images. Cells
cost O(N) (Yao, Wang, Liu & Cheng 2004).

A particle is lost, and the lists say DIVERGED, where a coordinate is not finite or beyond LOST, or where it has moved
by more than FAR list radii from one update to the next: no time step resolves that. How far from the origin it is does
not matter: what is lost there is the precision of the coordinates that the lists are given, and no more.

Threads share the work (`refimpl.team`), the force kernels' too. Tiles are dealt out in pieces, and the lists of a piece
have a stretch of the entries for themselves; slots, images and particles are dealt out in shares. Pieces and shares
depend on the number of particles alone, and so does every bit.

Literature: L. Verlet, Phys. Rev. 159, 98 (1967); M. P. Allen and D. J. Tildesley, Computer Simulation of Liquids
(1987), sections 5.3.1-5.3.2; Z. Yao, J.-S. Wang, G.-R. Liu and M. Cheng, Comput. Phys. Commun. 161, 27 (2004);
S. Pall and B. Hess, Comput. Phys. Commun. 184, 2641 (2013); S. Pall et al., J. Chem. Phys. 153, 134110 (2020).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, prod
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from refimpl.compilation import compiled
from refimpl.stepping.forces.generic import DIVERGED, GOOD, NEEDS_CAPACITY
from refimpl.stepping.kernels.compiled import at, inline_internal, internal, piece_of_work
from refimpl.stepping.kernels.simd import WIDTH, any_lane, load, load_splat, splat
from refimpl.team import FLAGS, address, begin_round, next_piece, piece_done, wait_for_pieces

#: Indices of `Neighbours.bookkeeping`.
STATUS = 0  # of the last `update`
VALID = 1  # 1 when the wide lists belong to the positions in `built`
BUILDS = 2  # number of builds of the wide lists so far
PRUNES = 3  # number of times that the close lists were picked from them
BLOCKS = 4  # image blocks in use, or needed when there were too few
SLOTS = 5  # slots in use with the images, or needed when there were too few
ENTRIES = 6  # wide list entries in use, or those that there must be if no piece may lack any
TESTS = 7  # distances computed so far to make lists, of a slot from the eight particles of a tile

#: Indices of `Shared.task`: the kind of the round's work; where the coordinates are, and the result of a force.
KIND, COORDINATES, RESULT = 0, 1, 2
#: Kinds of work on lists; other kinds, from FURTHER on, are of the force kernels. Not Python's integers, for each of
#: which numba would compile the functions that get it anew.
PLACE, REFRESH, FILL, PRUNE, FURTHER = np.arange(5)
#: Columns of `Shared.found`: distances computed; entries found; entries that there must be in all for the piece to have
#: room, or 0; and whether a particle has moved so far that the close lists may miss a pair.
DISTANCES, FOUND, LACKED, MOVED = 0, 1, 2, 3

#: Permitted displacements shrink by this factor, and list radii grow by it: rounding must not hide a pair.
SAFE = 1 - 1e-9
#: A particle that moves by more than this many list radii between two updates is lost.
FAR = 1e6
#: A coordinate beyond this, in whatever unit, is lost: volumes, which are cubes of coordinates, would overflow.
LOST = 1e100
#: Wrapped coordinates are at most this share of the box side outside it, by rounding.
OUTSIDE = 1e-6
#: Bound on the rounding of a coordinate, of its place among the cells and of its images, over the largest coordinate.
ROUNDING = 8 * 2.0**-52
#: Position of the slots that fill up the last tile: beyond any cutoff, and its square is still finite.
FILLER_POSITION = 1e150
#: Skin of the close lists over that of the wide ones.
CLOSE = 0.25
#: Largest number of entries of the lists in boxes that are shorter than the list radius: two gigabytes.
MOST_ENTRIES = 2**28
#: Cells along the last axis per column width: fine, as they need not hold a tile.
FINE = 7
#: A piece is this part of the tiles that are left, but so many tiles at least: long ones first, for few are quickly
#: dealt out, and short ones last, so that no thread waits long for another.
PART, LEAST_TILES = 16, 4
#: Particles of a share, at least, and shares at most.
LEAST_SHARE, MOST_SHARES = 512, 16


class Shared(NamedTuple):
    """How threads share the work on N particles.

    flags: of the team. task: (3,), what the round is about, see KIND. edges: the tiles edges[p] ... edges[p + 1] - 1
    are piece p. shares: (S,), the numbers 0 ... S - 1 of the shares. found: a row a piece or share, a cache line each;
    see DISTANCES and the names after it.
    """

    flags: np.ndarray
    task: np.ndarray
    edges: np.ndarray
    shares: np.ndarray
    found: np.ndarray


class Neighbours(NamedTuple):
    """Verlet lists of N particles in d = 2 or 3 dimensions, and the arrays that they are made from.

    sides: box side of each periodic axis, 0 for an open axis. cutoff, skin: the wide lists reach cutoff + skin.
    order: (N,) particle in each slot. place_of: (N,) where the first coordinate of each particle is in tiles.
    offset: (N*d,) what wrapping into the box subtracted from the coordinates.
    built, pruned: (N*d,) wrapped coordinates of the slots when the wide and the close lists were made.
    packed: coordinates of every slot, tile members first and images after, in records of 4 (3D) or 2 (2D).
    tiles: coordinates of the tiles, WIDTH x, then WIDTH y, then WIDTH z each.
    first, end: tile t has the neighbours entries[first[t] : end[t]], slots (the tile's own are left out);
    wide_first, wide_end and wide_entries likewise.
    grid: (3, 7), the cells, see `_Axis`. start, image_offset: slots of the cells and of their images. blocks: (first
    slot, number of slots, first slot of the image) of each run of consecutive slots that has an image, with its
    displacement in block_shift.
    bookkeeping: counters and capacities, see STATUS and the names after it. shared: how threads share the work.
    """

    sides: tuple[float, ...]
    cutoff: float
    skin: float
    order: np.ndarray
    place_of: np.ndarray
    offset: np.ndarray
    built: np.ndarray
    pruned: np.ndarray
    packed: np.ndarray
    tiles: np.ndarray
    first: np.ndarray
    end: np.ndarray
    entries: np.ndarray
    wide_first: np.ndarray
    wide_end: np.ndarray
    wide_entries: np.ndarray
    grid: np.ndarray
    start: np.ndarray
    image_offset: np.ndarray
    blocks: np.ndarray
    block_shift: np.ndarray
    bookkeeping: np.ndarray
    shared: Shared


class _Axis(NamedTuple):
    """Cells along one axis: their number, the lower end of the first, size, 1/size; and how many have images beyond
    either end, in how many shells of boxes; and a bound on the rounding of places."""

    cells: int
    low: float
    width: float
    inverse: float
    around: int
    shells: int
    rounding: float


class _Grid(NamedTuple):
    """Columns (a, b) of cells along c, the last axis; in two dimensions there is one b."""

    a: _Axis
    b: _Axis
    c: _Axis


class TooManyImages(ValueError):
    """A periodic box is so short that its images within the cutoff are too many to be listed."""


def neighbours(number: int, sides: Sequence[float], cutoff: float, skin: float) -> Neighbours:
    """Empty lists for `number` particles; the first `update` fills them.

    sides: box side of each periodic axis, 0 for an open one; cutoff, skin: lengths in the same unit.
    Raises ValueError unless number >= 1, there are 2 or 3 sides, cutoff > 0, skin >= 0 and the sides are finite;
    TooManyImages unless the lists of a box shorter than the list radius have at most MOST_ENTRIES entries.
    """
    dimension = len(sides)
    if number < 1:
        raise ValueError(f"number of particles must be at least 1, got {number}")
    if dimension not in (2, 3):
        raise ValueError(f"there must be 2 or 3 box sides, got {dimension}")
    if not (np.isfinite(cutoff) and cutoff > 0):
        raise ValueError(f"cutoff must be positive and finite, got {cutoff}")
    if not (np.isfinite(skin) and skin >= 0):
        raise ValueError(f"skin must be non-negative and finite, got {skin}")
    reach = float(cutoff + skin)
    if not all(0 <= side < LOST for side in (*sides, reach)):
        raise ValueError(f"box sides and cutoff + skin must lie below {LOST:g}, got {tuple(sides)} and {reach}")
    tiles = -(-number // WIDTH)
    # An estimate for a uniform fluid; where particles cluster, `enlarge_neighbours` enlarges the arrays.
    span = [side if side > 0 else number ** (1 / dimension) * cutoff / 2 for side in sides]
    density = number / prod(span)
    width = (WIDTH / density) ** (1 / dimension)
    grown = prod(side + 2 * (reach + width) if side > 0 else length for side, length in zip(sides, span, strict=True))
    images = 1.2 * (grown * density - number) + 64 if any(sides) else 0.0
    around = (width + 2 * reach) ** dimension if dimension == 2 else 0.85 * (width + 2 * reach) ** dimension
    entries = tiles * min(number + images, 1.2 * density * around + 32)
    if entries > MOST_ENTRIES and any(0 < side < reach for side in sides):
        raise TooManyImages(
            f"a box of sides {tuple(sides)} has {images:.1e} images of particles within cutoff + skin = {reach:g}, "
            f"whose lists need {entries:.1e} entries, the limit is {MOST_ENTRIES:.1e}: shorten the cutoff"
        )
    columns = prod(ceil(length / width) + 2 * ceil(reach / width) + 2 for length in span[:-1])
    blocks = (2 * _shells(reach, sides[-1]) + 1) * columns
    return Neighbours(
        sides=tuple(float(side) for side in sides),
        cutoff=float(cutoff),
        skin=float(skin),
        order=np.zeros(number, dtype=np.uint32),
        place_of=np.zeros(number, dtype=np.uint32),
        offset=np.zeros(number * dimension),
        built=np.zeros(number * dimension),
        pruned=np.zeros(number * dimension),
        packed=np.zeros((tiles * WIDTH + int(images)) * _record(dimension)),
        tiles=np.zeros(tiles * WIDTH * dimension),
        first=np.zeros(tiles, dtype=np.int64),
        end=np.zeros(tiles, dtype=np.int64),
        entries=np.zeros(int(entries), dtype=np.uint32),
        wide_first=np.zeros(tiles, dtype=np.int64),
        wide_end=np.zeros(tiles, dtype=np.int64),
        wide_entries=np.zeros(int(entries), dtype=np.uint32),
        grid=np.zeros((3, len(_Axis._fields))),
        start=np.zeros(number + 65, dtype=np.int64),
        image_offset=np.zeros(blocks, dtype=np.int64),
        blocks=np.zeros(3 * blocks, dtype=np.int64),
        block_shift=np.zeros(3 * blocks),
        bookkeeping=np.zeros(8, dtype=np.int64),
        shared=_shared(number, tiles),
    )


def _shared(number: int, tiles: int) -> Shared:
    edges = [0]
    while edges[-1] < tiles:
        left = tiles - edges[-1]
        edges.append(edges[-1] + min(left, max(left // PART, LEAST_TILES)))
    shares = min(max(number // LEAST_SHARE, 1), MOST_SHARES)
    return Shared(
        flags=np.zeros(FLAGS, dtype=np.int64),
        task=np.zeros(3, dtype=np.int64),
        edges=np.array(edges),
        shares=np.arange(shares),
        found=np.zeros((max(len(edges) - 1, shares), 8), dtype=np.int64),
    )


def enlarge_neighbours(neighbours: Neighbours) -> Neighbours:
    """The same lists, not valid yet, with room for what the last `update` lacked, and a quarter more."""
    dimension = len(neighbours.sides)
    bookkeeping = neighbours.bookkeeping.copy()
    bookkeeping[VALID] = 0
    blocks = max(len(neighbours.blocks) // 3, int(1.25 * bookkeeping[BLOCKS]) + 8)
    slots = max(len(neighbours.packed) // _record(dimension), int(1.25 * bookkeeping[SLOTS]) + 8)
    entries = len(neighbours.entries)
    if bookkeeping[ENTRIES] > entries:
        entries = max(2 * entries, int(1.25 * bookkeeping[ENTRIES]))
    return neighbours._replace(
        packed=np.zeros(slots * _record(dimension)),
        entries=np.zeros(entries, dtype=np.uint32),
        wide_entries=np.zeros(entries, dtype=np.uint32),
        image_offset=np.zeros(blocks, dtype=np.int64),
        blocks=np.zeros(3 * blocks, dtype=np.int64),
        block_shift=np.zeros(3 * blocks),
        bookkeeping=bookkeeping,
    )


@register_jitable
def _shells(reach: float, side: float) -> int:
    """Shells of boxes along an axis that hold images within `reach`; 1 without a period, where they are empty."""
    return max(1, int(np.ceil(reach / side))) if side > 0 else 1


@register_jitable
def _record(dimension: int) -> int:
    """Doubles per slot in `packed`."""
    return 4 if dimension == 3 else 2


@compiled(cache=True)
def update(neighbours: Neighbours, r: np.ndarray) -> int:
    """Moves the slots to the coordinates `r`, shape (N*d,); rebuilds the lists if they might miss a pair.

    Returns GOOD; NEEDS_CAPACITY, when `enlarge_neighbours` has to be called first; or DIVERGED, when a particle is lost
    (see the module). Raises ValueError if r has another number of particles.
    """
    if r.size != neighbours.built.size:
        raise ValueError("r must hold number * dimension coordinates")
    bookkeeping = neighbours.bookkeeping
    bookkeeping[STATUS] = GOOD
    if bookkeeping[VALID] == 1:
        still_close = _refreshed(neighbours, r)
        if still_close:
            return GOOD
        if _moved_less(neighbours, 0.5 * (1 - CLOSE) * neighbours.skin):
            _prune(neighbours, r)
            return GOOD
        bookkeeping[VALID] = 0
        if not _moved_less(neighbours, FAR * (neighbours.cutoff + neighbours.skin)):
            bookkeeping[STATUS] = DIVERGED
            return DIVERGED
    bookkeeping[STATUS] = _build(neighbours, r)
    if bookkeeping[STATUS] == GOOD:
        bookkeeping[VALID] = 1
        _prune(neighbours, r)
    return bookkeeping[STATUS]


@inline_internal
def share_of(index: int, number: int, shares: int) -> tuple[int, int]:
    """The first of `number` things that are in share `index` of so many, and the end of it."""
    return number * index // shares, number * (index + 1) // shares


@inline_internal
def tiles_of(shared: Shared, piece: int) -> tuple[int, int]:
    """The first tile of a piece, and its end."""
    return shared.edges[piece], shared.edges[piece + 1]


@internal
def _share_out(neighbours: Neighbours, kind: int, pieces: int, r: np.ndarray) -> None:
    """The leader's part of a round of work on lists, from its beginning until all is done; kind: PLACE ... PRUNE."""
    flags, task = neighbours.shared.flags, neighbours.shared.task
    task[KIND], task[COORDINATES] = kind, address(r)
    begin_round(flags, pieces)
    piece = next_piece(flags)
    while piece >= 0:
        piece = work_on_lists(neighbours, kind, piece, r)
    wait_for_pieces(flags, pieces)
    task[COORDINATES] = 0


@piece_of_work
def work_on_lists(neighbours: Neighbours, kind: int, piece: int, r: np.ndarray) -> int:
    """Does a piece of a round of the kind PLACE ... PRUNE; returns the next one, or -1."""
    if kind == FILL:
        return _fill_pieces(neighbours, piece)
    if kind == PRUNE:
        _prune_piece(neighbours, piece)
    elif piece >= len(neighbours.shared.shares):
        wait_for_pieces(neighbours.shared.flags, len(neighbours.shared.shares))
        _copy_images(neighbours, piece - len(neighbours.shared.shares))
    elif kind == REFRESH:
        _refresh(neighbours, piece, r)
    else:
        _place(neighbours, piece, r)
    piece_done(neighbours.shared.flags)
    return next_piece(neighbours.shared.flags)


@internal
def _refreshed(neighbours: Neighbours, r: np.ndarray) -> bool:
    """Moves all slots to `r`; False if the close lists may now miss a pair, or a coordinate is not a number."""
    shares = len(neighbours.shared.shares)
    _share_out(neighbours, REFRESH, 2 * shares, r)
    moved = 0
    for index in range(shares):
        moved += neighbours.shared.found[index, MOVED]
    return moved == 0


@piece_of_work
def _refresh(neighbours: Neighbours, index: int, r: np.ndarray) -> None:
    """Coordinates of a share of the sorted particles, and whether one has moved too far for the close lists."""
    order, offset, pruned = neighbours.order, neighbours.offset, neighbours.pruned
    packed, tiles = neighbours.packed, neighbours.tiles
    dimension = len(neighbours.sides)
    record = _record(dimension)
    limit2 = (0.5 * CLOSE * SAFE * neighbours.skin) ** 2
    still = True
    begin, end = share_of(index, len(order), len(neighbours.shared.shares))
    for slot in range(begin, end):
        particle = np.int64(order[at(slot)])
        tile = slot // WIDTH * WIDTH * dimension + slot % WIDTH
        displacement2 = 0.0
        for k in range(dimension):
            x = r[at(particle * dimension + k)] - offset[at(slot * dimension + k)]
            displacement2 += (x - pruned[at(slot * dimension + k)]) ** 2
            packed[at(slot * record + k)] = x
            tiles[at(tile + k * WIDTH)] = x
        still &= displacement2 <= limit2
    neighbours.shared.found[index, MOVED] = not still


@internal
def _moved_less(neighbours: Neighbours, limit: float) -> bool:
    """True if no particle is further than `limit` from where the wide lists were built; False for not-a-number."""
    packed, built = neighbours.packed, neighbours.built
    dimension = len(neighbours.sides)
    record = _record(dimension)
    still = True
    for slot in range(len(neighbours.order)):
        displacement2 = 0.0
        for k in range(dimension):
            displacement2 += (packed[slot * record + k] - built[slot * dimension + k]) ** 2
        still &= displacement2 <= (SAFE * limit) ** 2
    return still


@inline_internal
def _distance2(packed, sides, j, xi, yi, zi):  # type: ignore[no-untyped-def]
    """Squared distances of slot j from the members of a tile; two dimensions leave out zi."""
    record = _record(len(sides))
    dx = xi - load_splat(packed, j * record)
    dy = yi - load_splat(packed, j * record + 1)
    r2 = dx * dx + dy * dy
    if len(sides) == 3:
        dz = zi - load_splat(packed, j * record + 2)
        r2 = r2 + dz * dz
    return r2


@inline_internal
def _list_radius(neighbours: Neighbours, radius: float) -> float:
    """The radius that a list needs so that rounding hides no pair: of displacements, and of the shifts of images."""
    farthest = 0.0
    for side in neighbours.sides:
        farthest = max(farthest, side)
    return radius / SAFE + ROUNDING * (farthest + radius)


@internal
def _prune(neighbours: Neighbours, r: np.ndarray) -> None:
    """Close lists: the entries of the wide ones that are within cutoff + CLOSE * skin of a member of the tile."""
    pieces = len(neighbours.shared.edges) - 1
    _share_out(neighbours, PRUNE, pieces, r)
    neighbours.bookkeeping[PRUNES] += 1
    for piece in range(pieces):
        neighbours.bookkeeping[TESTS] += neighbours.shared.found[piece, DISTANCES]


@piece_of_work
def _prune_piece(neighbours: Neighbours, piece: int) -> None:
    packed, tiles, pruned = neighbours.packed, neighbours.tiles, neighbours.pruned
    first, end, entries = neighbours.first, neighbours.end, neighbours.entries
    wide_first, wide_end, wide_entries = neighbours.wide_first, neighbours.wide_end, neighbours.wide_entries
    dimension = len(neighbours.sides)
    record = _record(dimension)
    reach2 = splat(_list_radius(neighbours, neighbours.cutoff + CLOSE * neighbours.skin) ** 2)
    first_tile, end_tile = tiles_of(neighbours.shared, piece)
    for slot in range(first_tile * WIDTH, min(end_tile * WIDTH, len(neighbours.order))):
        for k in range(dimension):
            pruned[at(slot * dimension + k)] = packed[at(slot * record + k)]
    found = wide_first[first_tile]
    tests = 0
    for tile in range(first_tile, end_tile):
        first[tile] = found
        base = tile * WIDTH * dimension
        xi = load(tiles, base)
        yi = load(tiles, base + WIDTH)
        zi = load(tiles, base + (dimension - 1) * WIDTH)
        tests += wide_end[tile] - wide_first[tile]
        for entry in range(wide_first[tile], wide_end[tile]):
            j = wide_entries[at(entry)]
            entries[at(found)] = j
            found += any_lane(_distance2(packed, neighbours.sides, np.int64(j), xi, yi, zi) < reach2)
        end[tile] = found
    neighbours.shared.found[piece, DISTANCES] = tests


@piece_of_work
def _copy_images(neighbours: Neighbours, index: int) -> None:
    """Coordinates of a share of the images."""
    packed, blocks, block_shift = neighbours.packed, neighbours.blocks, neighbours.block_shift
    dimension = len(neighbours.sides)
    record = _record(dimension)
    begin, end = share_of(index, neighbours.bookkeeping[BLOCKS], len(neighbours.shared.shares))
    for block in range(begin, end):
        source, count, image = blocks[3 * block], blocks[3 * block + 1], blocks[3 * block + 2]
        for i in range(count):
            for k in range(dimension):
                x = packed[at((source + i) * record + k)] + block_shift[3 * block + k]
                packed[at((image + i) * record + k)] = x


@compiled(cache=True)
def copy_to_slots(neighbours: Neighbours, values: np.ndarray, slots: np.ndarray) -> None:
    """Copies the `values` of the particles, shape (N,), to their slots and images; other `slots` keep theirs."""
    for slot in range(len(neighbours.order)):
        slots[slot] = values[neighbours.order[slot]]
    blocks = neighbours.blocks
    for block in range(neighbours.bookkeeping[BLOCKS]):
        source, count, image = blocks[3 * block], blocks[3 * block + 1], blocks[3 * block + 2]
        for i in range(count):
            slots[image + i] = slots[source + i]


@internal
def _build(neighbours: Neighbours, r: np.ndarray) -> int:
    reach = neighbours.cutoff + neighbours.skin
    largest = 0.0
    for x in r:
        if not -LOST <= x <= LOST:
            return DIVERGED
        largest = max(largest, abs(x))
    grid = _choose_grid(neighbours.sides, reach, r, len(neighbours.start) - 1, ROUNDING * largest)
    _keep_grid(neighbours, grid)
    _sort(neighbours, grid, r)
    if not _make_images(neighbours, grid):
        return NEEDS_CAPACITY
    _share_out(neighbours, PLACE, 2 * len(neighbours.shared.shares), r)
    if not _fill_lists(neighbours, r):
        return NEEDS_CAPACITY
    neighbours.bookkeeping[BUILDS] += 1
    return GOOD


@internal
def _choose_grid(sides: tuple[float, ...], reach: float, r: np.ndarray, limit: int, rounding: float) -> _Grid:
    """Columns as wide as a cubic (2D: square) tile is at the mean density, at most `limit` cells in all.

    rounding: a bound on that of the coordinates r.
    """
    dimension = len(sides)
    low_a, extent_a = _extent(sides[0], r, 0, dimension)
    low_b, extent_b = _extent(sides[1], r, 1, dimension)
    low_c, extent_c = low_b, extent_b
    volume = max(extent_a, reach) * max(extent_b, reach)
    if dimension == 3:
        low_c, extent_c = _extent(sides[dimension - 1], r, dimension - 1, dimension)
        volume *= max(extent_c, reach)
    else:
        low_b, extent_b = 0.0, 0.0
    size = (WIDTH * volume / (r.size // dimension)) ** (1 / dimension)
    while True:
        cells_a = max(1.0, np.rint(extent_a / size))
        cells_b = max(1.0, np.rint(extent_b / size))
        cells_c = max(1.0, np.rint(extent_c / size * FINE))
        if cells_a * cells_b * cells_c <= limit:
            break
        size *= 1.2
    return _Grid(
        _axis(cells_a, low_a, extent_a, sides[0], reach, rounding),
        _axis(cells_b, low_b, extent_b, sides[1] if dimension == 3 else 0.0, reach, rounding),
        _axis(cells_c, low_c, extent_c, sides[dimension - 1], reach, rounding),
    )


@internal
def _keep_grid(neighbours: Neighbours, grid: _Grid) -> None:
    """Writes the grid to where helpers find it."""
    for k, axis in enumerate(grid):
        neighbours.grid[k, 0], neighbours.grid[k, 1] = axis.cells, axis.low
        neighbours.grid[k, 2], neighbours.grid[k, 3] = axis.width, axis.inverse
        neighbours.grid[k, 4], neighbours.grid[k, 5], neighbours.grid[k, 6] = axis.around, axis.shells, axis.rounding


@inline_internal
def _kept_axis(row: np.ndarray) -> _Axis:
    return _Axis(int(row[0]), row[1], row[2], row[3], int(row[4]), int(row[5]), row[6])


@internal
def _extent(side: float, r: np.ndarray, k: int, dimension: int) -> tuple[float, float]:
    """Lower end and length of axis k: the box if it is periodic, else what the particles take up."""
    if side > 0:
        return 0.0, side
    low = high = r[k]
    for i in range(k, r.size, dimension):
        low = min(low, r[i])
        high = max(high, r[i])
    return low, high - low


@internal
def _axis(cells: float, low: float, extent: float, side: float, reach: float, rounding: float) -> _Axis:
    inverse = cells / extent if extent > 0 else 0.0
    if side > 0:
        # wrapped coordinates are no further outside than that, see `_offset`
        rounding = min(rounding, 2 * OUTSIDE * side) + ROUNDING * side
    around = np.ceil((reach + 2 * rounding) * inverse) if side > 0 else 0.0
    shells = max(1, int(np.ceil(around / cells)))
    return _Axis(int(cells), low, extent / cells, inverse, int(around), shells, rounding)


@inline_internal
def _column(grid: _Grid, a: int, b: int) -> int:
    """Number of a column along the snaking path: neighbours on the path are neighbours in space."""
    return a * grid.b.cells + (grid.b.cells - 1 - b if a % 2 else b)


@inline_internal
def _slots(grid: _Grid, start: np.ndarray, column: int, low: int, high: int) -> tuple[int, int]:
    """First slot and end of the cells low ... high of a column; odd columns are walked downwards."""
    if column % 2:
        low, high = grid.c.cells - 1 - high, grid.c.cells - 1 - low
    return start[column * grid.c.cells + low], start[column * grid.c.cells + high + 1]


@inline_internal
def _imaged(grid: _Grid, shift_c: int) -> tuple[int, int]:
    """First and last cell of a column that has an image `shift_c` boxes along the column; none if last < first."""
    low = max(0, -shift_c * grid.c.cells - grid.c.around)
    high = min(grid.c.cells - 1, grid.c.around - 1 - (shift_c - 1) * grid.c.cells)
    return low, high


@inline_internal
def _offset(x: float, side: float) -> float:
    """What wrapping into the box subtracts from a coordinate: a whole number of box sides.

    Where rounding is coarser than OUTSIDE box sides, the coordinate itself: no digit says where in the box it is.
    """
    if side > 0:
        offset = side * np.floor(x / side)
        return offset if -OUTSIDE * side <= x - offset <= (1 + OUTSIDE) * side else x
    return 0.0


@inline_internal
def _cell(axis: _Axis, x: float, side: float) -> int:
    cell = int((x - _offset(x, side) - axis.low) * axis.inverse)
    return min(axis.cells - 1, max(0, cell))


@internal
def sort_by_cell(cell_of: np.ndarray, start: np.ndarray, order: np.ndarray) -> None:
    """Counting sort of N things, cell after cell: those of cell c are order[start[c] : start[c + 1]] afterwards.

    cell_of: (N,), the cell of each. start: (cells + 1,) and order: (N,), both written.
    """
    start[:] = 0
    for cell in cell_of:
        start[cell + 1] += 1
    for cell in range(len(start) - 1):
        start[cell + 1] += start[cell]
    for i in range(len(order)):
        order[start[cell_of[i]]] = i
        start[cell_of[i]] += 1
    # Every start has moved on to its cell's end, which is the next cell's start.
    for cell in range(len(start) - 1, 0, -1):
        start[cell] = start[cell - 1]
    start[0] = 0


@internal
def _sort(neighbours: Neighbours, grid: _Grid, r: np.ndarray) -> None:
    """Counting sort of the particles by cell along the snaking path: which one is in which slot."""
    sides, order, place_of, start = neighbours.sides, neighbours.order, neighbours.place_of, neighbours.start
    dimension = len(sides)
    number = len(order)
    cells = grid.a.cells * grid.b.cells * grid.c.cells
    cell_of = np.empty(number, dtype=np.int32)
    for i in range(number):
        a = _cell(grid.a, r[i * dimension], sides[0])
        b = _cell(grid.b, r[i * dimension + 1], sides[1]) if dimension == 3 else 0
        c = _cell(grid.c, r[i * dimension + dimension - 1], sides[dimension - 1])
        column = _column(grid, a, b)
        cell_of[i] = column * grid.c.cells + (grid.c.cells - 1 - c if column % 2 else c)
    sort_by_cell(cell_of, start[: cells + 1], order)
    for slot in range(number):
        place_of[order[slot]] = slot // WIDTH * WIDTH * dimension + slot % WIDTH


@piece_of_work
def _place(neighbours: Neighbours, index: int, r: np.ndarray) -> None:
    """Coordinates of a share of the slots, anew; those that fill up the last tile are of the last one."""
    sides, order, offset, built = neighbours.sides, neighbours.order, neighbours.offset, neighbours.built
    packed, tiles = neighbours.packed, neighbours.tiles
    dimension = len(sides)
    record = _record(dimension)
    number, shares = len(order), len(neighbours.shared.shares)
    begin, end = share_of(index, number, shares)
    for slot in range(begin, end):
        tile = slot // WIDTH * WIDTH * dimension + slot % WIDTH
        for k in range(dimension):
            x = r[at(np.int64(order[at(slot)]) * dimension + k)]
            away = _offset(x, sides[k])
            offset[at(slot * dimension + k)] = away
            built[at(slot * dimension + k)] = x - away
            packed[at(slot * record + k)] = x - away
            tiles[at(tile + k * WIDTH)] = x - away
    if index < shares - 1:
        return
    for slot in range(number, len(tiles) // dimension):
        tile = slot // WIDTH * WIDTH * dimension + slot % WIDTH
        for k in range(dimension):
            # Apart from each other, so that they do not interact either.
            packed[slot * record + k] = FILLER_POSITION * (slot % WIDTH)
            tiles[tile + k * WIDTH] = FILLER_POSITION * (slot % WIDTH)


@inline_internal
def _shift(axis: _Axis, cell: int) -> int:
    """In which box, counted from that of the particles, a cell of the axis lies."""
    return cell // axis.cells if cell < 0 or cell >= axis.cells else 0


@internal
def _make_images(neighbours: Neighbours, grid: _Grid) -> bool:
    """Lists which slots have images, their places and displacements; False if the arrays are too small."""
    sides, start, bookkeeping = neighbours.sides, neighbours.start, neighbours.bookkeeping
    image_offset, blocks, block_shift = neighbours.image_offset, neighbours.blocks, neighbours.block_shift
    dimension = len(sides)
    end = len(neighbours.first) * WIDTH
    block = 0
    columns = (grid.a.cells + 2 * grid.a.around) * (grid.b.cells + 2 * grid.b.around)
    most = (2 * grid.c.shells + 1) * columns
    if most > len(image_offset) or 3 * most > len(blocks):
        bookkeeping[BLOCKS] = most
        return False
    position = 0
    for a in range(-grid.a.around, grid.a.cells + grid.a.around):
        shift_a = _shift(grid.a, a)
        for b in range(-grid.b.around, grid.b.cells + grid.b.around):
            shift_b = _shift(grid.b, b)
            column = _column(grid, a - shift_a * grid.a.cells, b - shift_b * grid.b.cells)
            for shift_c in range(-grid.c.shells, grid.c.shells + 1):
                low, high = _imaged(grid, shift_c)
                image_offset[position] = 0
                if low <= high and not (shift_a == 0 and shift_b == 0 and shift_c == 0):
                    source, source_end = _slots(grid, start, column, low, high)
                    image_offset[position] = end - source
                    blocks[3 * block] = source
                    blocks[3 * block + 1] = source_end - source
                    blocks[3 * block + 2] = end
                    block_shift[3 * block] = shift_a * sides[0]
                    block_shift[3 * block + 1] = shift_b * sides[1]
                    block_shift[3 * block + dimension - 1] = shift_c * sides[dimension - 1]
                    end += source_end - source
                    block += 1
                position += 1
    bookkeeping[BLOCKS] = block
    bookkeeping[SLOTS] = end
    return end * _record(dimension) <= len(neighbours.packed)


@internal
def _fill_lists(neighbours: Neighbours, r: np.ndarray) -> bool:
    """Wide lists: the slots within cutoff + skin of a member of each tile; False if the array is too small."""
    bookkeeping, results, pieces = neighbours.bookkeeping, neighbours.shared.found, len(neighbours.shared.edges) - 1
    _share_out(neighbours, FILL, pieces, r)
    needed = found = 0
    for piece in range(pieces):
        bookkeeping[TESTS] += results[piece, DISTANCES]
        found += results[piece, FOUND]
        needed = max(needed, results[piece, LACKED])
    bookkeeping[ENTRIES] = max(needed, found)
    return needed == 0


@internal
def _fill_pieces(neighbours: Neighbours, piece: int) -> int:
    """Does pieces of FILL as long as there are any; returns one of another kind of work, or -1."""
    shared = neighbours.shared
    runs = np.empty(2 * len(neighbours.image_offset), dtype=np.int64)
    while True:
        _fill_piece(neighbours, piece, runs)
        piece_done(shared.flags)
        piece = next_piece(shared.flags)
        # a helper that is late may get one of a later round
        if piece < 0 or shared.task[KIND] != FILL:
            return piece


@piece_of_work
def _fill_piece(neighbours: Neighbours, piece: int, runs: np.ndarray) -> None:
    packed, tiles, start, grid = neighbours.packed, neighbours.tiles, neighbours.start, neighbours.grid
    first, tile_end, entries = neighbours.wide_first, neighbours.wide_end, neighbours.wide_entries
    image_offset, result = neighbours.image_offset, neighbours.shared.found[piece]
    axes = _Grid(_kept_axis(grid[0]), _kept_axis(grid[1]), _kept_axis(grid[2]))
    dimension = len(neighbours.sides)
    number = len(neighbours.order)
    reach = _list_radius(neighbours, neighbours.cutoff + neighbours.skin)
    reach2 = reach * reach
    first_tile, end_tile = tiles_of(neighbours.shared, piece)
    room = len(entries) // len(first)
    found = first_tile * room
    tests = 0
    result[LACKED] = 0
    for tile in range(first_tile, end_tile):
        first[tile] = found
        base = tile * WIDTH * dimension
        members = min(WIDTH, number - tile * WIDTH)
        count = _runs(axes, tiles, start, image_offset, base, members, dimension, reach, runs)
        xi = load(tiles, base)
        yi = load(tiles, base + WIDTH)
        zi = load(tiles, base + (dimension - 1) * WIDTH)
        for run in range(0, count, 2):
            slot, end = runs[run], runs[run + 1]
            if found + end - slot > end_tile * room:
                needed = found + end - slot - first_tile * room
                # in all, for every tile has the same room
                result[LACKED] = needed * len(first) // (end_tile - first_tile) + len(first)
                return
            tests += end - slot
            # the slots of the tile itself, which one run holds, are left out: what comes before them, and what after
            own = max(slot, min(end, tile * WIDTH))
            for j in range(slot, own):
                entries[at(found)] = j
                found += any_lane(_distance2(packed, neighbours.sides, j, xi, yi, zi) < splat(reach2))
            for j in range(max(own, min(end, tile * WIDTH + WIDTH)), end):
                entries[at(found)] = j
                found += any_lane(_distance2(packed, neighbours.sides, j, xi, yi, zi) < splat(reach2))
        tile_end[tile] = found
    result[DISTANCES] = tests
    result[FOUND] = found - first_tile * room


@inline_internal
def _runs(grid, tiles, start, image_offset, base, members, dimension, reach, runs):  # type: ignore[no-untyped-def]
    """Runs of slots that a tile may reach, one in each column or image of a column; returns twice their number.

    runs: gets the first slot and the end of each.
    """
    a_low, a_high, a_from, a_to = _range(grid.a, tiles, base, members, reach)
    b_low, b_high, b_from, b_to = _range(grid.b, tiles, base + WIDTH, members, reach)
    if dimension == 2:
        b_low, b_high, b_from, b_to = 0.0, 0.0, 0, 0
    c_low, c_high, _, _ = _range(grid.c, tiles, base + (dimension - 1) * WIDTH, members, reach)
    columns_b = grid.b.cells + 2 * grid.b.around
    count = 0
    for a in range(a_from, a_to + 1):
        shift_a = _shift(grid.a, a)
        left_a = reach * reach - _gap(grid.a, a, a_low, a_high) ** 2
        for b in range(b_from, b_to + 1):
            shift_b = _shift(grid.b, b)
            left2 = left_a - _gap(grid.b, b, b_low, b_high) ** 2
            left = np.sqrt(max(left2, 0.0)) + grid.c.rounding
            c_from = int(np.floor((c_low - left - grid.c.low) * grid.c.inverse))
            c_to = int(np.floor((c_high + left - grid.c.low) * grid.c.inverse))
            column = _column(grid, a - shift_a * grid.a.cells, b - shift_b * grid.b.cells)
            position = ((a + grid.a.around) * columns_b + b + grid.b.around) * (2 * grid.c.shells + 1)
            first_shift = -grid.c.shells if c_from < 0 else 0
            last_shift = grid.c.shells if c_to >= grid.c.cells else 0
            for shift_c in range(first_shift, last_shift + 1):
                low, high = _imaged(grid, shift_c)
                low = max(low, c_from - shift_c * grid.c.cells)
                high = min(high, c_to - shift_c * grid.c.cells)
                # no branch: which columns are out of reach cannot be foretold
                wanted = (low <= high) & (left2 > 0)
                low, high = min(low, grid.c.cells - 1), max(high, 0)
                slot, end = _slots(grid, start, column, low, high)
                offset = image_offset[position + shift_c + grid.c.shells]
                runs[count] = slot + offset
                runs[count + 1] = end + offset
                count += 2 * wanted
    return count


@inline_internal
def _range(axis: _Axis, tiles: np.ndarray, base: int, members: int, reach: float) -> tuple[float, float, int, int]:
    """Extent of a tile along an axis, and the range of the cells, images included, within `reach` of it."""
    low = high = tiles[base]
    for lane in range(1, members):
        low = min(low, tiles[base + lane])
        high = max(high, tiles[base + lane])
    reach += axis.rounding
    cell_from = int(np.floor((low - reach - axis.low) * axis.inverse))
    cell_to = int(np.floor((high + reach - axis.low) * axis.inverse))
    return low, high, max(-axis.around, cell_from), min(axis.cells - 1 + axis.around, cell_to)


@inline_internal
def _gap(axis: _Axis, cell: int, low: float, high: float) -> float:
    """Distance between a cell and the interval low ... high, less the rounding of places."""
    cell_low = axis.low + cell * axis.width
    return max(0.0, cell_low - high - axis.rounding, low - cell_low - axis.width - axis.rounding)
