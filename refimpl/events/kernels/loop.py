"""The event loop: cells, asynchronous clocks, prediction, and the rules at each event.

rows (N, 8): x 0-2, v 3-5 and own time 6 of the last change of state, time of the next pair event 7: one cache line.
ints (N, 8): partner, its count at the prediction, own count of changes of state, cell 3-5, kind of the own event 6, and
7: twice the number of events in a row at one instant, plus 1 if the last was at a wall; -1 where the time of the state
is not that of an event. own (N,): time of the next event of the particle alone: a wall, a face of its cell, the edge of
its shell. Counts of changes are modulo 2^32: all that is asked is whether two are equal, of which one is the other some
changes ago, and never 2^32 of them: predictions end when the clock is renewed.

The time of a pair's event is computed from the two states at the later of their own times. It is thus a function of
these states alone, and the same to the last bit from whichever particle and whenever it is computed: every scheduler
gives the same events, with cells and with lists of neighbours (`shells`). For this a shift by a period must be exact:
positions are multiples of `Grid.quantum`, and the state of a particle that has flown over one side of the box is taken
anew, at a time that depends on that state alone (`_flight_over_box`).
"""

from typing import Any, NamedTuple

import numpy as np

from refimpl.compilation import INTERPRETED
from refimpl.events.kernels.compiled import inline_internal, kernel
from refimpl.events.kernels.lanes import (
    WIDTH,
    bits_of,
    columns,
    elements,
    least,
    lowest_bit,
    splat,
    square_root,
    where,
)
from refimpl.events.kernels.lanes import store as store_lanes
from refimpl.events.kernels.measure import (
    note_crossing,
    note_cylinder,
    note_pair_after,
    note_pair_before,
    note_wall_after,
    note_wall_before,
    note_well,
)
from refimpl.events.kernels.memory import prefetch
from refimpl.events.kernels.schedule import (
    CELL,
    COUNT,
    CROSSINGS,
    FIRST_NODE,
    INVALID,
    NEXT,
    OWN,
    PARTNER,
    PARTNER_COUNT,
    PREDICTIONS,
    RENEWALS,
    SPEED,
    STREAK,
    TIME,
    WALL_EVENTS,
    add,
    drop_events,
    first,
    has_room,
    keeps_all,
    pop,
    prefetch_entry,
    rival,
    tick,
    update,
)
from refimpl.events.kernels.shells import (
    ID,
    ID_BITS,
    NO_CELL,
    NO_LIST,
    NO_SHIFT,
    gather_list,
    leaving_shell,
    prefetch_list,
    prefetch_neighbours,
    renew_list,
)
from refimpl.events.model import AMPLITUDE, OSCILLATING, Vector
from refimpl.events.prediction import (
    FAR,
    NEVER,
    contact_distance,
    cylinder_time,
    drift,
    falling_time,
    field_along,
    nearest,
    pair_time,
    radius_of,
    resting_flight,
    rests,
    speed_after,
    squared_moment,
    wall_time,
)
from refimpl.events.rules import (
    apply_impulse,
    at_cylinder,
    at_edge,
    at_plane,
    is_fixed,
    normal_restitution,
    pair_impulse,
    pass_edge,
    still_in_contact,
)

#: Why the loop returned.
REACHED, COUNTED, PAUSED, CELL_FULL, LISTS_FULL, STORE_FULL, BONDS_FULL, COLLAPSED, TRACE_FULL, GOING_ON = range(10)
#: Kinds of own events: below `SHELL` cell faces (2 axis + side); the edge of the shell; `WALL` + face; the cylinder;
#: all events of the particle are to be predicted; its state is to be taken anew.
SHELL, WALL, CYLINDER, REPREDICT, RENEW = 6, 8, 16, 17, 18
#: Relative rounding of the two terms of a discriminant, generously: such pairs are looked at again, more precisely.
SLACK = 1.0 + 2.0**-48
#: More than COLLAPSE collisions of a particle in a row at one instant are an inelastic collapse; so are more than two
#: whose relative normal velocity, squared, is below VANISHED times the squared velocities.
COLLAPSE, VANISHED = 100, (2.0**-38) ** 2
#: STREAK: the number of events in a row at one instant, and below it, in so many bits, who the last one was with: a
#: wall, or a particle. Of more particles than that, two may have the same number, and a tie with both is not counted.
_PARTNER_BITS, _WALL = 24, 0
_PARTNERS = (1 << _PARTNER_BITS) - 1
#: Fewer particles than this are in the caches anyway. AHEAD: of so many the earliest is guessed to be next.
FEW, AHEAD = 2048, 4
#: More cells than this do not fit into the first two caches.
MANY = 1 << 14
#: Entries of `progress`; UNPREDICTED: the first particle whose events have not been predicted yet.
PAIRS, EVENTS, INTERACTIONS, FIRST, SECOND, UNPREDICTED = range(6)


class Grid(NamedTuple):
    """counts, sides, overlaps, wraps: of the cells along three axes. shifts: (27, 8) periods, along three axes.
    quantum: of positions.

    near: |r^2 - s^2|/s^2 that rounding may hide.

    A particle changes its cell only `overlaps` beyond the edge, so that it does not change it back at once; two
    particles that are not in neighbouring cells are still further apart than the contact range.
    """

    counts: Any
    sides: Any
    overlaps: Any
    wraps: Any
    shifts: Any
    quantum: float
    near: float


