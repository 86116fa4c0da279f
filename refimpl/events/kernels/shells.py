"""Lists of neighbours, each good for as long as its particle stays in its shell.

The list of a particle was made when it was at its centre; it leaves its shell where it is `width` away from there, and
then gets a new one. Centres of a pair that may meet are within its contact range and twice the width, so it is in both
lists; cells, of the centres, are looked at only where a list is made (A. Donev, S. Torquato and F. H. Stillinger, J.
Comput. Phys. 202, 737 (2005); F. Smallenburg, Eur. Phys. J. E 45, 22 (2022)).

Lists change what is looked at, and never a state or the time of a pair's event: the events are those that cells give,
to the last bit. They are for particles without walls and fields: the time of a wall's event is rounded as the clock is
when it was last predicted.
"""

from typing import Any, NamedTuple

import numpy as np

from refimpl.events.kernels.compiled import inline_internal, kernel
from refimpl.events.kernels.memory import prefetch
from refimpl.events.kernels.schedule import CELL, LIST_BUILDS, LIST_TESTS, SPEED, TIME, tick
from refimpl.events.prediction import NEVER, contact_distance, separation

#: Bits of a particle's number in a list; above them, the code of the shift by a period.
NUMBER_BITS = 26
#: The largest number of particles that lists can hold.
MOST = 1 << NUMBER_BITS
_NUMBER = MOST - 1
#: Bits of a particle's number, in the buffer of a prediction; above them, the code.
ID_BITS = 32
ID = (1 << ID_BITS) - 1
#: Codes of the shift: 13 is none, and 26 - code the opposite one.
NO_SHIFT, LAST_SHIFT = 13, 26
#: Share of the width that rounding may hide.
SLACK = 1e-6
#: What became of a new list: there was no room in the cell, or in a list, and nothing has been done; it is there.
NO_CELL, NO_LIST, MADE = range(3)


class Shells(NamedTuple):
    """lists: (N, 1 + slots) int32, a row being the number of neighbours, then those. centres: (N, 3). width: length.

    reach: contact ranges of pairs, in contact distances.
    """

    lists: Any
    centres: Any
    width: float
    reach: float


@inline_internal
def range_of_lists(shells: Any, distance: float) -> float:
    """The distance of two centres within which they are in each other's lists; distance: contact distance."""
    return distance * shells.reach + 2.0 * shells.width


@inline_internal
def leaving_shell(shells: Any, model: Any, rows: Any, i: int, s: float) -> float:
    """Time until the particle, whose state is older than the present by s, leaves its shell."""
    b, c, w = 0.0, 0.0, 0.0
    for k in range(len(model.lengths)):
        v = rows[i, SPEED + k]
        r = rows[i, k] + v * s - shells.centres[i, k]
        b += r * v
        c += r * r
        w += v * v
    width = (1.0 - SLACK) * shells.width
    c = min(c - width * width, 0.0)
    return separation(b, c, w, b * b - w * c) if w > 0.0 else NEVER


@inline_internal
def gather_list(shells: Any, ids: Any, i: int) -> tuple[int, bool]:
    """Puts the neighbours of i into the buffer; how many they are, and whether none is shifted by a period."""
    lists = shells.lists
    held, shifted = lists[i, 0], 0
    for q in range(held):
        entry = lists[i, 1 + q]
        code = entry >> NUMBER_BITS
        shifted |= code ^ NO_SHIFT
        ids[q] = (np.int64(code) << ID_BITS) | (entry & _NUMBER)
    return held, shifted == 0


@inline_internal
def prefetch_list(shells: Any, i: int) -> None:
    """Hints to the processor that the list of i is needed soon."""
    prefetch(shells.lists, i * 4 * shells.lists.shape[1])


@inline_internal
def prefetch_neighbours(shells: Any, rows: Any, i: int) -> None:
    """Hints to the processor that the states of the neighbours of i are needed soon."""
    for q in range(1, shells.lists[i, 0] + 1):
        prefetch(rows, (shells.lists[i, q] & _NUMBER) * 64)


@inline_internal
def drop_from_lists(shells: Any, i: int) -> None:
    """Takes i from the lists of its neighbours, and empties its own."""
    lists = shells.lists
    for q in range(1, lists[i, 0] + 1):
        prefetch_list(shells, lists[i, q] & _NUMBER)
    for q in range(1, lists[i, 0] + 1):
        j = lists[i, q] & _NUMBER
        slot = 1
        while lists[j, slot] & _NUMBER != i:
            slot += 1
        lists[j, slot] = lists[j, lists[j, 0]]
        lists[j, 0] -= 1
    lists[i, 0] = 0


@inline_internal
def put_into_lists(shells: Any, i: int, j: int, code: int) -> None:
    """Two particles are in each other's lists from now on; code: of the shift of j as i sees it."""
    lists = shells.lists
    lists[i, 0] += 1
    lists[i, lists[i, 0]] = (code << NUMBER_BITS) | j
    lists[j, 0] += 1
    lists[j, lists[j, 0]] = ((LAST_SHIFT - code) << NUMBER_BITS) | i


