"""Pairs of grains that touch or are about to: two Verlet lists, made from cells, and the stretches of their contacts.

A list of the pairs whose surfaces were nearer than `skin` when it was made is good until a grain has moved by skin/2
(Verlet 1967). There are two: a wide one, made from cells as wide as the largest diameter and the skin in O(N), and a
close one with a tenth of its skin, picked from the wide one, that the forces run through (dual lists, Pall et al.
2020). A pair has the grain of the smaller number first, whatever list it is in: so its stretch keeps its sign.

What lasts from one evaluation to the next are the contacts: the pairs that touched, in the order of the close list,
with the stretches of their tangential springs.

A grain is lost as in `refimpl.stepping.kernels.neighbours`, with the largest diameter and the skin as the list radius.

Literature: L. Verlet, Phys. Rev. 159, 98 (1967); S. Pall et al., J. Chem. Phys. 153, 134110 (2020).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from refimpl.stepping.forces.generic import DIVERGED, GOOD, NEEDS_CAPACITY
from refimpl.stepping.kernels.compiled import inline_internal, internal
from refimpl.stepping.kernels.neighbours import FAR, LOST, ROUNDING, SAFE, sort_by_cell

#: Places of the numbers in the bookkeeping of the lists: outcome of the last evaluation; 1 when the wide list is good
#: for the positions `built`; pairs in it, and in the close one; contacts of the last evaluation; pairs for which there
#: was no room; so far, wide lists made, close ones picked, and distances computed for both; and evaluations of all
#: forces, and distances of pairs computed by them.
STATUS, LISTED, PAIRS, CLOSE_PAIRS, CONTACTS, NEEDED, BUILDS, PRUNES, LIST_TESTS, EVALUATIONS, PAIR_TESTS = range(11)
#: Skin of the close list over that of the wide one.
CLOSE = 0.1


class ContactLists(NamedTuple):
    """The lists of N grains in d dimensions; make them with `contact_lists`.

    sides: box side of each periodic axis, 0 for others. radii: (N,). skin: of the wide list. built, pruned: (N*d,),
    positions for which the wide and the close list were made. pairs, close: (P, 2), the grains of the pairs of the two
    lists; the last row is never used. reach2: (P,), squared contact distances of the close pairs. places: (2, P), where
    in the close list the contacts are; ends, stretches: (2, P, 2) and (2, P, 3), their grains, and the stretches of
    rough ones: the row EVALUATIONS % 2 is that of the last evaluation. bookkeeping: see STATUS.
    """

    sides: tuple[float, ...]
    radii: np.ndarray
    skin: float
    built: np.ndarray
    pruned: np.ndarray
    pairs: np.ndarray
    close: np.ndarray
    reach2: np.ndarray
    places: np.ndarray
    ends: np.ndarray
    stretches: np.ndarray
    bookkeeping: np.ndarray


def contact_lists(sides: tuple[float, ...], radii: np.ndarray, skin: float, rough: bool) -> ContactLists:
    """Lists without a pair, of as many pairs as there are grains; rough: whether contacts have stretches."""
    number = len(radii)
    return ContactLists(
        sides=sides,
        radii=radii,
        skin=skin,
        built=np.zeros(number * len(sides)),
        pruned=np.zeros(number * len(sides)),
        **_room(number, rough),
        bookkeeping=np.zeros(11, dtype=np.int64),
    )


def _room(pairs: int, rough: bool) -> dict[str, np.ndarray]:
    """The arrays that hold so many pairs."""
    rows, remembered = pairs + 1, (pairs + 1) * rough
    return {
        "pairs": np.zeros((rows, 2), dtype=np.uint32),
        "close": np.zeros((rows, 2), dtype=np.uint32),
        "reach2": np.zeros(rows),
        "places": np.zeros((2, rows), dtype=np.uint32),
        "ends": np.zeros((2, remembered, 2), dtype=np.uint32),
        "stretches": np.zeros((2, remembered, 3)),
    }


def enlarge_lists(lists: ContactLists) -> ContactLists:
    """The same lists with room for the pairs that were found, and a quarter more."""
    contacts = lists.bookkeeping[CONTACTS]
    larger = _room(int(1.25 * lists.bookkeeping[NEEDED]) + 1, lists.stretches.size > 0)
    # contacts are kept, the lists are made anew; the smaller ones may be used again, and share no array with these
    for name in ("ends", "stretches"):
        larger[name][:, :contacts] = getattr(lists, name)[:, :contacts]
    own = {name: getattr(lists, name).copy() for name in ("bookkeeping", "built", "pruned")}
    return lists._replace(**larger, **own)


# -- distances ---------------------------------------------------------------------------------------------------------


@inline_internal
def inverses(sides):  # type: ignore[no-untyped-def]
    """1/side along x, y and z, and 0 along axes without a period, and along z in the plane."""
    x = 1.0 / sides[0] if sides[0] > 0.0 else 0.0
    y = 1.0 / sides[1] if sides[1] > 0.0 else 0.0
    z = 1.0 / sides[len(sides) - 1] if len(sides) == 3 and sides[len(sides) - 1] > 0.0 else 0.0
    return x, y, z


@inline_internal
def separation(sides, per_side, r, i, j):  # type: ignore[no-untyped-def]
    """Vector from grain j to the nearest image of grain i, (x, y, z), z = 0 in the plane.

    per_side: `inverses` of the sides. i, j: places in r, of whatever type that is not negative.
    """
    d = len(sides)
    i, j = np.int64(i), np.int64(j)
    x, y, z = r[d * i] - r[d * j], r[d * i + 1] - r[d * j + 1], 0.0
    x -= sides[0] * np.rint(x * per_side[0])
    y -= sides[1] * np.rint(y * per_side[1])
    if d == 3:
        z = r[d * i + 2] - r[d * j + 2]
        z -= sides[d - 1] * np.rint(z * per_side[2])
    return x, y, z


@inline_internal
def apart2(sides, per_side, r, i, j):  # type: ignore[no-untyped-def]
    """Squared distance of the nearest images of grains i and j; arguments as of `separation`."""
    x, y, z = separation(sides, per_side, r, i, j)
    return x * x + y * y + z * z


@internal
def _list_radius(radii, skin):  # type: ignore[no-untyped-def]
    """The largest diameter and the skin: no pair of a list is further apart."""
    largest = 0.0
    for radius in radii:
        largest = max(largest, radius)
    return 2.0 * largest + skin


@internal
def _has_moved(r, before, dimension, skin):  # type: ignore[no-untyped-def]
    """True if a grain is further than skin/2 from where it was `before`, or its place is not a number."""
    limit2 = (0.5 * SAFE * skin) ** 2
    still = True
    for first in range(0, len(before), dimension):
        square = 0.0
        for k in range(dimension):
            square += (r[first + k] - before[first + k]) ** 2
        still &= square <= limit2
    return not still


# -- the wide list -----------------------------------------------------------------------------------------------------


@internal
def _near(cells, place, around, near):  # type: ignore[no-untyped-def]
    """Every cell next to `place` along an axis, and that one, once; returns how many. near: gets them in order."""
    count = 0
    for step in range(-1, 2):
        c = place + step
        if around:
            # a periodic axis may have fewer than three
            if (step == -1 and cells < 3) or (step == 1 and cells < 2):
                continue
            c %= cells
        elif c < 0 or c >= cells:
            continue
        near[count] = c
        count += 1
    return count


@internal
def _grid(lists, r):  # type: ignore[no-untyped-def]
    """Cells no smaller than a list reaches: low end, width and number along x, y and z; no axis: one of them."""
    sides, number = lists.sides, len(lists.radii)
    d = len(sides)
    farthest = 0.0
    for k in range(d * number):
        farthest = max(farthest, abs(r[k]))
    reach = _list_radius(lists.radii, lists.skin) / SAFE + ROUNDING * farthest
    low, width, cells = np.zeros(3), np.ones(3), np.ones(3, dtype=np.int64)
    for k in range(d):
        extent = sides[k]
        if extent == 0.0:
            low[k] = high = r[k]
            for i in range(number):
                low[k], high = min(low[k], r[d * i + k]), max(high, r[d * i + k])
            extent = high - low[k]
        # no more cells than grains along an axis: empty ones cost too
        cells[k] = max(1, int(min(number, extent / reach)))
        width[k] = extent / cells[k] if extent > 0.0 else 1.0
    while cells[0] * cells[1] * cells[2] > 8 * number:
        longest = 0
        for k in range(1, d):
            longest = k if cells[k] > cells[longest] else longest
        width[longest] *= cells[longest] / (cells[longest] // 2)
        cells[longest] //= 2
    return low, width, cells


@internal
def _sort(sides, r, low, width, cells, order):  # type: ignore[no-untyped-def]
    """Counting sort of the grains by cell: writes their numbers to `order`; returns where each cell begins in it."""
    d, number = len(sides), len(order)
    start, cell_of = np.empty(cells[0] * cells[1] * cells[2] + 1, dtype=np.int64), np.empty(number, dtype=np.int64)
    for i in range(number):
        cell = 0
        for k in range(3):
            place = 0
            if k < d:
                x = np.floor((r[d * i + k] - low[k]) / width[k])
                if sides[min(k, d - 1)] > 0.0:
                    x -= cells[k] * np.floor(x / cells[k])
                place = int(min(max(x, 0.0), cells[k] - 1.0))
            cell = cell * cells[k] + place
        cell_of[i] = cell
    sort_by_cell(cell_of, start, order)
    return start


@internal
def _runs(cells, start, near, counts, runs):  # type: ignore[no-untyped-def]
    """Runs of grains in the cells `near`, (3, 3), of which `counts` along each axis; returns how many.

    runs: gets the first and the end of each, places in the order of the cells.
    """
    count = 0
    for x in range(counts[0]):
        for y in range(counts[1]):
            for z in range(counts[2]):
                cell = (near[0, x] * cells[1] + near[1, y]) * cells[2] + near[2, z]
                if count > 0 and runs[count - 1, 1] == start[cell]:
                    runs[count - 1, 1] = start[cell + 1]
                else:
                    runs[count, 0], runs[count, 1] = start[cell], start[cell + 1]
                    count += 1
    return count


@internal
def _find_pairs(lists, r):  # type: ignore[no-untyped-def]
    """Number of pairs with surfaces nearer than skin, and, as far as there is room, the pairs."""
    sides, radii, skin, pairs = lists.sides, lists.radii, lists.skin, lists.pairs
    d, number, per_side = len(sides), len(radii), inverses(sides)
    low, width, cells = _grid(lists, r)
    order = np.empty(number, dtype=np.uint32)
    start = _sort(sides, r, low, width, cells, order)
    sorted_r, sorted_radii = np.empty(d * number), np.empty(number)
    for rank in range(number):
        sorted_radii[rank] = radii[order[rank]]
        for k in range(d):
            sorted_r[d * rank + k] = r[d * np.int64(order[rank]) + k]
    near, counts = np.empty((3, 3), dtype=np.int64), np.ones(3, dtype=np.int64)
    runs = np.empty((27, 2), dtype=np.int64)
    room, found, tests = len(pairs) - 1, 0, 0
    for cell in range(len(start) - 1):
        if start[cell] == start[cell + 1]:
            continue
        column = cell // cells[2]
        counts[0] = _near(cells[0], column // cells[1], sides[0] > 0.0, near[0])
        counts[1] = _near(cells[1], column % cells[1], sides[1] > 0.0, near[1])
        counts[2] = _near(cells[2], cell % cells[2], d == 3 and sides[d - 1] > 0.0, near[2])
        count = _runs(cells, start, near, counts, runs)
        for rank in range(start[cell], start[cell + 1]):
            for run in range(count):
                # each pair once: from the one that comes first in the order of the cells
                first = max(runs[run, 0], rank + 1)
                tests += max(0, runs[run, 1] - first)
                for other in range(first, runs[run, 1]):
                    reach = (sorted_radii[rank] + sorted_radii[other] + skin) / SAFE
                    row = min(found, room)
                    pairs[row, 0], pairs[row, 1] = min(order[rank], order[other]), max(order[rank], order[other])
                    found += apart2(sides, per_side, sorted_r, rank, other) < reach**2
    lists.bookkeeping[LIST_TESTS] += tests
    return found


@internal
def _make_list(lists, r):  # type: ignore[no-untyped-def]
    """A new wide list for the positions r."""
    built, bookkeeping = lists.built, lists.bookkeeping
    for k in range(len(built)):
        if not -LOST <= r[k] <= LOST:
            return DIVERGED
    found = _find_pairs(lists, r)
    if found >= len(lists.pairs):
        bookkeeping[NEEDED] = found
        return NEEDS_CAPACITY
    bookkeeping[PAIRS] = found
    for k in range(len(built)):
        built[k] = r[k]
    bookkeeping[BUILDS] += 1
    return GOOD


# -- the close list, and the contacts ----------------------------------------------------------------------------------


@internal
def _prune(lists, r):  # type: ignore[no-untyped-def]
    """The close list: the pairs of the wide one whose surfaces are nearer than CLOSE * skin."""
    sides, radii, skin, bookkeeping = lists.sides, lists.radii, lists.skin, lists.bookkeeping
    pairs, close, reach2, per_side = lists.pairs, lists.close, lists.reach2, inverses(sides)
    found = 0
    for pair in range(bookkeeping[PAIRS]):
        i, j = pairs[pair, 0], pairs[pair, 1]
        touch = radii[i] + radii[j]
        close[found, 0], close[found, 1] = i, j
        reach2[found] = touch * touch
        found += apart2(sides, per_side, r, i, j) < ((touch + CLOSE * skin) / SAFE) ** 2
    for k in range(len(lists.pruned)):
        lists.pruned[k] = r[k]
    bookkeeping[CLOSE_PAIRS] = found
    bookkeeping[LIST_TESTS] += bookkeeping[PAIRS]
    bookkeeping[PRUNES] += 1


@inline_internal
def _copy_contact(ends, stretches, contact, new_ends, new_stretches, new):  # type: ignore[no-untyped-def]
    new_ends[new, 0], new_ends[new, 1] = ends[contact, 0], ends[contact, 1]
    for k in range(3):
        new_stretches[new, k] = stretches[contact, k]


@internal
def _place_contacts(lists):  # type: ignore[no-untyped-def]
    """Finds the contacts of the last evaluation in a new close list; those that are not in it are over."""
    bookkeeping, close, now = lists.bookkeeping, lists.close, lists.bookkeeping[EVALUATIONS] % 2
    places, ends, stretches = lists.places[now], lists.ends[now], lists.stretches[now]
    # a chain from the first grain of each; numbers from 1, 0 ends it
    held, found = bookkeeping[CONTACTS], 0
    head, following = np.zeros(len(lists.radii), dtype=np.int64), np.zeros(held, dtype=np.int64)
    kept_ends, kept = np.empty((held, 2), dtype=np.uint32), np.empty((held, 3))
    for contact in range(held):
        _copy_contact(ends, stretches, contact, kept_ends, kept, contact)
        following[contact], head[ends[contact, 0]] = head[ends[contact, 0]], contact + 1
    for pair in range(bookkeeping[CLOSE_PAIRS]):
        contact = head[close[pair, 0]] - 1
        while contact >= 0:
            if kept_ends[contact, 1] == close[pair, 1]:
                places[found] = pair
                _copy_contact(kept_ends, kept, contact, ends, stretches, found)
                found += 1
            contact = following[contact] - 1
    bookkeeping[CONTACTS] = found


@internal
def find_contacts(lists, r, places):  # type: ignore[no-untyped-def]
    """Number of pairs of the close list that touch at r; their places in it go to `places`, (P,), in order."""
    sides, close, reach2 = lists.sides, lists.close, lists.reach2
    per_side, found = inverses(sides), 0
    for pair in range(lists.bookkeeping[CLOSE_PAIRS]):
        places[found] = pair
        found += apart2(sides, per_side, r, close[pair, 0], close[pair, 1]) < reach2[pair]
    return found


@internal
def update(lists, r):  # type: ignore[no-untyped-def]
    """Makes the lists anew where they may miss a contact at r; False, with the reason in STATUS, if it cannot."""
    bookkeeping = lists.bookkeeping
    bookkeeping[STATUS] = GOOD
    d, skin, listed = len(lists.sides), lists.skin, bookkeeping[LISTED]
    if listed == 1 and not _has_moved(r, lists.pruned, d, CLOSE * skin):
        return True
    if listed == 0 or _has_moved(r, lists.built, d, (1.0 - CLOSE) * skin):
        bookkeeping[LISTED] = 0
        lost = listed == 1 and _has_moved(r, lists.built, d, 2.0 * FAR * _list_radius(lists.radii, skin))
        bookkeeping[STATUS] = DIVERGED if lost else _make_list(lists, r)
        if bookkeeping[STATUS] != GOOD:
            return False
        bookkeeping[LISTED] = 1
    _prune(lists, r)
    if lists.stretches.size > 0:
        _place_contacts(lists)
    return True
