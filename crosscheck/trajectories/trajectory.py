"""The trajectory that a run recorded, as writers of files take it: in space, with its box and its particles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosscheck.engines.protocol import Run, strides
from crosscheck.engines.soft_spheres import inertia_ratio
from crosscheck.scene import Floats, Method, Scene

#: What a file may hold beside times, steps, positions, box, masses and species: vectors of each particle at each time
#: (S, N, 3), and constants of the particles (N,). Moments of inertia are those of grains that rotate.
QUANTITIES = ("velocities", "angular_velocities", "radius", "moment_of_inertia")


@dataclass(frozen=True)
class Trajectory:
    """N particles in space at S times, up to the last sample that is finite.

    The vectors of a scene of fewer dimensions are completed with zeros; in the plane, rotation is about z. Units are
    the scene's own.

    time: (S,), time. steps: (S,), number of time steps before each sample; of a run without time steps, numbers of the
    samples. positions: (S, N, 3), length, not wrapped into the box. dimension: of the scene. cell: sides of the box,
    (3,), length, its lower corner at 0; 0 along axes without a box. periodic: which axes are, (3,). walled: which of
    the lower and upper faces of the box are plane walls, (3, 2). masses: (N,), mass. species: (N,), from 0, or None if
    the scene has no species. more: name -> (S, N, 3) vectors or (N,) constants, those of `QUANTITIES` that there are.
    """

    time: Floats
    steps: NDArray[np.int64]
    positions: Floats
    dimension: int
    cell: Floats
    periodic: NDArray[np.bool_]
    walled: NDArray[np.bool_]
    masses: Floats
    species: NDArray[np.int64] | None
    more: dict[str, Floats]

    @property
    def species_of_all(self) -> NDArray[np.int64]:
        """The species of each particle, (N,): 0 where the scene has none."""
        return np.zeros(len(self.masses), dtype=np.int64) if self.species is None else self.species


def trajectory_of(scene: Scene, run: Run, method: Method | None = None) -> Trajectory | None:
    """The trajectory that `run`, a run of `scene`, recorded; None if it recorded none.

    method: of the run, whose steps are counted; None: that of the scene.
    """
    positions, velocities = run.get("positions"), run.get("velocities")
    spins = run.get("angular_velocities")
    if positions is None:
        return None
    good = min(_good_samples(values) for values in (positions, velocities, spins) if values is not None)
    state = scene.own_start()
    cell, periodic, walled = np.zeros(3), np.zeros(3, dtype=bool), np.zeros((3, 2), dtype=bool)
    if state.lengths is not None:
        cell[: scene.dimension] = state.lengths
        periodic[: scene.dimension] = [boundary == "periodic" for boundary in scene.boundaries]
        faces = np.reshape([face is not None for face in scene.faces], (-1, 2))
        walled[: scene.dimension] = faces | [[boundary == "wall"] for boundary in scene.boundaries]
    more: dict[str, Floats] = {}
    if velocities is not None:
        more["velocities"] = in_space(velocities[:good])
    if spins is not None:
        more["angular_velocities"] = np.pad(spins[:good], ((0, 0), (0, 0), (3 - spins.shape[2], 0)))
    if state.diameters is not None:
        more["radius"] = state.diameters / 2
        if spins is not None:
            more["moment_of_inertia"] = inertia_ratio(scene) * state.masses * (state.diameters / 2) ** 2
    return Trajectory(
        run["time"][:good],
        np.arange(good) * _steps_between(scene, scene.method if method is None else method),
        in_space(positions[:good]),
        scene.dimension,
        cell,
        periodic,
        walled,
        state.masses,
        state.species,
        more,
    )


def _good_samples(samples: Floats) -> int:
    """Number of samples, of (S, N, k), before the first one with a number that is not finite."""
    good = np.isfinite(samples).all(axis=(1, 2))
    return good.size if good.all() else int(np.argmin(good))


def _steps_between(scene: Scene, method: Method | None) -> int:
    """Time steps from one sample to the next; 1 for a method that has none, or whose engine chooses their length."""
    return 1 if method is None or method.dt is None else strides(scene, method)[1]


def in_space(vectors: Floats) -> Floats:
    """The vectors, (..., d), completed with zeros to (..., 3)."""
    missing = 3 - vectors.shape[-1]
    return vectors if missing == 0 else np.pad(vectors, ((0, 0),) * (vectors.ndim - 1) + ((0, missing),))


# -- the box of a file -----------------------------------------------------------------------------------------

#: Between the outermost particles and the face of a box that is made for them: a share of their extent.
_MARGIN = 1e-3
#: Largest coordinates are told from their neighbours by this share of themselves, also in single precision.
_RESOLVED = 1e-6
#: A smaller margin is that of a single point, about which no size is known.
_POINT = 1e-30
#: Thickness of the box along an axis that the scene does not have, as a share of its longest side.
_THIN = 1e-2


def box_around(trajectory: Trajectory) -> Floats:
    """Lower and upper end of a box along each axis, (3, 2), length, for formats in which every trajectory has one.

    It is the same for all samples. Between walls and along periodic axes, that of the scene. Along an axis that is
    open, or on a side without a wall: around the scene's box, if it has one, and all positions, with a margin of the
    largest radius or a thousandth of the extent. Along axes that the scene does not have: a hundredth of the longest
    side, about 0. trajectory: of which it is the box.
    """
    largest = np.finfo(np.float64).max
    box = np.stack([np.zeros(3), trajectory.cell], axis=1)
    closed = trajectory.walled | trajectory.periodic[:, None]
    radius = float(trajectory.more["radius"].max()) if "radius" in trajectory.more else 0.0
    with np.errstate(over="ignore"):
        lowest, highest = trajectory.positions.min(axis=(0, 1)), trajectory.positions.max(axis=(0, 1))
        extent = float((highest - lowest).max())
        for axis in range(trajectory.dimension):
            far = max(abs(lowest[axis]), abs(highest[axis]))
            margin = max(radius, _MARGIN * extent, _RESOLVED * far)
            margin = 0.5 if margin < _POINT else margin
            outer = np.array([lowest[axis] - margin, highest[axis] + margin])
            if trajectory.cell[axis] > 0:
                outer = np.array([min(outer[0], 0.0), max(outer[1], trajectory.cell[axis])])
            box[axis] = np.where(closed[axis], box[axis], np.clip(outer, -largest, largest))
        sides = np.minimum(box[:, 1] - box[:, 0], largest)
        box[trajectory.dimension :] = np.array([-0.5, 0.5]) * _THIN * sides.max()
    return box
