"""The nonlinear lattice Boltzmann equation: a lattice gas whose occupations are independent before each collision.

f_i(r + c_i, t + 1) = f_i(r, t) + Delta_i(f(r, t)), on mean occupations; lattice links, steps.

Literature: U. Frisch et al., Complex Systems 1, 649 (1987); G. R. McNamara and G. Zanetti, Phys. Rev. Lett. 61, 2332
(1988).
"""

from __future__ import annotations

from functools import cache
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from refimpl.lattice.gas import Forcing
from refimpl.lattice.models import Model
from refimpl.lattice.velocities import VelocitySet

Floats: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.intp]


class BoltzmannLattice:
    """Mean occupations f, advanced step by step; the edges of the array are periodic.

    A step is propagation; then the force at fluid sites; then collision at fluid sites, reflection at wall sites.

    model: the velocity set and the collisions. f: (rows, columns, b) mean occupations, in [0, 1].
    walls: (rows, columns); 0 fluid; 1 reverses the x component of the velocity, 2 the y component, 4 and 8 do so with
    probability 1/2, on one draw; their sums do both. 3 is bounce-back, 2 a specular and 6 a diffusive wall whose normal
    is y; 1 and 9 those whose normal is x. No walls: None.
    forcing: with probability p a particle of the channel opposite to i turns into channel i if that is free, so that
    p f_opp (1 - f_i) moves on average. None: no force.

    ValueError for arrays of the wrong shape, an odd number of rows on the triangular lattice, occupations outside
    [0, 1], walls above 15, and a force along no channel, along a rest channel or with a probability outside [0, 1].
    """

    def __init__(
        self, model: Model, f: ArrayLike, walls: ArrayLike | None = None, forcing: Forcing | None = None
    ) -> None:
        self.model = model
        self.f = np.array(f, dtype=np.float64, order="C")  # the order of sums over it
        self.time = 0
        #: its sum is how often a row's sites have been computed
        self.passes = np.zeros(self.f.shape[0], dtype=np.int64)
        velocities = model.velocities
        if self.f.ndim != 3 or self.f.shape[2] != model.channels:
            raise ValueError(f"f must have the shape (rows, columns, {model.channels}), got {self.f.shape}")
        if velocities.half_rows and self.f.shape[0] % 2:
            raise ValueError(f"a periodic triangular lattice has an even number of rows, got {self.f.shape[0]}")
        wrong = ~((self.f >= 0) & (self.f <= 1))
        if wrong.any():
            raise ValueError(f"occupations must be between 0 and 1, got {self.f[wrong][0]}")
        self.forcing = forcing
        if forcing is not None:
            if not 0 <= forcing.channel < model.channels or forcing.channel in velocities.rest:
                raise ValueError(f"a drive needs a channel that moves, got {forcing.channel}")
            if not 0 <= forcing.probability <= 1:
                raise ValueError(f"the probability of a drive must be between 0 and 1, got {forcing.probability}")
        self._sources = _sources(velocities, *self.f.shape[:2])
        codes = np.zeros(self.f.shape[:2], dtype=np.uint8) if walls is None else np.asarray(walls)
        if codes.shape != self.f.shape[:2]:
            raise ValueError(f"walls must have the shape {self.f.shape[:2]}, got {codes.shape}")
        wrong = ~((codes >= 0) & (codes <= 15))
        if wrong.any():
            raise ValueError(f"walls are numbered 0 to 15, got {codes[wrong][0]}")
        self._fluid: Indices = np.flatnonzero(codes == 0)
        self._walls = [
            (np.flatnonzero(codes == code), _reflection(velocities, int(code))) for code in np.unique(codes) if code
        ]

    def advance(self, steps: int) -> None:
        """Takes `steps` steps."""
        for _ in range(steps):
            arrived = self.f.take(self._sources).reshape(-1, self.model.channels)
            fluid = arrived[self._fluid] if self._walls else arrived
            if self.forcing is not None:
                self._drive(fluid, self.forcing)
            fluid += _collision_term(self.model, fluid)
            if self._walls:
                arrived[self._fluid] = fluid
            for sites, reflection in self._walls:
                arrived[sites] = arrived[sites] @ reflection
            self.f = arrived.reshape(self.f.shape)
            self.time += 1
            self.passes += 1

    def _drive(self, fluid: Floats, forcing: Forcing) -> None:
        i, opposite = forcing.channel, self.model.velocities.image(-1, -1)[forcing.channel]
        moved = forcing.probability * fluid[:, opposite] * (1 - fluid[:, i])
        fluid[:, opposite] -= moved
        fluid[:, i] += moved

    def populations(self, down: int, across: int) -> Floats:
        """Mean particles of each channel in down x across equal blocks, (down, across, b), row 0 and column 0 first.

        Raises ValueError if the blocks do not divide the lattice.
        """
        rows, columns, channels = self.f.shape
        if down < 1 or across < 1 or rows % down or columns % across:
            raise ValueError(f"{down} x {across} blocks do not divide {rows} rows and {columns} columns evenly")
        return np.asarray(self.f.reshape(down, rows // down, across, columns // across, channels).sum(axis=(1, 3)))

    @property
    def h_function(self) -> float:
        """H = sum of f ln f + (1 - f) ln(1 - f): never increases without a force."""
        # occupations that round-off has carried past 0 or 1 count as 0 or 1
        both = np.stack([self.f, 1 - self.f])
        return float((both * np.log(np.where(both > 0, both, 1.0))).sum())


@cache
def _changes(model: Model) -> tuple[NDArray[np.bool_], Floats]:
    """Of the active states: the channels that are occupied, (n, b), and the mean change by a collision, (n, b)."""
    occupied = np.array([[s >> i & 1 for i in range(model.channels)] for s in range(model.velocities.states)])
    active = list(model.active)
    after = np.array([occupied[list(model.outcomes[s])].mean(axis=0) for s in active]).reshape(-1, model.channels)
    return occupied[active].astype(bool), after - occupied[active]


def _collision_term(model: Model, f: Floats) -> Floats:
    """Delta_i = sum_ss' (s'_i - s_i) A(s -> s') prod_j f_j^s_j (1 - f_j)^(1 - s_j); (..., b) of f (..., b).

    The mean change by a collision, if the occupations of a site are independent.
    """
    occupied, change = _changes(model)
    probability = np.ones((*f.shape[:-1], len(occupied)))
    for i in range(model.channels):
        here = f[..., i, None]
        probability *= np.where(occupied[:, i], here, 1 - here)
    return np.asarray(probability @ change)


def _sources(velocities: VelocitySet, rows: int, columns: int) -> Indices:
    """Where, in the flat array of occupations, those come from that arrive: (rows, columns, b)."""
    row = np.arange(rows)
    sources = np.empty((rows, columns, velocities.channels), dtype=np.intp)
    for i, (_, up) in enumerate(velocities.integers):
        shift = np.array([velocities.column_shift(i, y) for y in row.tolist()])
        column = (np.arange(columns) - shift[:, None]) % columns
        sources[..., i] = (((row - up) % rows)[:, None] * columns + column) * velocities.channels + i
    return sources


def _reflection(velocities: VelocitySet, code: int) -> Floats:
    """R_ij of a wall, (b, b): the mean part of what arrives in channel i that leaves in channel j."""

    def turned(flips: int) -> Floats:
        image = velocities.image(-1 if flips & 1 else 1, -1 if flips & 2 else 1)
        return np.asarray(np.eye(velocities.channels)[list(image)])

    always = code & 3
    return (turned(always) + turned(always | code >> 2)) / 2
