"""Velocity sets of lattice gases, in exact integers.

A site holds at most one particle a channel; channel i moves by c_i in a step, and is bit i of the site's state. Lengths
are lattice links, times are steps. The triangular lattice lies on a rectangular array: the site in column x of row y is
at (x + (y mod 2)/2, y sqrt(3)/2), that of the square lattice at (x, y).

Literature: Hardy, de Pazzis & Pomeau, Phys. Rev. A 13, 1949 (1976); Frisch et al., Complex Systems 1, 649 (1987).
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np


class VelocitySet:
    """b channels. integers[i] = c_i in the units `unit`; the rest channel, if there is one, is the last.

    half_rows: odd rows are shifted by half a link.
    """

    def __init__(self, integers: tuple[tuple[int, int], ...], unit: tuple[float, float], half_rows: bool) -> None:
        self.integers = integers
        self.unit = unit
        self.half_rows = half_rows

    @property
    def channels(self) -> int:
        """b."""
        return len(self.integers)

    @property
    def states(self) -> int:
        """2^b."""
        return 1 << self.channels

    @cached_property
    def cartesian(self) -> np.ndarray:
        """c_i, (b, 2)."""
        return np.array(self.integers) * np.array(self.unit)

    @property
    def row_height(self) -> float:
        """Distance between rows."""
        return self.unit[1]

    @cached_property
    def rest(self) -> tuple[int, ...]:
        """Channels that do not move."""
        return tuple(i for i, c in enumerate(self.integers) if c == (0, 0))

    def image(self, sign_x: int, sign_y: int) -> tuple[int, ...]:
        """Channel of (sign_x c_ix, sign_y c_iy), for each i."""
        return tuple(self.integers.index((sign_x * a, sign_y * b)) for a, b in self.integers)

    def column_shift(self, channel: int, row: int) -> int:
        """Columns from the site that a particle comes from to the one in `row` that it arrives at."""
        a, b = self.integers[channel]
        if not self.half_rows:
            return a
        return (a + (row - b) % 2 - row % 2) // 2

    def mass(self, state: int) -> int:
        """Number of particles."""
        return state.bit_count()

    def momentum(self, state: int) -> tuple[int, int]:
        """Sum of c_i over the particles, in `unit`: exact."""
        there = [c for i, c in enumerate(self.integers) if state >> i & 1]
        return sum(a for a, _ in there), sum(b for _, b in there)


_HEXAGON = ((2, 0), (1, 1), (-1, 1), (-2, 0), (-1, -1), (1, -1))
_HALF = (0.5, math.sqrt(3) / 2)

#: Four links, counter-clockwise from +x.
SQUARE = VelocitySet(((1, 0), (0, 1), (-1, 0), (0, -1)), (1.0, 1.0), half_rows=False)
#: Six links at multiples of 60 degrees, from +x.
TRIANGULAR = VelocitySet(_HEXAGON, _HALF, half_rows=True)
#: The same with a particle at rest.
TRIANGULAR_REST = VelocitySet((*_HEXAGON, (0, 0)), _HALF, half_rows=True)
