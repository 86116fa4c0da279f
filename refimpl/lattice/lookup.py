"""A lattice gas of bytes: each site looks its collision up in a table. The executable specification, compiled."""

from __future__ import annotations

import numpy as np

from refimpl.compilation import compiled
from refimpl.lattice.gas import Forcing, LatticeGas, reflections
from refimpl.lattice.logic import draws
from refimpl.lattice.models import Model
from refimpl.lattice.randomness import COLLISION, DIGITS, FORCING, ROW, WALLS, random_word, row_key


class LookupGas(LatticeGas):
    """A byte a site: occupations are read from the neighbours, and the collision is looked up.

    model, sites, seed, walls, forcing: as of `LatticeGas`, with its errors.
    """

    def __init__(
        self,
        model: Model,
        sites: np.ndarray,
        *,
        seed: int = 0,
        walls: np.ndarray | None = None,
        forcing: Forcing | None = None,
    ) -> None:
        super().__init__(model, sites, seed=seed, walls=walls, forcing=forcing)
        self._sites = np.array(sites)
        self._spare = np.empty_like(self._sites)
        self._mirrors = reflections(model)
        v = model.velocities
        #: of even and odd rows: bit, row below (1), here (0) or above (-1), column shift
        self._moves = np.array(
            [[(1 << i, b, v.column_shift(i, odd)) for i, (_, b) in enumerate(v.integers)] for odd in (0, 1)]
        )

    @property
    def sites(self) -> np.ndarray:
        return self._sites.copy()

    def _set(self, sites: np.ndarray) -> None:
        self._sites = np.array(sites)

    def advance(self, steps: int) -> None:
        force = None
        if self.forcing is not None:
            channel = self.forcing.channel
            force = (self.forcing.threshold, channel, self.model.velocities.image(-1, 1)[channel])
        _advance(
            self._sites,
            self._spare,
            self._moves,
            (*self.model.table, draws(self.model.outcomes)),
            self._mirrors,
            self.walls,
            force,
            self.impulses,
            np.uint64(self.seed),
            self.time,
            steps,
        )
        if steps % 2:
            self._sites, self._spare = self._spare, self._sites
        self.time += steps


@compiled(cache=True)
def _step(sites, target, moves, table, mirrors, walls, force, impulses, seed, time):  # type: ignore[no-untyped-def]
    rows, columns = sites.shape
    outcomes, numbers, number_of_draws = table
    arrived = np.empty(columns, dtype=np.uint8)
    ring = np.empty(columns + 2, dtype=np.uint8)  # a row between its periodic images
    for y in range(rows):
        arrived[:] = 0
        for i in range(moves.shape[1]):
            bit, down, shift = np.uint8(moves[y % 2, i, 0]), moves[y % 2, i, 1], moves[y % 2, i, 2]
            source = sites[(y - down) % rows]
            ring[0], ring[columns + 1] = source[columns - 1], source[0]
            ring[1 : columns + 1] = source
            arrived |= ring[1 - shift : columns + 1 - shift] & bit
        key = row_key(seed, COLLISION, np.uint64(time), np.uint64(y))
        for x in range(columns):
            state = np.int64(arrived[x])
            if walls is not None and walls[y, x] > 0:
                target[y, x] = _reflected(state, walls[y, x], mirrors, seed, time, y, x)
                continue
            if force is not None:
                threshold, channel, back = force
                if state >> back & 1 and not state >> channel & 1 and _uniform(seed, time, y, x) < threshold:
                    state ^= 1 << channel | 1 << back
                    impulses[y] += 1
            target[y, x] = outcomes[state, _choice(numbers[state], number_of_draws, key, x)]


@compiled(cache=True)
def _random_bit(key, draw, x):  # type: ignore[no-untyped-def]
    """Bit x mod 64 of word x // 64 of a row."""
    return np.int64(random_word(key, np.uint64(draw * ROW + x // 64)) >> np.uint64(x % 64)) & 1


@compiled(cache=True)
def _choice(number, number_of_draws, key, x):  # type: ignore[no-untyped-def]
    """Uniform among 0 ... number - 1: as many random bits as number them, drawn again where they say more."""
    if number == 1:
        return 0
    used = 0
    while (1 << used) < number:
        used += 1
    draw = 0
    while True:
        code = 0
        for j in range(used):
            code |= _random_bit(key, draw + j, x) << j
        if code < number:
            return code
        draw += number_of_draws


@compiled(cache=True)
def _uniform(seed, time, y, x):  # type: ignore[no-untyped-def]
    """Uniform integer of DIGITS binary digits."""
    key = row_key(seed, FORCING, np.uint64(time), np.uint64(y))
    value = 0
    for digit in range(DIGITS):
        value |= _random_bit(key, digit, x) << digit
    return value


@compiled(cache=True)
def _reflected(state, rule, mirrors, seed, time, y, x):  # type: ignore[no-untyped-def]
    """Components are reversed by the rule's bits 1 and 2, and with probability 1/2 by its bits 4 and 8."""
    flips = rule & 3
    if rule >> 2:
        coin = _random_bit(row_key(seed, WALLS, np.uint64(time), np.uint64(y)), 0, x)
        flips |= (rule >> 2) * coin
    return mirrors[flips, state]


@compiled(cache=True, nogil=True)
def _advance(  # type: ignore[no-untyped-def]
    sites, target, moves, table, mirrors, walls, force, impulses, seed, start, steps
):
    """The last state is in `target` after an odd number of steps, in `sites` after an even one."""
    for time in range(start, start + steps):
        _step(sites, target, moves, table, mirrors, walls, force, impulses, seed, time)
        sites, target = target, sites
