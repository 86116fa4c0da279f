"""What all evolvers of a lattice gas share: the lattice, its walls, the force, and what they return.

A step is propagation, then the force, then the collision; at wall sites, reflection takes the place of the latter two.
The array of sites is periodic along both axes: a wall is a row, a column or any set of sites of its own, and particles
that enter it leave it one step later.

Literature: Frisch et al., Complex Systems 1, 649 (1987); Cornubert, d'Humieres & Levermore, Physica D 47, 241 (1991)
(walls); Kadanoff, McNamara & Zanetti, Phys. Rev. A 40, 4527 (1989) (force); Hardy, de Pazzis & Pomeau, Phys. Rev. A 13,
1949 (1976) (reversal).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from refimpl.lattice.models import Model
from refimpl.lattice.randomness import DIGITS

#: Rules of a wall site: sums of these. A velocity component is reversed, always or with probability 1/2.
FLUID, REVERSE_X, REVERSE_Y, DRAW_X, DRAW_Y = 0, 1, 2, 4, 8
#: No slip: particles go back where they came from.
BOUNCE_BACK = REVERSE_X | REVERSE_Y
#: Walls whose normal is x, or y: smooth, or diffusive (a particle leaves along either channel with probability 1/2).
SPECULAR_X, SPECULAR_Y = REVERSE_X, REVERSE_Y
DIFFUSIVE_X, DIFFUSIVE_Y = REVERSE_X | DRAW_Y, REVERSE_Y | DRAW_X


class Forcing(NamedTuple):
    """A force along x: with this probability a particle in the channel opposite to `channel` goes over to it, if empty.

    channel: +x or -x. Mean momentum given to a fluid site in a step: 2 probability f_opposite (1 - f_channel) along c;
    the probability counts to 2^-24.
    """

    channel: int
    probability: float

    @property
    def threshold(self) -> int:
        """The probability in units of 2^-24."""
        return round(self.probability * (1 << DIGITS))


class LatticeGas(ABC):
    """A lattice gas at `time`, in steps; `impulses` (rows,): particles that the force has turned in each row.

    passes: (rows,), whose sum is how often a row's sites have been computed.

    model: velocity set and collision table. sites: (rows, columns) of states, uint8, bit i for channel i. walls: (rows,
    columns) of rules, sums of REVERSE_X, REVERSE_Y, DRAW_X, DRAW_Y, or None. seed: of collisions, diffusive walls and
    the force, 0 <= seed < 2^63. forcing: the force, or None.

    Raises ValueError that names the argument for arrays of another shape or type, states beyond the channels, an odd
    number of rows on the triangular lattice, rules above 15, and a force that is not along x or whose probability is
    outside [0, 1].
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
        sites = np.asarray(sites)
        if sites.ndim != 2 or sites.size == 0 or sites.dtype != np.uint8:
            raise ValueError(f"sites must be a (rows, columns) array of uint8, got {sites.dtype} {sites.shape}")
        if int(sites.max()) >= model.velocities.states:
            raise ValueError(f"state {int(sites.max())} is beyond the {model.channels} channels of {model.name}")
        if model.velocities.half_rows and sites.shape[0] % 2:
            raise ValueError(f"{sites.shape[0]} rows: a periodic triangular lattice needs an even number")
        if walls is not None:
            walls = np.asarray(walls)
            if walls.shape != sites.shape:
                raise ValueError(f"walls must have the shape of the sites, {sites.shape}, got {walls.shape}")
            if walls.min() < 0 or walls.max() > 15:
                raise ValueError(f"walls are rules 0 ... 15, got {walls.min()} ... {walls.max()}")
            walls = np.ascontiguousarray(walls, dtype=np.uint8) if walls.any() else None
        if not 0 <= seed < 1 << 63:
            raise ValueError(f"seed = {seed} must be in 0 ... 2^63 - 1")
        if forcing is not None:
            if forcing.channel not in (0, model.velocities.image(-1, 1)[0]):
                raise ValueError(f"a force along channel {forcing.channel}: it must be +x or -x")
            if not 0 <= forcing.probability <= 1:
                raise ValueError(f"forcing.probability = {forcing.probability} is not in [0, 1]")
        self.model = model
        self.rows, self.columns = sites.shape
        self.seed = seed
        self.walls = walls
        self.forcing = forcing
        self.time = 0
        self.impulses = np.zeros(self.rows, dtype=np.int64)
        self.passes = np.zeros(self.rows, dtype=np.int64)

    @property
    @abstractmethod
    def sites(self) -> np.ndarray:
        """States of the sites, (rows, columns) uint8."""

    @abstractmethod
    def _set(self, sites: np.ndarray) -> None:
        """Puts the sites into these states."""

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Takes `steps` steps."""

    def populations(self, down: int, across: int) -> np.ndarray:
        """Particles of each channel in down x across equal blocks, (down, across, b), row 0 and column 0 first.

        Raises ValueError if the blocks do not divide the lattice.
        """
        self._check_blocks(down, across)
        sites = self.sites.reshape(down, self.rows // down, across, self.columns // across)
        counts = [((sites >> i) & 1).sum(axis=(1, 3), dtype=np.int64) for i in range(self.model.channels)]
        return np.stack(counts, axis=-1)

    def _check_blocks(self, down: int, across: int) -> None:
        if down < 1 or across < 1 or self.rows % down or self.columns % across:
            raise ValueError(
                f"{down} x {across} blocks do not divide {self.rows} rows and {self.columns} columns evenly"
            )

    def reverse(self) -> None:
        """Reverses all velocities half-way between two steps: as many steps more lead back, to the same arrays.

        With the collision C and the reversal R the state becomes R C state, which is its own inverse. ValueError where
        the dynamics draws random numbers, or a collision is not its own inverse.
        """
        drawn = self.walls is not None and bool((self.walls & (DRAW_X | DRAW_Y)).any())
        outcomes = np.array([found[0] for found in self.model.outcomes])
        if not self.model.deterministic or drawn or self.forcing is not None:
            raise ValueError("only dynamics without random numbers can be reversed")
        if (outcomes[outcomes] != np.arange(outcomes.size)).any():
            raise ValueError(f"the collisions of {self.model.name} are not their own inverse")
        mirrors = reflections(self.model)
        sites = self.sites
        after = outcomes[sites]
        if self.walls is not None:
            after = np.where(self.walls > 0, mirrors[self.walls & BOUNCE_BACK, sites], after)
        self._set(mirrors[BOUNCE_BACK, after].astype(np.uint8))


def reflections(model: Model) -> np.ndarray:
    """The state with x reversed (1), y reversed (2) or both (3), of a `model`: uint8, (4, 2^b), [rule, state]."""
    states = np.arange(model.velocities.states)
    table = np.zeros((4, states.size), dtype=np.uint8)
    for rule in range(4):
        image = model.velocities.image(-1 if rule & REVERSE_X else 1, -1 if rule & REVERSE_Y else 1)
        for i, j in enumerate(image):
            table[rule] |= ((states >> i & 1) << j).astype(np.uint8)
    return table


def places(model: Model, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Cartesian x and y of the sites of a `model`, in links, (rows, columns) each."""
    v = model.velocities
    row = np.arange(rows)[:, None]
    shift = 0.5 * (row % 2) if v.half_rows else 0.0 * row
    return np.arange(columns) + shift, np.broadcast_to(row * v.row_height, (rows, columns))