@inline_internal
def find_neighbours(
    shells: Any, model: Any, grid: Any, cells: Any, ids: Any, counts: Any, i: int, place: Any, cell: Any
) -> int:
    """Puts those that are to be in the list of i, with its centre at `place` in `cell`, into the buffer.

    How many they are, or -1 if a list has no room for one more.
    """
    (x, y, z), (cx, cy, cz), (nx, ny, nz) = place, cell, grid.counts
    deep = len(model.lengths) - 2
    lists, centres, shifts = shells.lists, shells.centres, grid.shifts
    found = looked = 0
    for kz in range(cz - deep, cz + deep + 1):
        sz = -1 if kz < 0 else (1 if kz >= nz else 0)
        for ky in range(cy - 1, cy + 2):
            sy = -1 if ky < 0 else (1 if ky >= ny else 0)
            for kx in range(cx - 1, cx + 2):
                sx = -1 if kx < 0 else (1 if kx >= nx else 0)
                code = (sx + 1) + 3 * (sy + 1) + 9 * (sz + 1)
                beyond = (
                    (sx != 0 and not grid.wraps[0])
                    or (sy != 0 and not grid.wraps[1])
                    or (sz != 0 and not grid.wraps[2])
                )
                at = ((kz - sz * nz) * ny + (ky - sy * ny)) * nx + (kx - sx * nx)
                held = 0 if beyond else cells[at, 0]
                looked += held
                for slot in range(1, held + 1):
                    j = cells[at, slot]
                    a = centres[j, 0] - x + shifts[code, 0]
                    b = centres[j, 1] - y + shifts[code, 1]
                    c = centres[j, 2] - z + shifts[code, 2]
                    most = range_of_lists(shells, contact_distance(model.diameter, model.radii, i, j))
                    ids[found] = (np.int64(code) << ID_BITS) | j
                    found += np.int64((a * a + b * b + c * c < most * most) & (j != i))
    tick(counts, LIST_TESTS, looked)
    if found + 1 >= lists.shape[1]:
        return -1
    for q in range(found):
        if lists[ids[q] & ID, 0] + 1 >= lists.shape[1]:
            return -1
    return found


@inline_internal
def renew_list(shells: Any, model: Any, grid: Any, particles: Any, ids: Any, counts: Any, i: int, now: float) -> int:
    """Makes the list of a particle anew, about the place where it is now, which is wrapped into the box; see `MADE`."""
    rows, ints, cells = particles.rows, particles.ints, particles.cells
    s = now - rows[i, TIME]
    place, turns, cell = (0.0, 0.0, 0.0), (0, 0, 0), (0, 0, 0)
    for k in range(len(model.lengths)):
        x = rows[i, k] + rows[i, SPEED + k] * s
        turn = np.int64(np.floor(x / model.lengths[k])) if grid.wraps[k] else np.int64(0)
        x -= turn * model.lengths[k]
        column = min(max(np.int64(np.floor(x / grid.sides[k])), 0), grid.counts[k] - 1)
        if k == 0:
            place, turns, cell = (x, place[1], place[2]), (turn, 0, 0), (column, 0, 0)
        elif k == 1:
            place, turns, cell = (place[0], x, 0.0), (turns[0], turn, 0), (cell[0], column, 0)
        else:
            place, turns, cell = (place[0], place[1], x), (turns[0], turns[1], turn), (cell[0], cell[1], column)
    old = (ints[i, CELL + 2] * grid.counts[1] + ints[i, CELL + 1]) * grid.counts[0] + ints[i, CELL]
    new = (cell[2] * grid.counts[1] + cell[1]) * grid.counts[0] + cell[0]
    if new != old and cells[new, 0] + 1 >= cells.shape[1]:
        return NO_CELL
    found = find_neighbours(shells, model, grid, cells, ids, counts, i, place, cell)
    if found < 0:
        return NO_LIST
    drop_from_lists(shells, i)
    if new != old:
        slot = 1
        while cells[old, slot] != i:
            slot += 1
        cells[old, slot] = cells[old, cells[old, 0]]
        cells[old, 0] -= 1
        cells[new, 0] += 1
        cells[new, cells[new, 0]] = i
    for k in range(len(model.lengths)):
        ints[i, CELL + k] = cell[k]
        shells.centres[i, k] = place[k]
        rows[i, k] -= turns[k] * model.lengths[k]
        particles.images[i, k] += turns[k]
    for q in range(found):
        put_into_lists(shells, i, ids[q] & ID, ids[q] >> ID_BITS)
    tick(counts, LIST_BUILDS, 1)
    return MADE


@kernel
def fill_lists(shells: Any, radii: Any, cell_of: Any, cells: Any, grid: Any) -> bool:
    """Makes the lists of all particles, about their centres, from empty ones; False: a list has no room."""
    lists, centres = shells.lists, shells.centres
    nx, ny, nz = grid.counts
    for i in range(centres.shape[0]):
        for turn in range(27):
            x, y, z = cell_of[i, 0] + turn % 3 - 1, cell_of[i, 1] + turn // 3 % 3 - 1, cell_of[i, 2] + turn // 9 - 1
            sx = -1 if x < 0 else (1 if x >= nx else 0)
            sy = -1 if y < 0 else (1 if y >= ny else 0)
            sz = -1 if z < 0 else (1 if z >= nz else 0)
            if (sx == 0 or grid.wraps[0]) and (sy == 0 or grid.wraps[1]) and (sz == 0 or grid.wraps[2]):
                code = (sx + 1) + 3 * (sy + 1) + 9 * (sz + 1)
                at = ((z - sz * nz) * ny + (y - sy * ny)) * nx + (x - sx * nx)
                for slot in range(1, cells[at, 0] + 1):
                    j = cells[at, slot]
                    if j > i:
                        a = centres[j, 0] - centres[i, 0] + grid.shifts[code, 0]
                        b = centres[j, 1] - centres[i, 1] + grid.shifts[code, 1]
                        c = centres[j, 2] - centres[i, 2] + grid.shifts[code, 2]
                        most = range_of_lists(shells, radii[i] + radii[j])
                        if a * a + b * b + c * c < most * most:
                            if lists[i, 0] + 1 >= lists.shape[1] or lists[j, 0] + 1 >= lists.shape[1]:
                                return False
                            put_into_lists(shells, i, j, code)
    return True
