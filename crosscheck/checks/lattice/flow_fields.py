"""Velocity fields of flows of FHP-III, and how they are drawn.

With the factor g(rho) in front of the advection, g u takes the place of the velocity in Reynolds and Strouhal numbers.
"""

from __future__ import annotations

import numpy as np

from crosscheck.figure import FieldMap, Figure, Frame
from crosscheck.references.lattice_models import VELOCITIES
from crosscheck.scene import Floats

#: The gas of these flows: the one with the smallest viscosity.
MODEL = "fhp3"


def mean_velocity(counts: Floats) -> Floats:
    """Mean velocity of blocks, (..., 2), links per step; NaN in empty blocks.

    counts: particles by channel, (..., b).
    """
    mass = counts.sum(axis=-1)
    with np.errstate(invalid="ignore"):
        return counts @ VELOCITIES[MODEL].cartesian / np.where(mass > 0, mass, np.nan)[..., None]


def vorticity_map(title: str, velocity: Floats, size: tuple[float, float], coarse: int) -> Figure:
    """Vorticity of blocks with arrows of the velocity on blocks `coarse` times as large.

    title: of the figure. velocity: (blocks along x, along y, 2), links per step. size: of the whole field along x and
    y, in links.
    """
    width, height = size
    nx, ny = velocity.shape[:2]
    filled_in = np.nan_to_num(velocity)
    vorticity = np.gradient(filled_in[..., 1], width / nx, axis=0) - np.gradient(filled_in[..., 0], height / ny, axis=1)
    limit = float(np.quantile(np.abs(vorticity), 0.98))
    blocks = filled_in.reshape(nx // coarse, coarse, ny // coarse, coarse, 2).mean(axis=(1, 3))
    arrows = (blocks[..., 0].T.tolist(), blocks[..., 1].T.tolist())
    frame = Frame(0.0, width, 0.0, height, ())
    field = FieldMap(vorticity.T.tolist(), frame, "vorticity", (-limit, limit), arrows, "velocity")
    return Figure(title, "x", "y", map=field)