def drawn_sites(occupations: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """States of sites, (...) uint8, with channels occupied at random, independently of each other.

    occupations: (..., b) probabilities. generator: of the random numbers.
    """
    found = np.zeros(occupations.shape[:-1], dtype=np.uint8)
    for i in range(occupations.shape[-1]):
        found |= (generator.random(found.shape) < occupations[..., i]).astype(np.uint8) << np.uint8(i)
    return found


def filled_cells(model: Model, density: np.ndarray, cell: int, generator: np.random.Generator) -> np.ndarray:
    """States of cells of cell x cell sites with exact numbers of particles, placed at random in the cell's channels.

    model: gives b channels. density: (rows/cell, columns/cell) mean occupations; a cell gets round(density b cell^2)
    particles. cell: its side, in sites. generator: of the random numbers. Result: (rows, columns) uint8.
    """
    channels, size = model.channels, cell * cell * model.channels
    down, across = density.shape
    # the particles of a cell take the first channels of a random order
    order = generator.random((down, across, size)).argsort(axis=-1)
    filled = order < np.rint(density * size)[..., None]
    bits = filled.reshape(down, across, cell, cell, channels)
    states = (bits << np.arange(channels, dtype=np.uint8)).sum(axis=-1, dtype=np.uint8)
    return states.transpose(0, 2, 1, 3).reshape(down * cell, across * cell)
