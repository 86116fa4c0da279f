"""A lattice gas of bit planes: 512 sites an operation, threads by rows, the same bits for any number of threads."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np

from refimpl.lattice.gas import DRAW_X, DRAW_Y, REVERSE_X, REVERSE_Y, Forcing, LatticeGas
from refimpl.lattice.kernels.planes import PAD, Push, advance, populations, seal
from refimpl.lattice.kernels.words import WIDTH
from refimpl.lattice.models import Model

# In words of 8 bytes. Neighbouring planes, and source and target, must not lie a multiple of 4096 bytes apart: the
# processor would make loads wait for stores to the same offset of another page, and planes would share cache lines.
_PAGE, _HUGE, _APART = 512, 1 << 18, 72


class PlaneGas(LatticeGas):
    """One plane of bits a channel.

    model, sites, seed, walls, forcing: as of `LatticeGas`, with its errors. threads: each takes a stretch
    of rows; ValueError if there is none.
    """

    def __init__(
        self,
        model: Model,
        sites: np.ndarray,
        *,
        threads: int = 1,
        seed: int = 0,
        walls: np.ndarray | None = None,
        forcing: Forcing | None = None,
    ) -> None:
        super().__init__(model, sites, seed=seed, walls=walls, forcing=forcing)
        if threads < 1:
            raise ValueError(f"threads = {threads} must be at least 1")
        words = -(-self.columns // (64 * WIDTH)) * WIDTH
        stride = words + 2 * PAD
        size = self.rows * stride + _APART
        self._shape = (self.rows, self.columns, words, stride, size)
        self._source = _aligned(model.channels * size, 0)
        self._target = _aligned(model.channels * size, _PAGE // 2)
        self._edges = [self.rows * k // threads for k in range(threads + 1)]
        self._set(np.asarray(sites))
        rules: Any = (None, None) if self.walls is None else self._wall_planes(self.walls)
        inside = np.ones((1, self.columns), dtype=np.uint8)
        channel = None if self.forcing is None else self.forcing.channel
        push = None
        if self.forcing is not None:
            push = Push(self.forcing.threshold, 1 if channel == 0 else -1, self._packed(inside)[0], self.impulses)
        #: the arguments of the kernel that never change; what a scene does not have is None, and not compiled
        self._fixed: tuple[Any, ...] = (*rules, push, self._shape, self.passes)

    @property
    def sites(self) -> np.ndarray:
        found = np.zeros((self.rows, self.columns), dtype=np.uint8)
        for channel, plane in enumerate(self._planes(self._source)):
            bits = np.unpackbits(np.ascontiguousarray(plane).astype("<u8").view(np.uint8), axis=1, bitorder="little")
            found |= bits[:, : self.columns] << np.uint8(channel)
        return found

    def _set(self, sites: np.ndarray) -> None:
        for channel, plane in enumerate(self._planes(self._source)):
            plane[:] = self._packed(sites >> np.uint8(channel) & 1)
        seal(self._source, self._shape)

    def advance(self, steps: int) -> None:
        if len(self._edges) == 2:
            self._take(self._source, self._target, 0, self.rows, steps)
            if steps % 2:
                self._source, self._target = self._target, self._source
            self.time += steps
            return
        with ThreadPoolExecutor(len(self._edges) - 1) as pool:
            for _ in range(steps):
                parts = [
                    pool.submit(self._take, self._source, self._target, *ends, 1) for ends in pairwise(self._edges)
                ]
                for part in parts:
                    part.result()
                self._source, self._target = self._target, self._source
                self.time += 1

    def populations(self, down: int, across: int) -> np.ndarray:
        self._check_blocks(down, across)
        counts = np.zeros((down, across, self.model.channels), dtype=np.int64)
        populations(self._source, counts, self._shape)
        return counts

    def _take(self, source: np.ndarray, target: np.ndarray, first: int, last: int, steps: int) -> None:
        seed = np.uint64(self.seed)
        kernel: Any = advance  # its signature is compiled
        kernel(self.model, source, target, *self._fixed, (first, last), seed, self.time, steps)

    def _planes(self, array: np.ndarray) -> Iterator[np.ndarray]:
        """Views (rows, words) of the planes."""
        rows, _, words, stride, size = self._shape
        for plane in array.reshape(-1, size):
            yield plane[: rows * stride].reshape(rows, stride)[:, PAD : PAD + words]

    def _packed(self, bits: np.ndarray) -> np.ndarray:
        """(rows, columns) of 0 and 1 as (rows, words)."""
        padded = np.zeros((bits.shape[0], self._shape[2] * 64), dtype=np.uint8)
        padded[:, : self.columns] = bits
        return np.packbits(padded, axis=1, bitorder="little").view("<u8").astype(np.uint64)

    def _wall_planes(self, walls: np.ndarray) -> tuple[Any, Any]:
        rows, _, words, stride, size = self._shape

        def plane(rule: int) -> np.ndarray:
            array = np.zeros(size, dtype=np.uint64)
            array[: rows * stride].reshape(rows, stride)[:, PAD : PAD + words] = self._packed(walls & rule > 0)
            return array

        drawn = (walls & (DRAW_X | DRAW_Y)).any()
        return (plane(REVERSE_X), plane(REVERSE_Y)), (plane(DRAW_X), plane(DRAW_Y)) if drawn else None


def _aligned(words: int, offset: int) -> np.ndarray:
    """Zeros that start `offset` words behind the boundary of a page; of a huge page where the array is that large.

    numpy asks the system for huge pages for memory that it need not have zeroed; with them the rates vary less.
    """
    page = _HUGE if words > 2 * _HUGE else _PAGE
    array = np.empty(words + page + _PAGE, dtype=np.uint64)
    start = -(array.ctypes.data // 8) % page + offset
    found = array[start : start + words]
    found[:] = 0
    return found