class Particles(NamedTuple):
    """rows, ints, own as above. images: (N, 3) periods left behind. cells: (number, 1 + slots). spins: (N, 3) | None.

    bonds: (N, 1 + slots) partners inside the well | None. hits: (N,) collisions with walls, of random walls | None.
    last: (N,) times of the last collisions, for the TC model | None. shells: lists of neighbours | None: cells alone.
    """

    rows: Any
    ints: Any
    own: Any
    images: Any
    cells: Any
    spins: Any
    bonds: Any
    hits: Any
    last: Any
    shells: Any


class Trace(NamedTuple):
    """Changes of state in order: time (length,), pairs (length, 2): i, and j or -1 - face; filled: (1,).

    after: (length, 2, 9) positions, not wrapped into the box, velocities and spins of both after the event; 0 of a
    wall.
    """

    time: Any
    pairs: Any
    filled: Any
    after: Any


class Measured(NamedTuple):
    """What is recorded during a run; each but the last may be None. counts: (6,) operations.

    simultaneous: (2,) number of events that share a particle with another one of the same time, time of the first.
    """

    tallies: Any
    fields: Any
    counts: Any
    trace: Any
    simultaneous: Any


class Limits(NamedTuple):
    """Where a run ends: a time, or a number of pair collisions since the start. Beyond `renewal` the clock is renewed.

    instant: two collisions of a particle that are nearer in time count as one instant, for a collapse. resolution:
    two events nearer in time than this are simultaneous but for rounding.
    """

    until: float
    renewal: float
    instant: float
    resolution: float
    collisions: int


class Scratch(NamedTuple):
    """Buffers of one prediction: ids (slots,), with the code of the shift in the upper half; numbers (4, slots)."""

    ids: Any
    numbers: Any


# -- relative motion -------------------------------------------------------------------------------


@inline_internal
def _relative_position(gap: float, vi: float, vj: float, s: float, acceleration: Any, k: int) -> float:
    """r_j - r_i when the later of the two states was taken; s = tau_i - tau_j: the earlier one flies on for |s|."""
    if acceleration is None:
        return gap + (vj * max(s, 0.0) + vi * min(s, 0.0))
    return gap + (vj * max(s, 0.0) + vi * min(s, 0.0)) + 0.5 * acceleration[k] * (s * abs(s))


@inline_internal
def _relative_speed(vi: float, vj: float, s: float, acceleration: Any, k: int) -> float:
    if acceleration is None:
        return vj - vi
    return (vj - vi) + acceleration[k] * s


@inline_internal
def _quantised(x: float, quantum: float) -> float:
    big = 6755399441055744.0 * quantum  # 1.5 2^52
    return (x + big) - big


@inline_internal
def _advance_to_now(model: Any, grid: Any, rows: Any, i: int, now: float) -> None:
    """Moves a particle's state to the time `now`; by a path that is rounded, so that a shift by a period is exact."""
    s = now - rows[i, TIME]
    for k in range(len(model.lengths)):
        rows[i, k] += _quantised(drift(0.0, rows[i, SPEED + k], model.acceleration, k, s), grid.quantum)
        rows[i, SPEED + k] = speed_after(rows[i, SPEED + k], model.acceleration, k, s)
    rows[i, TIME] = now


@inline_internal
def _flight_over_box(model: Any, grid: Any, rows: Any, i: int, end: float) -> float:
    """When the particle has flown over a side of the box since its state, if that is before `end`; else `NEVER`.

    Its state is then taken anew: without this, distances would be rounded as the length of a free path is, however
    small the box. The time is a function of the state alone.
    """
    due, s = NEVER, end - rows[i, TIME]
    for k in range(len(model.lengths)):
        v, a = abs(rows[i, SPEED + k]), abs(field_along(model.acceleration, k))
        if grid.wraps[k] and s * (v + 0.5 * a * s) >= model.lengths[k]:
            due = min(due, rows[i, TIME] + falling_time(model.lengths[k], -v, -a))
    return due if due < end else NEVER


@inline_internal
def _moment_of_pair(model: Any, grid: Any, rows: Any, i: int, j: int, code: int) -> float:
    """|r x v|^2 of a pair at the later of its two states; code: of the shift by a period, 13 for none."""
    s = rows[i, TIME] - rows[j, TIME]
    x, u = _relative_motion(model, grid, rows, i, j, code, s, 0)
    y, v = _relative_motion(model, grid, rows, i, j, code, s, 1)
    z, w = 0.0, 0.0
    if len(model.lengths) == 3:
        z, w = _relative_motion(model, grid, rows, i, j, code, s, len(model.lengths) - 1)
    return squared_moment(x, y, z, u, v, w)


@inline_internal
def _relative_motion(
    model: Any, grid: Any, rows: Any, i: int, j: int, code: int, s: float, k: int
) -> tuple[float, float]:
    vi, vj = rows[i, SPEED + k], rows[j, SPEED + k]
    gap = rows[j, k] - rows[i, k] + grid.shifts[code, k]
    acceleration = model.acceleration
    return _relative_position(gap, vi, vj, s, acceleration, k), _relative_speed(vi, vj, s, acceleration, k)


# -- square wells ----------------------------------------------------------------------------------


@inline_internal
def _reach(well: Any) -> float:
    if well is None:
        return 1.0
    return well.range


