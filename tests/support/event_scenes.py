"""Scenes of hard particles for tests. A model's types decide which kernel is compiled: few types, much use."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from refimpl.events.model import Floats, HardSpheres, PlaneWalls, Rough, hard_spheres
from refimpl.events.simulation import Simulation

#: A field that moves nobody: with 0 there is no field at all, by type.
NO_FIELD = 1e-200


def full(number: int, **arguments: Any) -> HardSpheres:
    """`hard_spheres` with everything but wells and a cylinder by type; what is not asked for has neutral values."""
    given = hard_spheres(**arguments)
    d = len(given.lengths)
    neutral = HardSpheres(
        given.lengths, given.periodic, given.diameter, 1.0, np.full(number, given.diameter / 2),
        np.full(number, 1 / given.mass), 1.0, Rough(1.0, math.inf, math.inf, 0.4), (NO_FIELD,) * d, None,
        PlaneWalls(np.zeros(2 * d, bool), np.zeros(2 * d, np.int64), np.zeros((2 * d, 9))), None, 0.0, np.uint64(0),
    )  # fmt: skip
    chosen = {
        name: value if value is not None else getattr(neutral, name)
        for name, value in given._asdict().items()
        if name not in ("mass", "well", "drum")
    }
    return neutral._replace(**chosen)


def disks(**arguments: Any) -> HardSpheres:
    """Disks or spheres with a restitution by type, 1 too."""
    model = hard_spheres(**arguments)
    return model if model.restitution is not None else model._replace(restitution=1.0)


def scatter(
    rng: np.random.Generator,
    lengths: Sequence[float],
    periodic: Sequence[bool],
    diameters: ArrayLike,
    number: int,
    *,
    clearance: float = 0.0,
    circle: tuple[float, int, int] | None = None,
) -> Floats:
    """(N, d) positions without overlap, one after the other at random; so far from walls, and in a circle."""
    radii, sides = np.broadcast_to(np.asarray(diameters) / 2, (number,)), np.array(lengths)
    placed = np.empty((number, len(sides)))
    for i in range(number):
        margin = np.where(periodic, 0.0, radii[i] + clearance)
        for _ in range(10000):
            x = rng.uniform(margin, sides - margin)
            if circle is not None:
                radius, first, second = circle
                if math.hypot(x[first] - sides[first] / 2, x[second] - sides[second] / 2) > radius - radii[i]:
                    continue
            gaps = placed[:i] - x
            gaps -= np.where(periodic, sides * np.round(gaps / sides), 0.0)
            if (np.sum(gaps**2, axis=1) > (radii[:i] + radii[i]) ** 2).all():
                break
        else:
            raise ValueError(f"no room for particle {i}: take a larger box")
        placed[i] = x
    return placed


def thermal(rng: np.random.Generator, number: int, d: int) -> Floats:
    """(N, d) velocities of unit variance and no total momentum."""
    v = rng.normal(size=(number, d))
    return v - v.mean(axis=0)


def fcc(cells: int, packing: float) -> tuple[Floats, float]:
    """Positions of 4 cells^3 spheres of unit diameter, and the box's side."""
    corner = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
    at = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    number = 4 * cells**3
    side = (number * math.pi / 6 / packing) ** (1 / 3)
    return (at + corner).reshape(-1, 3) * side / cells, side


def spheres(cells: int = 3, packing: float = 0.3, seed: int = 1, **options: Any) -> Simulation:
    """Bare spheres of unit temperature from an fcc lattice, traced."""
    x, side = fcc(cells, packing)
    v = thermal(np.random.default_rng(seed), len(x), 3)
    model = hard_spheres(lengths=(side,) * 3, periodic=(True,) * 3)
    return Simulation(model, x, v, **({"trace": True} | options))
