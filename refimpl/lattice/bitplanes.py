"""A lattice gas of bit planes: 512 sites an operation, blocks of steps, threads by rows.

No bit depends on the blocks or on the number of threads.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from refimpl.lattice.gas import DRAW_X, DRAW_Y, REVERSE_X, REVERSE_Y, Forcing, LatticeGas
from refimpl.lattice.kernels.planes import PAD, Push, advance, populations, seal
from refimpl.lattice.kernels.words import WIDTH
from refimpl.lattice.models import Model

# Words of 8 bytes that a band of rows, and all rows of a block of steps, may take in both copies: a core's first cache,
# 32 kB or more, and three quarters of its second one, 512 kB or more in the processors of today.
_BAND, _BLOCK = 4096, 49152
# Rows of a band, and steps of a block, of narrow rows. More of either gains nothing.
_ROWS, _STEPS = 16, 128
# In words of 8 bytes. Neighbouring planes, and source and target, must not lie a multiple of 4096 bytes apart: the
# processor would make loads wait for stores to the same offset of another page, and planes would share cache lines.
_PAGE, _HUGE, _APART = 512, 1 << 18, 72


class PlaneGas(LatticeGas):
    """One plane of bits a channel; `fetches` (rows,), whose sum is how often a row was fetched, for a step or several.

    model, sites, seed, walls, forcing: as of `LatticeGas`, with its errors. threads: each takes a stretch of rows;
    ValueError if there is none. block: steps that are taken in one pass over memory, at most; None: what fits into the
    cache. ValueError below 1.
    """

    def __init__(
        self,
        model: Model,
        sites: np.ndarray,
        *,
        threads: int = 1,
        block: int | None = None,
        seed: int = 0,
        walls: np.ndarray | None = None,
        forcing: Forcing | None = None,
    ) -> None:
        super().__init__(model, sites, seed=seed, walls=walls, forcing=forcing)
        if threads < 1:
            raise ValueError(f"threads = {threads} must be at least 1")
        if block is not None and block < 1:
            raise ValueError(f"block = {block} must be at least 1")
        words = -(-self.columns // (64 * WIDTH)) * WIDTH
        stride = words + PAD
        size = self.rows * stride + _APART
        copy = -(-model.channels * size // _PAGE) * _PAGE + _PAGE // 2
        self._shape = (self.rows, self.columns, words, stride, size, copy)
        self._planes = _aligned(2 * copy)
        self._current = 0  # of the two copies, that of the present state
        self._band, most = _in_cache(2 * model.channels * stride)
        self._block, self._phases = _tiling(self.rows, threads, most if block is None else block)
        self._helpers = ThreadPoolExecutor(threads - 1) if threads > 1 else None
        self.fetches = np.zeros(self.rows, dtype=np.int64)
        self._set(np.asarray(sites))
        rules: Any = (None, None) if self.walls is None else self._wall_planes(self.walls)
        inside = np.ones((1, self.columns), dtype=np.uint8)
        channel = None if self.forcing is None else self.forcing.channel
        push = None
        if self.forcing is not None:
            push = Push(self.forcing.threshold, 1 if channel == 0 else -1, self._packed(inside)[0], self.impulses)
        #: the arguments of the kernel that never change; what a scene does not have is None, and not compiled
        self._fixed: tuple[Any, ...] = (*rules, push, self._shape, self.passes, self.fetches)

    @property
    def sites(self) -> np.ndarray:
        found = np.zeros((self.rows, self.columns), dtype=np.uint8)
        for channel, plane in enumerate(self._words()):
            bits = np.unpackbits(np.ascontiguousarray(plane).astype("<u8").view(np.uint8), axis=1, bitorder="little")
            found |= bits[:, : self.columns] << np.uint8(channel)
        return found

    def _set(self, sites: np.ndarray) -> None:
        for channel, plane in enumerate(self._words()):
            plane[:] = self._packed(sites >> np.uint8(channel) & 1)
        seal(self._planes, self._current, self._shape)

    def advance(self, steps: int) -> None:
        if self._helpers is None:
            self._take(np.concatenate(self._phases), steps)
            self._done(steps)
            return
        self._take(self._phases[0], 0)  # compiles, in one thread
        while steps:
            now = min(steps, self._block)
            for tiles in self._phases:
                parts = [self._helpers.submit(self._take, tile[None], now) for tile in tiles[1:]]
                self._take(tiles[:1], now)
                for part in parts:
                    part.result()
            self._done(now)
            steps -= now

    def _done(self, steps: int) -> None:
        self._current = (self._current + steps) % 2
        self.time += steps

    def populations(self, down: int, across: int) -> np.ndarray:
        self._check_blocks(down, across)
        counts = np.zeros((down, across, self.model.channels), dtype=np.int64)
        populations(self._planes, self._current, counts, self._shape)
        return counts

    def _take(self, tiles: np.ndarray, steps: int) -> None:
        kernel: Any = advance  # its signature is compiled
        kernel(
            self.model, self._planes, self._current, *self._fixed, tiles, np.uint64(self.seed), self.time, steps,
            self._block, self._band,
        )  # fmt: skip

    def _words(self) -> Iterator[np.ndarray]:
        """Views (rows, words) of the planes of the present state."""
        rows, _, words, stride, size, copy = self._shape
        for channel in range(self.model.channels):
            start = self._current * copy + channel * size + PAD
            yield self._planes[start : start + rows * stride].reshape(rows, stride)[:, :words]

    def _packed(self, bits: np.ndarray) -> np.ndarray:
        """(rows, columns) of 0 and 1 as (rows, words)."""
        padded = np.zeros((bits.shape[0], self._shape[2] * 64), dtype=np.uint8)
        padded[:, : self.columns] = bits
        return np.packbits(padded, axis=1, bitorder="little").view("<u8").astype(np.uint64)

    def _wall_planes(self, walls: np.ndarray) -> tuple[Any, Any]:
        rows, _, words, stride, size, _ = self._shape

        def plane(rule: int) -> np.ndarray:
            array = np.zeros(size, dtype=np.uint64)
            array[PAD : PAD + rows * stride].reshape(rows, stride)[:, :words] = self._packed(walls & rule > 0)
            return array

        drawn = (walls & (DRAW_X | DRAW_Y)).any()
        return (plane(REVERSE_X), plane(REVERSE_Y)), (plane(DRAW_X), plane(DRAW_Y)) if drawn else None


def _in_cache(width: int) -> tuple[int, int]:
    """Rows of a band, and steps of a block, for rows of `width` words in both copies.

    Rows wider than a cache have some steps too: the next larger cache may hold them.
    """
    band = min(max(_BAND // width, 4), _ROWS)
    return band, min(max(_BLOCK // width - band, 8), _STEPS)


def _tiling(rows: int, threads: int, most: int) -> tuple[int, list[np.ndarray]]:
    """Steps of a block, at most `most`, and phases of tiles: tiles of one phase may be taken at the same time.

    First a stretch of rows a thread, that gets shorter by a row at both ends in each step; then what these leave out
    between them. Where a stretch is too short for two steps, all its rows are taken, one step at a time.
    """
    edges = np.array([rows * k // threads for k in range(threads + 1)])
    first, last = edges[:-1], edges[1:]
    block = min(most, int((last - first).min()) // 2)
    if block < 2:
        return 1, [np.stack([first, last, np.zeros_like(first)], axis=1)]
    slope = np.ones_like(first)
    return block, [np.stack([first, last, slope], axis=1), np.stack([last, last, -slope], axis=1)]


def _aligned(words: int) -> np.ndarray:
    """Zeros that start at the boundary of a page; of a huge page where the array is that large.

    numpy asks the system for huge pages for memory that it need not have zeroed; with them the rates vary less.
    """
    page = _HUGE if words > 2 * _HUGE else _PAGE
    array = np.empty(words + page, dtype=np.uint64)
    start = -(array.ctypes.data // 8) % page
    found = array[start : start + words]
    found[:] = 0
    return found