@inline_internal
def _may_have_event(well: Any, b: Any, c: Any, w: Any, s2: Any, near: float, within: Any) -> int:
    """The lanes, as bits, whose pairs may have an event before `within`; generously, as rounding may hide it."""
    zero, square = splat(0.0), splat(SLACK) * (b * b)
    if well is None:
        return bits_of((b < zero) & (zero < square - w * c) & (c < splat(-2.0) * b * within))
    edge = c + s2 - s2 * splat(well.range * well.range)
    return bits_of(edge < splat(near) * s2) | bits_of((b < zero) & (zero < square - w * edge))


# -- prediction ------------------------------------------------------------------------------------


@inline_internal
def _prefetch_radius(radii: Any, i: int) -> None:
    if radii is not None:
        prefetch(radii, i * 8)


@inline_internal
def _prefetch_rows(cells: Any, nx: int, ny: int, x0: int, y0: int, y1: int, z0: int, z1: int) -> None:
    """Fetches the first cells of rows along x, from the column x0 on, at y0 to y1 and z0 to z1."""
    for kz in range(z0, z1 + 1):
        for ky in range(y0, y1 + 1):
            place = ((kz * ny + ky) * nx + x0) * (4 * cells.shape[1])
            prefetch(cells, place)
            prefetch(cells, place + 64)


@inline_internal
def _gather(shells: Any, model: Any, grid: Any, particles: Any, ids: Any, i: int, layer: int) -> tuple[int, bool]:
    """Puts the numbers of those that i may meet into the buffer; how many, and whether none is shifted by a period.

    layer: a face of its cell, to search only the cells beyond it, or -1 for all; lists are taken whole.
    """
    if shells is not None:
        return gather_list(shells, ids, i)
    cells = particles.cells
    nx, ny, nz = grid.counts
    cx, cy, cz = particles.ints[i, CELL], particles.ints[i, CELL + 1], particles.ints[i, CELL + 2]
    deep = len(model.lengths) - 2
    x0, x1, y0, y1, z0, z1 = cx - 1, cx + 1, cy - 1, cy + 1, cz - deep, cz + deep
    if layer == 0:
        x1 = x0
    elif layer == 1:
        x0 = x1
    elif layer == 2:
        y1 = y0
    elif layer == 3:
        y0 = y1
    elif layer == 4:
        z1 = z0
    elif layer == 5:
        z0 = z1
    inside = (x0 >= 0) & (y0 >= 0) & (z0 >= 0) & (x1 < nx) & (y1 < ny) & (z1 < nz)
    p = 0
    if inside:
        if cells.shape[0] > MANY:
            _prefetch_rows(cells, nx, ny, x0, y0, y1, z0, z1)
        for kz in range(z0, z1 + 1):
            for ky in range(y0, y1 + 1):
                row = (kz * ny + ky) * nx
                for kx in range(x0, x1 + 1):
                    cell = row + kx
                    held = cells[cell, 0]
                    ids[p] = cells[cell, 1]
                    ids[p + 1] = cells[cell, 2]
                    ids[p + 2] = cells[cell, 3]
                    if held > 3:
                        for slot in range(4, held + 1):
                            ids[p + slot - 1] = cells[cell, slot]
                    p += held
    else:
        if not grid.wraps[0]:
            x0, x1 = max(x0, 0), min(x1, nx - 1)
        if not grid.wraps[1]:
            y0, y1 = max(y0, 0), min(y1, ny - 1)
        if not grid.wraps[2]:
            z0, z1 = max(z0, 0), min(z1, nz - 1)
        for kz in range(z0, z1 + 1):
            sz = -1 if kz < 0 else (1 if kz >= nz else 0)
            for ky in range(y0, y1 + 1):
                sy = -1 if ky < 0 else (1 if ky >= ny else 0)
                row = ((kz - sz * nz) * ny + (ky - sy * ny)) * nx
                for kx in range(x0, x1 + 1):
                    sx = -1 if kx < 0 else (1 if kx >= nx else 0)
                    cell = row + (kx - sx * nx)
                    code = np.int64((sx + 1) + 3 * (sy + 1) + 9 * (sz + 1)) << ID_BITS
                    for slot in range(1, cells[cell, 0] + 1):
                        ids[p] = code | cells[cell, slot]
                        p += 1
    return p, inside


@inline_internal
def _sizes(diameter: float, radii: Any, ids: Any, q: int, i: int) -> Any:
    """Contact distances of i and eight others."""
    if radii is None:
        return splat(diameter)
    return splat(radii[i]) + elements(radii, ids, q)


@inline_internal
def _fallen(acceleration: Any, k: int, x: Any, s: Any, ahead: Any, behind: Any) -> Any:
    """x + g s |s|/2 along one axis, s = ahead + behind."""
    if acceleration is None:
        return x
    return x + splat(0.5 * acceleration[k]) * (s * (ahead - behind))


@inline_internal
def _accelerated(acceleration: Any, k: int, v: Any, s: Any) -> Any:
    """v + g s along one axis."""
    if acceleration is None:
        return v
    return v + splat(acceleration[k]) * s


