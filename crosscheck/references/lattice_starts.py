"""Initial states of lattice gases, from the words of a scene: mean occupations of sites, and fixed numbers of cells.

Units: links and steps. Derived from coordinates and from the two properties that make occupations an equilibrium of
Fermi and Dirac: their sums, and that the logarithm of f/(1 - f) is a constant plus a vector times the velocity. There
is one such set of occupations for a density and a velocity, so nothing need be solved to recognise it.

Literature: U. Frisch et al., Complex Systems 1, 649 (1987).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.references.lattice_audit import Lattice, velocities
from crosscheck.scene.parts import Occupations

Floats = NDArray[np.float64]


class Fields(NamedTuple):
    """What a scene asks for at each site: density (rows, columns) and velocity (rows, columns, 2)."""

    density: Floats
    velocity: Floats


def fields(lattice: Lattice, initial: Occupations) -> Fields:
    """Density and velocity that `initial` asks for, at the places of the sites of `lattice`; with `density` given."""
    parts = {}
    for name in ("density", "velocity_x", "velocity_y"):
        value = getattr(initial, name)
        column = np.array(value if isinstance(value, tuple) else [value] * lattice.rows, dtype=np.float64)
        parts[name] = np.repeat(column[:, None], lattice.columns, axis=1)
    for wave in initial.waves:
        turns = lattice.places / lattice.box @ np.array(wave.mode)
        parts[wave.of] = parts[wave.of] + wave.amplitude * np.cos(2 * np.pi * turns + wave.phase)
    return Fields(parts["density"], np.stack([parts["velocity_x"], parts["velocity_y"]], axis=-1))


def deviation_from_equilibrium(model: str, occupations: Floats, asked: Fields) -> tuple[float, float]:
    """How far occupations are from the equilibrium asked for: the largest error of a sum, and of an occupation.

    The first is that of sum f_i and sum f_i c_i, over b. The second: what is left of ln(f/(1 - f)) beside 1 and c_i,
    times f (1 - f), the change of an occupation that would cause it. Both are zero for the equilibrium alone.

    model: a name of `lattice_models.MODELS`. occupations: (..., b), none of them 0 or 1. asked: for each of the sites.
    """
    c = velocities(model)
    charges = np.column_stack([np.ones(len(c)), c])
    sums = asked.density[..., None] * np.concatenate([np.ones((*asked.velocity.shape[:-1], 1)), asked.velocity], -1)
    missed = np.abs(occupations @ charges / len(c) - sums).max()
    logarithm = np.log(occupations) - np.log1p(-occupations)
    kept, _ = np.linalg.qr(charges)
    beside = logarithm - logarithm @ kept @ kept.T
    return float(missed), float(np.abs(beside * occupations * (1 - occupations)).max())


def numbers_of_cells(model: str, rows: int, columns: int, initial: Occupations) -> Floats:
    """Particles of each cell, (cells down, cells across), of a start with `initial.cells`.

    model: a name of `lattice_models.MODELS`. rows, columns: of the lattice. ValueError without cells.
    """
    if initial.cells is None or isinstance(initial.density, tuple) or initial.density is None:
        raise ValueError("a start without cells has no numbers of cells")
    down, across = rows // initial.cells, columns // initial.cells
    found = np.empty((down, across))
    for row in range(down):
        for column in range(across):
            x, y = column / max(across - 1, 1), row / max(down - 1, 1)
            density = initial.density + sum(
                wave.amplitude * np.cos(2 * np.pi * (wave.mode[0] * x + wave.mode[1] * y) + wave.phase)
                for wave in initial.waves
            )
            found[row, column] = np.rint(density * len(velocities(model)) * initial.cells**2)
    return found
