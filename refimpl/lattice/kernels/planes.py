"""Steps of a lattice gas on bit planes: propagation, force, collision and walls in one pass, and several steps a pass.

There are two copies of the lattice, one for even and one for odd steps; a copy is a plane a channel. A plane is PAD
words, and then for each row its words, padded to whole wide words, and PAD words again. Bit x mod 64 of word x // 64 of
a row is the site in column x. The bit before a row's first and the one behind its last hold the periodic images of the
other end; further bits of the padding hold nothing.

A step of a row needs three rows of the step before. So a block of steps need not pass through memory once a step: each
step follows one row behind the one before it, while the rows are in the cache (time skewing: Wonnacott, Int. J.
Parallel Program. 30, 181 (2002)). At the ends of a stretch of rows the later steps lack neighbours: there each step
leaves out one row more than the one before. What is left out, a triangle in rows and steps about each end, comes
second, when the stretches on its two sides are done. Two copies are enough, for a row is written again only when its
neighbours have used it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba.extending import overload, register_jitable

from refimpl.compilation import compiled
from refimpl.lattice.kernels.words import (
    WIDTH,
    any_bit,
    arrivals,
    chosen,
    collided,
    lanes,
    load,
    ones,
    population,
    pushed,
    reflected,
    splat,
    store,
)
from refimpl.lattice.logic import draws
from refimpl.lattice.randomness import COLLISION, DIGITS, FORCING, ROW, WALLS, random_word, row_key

#: Words before and after the words of a row.
PAD = WIDTH
_ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
_NONE = np.uint64(0)


class Push(NamedTuple):
    """A force along x.

    threshold: its probability in units of 2^-DIGITS. sign: +1 or -1, the direction. inside: the words of a row with
    the bits of its columns set. impulses: (rows,), to which the numbers of particles pushed are added.
    """

    threshold: int
    sign: int
    inside: np.ndarray
    impulses: np.ndarray


@register_jitable
def _word(key, draw, place):  # type: ignore[no-untyped-def]
    """Random wide word: draw `draw` of the words place, place + 1, ... of a row."""
    return random_word(key, lanes() + np.uint64(draw * ROW + place))


def _without_draws(model, occupied, key, place):  # type: ignore[no-untyped-def]
    return collided(model, occupied, ())[0]


def _with_one_draw(model, occupied, key, place):  # type: ignore[no-untyped-def]
    return collided(model, occupied, (_word(key, 0, place),))[0]


def _with_two_draws(model, occupied, key, place):  # type: ignore[no-untyped-def]
    bits = (_word(key, 0, place), _word(key, 1, place))
    after, again = collided(model, occupied, bits)
    draw = 2
    while any_bit(again):
        bits = chosen(again, (_word(key, draw, place), _word(key, draw + 1, place)), bits)
        after, again = collided(model, occupied, bits)
        draw += 2
    return after


def _collision(outcomes):  # type: ignore[no-untyped-def]
    """What `_collide` does for a collision table."""
    number = draws(outcomes)
    if number > 2:
        raise ValueError(f"a state has too many outcomes for two random bits: {number} are needed")
    return (_without_draws, _with_one_draw, _with_two_draws)[number]


def _collide(model, occupied, key, place):  # type: ignore[no-untyped-def]
    """Collision of WIDTH words at `place` of a row; compiled to what the model's table needs."""
    return _collision(model.outcomes)(model, occupied, key, place)


@overload(_collide, jit_options={"forceinline": True, "error_model": "numpy"})
def _collide_compiled(model, occupied, key, place):  # type: ignore[no-untyped-def]
    return _collision(model.outcomes)


@register_jitable
def _bernoulli(key, threshold, place):  # type: ignore[no-untyped-def]
    """Bits set with probability threshold/2^DIGITS: U < threshold, digit by digit from the last one."""
    if threshold >> DIGITS:
        return splat(_ALL)
    below = splat(_NONE)
    for digit in range(DIGITS):
        word = _word(key, digit, place)
        below = (below & ~word) | ((below ^ ~word) & splat(_ALL if threshold >> digit & 1 else _NONE))
    return below