@inline_internal
def _along(model: Any, rows: Any, i: int, k: int, x: Any, v: Any, s: Any, ahead: Any, behind: Any, sums: Any) -> Any:
    """Adds what one axis gives to r.v, r.r and v.v; as `_relative_position` and `_relative_speed`, eight pairs at once.

    x: of r_j - r_i, the shift included. v: of the others. s: as there. ahead, behind: s where it is positive, where it
    is negative.
    """
    b, rr, w = sums
    mine = splat(rows[i, SPEED + k])
    x = _fallen(model.acceleration, k, x + (v * ahead + mine * behind), s, ahead, behind)
    v = _accelerated(model.acceleration, k, v - mine, s)
    return b + x * v, rr + x * x, w + v * v


@inline_internal
def _motion(model: Any, grid: Any, rows: Any, ids: Any, q: int, i: int, inside: bool) -> Any:
    """Of i and the eight in the buffer from q on: r.v, r.r, v.v, the later of the two times, and when j is busy."""
    x, y, z, u, v, w, tau, busy = columns(rows, ids, q, 0)
    zero, mine = splat(0.0), splat(rows[i, TIME])
    s = mine - tau
    ahead, behind = where(zero < s, s, zero), where(s < zero, s, zero)
    later = where(tau < mine, mine, tau)
    x, y, z = x - splat(rows[i, 0]), y - splat(rows[i, 1]), z - splat(rows[i, 2])
    if not inside:
        shift_x, shift_y, shift_z, _, _, _, _, _ = columns(grid.shifts, ids, q, ID_BITS)
        x, y, z = x + shift_x, y + shift_y, z + shift_z
    sums = _along(model, rows, i, 0, x, u, s, ahead, behind, (zero, zero, zero))
    sums = _along(model, rows, i, 1, y, v, s, ahead, behind, sums)
    if len(model.lengths) == 3:
        sums = _along(model, rows, i, len(model.lengths) - 1, z, w, s, ahead, behind, sums)
    return sums, later, busy


@inline_internal
def _add_event(
    model: Any, grid: Any, particles: Any, store: Any, counts: Any, i: int, j: int, code: int, b: float, c: float,
    w: float, later: float,
) -> None:  # fmt: skip
    """The event of a pair, if it has one, for the store; b, c, w: as in `prediction`, at the later state."""
    rows = particles.rows
    s = contact_distance(model.diameter, model.radii, i, j)
    s2 = s * s
    # points have no collisions: their times would be rounding only
    if s > 0.0 and (c > grid.near * s2 or b >= 0.0 or not rests(rows, i, j, b, s2)):
        moment2 = 0.0
        if c > FAR * s2:
            moment2 = _moment_of_pair(model, grid, rows, i, j, code)
        span = pair_time(model.well, particles.bonds, i, j, b, c, w, s2, moment2, grid.near)
        if span < NEVER:
            add(store, rows, particles.ints, counts, i, later + span, j)


@inline_internal
def _ordinary(well: Any, store: Any, c: Any, s2: Any, near: float) -> int:
    """The lanes, as bits, whose times need no precautions of `_add_event`; for a store of the earliest event."""
    if well is not None:
        return 0
    if keeps_all(store):
        return 0
    return bits_of(_ordinary_lanes(c, s2, near))


@inline_internal
def _ordinary_lanes(c: Any, s2: Any, near: float) -> Any:
    return (splat(near) * s2 < c) & (c <= splat(FAR) * s2)


@inline_internal
def _predict(model: Any, grid: Any, particles: Any, store: Any, scratch: Any, counts: Any, i: int, layer: int) -> None:
    """Predicts the events of i with those in its list, or in its own and the neighbouring cells, for the store.

    layer: as `_gather`. Eight at a time: relative motion, and the times of their collisions, of which the earliest
    counts. Those that need more care than that are done one by one.
    """
    rows, ints, ids, numbers = particles.rows, particles.ints, scratch.ids, scratch.numbers
    p, inside = _gather(particles.shells, model, grid, particles, ids, i, layer)
    if not INTERPRETED:
        for q in range(p):
            prefetch(rows, (ids[q] & ID) * 64)
            _prefetch_radius(model.radii, ids[q] & ID)
    tick(counts, PREDICTIONS, p)
    for lane in range(WIDTH - 1):  # a particle has no event with itself
        ids[p + lane] = (NO_SHIFT << ID_BITS) | i
    zero, never = splat(0.0), splat(NEVER)
    for q in range(0, p, WIDTH):
        (b, rr, w), later, busy = _motion(model, grid, rows, ids, q, i, inside)
        size = _sizes(model.diameter, model.radii, ids, q, i)
        s2 = size * size
        c = rr - s2
        best = rows[i, NEXT]
        within = never if keeps_all(store) else splat(best) - later
        rest = _may_have_event(model.well, b, c, w, s2, grid.near, within)
        ordinary = _ordinary(model.well, store, c, s2, grid.near)
        if rest & ordinary != 0:
            # `discriminant` and `approach` of `prediction`
            disc = b * b - w * c
            span = c / (square_root(disc) - b)
            due = later + where(zero < span, span, zero)
            due = where((b < zero) & (zero < disc) & (due < busy), due, never)
            first = least(where(_ordinary_lanes(c, s2, grid.near), due, never))
            if first <= best:
                ties = bits_of(due <= splat(first)) & ordinary
                while ties != 0:
                    add(store, rows, ints, counts, i, first, ids[q + lowest_bit(ties)] & ID)
                    ties &= ties - 1
        rest &= ~ordinary
        if rest != 0:
            store_lanes(numbers, 0, q, b)
            store_lanes(numbers, 1, q, c)
            store_lanes(numbers, 2, q, w)
            store_lanes(numbers, 3, q, later)
            while rest != 0:
                k = q + lowest_bit(rest)
                rest &= rest - 1
                j = ids[k] & ID
                if j != i:
                    _add_event(
                        model, grid, particles, store, counts, i, j, NO_SHIFT if inside else ids[k] >> ID_BITS,
                        numbers[0, k], numbers[1, k], numbers[2, k], numbers[3, k],
                    )  # fmt: skip


