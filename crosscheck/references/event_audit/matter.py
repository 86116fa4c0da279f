"""What a scene of hard spheres says of its particles and walls, as numbers.

By derivation from the definitions of the words of a scene.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from crosscheck.scene import Floats, HardSpheres, Scene
from crosscheck.scene.parts import Cylinder, Face, Friction


@dataclass(frozen=True)
class Matter:
    """Particles, laws and walls of a scene of hard spheres.

    dimension: d. lengths: sides of the box, (d,), length; infinite without a box. periods: the same along periodic axes
    and 0 along others. masses: (N,), mass; of fixed particles infinite. inverse: 1/mass, 0 of fixed ones. radii: (N,),
    length. places: positions at the start, (N, d), length. moments: moments of inertia q m R^2, (N,); infinite of fixed
    ones. shape: q; of balls and disks unless the scene says otherwise. acceleration: (3,), the third component 0 in the
    plane. spheres: the table [hard_spheres]. faces: walls x-, x+, y- ..., None where there is none. cylinder: None
    without one. across: the two axes across it.
    """

    dimension: int
    lengths: Floats
    periods: Floats
    masses: Floats
    inverse: Floats
    radii: Floats
    places: Floats
    moments: Floats
    shape: float
    acceleration: Floats
    spheres: HardSpheres
    faces: tuple[Face | None, ...]
    cylinder: Cylinder | None
    across: tuple[int, ...]

    @property
    def number(self) -> int:
        """N."""
        return len(self.masses)

    @cached_property
    def fixed(self) -> NDArray[np.bool_]:
        """Which particles never move, (N,)."""
        return self.inverse == 0.0

    @cached_property
    def weights(self) -> Floats:
        """(N,) masses that carry momentum and energy: 0 of fixed particles."""
        return np.where(self.fixed, 0.0, self.masses)

    @property
    def well_range(self) -> float:
        """Edge of the well in contact distances; 1 without a well."""
        return 1.0 if self.spheres.well is None else self.spheres.well.range

    @property
    def depth(self) -> float:
        """Depth of the well, energy; 0 without one."""
        return 0.0 if self.spheres.well is None else self.spheres.well.depth

    def nearest(self, gaps: Floats) -> Floats:
        """Differences of positions, `gaps` (..., d), length, as those to the nearest image."""
        turns = np.round(gaps / np.where(self.periods > 0, self.periods, 1.0))
        return np.asarray(gaps - np.where(self.periods > 0, self.periods * turns, 0.0))


def matter_of(scene: Scene) -> Matter:
    """The particles and walls of a scene of hard spheres, from its initial state."""
    spheres = scene.hard_spheres
    assert spheres is not None
    state, fixed, d = scene.initial_state(), scene.fixed(), scene.dimension
    assert state.diameters is not None
    masses, radii = np.where(fixed, math.inf, state.masses), state.diameters / 2
    friction = spheres.friction
    shape = 2 / 5 if d == 3 else 1 / 2
    if friction is not None and friction.inertia is not None:
        shape = friction.inertia
    acceleration = np.zeros(3)
    acceleration[:d] = 0.0 if scene.acceleration is None else scene.acceleration
    lengths = scene.lengths()
    return Matter(
        dimension=d,
        lengths=np.full(d, math.inf) if lengths is None else lengths,
        periods=scene.periods(),
        masses=masses,
        inverse=np.where(fixed, 0.0, 1 / state.masses),
        radii=radii,
        places=state.positions,
        moments=np.where(fixed, math.inf, shape * state.masses * radii**2),
        shape=shape,
        acceleration=acceleration,
        spheres=spheres,
        faces=scene.faces,
        cylinder=None if scene.box is None else scene.box.cylinder,
        across=scene.across,
    )


def wall_motion(wall: Face, time: float) -> tuple[float, float]:
    """Displacement (length) and velocity (length/time) of a plane wall, both into the box.

    wall: not one of random phase. time: since the start.
    """
    if wall.oscillation is not None:
        amplitude, frequency, phase = wall.oscillation.amplitude, wall.oscillation.frequency, wall.oscillation.phase
        angle = frequency * time + phase
        return amplitude * math.cos(angle), -amplitude * frequency * math.sin(angle)
    return 0.0, wall.velocity or 0.0


def law_of(friction: Friction | None) -> tuple[float, float, float]:
    """Tangential restitution, static and sliding coefficient of friction; (1, inf, inf) of smooth surfaces."""
    if friction is None:
        return 1.0, math.inf, math.inf
    return (
        friction.tangential_restitution,
        math.inf if friction.static is None else friction.static,
        math.inf if friction.sliding is None else friction.sliding,
    )