@register_jitable
def _seal(planes, channels, base, size, columns):  # type: ignore[no-untyped-def]
    """Periodic images at both ends of a row."""
    end, bit = base + columns // 64, np.uint64(columns % 64)
    last = columns - 1
    for channel in range(channels):
        shift = channel * size
        first = planes[shift + base] & np.uint64(1)
        planes[shift + end] = (planes[shift + end] & ~(np.uint64(1) << bit)) | (first << bit)
        tail = planes[shift + base + last // 64] >> np.uint64(last % 64)
        planes[shift + base - 1] = tail << np.uint64(63)


@compiled(cache=True, nogil=True)
def seal(planes, current, shape):  # type: ignore[no-untyped-def]
    """Periodic images at the ends of all rows of the copy `current`, 0 or 1."""
    rows, columns, _, stride, size, copy = shape
    for row in range(rows):
        _seal(planes, copy // size, current * copy + row * stride + PAD, size, columns)


@register_jitable(forceinline=True)
def _move_row(  # type: ignore[no-untyped-def]
    model, planes, source, target, row, walls, wall_draws, push, shape, seed, now
):
    """Step `now` of a row. source, target: where row 0 of either copy begins; the rest as of `advance`."""
    rows, columns, words, stride, size, copy = shape
    below = source + (row - 1 if row > 0 else rows - 1) * stride
    here = source + row * stride
    above = source + (row + 1 if row + 1 < rows else 0) * stride
    there = target + row * stride
    fixed = PAD + row * stride
    key = row_key(seed, COLLISION, np.uint64(now), np.uint64(row))
    if push is not None:
        force_key = row_key(seed, FORCING, np.uint64(now), np.uint64(row))
        count = 0
    if wall_draws is not None:
        wall_key = row_key(seed, WALLS, np.uint64(now), np.uint64(row))
    for k in range(0, words, WIDTH):
        if row % 2 == 0:
            found = arrivals(model, 0, planes, below + k, here + k, above + k, size)
        else:
            found = arrivals(model, 1, planes, below + k, here + k, above + k, size)
        if walls is not None:
            flip_x, flip_y = load(walls[0], fixed + k), load(walls[1], fixed + k)
            solid = flip_x | flip_y
            if wall_draws is not None:
                coin = _word(wall_key, 0, k)
                draw_x, draw_y = load(wall_draws[0], fixed + k), load(wall_draws[1], fixed + k)
                solid = solid | draw_x | draw_y
                flip_x, flip_y = flip_x | (draw_x & coin), flip_y | (draw_y & coin)
            bounced = reflected(model, found, flip_x, flip_y)
        if push is not None:
            where = _bernoulli(force_key, push.threshold, k) & load(push.inside, k)
            if walls is not None:
                where = where & ~solid
            along = splat(_ALL if push.sign > 0 else _NONE)
            found, went = pushed(model, found, where & along, where & ~along)
            count += population(went)
        found = _collide(model, found, key, k)
        if walls is not None:
            found = chosen(solid, bounced, found)
        store(found, planes, there + k, size)
    if push is not None:
        push.impulses[row] += count
    _seal(planes, copy // size, there, size, columns)


@compiled(cache=True, nogil=True)
def advance(  # type: ignore[no-untyped-def]
    model, planes, current, walls, wall_draws, push, shape, passes, fetches, tiles, seed, step, steps, block, band
):
    """Moves the rows of some tiles by `steps` steps, from the state at `step` on.

    planes: two copies of the lattice. current: which one, 0 or 1, holds the state at `step`; each step writes the other
    one. walls: None or planes (reverse x, reverse y); wall_draws: None or planes of the sites that reverse x, y with
    probability 1/2. push: None or `Push`. shape: rows, columns, words of a row, stride of the rows, size of a plane,
    size of a copy. passes, fetches: (rows,), to whose entry of a tile's first row are added the numbers of rows
    computed, and of different ones in each block of steps. tiles: (m, 3): first row, row behind the last, and slope.
    Step k = 1, 2, ... of a block computes the rows first + k slope ... last - k slope - 1 of a tile, modulo the number
    of rows. seed: of the run. block: steps that are taken in a tile before the next tile; 1 for a slope of 0. band:
    neighbouring rows that a step computes before the next step follows.
    """
    rows, copy = shape[0], shape[5]
    for start in range(step, step + steps, block):
        levels = min(block, step + steps - start)
        for tile in range(len(tiles)):
            first, last, slope = tiles[tile, 0], tiles[tile, 1], tiles[tile, 2]
            computed = 0  # in a register: a row of few words would notice an addition in memory
            for front in range(first + slope, last - slope + (1 - slope) * (levels - 1), band):
                for level in range(levels):
                    inset = slope * (level + 1)
                    now = start + level
                    source = ((current + now - step) & 1) * copy + PAD
                    target = ((current + now + 1 - step) & 1) * copy + PAD
                    for line in range(max(first + inset, front - level), min(last - inset, front - level + band)):
                        row = line if line < rows else line - rows
                        _move_row(model, planes, source, target, row, walls, wall_draws, push, shape, seed, now)
                        computed += 1
            passes[first % rows] += computed
            fetches[first % rows] += last - first - 2 * min(slope, slope * levels)


@compiled(cache=True, nogil=True)
def populations(planes, current, counts, shape):  # type: ignore[no-untyped-def]
    """Particles of the copy `current`, added to counts (blocks in y, blocks in x, b): equal blocks."""
    rows, columns, _, stride, size, copy = shape
    down, across, channels = counts.shape
    tall, wide = rows // down, columns // across
    for channel in range(channels):
        for row in range(rows):
            base = current * copy + channel * size + row * stride + PAD
            for block in range(across):
                start, end = block * wide, (block + 1) * wide
                first, last = start // 64, (end - 1) // 64
                total = 0
                for k in range(first, last + 1):
                    word = planes[base + k]
                    if k == first:
                        word = (word >> np.uint64(start % 64)) << np.uint64(start % 64)
                    if k == last:
                        word = word << np.uint64(63 - (end - 1) % 64)
                    total += ones(word)
                counts[row // tall, block, channel] += total