@inline_internal
def _first_wall(
    walls: Any, model: Any, grid: Any, rows: Any, ints: Any, i: int, s: float, now: float, best: float, kind: int
) -> tuple[float, int]:
    """The own event that comes before `best`, if a wall is one."""
    if walls is None:
        return best, kind
    radius = radius_of(model.diameter, model.radii, i)
    for k in range(len(model.lengths)):
        x = drift(rows[i, k], rows[i, SPEED + k], model.acceleration, k, s)
        v = speed_after(rows[i, SPEED + k], model.acceleration, k, s)
        low = ints[i, CELL + k] * grid.sides[k] - grid.overlaps[k]
        high = (grid.counts[k] - 1 - ints[i, CELL + k]) * grid.sides[k] - grid.overlaps[k]
        for side in range(2):
            face = 2 * k + side
            away = low if side == 0 else high
            # a cell is at least a diameter deep: only a particle in the last one can meet a wall that does not move
            reach = walls.numbers[face, AMPLITUDE] + radius if walls.motion[face] == OSCILLATING else 0.0
            if walls.present[face] and (away < reach or away <= 0.0):
                span = wall_time(model, walls, face, x, v, radius, now, best)
                if span <= best and span < NEVER:
                    best, kind = span, WALL + face
    return best, kind


@inline_internal
def _leaving(shells: Any, model: Any, grid: Any, rows: Any, ints: Any, i: int, s: float) -> tuple[float, int]:
    """Time until the particle passes a face of its cell, or the edge of its shell, and which."""
    if shells is not None:
        return leaving_shell(shells, model, rows, i, s), SHELL
    best, kind = NEVER, 0
    for k in range(len(model.lengths)):
        x = drift(rows[i, k], rows[i, SPEED + k], model.acceleration, k, s)
        v = speed_after(rows[i, SPEED + k], model.acceleration, k, s)
        a = field_along(model.acceleration, k)
        cell = ints[i, CELL + k]
        if cell > 0 or grid.wraps[k]:
            span = falling_time(x - (cell * grid.sides[k] - grid.overlaps[k]), v, a)
            if span < best:
                best, kind = span, 2 * k
        if cell < grid.counts[k] - 1 or grid.wraps[k]:
            span = falling_time((cell + 1) * grid.sides[k] + grid.overlaps[k] - x, -v, -a)
            if span < best:
                best, kind = span, 2 * k + 1
    return best, kind


@inline_internal
def own_event(model: Any, grid: Any, particles: Any, i: int, now: float) -> None:
    """Predicts the next wall, or face of its cell, or edge of its shell, that the particle meets."""
    rows, ints = particles.rows, particles.ints
    s = now - rows[i, TIME]
    best, kind = _leaving(particles.shells, model, grid, rows, ints, i, s)
    best, kind = _first_wall(model.walls, model, grid, rows, ints, i, s, now, best, kind)
    span = cylinder_time(model, model.cylinder, rows, i, s, radius_of(model.diameter, model.radii, i))
    if span <= best and span < NEVER:
        best, kind = span, CYLINDER
    due = now + best if best < NEVER else NEVER
    renewed = _flight_over_box(model, grid, rows, i, due)
    if renewed < due:
        due, kind = renewed, RENEW
    particles.own[i] = due
    ints[i, OWN] = kind


# -- cells -----------------------------------------------------------------------------------------


@inline_internal
def _cell_of(grid: Any, ints: Any, i: int) -> int:
    return (ints[i, CELL + 2] * grid.counts[1] + ints[i, CELL + 1]) * grid.counts[0] + ints[i, CELL]


@inline_internal
def _leave_cell(grid: Any, particles: Any, i: int) -> None:
    cells = particles.cells
    cell = _cell_of(grid, particles.ints, i)
    last, slot = cells[cell, 0], 1
    while cells[cell, slot] != i:
        slot += 1
    cells[cell, slot] = cells[cell, last]
    cells[cell, 0] = last - 1


@inline_internal
def _enter_cell(grid: Any, particles: Any, i: int) -> None:
    cells = particles.cells
    cell = _cell_of(grid, particles.ints, i)
    cells[cell, 0] += 1
    cells[cell, cells[cell, 0]] = i


# -- the loop --------------------------------------------------------------------------------------


@inline_internal
def _no_bond_left(bonds: Any, i: int, j: int) -> bool:
    if bonds is None:
        return False
    return bonds[i, 0] + 1 >= bonds.shape[1] or bonds[j, 0] + 1 >= bonds.shape[1]


@inline_internal
def _time_since_event(rows: Any, ints: Any, i: int, now: float) -> float:
    """Time since the particle's last event; NEVER where its state is not that of an event."""
    return now - rows[i, TIME] if ints[i, STREAK] >= 0 else NEVER


