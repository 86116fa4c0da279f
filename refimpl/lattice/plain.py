"""A lattice gas in plain NumPy: whole arrays of sites, a byte each."""

from __future__ import annotations

import numpy as np

from refimpl.lattice.gas import BOUNCE_BACK, DRAW_X, DRAW_Y, Forcing, LatticeGas, reflections
from refimpl.lattice.logic import draws
from refimpl.lattice.models import Model
from refimpl.lattice.randomness import COLLISION, DIGITS, FORCING, ROW, WALLS, random_word, row_key


class PlainGas(LatticeGas):
    """Propagation by rolling rows, collisions by looking up the table for all sites at once.

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
        self._outcomes, self._numbers = model.table
        self._codes = np.array([(1 << (len(found) - 1).bit_length()) - 1 for found in model.outcomes])
        self._mirrors = reflections(model)

    @property
    def sites(self) -> np.ndarray:
        return self._sites

    def _set(self, sites: np.ndarray) -> None:
        self._sites = sites

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            arrived = self._propagated()
            solid = np.zeros(arrived.shape, dtype=bool) if self.walls is None else self.walls > 0
            forced = self._forced(arrived, ~solid)
            after = self._collided(forced)
            if self.walls is not None:
                after = np.where(solid, self._reflected(arrived), after)
            self._sites = after
            self.time += 1

    def _propagated(self) -> np.ndarray:
        velocities = self.model.velocities
        self.passes += 1
        arrived = np.zeros_like(self._sites)
        for i, (_, b) in enumerate(velocities.integers):
            moving = np.roll(self._sites & np.uint8(1 << i), b, axis=0)
            for parity in (0, 1):
                arrived[parity::2] |= np.roll(moving[parity::2], velocities.column_shift(i, parity), axis=1)
        return arrived

    def _bits(self, purpose: np.uint64, draw: int) -> np.ndarray:
        """A random bit for each site."""
        rows = np.arange(self.rows, dtype=np.uint64)
        # arrays, for numpy warns when the product of two numbers overflows
        seed, purpose_, time = np.array([[self.seed], [purpose], [self.time]], dtype=np.uint64)
        key = row_key(seed, purpose_, time, rows)
        numbers = np.arange(-(-self.columns // 64), dtype=np.uint64) + np.uint64(draw * ROW)
        words = random_word(key[:, None], numbers).astype("<u8")
        return np.unpackbits(words.view(np.uint8), axis=1, bitorder="little")[:, : self.columns]

    def _collided(self, sites: np.ndarray) -> np.ndarray:
        number = draws(self.model.outcomes)
        code, draw = np.zeros(sites.shape, dtype=np.int64), 0
        again = np.full(sites.shape, number > 0)
        while again.any():
            fresh = sum(self._bits(COLLISION, draw + j).astype(np.int64) << j for j in range(number))
            code = np.where(again, fresh & self._codes[sites], code)
            again, draw = code >= self._numbers[sites], draw + number
        return self._outcomes[sites, code]

    def _forced(self, sites: np.ndarray, fluid: np.ndarray) -> np.ndarray:
        if self.forcing is None:
            return sites
        uniform = sum(self._bits(FORCING, digit).astype(np.int64) << digit for digit in range(DIGITS))
        channel = self.forcing.channel
        back = self.model.velocities.image(-1, 1)[channel]
        goes = (uniform < self.forcing.threshold) & fluid & (sites >> back & 1 > 0) & (sites >> channel & 1 == 0)
        self.impulses += goes.sum(axis=1)
        return sites ^ (goes * np.uint8(1 << channel | 1 << back))

    def _reflected(self, sites: np.ndarray) -> np.ndarray:
        assert self.walls is not None
        coin = self._bits(WALLS, 0)
        drawn = np.where(self.walls & DRAW_X, coin, 0) | np.where(self.walls & DRAW_Y, coin << 1, 0)
        return self._mirrors[(self.walls & BOUNCE_BACK) | drawn, sites]