@inline_internal
def _collided_before(contact_duration: Any, last: Any, i: int, now: float) -> float:
    """Time since the particle's last collision, for the TC model: the edge of a well is not one."""
    if contact_duration is None:
        return NEVER
    return now - last[i]


@inline_internal
def _note_collision(contact_duration: Any, last: Any, i: int, now: float) -> None:
    if contact_duration is not None:
        last[i] = now


@inline_internal
def _hits_so_far(seed: Any, hits: Any, i: int) -> int:
    """Number of the particle's collisions with walls, and one more from now on."""
    if seed is None:
        return np.int64(0)
    hits[i] += 1
    return hits[i] - 1


@inline_internal
def _code(j: int) -> int:
    """Who an event is with, in the lowest bits of STREAK."""
    return (j + 1) & _PARTNERS


@inline_internal
def _last_with(ints: Any, i: int) -> int:
    return ints[i, STREAK] & _PARTNERS


@inline_internal
def _streak(ints: Any, i: int) -> int:
    return ints[i, STREAK] >> _PARTNER_BITS


@inline_internal
def _note_event(ints: Any, i: int, partner: int, at_once: bool) -> None:
    """The particle's state is that of an event now. at_once: its last one was at the same instant."""
    streak = min(_streak(ints, i) + 1, COLLAPSE + 1) if at_once else 0
    ints[i, STREAK] = (streak << _PARTNER_BITS) | partner


@inline_internal
def _note_simultaneous(simultaneous: Any, now: float) -> None:
    simultaneous[0] += 1.0
    if simultaneous[0] == 1.0:
        simultaneous[1] = now


@inline_internal
def _at_well_edge(
    well: Any, model: Any, particles: Any, tallies: Any, fields: Any, i: int, j: int, n: Vector, distance: float,
    gn: float, now: float,
) -> bool:  # fmt: skip
    """Applies the event at the edge of a well, if the pair is there; whether it was."""
    if well is None:
        return False
    if not at_edge(well, model, i, j, distance * distance):
        return False
    rows, spins = particles.rows, particles.spins
    note_pair_before(tallies, fields, model, rows, spins, i, j, now)
    impulse, bound = pass_edge(well, model, rows, particles.bonds, i, j, n, gn)
    note_well(tallies, fields, model, rows, spins, i, j, n, distance, impulse, bound)
    return True


@inline_internal
def _collide(
    model: Any, grid: Any, particles: Any, measured: Any, i: int, j: int, now: float, instant: float, resolution: float
) -> int:
    """The event of a pair: REACHED a collision, PAUSED the edge of a well; BONDS_FULL before anything; COLLAPSED."""
    if _no_bond_left(particles.bonds, i, j):
        return BONDS_FULL
    rows, ints, spins, last = particles.rows, particles.ints, particles.spins, particles.last
    tallies, fields, _, _, simultaneous = measured
    age_i, age_j = _time_since_event(rows, ints, i, now), _time_since_event(rows, ints, j, now)
    tied = (age_i < resolution and _last_with(ints, i) != _code(j)) or (
        age_j < resolution and _last_with(ints, j) != _code(i)
    )
    fixed = is_fixed(model.inverse_masses, j)
    _advance_to_now(model, grid, rows, i, now)
    if not fixed:
        _advance_to_now(model, grid, rows, j, now)
    x, y, z = nearest(model, rows, i, j)
    distance = np.sqrt(x * x + y * y + z * z)
    x, y, z = x / distance, y / distance, z / distance
    n = (x, y, z)
    gn = (rows[j, 3] - rows[i, 3]) * x + (rows[j, 4] - rows[i, 4]) * y + (rows[j, 5] - rows[i, 5]) * z
    speed2 = 0.0
    for k in range(3):
        speed2 += rows[i, SPEED + k] * rows[i, SPEED + k] + rows[j, SPEED + k] * rows[j, SPEED + k]
    status = PAUSED
    changed = _at_well_edge(model.well, model, particles, tallies, fields, i, j, n, distance, gn, now)
    if not changed and gn < 0.0:
        one = _collided_before(model.contact_duration, last, i, now)
        other = _collided_before(model.contact_duration, last, j, now)
        recent = still_in_contact(model.contact_duration, min(one, other))
        alpha = normal_restitution(model.restitution, recent)
        note_pair_before(tallies, fields, model, rows, spins, i, j, now)
        impulse = pair_impulse(model.rough, spins, model, rows, i, j, n, gn, alpha, recent)
        apply_impulse(model, rows, i, j, impulse)
        note_pair_after(tallies, fields, model, rows, spins, i, j, n, distance, impulse)
        _note_collision(model.contact_duration, last, i, now)
        if not fixed:
            _note_collision(model.contact_duration, last, j, now)
        status, changed = REACHED, True
    if changed and tied:
        _note_simultaneous(simultaneous, now)
    ints[i, COUNT] += 1
    at_once = age_i < instant and (fixed or age_j < instant)
    _note_event(ints, i, _code(j), at_once)
    streak = _streak(ints, i)
    if not fixed:
        ints[j, COUNT] += 1
        _note_event(ints, j, _code(i), at_once)
        streak = min(streak, _streak(ints, j))
    if not at_once:
        return status
    if streak > COLLAPSE or (streak > 2 and gn * gn < VANISHED * speed2):
        return COLLAPSED
    return status


@inline_internal
def _cross_cell_face(model: Any, grid: Any, particles: Any, fields: Any, i: int, now: float) -> bool:
    """Moves the particle through a face of its cell into the next one; False, and no change, if that is full."""
    rows, ints, images = particles.rows, particles.ints, particles.images
    face = ints[i, OWN]
    k = face >> 1
    old = ints[i, CELL + k]
    cell = old + (1 if face & 1 else -1)
    turn = 1 if cell == grid.counts[k] else (-1 if cell < 0 else 0)
    cell -= turn * grid.counts[k]
    ints[i, CELL + k] = cell
    full = particles.cells[_cell_of(grid, ints, i), 0] + 1 >= particles.cells.shape[1]
    ints[i, CELL + k] = old
    if full:
        return False
    note_crossing(fields, model, rows, particles.spins, particles.bonds, i, face, now)
    _leave_cell(grid, particles, i)
    ints[i, CELL + k] = cell
    rows[i, k] -= turn * model.lengths[k]
    images[i, k] += turn
    _enter_cell(grid, particles, i)
    return True


@inline_internal
def _move_on(
    shells: Any, model: Any, grid: Any, particles: Any, fields: Any, scratch: Any, counts: Any, i: int, now: float
) -> int:
    """The passage of a cell's face or a shell's edge; GOING_ON, or what is full, and then nothing has been done."""
    if shells is None:
        if not _cross_cell_face(model, grid, particles, fields, i, now):
            return CELL_FULL
        tick(counts, CROSSINGS, 1)
        return GOING_ON
    made = renew_list(shells, model, grid, particles, scratch.ids, counts, i, now)
    return CELL_FULL if made == NO_CELL else (LISTS_FULL if made == NO_LIST else GOING_ON)


@inline_internal
def _put_onto_plane(model: Any, walls: Any, grid: Any, rows: Any, i: int, face: int) -> None:
    """Puts a particle that touches a wall less than a quantum behind its contact, where a field acts.

    A place that is rounded to before the wall would give it the speed of the fall from there at each impact: it would
    never come to rest.
    """
    if walls is None or model.acceleration is None:
        return
    if walls.motion[face] == OSCILLATING:
        return
    k, radius = face >> 1, radius_of(model.diameter, model.radii, i)
    if face & 1 == 0:
        rows[i, k] = np.floor(radius / grid.quantum) * grid.quantum
    else:
        rows[i, k] = model.lengths[k] - np.floor(radius / grid.quantum) * grid.quantum


@inline_internal
def _hit_wall(
    model: Any, grid: Any, particles: Any, measured: Any, i: int, now: float, instant: float, resolution: float
) -> bool:
    """Applies the collision of a particle with a wall; True if it is an inelastic collapse."""
    rows, ints, spins, last = particles.rows, particles.ints, particles.spins, particles.last
    tallies, fields, _, _, simultaneous = measured
    age = _time_since_event(rows, ints, i, now)
    _advance_to_now(model, grid, rows, i, now)
    recent = still_in_contact(model.contact_duration, _collided_before(model.contact_duration, last, i, now))
    hits = _hits_so_far(model.seed, particles.hits, i)
    note_wall_before(tallies, fields, model, rows, spins, i, now)
    face = ints[i, OWN] - WALL
    if ints[i, OWN] == CYLINDER:
        face = 2 * len(model.lengths)
        at_cylinder(model, model.cylinder, rows, spins, i, recent)
    else:
        instant = max(instant, resting_flight(model.walls, model, face))
        _put_onto_plane(model, model.walls, grid, rows, i, face)
        at_plane(model, model.walls, rows, spins, i, hits, face, now, recent)
    note_wall_after(tallies, fields, model, rows, spins, i, face)
    note_cylinder(tallies, model, rows, i, face)
    _note_collision(model.contact_duration, last, i, now)
    if age < resolution and _last_with(ints, i) != _WALL:
        _note_simultaneous(simultaneous, now)
    ints[i, COUNT] += 1
    _note_event(ints, i, _WALL, age < instant)
    return _streak(ints, i) > COLLAPSE


@inline_internal
def _append_to_trace(trace: Any, model: Any, particles: Any, now: float, i: int, j: int) -> None:
    """Notes an event that has been applied."""
    if trace is not None:
        place = trace.filled[0]
        trace.time[place], trace.pairs[place, 0], trace.pairs[place, 1] = now, i, j
        trace.after[place] = 0.0
        _note_state(trace.after[place, 0], model, particles, particles.spins, i)
        if j >= 0:
            _note_state(trace.after[place, 1], model, particles, particles.spins, j)
        trace.filled[0] = place + 1


@inline_internal
def _note_state(after: Any, model: Any, particles: Any, spins: Any, i: int) -> None:
    for k in range(len(model.lengths)):
        turn = np.int64(np.floor(particles.rows[i, k] / model.lengths[k]))
        wrapped = particles.rows[i, k] - turn * model.lengths[k]
        after[k] = wrapped + (particles.images[i, k] + turn) * model.lengths[k]
        after[3 + k] = particles.rows[i, SPEED + k]
    if spins is not None:
        for k in range(3):
            after[6 + k] = spins[i, k]


@inline_internal
def _trace_is_full(trace: Any) -> bool:
    if trace is None:
        return False
    return trace.filled[0] >= trace.time.size


@inline_internal
def _reason_to_stop(due: float, pairs: int, store: Any, scratch: Any, trace: Any, limits: Any) -> int:
    """Why the event at the time `due` has to wait; GOING_ON if it has not."""
    if pairs >= limits.collisions:
        return COUNTED
    if due > limits.until:
        return REACHED
    if due > limits.renewal:
        return PAUSED
    if not has_room(store, 2 * scratch.ids.size):
        return STORE_FULL
    if _trace_is_full(trace):
        return TRACE_FULL
    return GOING_ON


@inline_internal
def _look_ahead(shells: Any, queue: Any, particles: Any, i: int) -> None:
    """Fetches what the events after that of i, which is the first, will need: who they are is a good guess."""
    if shells is None:
        return
    if particles.rows.shape[0] < FEW:
        return
    after, node = i, FIRST_NODE
    soonest = NEVER
    for _ in range(AHEAD):
        node, j, due = rival(queue, node, i)
        prefetch(particles.rows, j * 64)
        prefetch(particles.ints, j * 32)
        prefetch(particles.own, j * 8)
        prefetch_list(shells, j)
        after = j if due < soonest else after
        soonest = due if due < soonest else soonest
    prefetch_neighbours(shells, particles.rows, after)
    partner = particles.ints[after, PARTNER]
    if partner >= 0:
        prefetch(particles.ints, partner * 32)
        prefetch_neighbours(shells, particles.rows, partner)


@kernel
def advance(
    model: Any, grid: Any, particles: Any, store: Any, queue: Any, scratch: Any, measured: Any, progress: Any,
    clock: float, limits: Any,
) -> tuple[int, float]:  # fmt: skip
    """Processes events from the time `clock` on until one of the `limits`; why it stopped, and the time then."""
    _, fields, counts, trace, _ = measured
    instant, resolution = limits.instant, limits.resolution
    rows, ints, own = particles.rows, particles.ints, particles.own
    now, status = clock, GOING_ON
    pairs, events = progress[PAIRS], progress[EVENTS]
    interactions, unpredicted = progress[INTERACTIONS], progress[UNPREDICTED]
    while True:
        # at the start all are due at one time, and the calendar would compare all of these for each of them
        if unpredicted < rows.shape[0]:
            if is_fixed(model.inverse_masses, unpredicted):
                unpredicted += 1
                continue
            i = unpredicted
        else:
            i = first(queue, counts)
        prefetch_entry(queue, i)
        _look_ahead(particles.shells, queue, particles, i)
        pair_time, own_time = rows[i, NEXT], own[i]
        due = min(pair_time, own_time)
        status = _reason_to_stop(due, pairs, store, scratch, trace, limits)
        if status != GOING_ON:
            break
        now = max(now, due)
        j = np.int64(-1)  # a second particle whose events change
        anew, again, layer = True, True, -1  # its own events; the pair events; those beyond one face only
        if own_time < pair_time:
            if ints[i, OWN] < WALL:
                layer = ints[i, OWN]
                status = _move_on(particles.shells, model, grid, particles, fields, scratch, counts, i, now)
            elif ints[i, OWN] == REPREDICT:
                unpredicted += 1
            elif ints[i, OWN] == RENEW:
                tick(counts, RENEWALS, 1)
                _advance_to_now(model, grid, rows, i, now)
                ints[i, COUNT] += 1
                ints[i, STREAK] = -1
            else:
                interactions += 1
                tick(counts, WALL_EVENTS, 1)
                wall = WALL - 1 - ints[i, OWN]
                collapsed = _hit_wall(model, grid, particles, measured, i, now, instant, resolution)
                _append_to_trace(trace, model, particles, now, i, wall)
                if collapsed:
                    progress[FIRST], progress[SECOND] = i, -1
                    status = COLLAPSED
        else:
            j = np.int64(ints[i, PARTNER])
            if ints[j, COUNT] != ints[i, PARTNER_COUNT]:
                tick(counts, INVALID, 1)
                pop(store, rows, ints, counts, i)
                j = np.int64(-1)
                anew, again = False, not keeps_all(store)
            else:
                prefetch_entry(queue, j)
                done = _collide(model, grid, particles, measured, i, j, now, instant, resolution)
                pairs += done in (REACHED, COLLAPSED)
                interactions += done != BONDS_FULL
                if done != BONDS_FULL:
                    _append_to_trace(trace, model, particles, now, i, j)
                if done == BONDS_FULL or done == COLLAPSED:
                    progress[FIRST], progress[SECOND] = i, j
                    status = done
                if is_fixed(model.inverse_masses, j):
                    j = np.int64(-1)
        if status == CELL_FULL or status == LISTS_FULL or status == BONDS_FULL:  # the event has not been applied
            break
        events += 1
        if status == COLLAPSED:
            break
        if again and layer < 0:
            drop_events(store, rows, ints, counts, i)
            if j >= 0:
                drop_events(store, rows, ints, counts, j)
        one = i
        while one >= 0:
            if anew:
                own_event(model, grid, particles, one, now)
            if again:
                _predict(model, grid, particles, store, scratch, counts, one, layer)
            update(queue, counts, one, min(rows[one, NEXT], own[one]))
            one, j = j, np.int64(-1)
    if status == REACHED:
        now = limits.until
    elif status == PAUSED:
        now = min(due, np.floor(due / limits.renewal) * limits.renewal)
    progress[PAIRS], progress[EVENTS] = pairs, events
    progress[INTERACTIONS], progress[UNPREDICTED] = interactions, unpredicted
    return status, now
