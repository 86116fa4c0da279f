"""The potential energy of a scene's interaction at other positions, from the independent sums of the references."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.compare.pairs import pairs_within
from crosscheck.references.lennard_jones import pair_sum
from crosscheck.references.smooth_forces import smooth
from crosscheck.scene import Floats, Scene
from crosscheck.trajectories.frames import Frame

#: Most bodies whose gravity is summed: all pairs of a frame are looked at.
_BODIES = 1000
Potential = Callable[[Frame], float]


def potential_of(scene: Scene) -> Potential | str:
    """The function that gives the potential energy of a frame, in the units of the scene; or why there is none.

    scene: what was run. It is not finite where two particles are in one place. Of a plain cut, the energy is that of
    the shifted potential: its forces are those, and conserve it. Without tail corrections, which are constant.
    """
    if scene.spring is not None or (scene.gravity is not None and scene.number <= _BODIES):
        return lambda frame: _of_all(scene, _positions(frame, scene))
    if scene.gravity is not None:
        return f"the gravity of more than {_BODIES} bodies is not summed"
    if scene.lennard_jones is not None:
        lj = scene.lennard_jones
        shifted = scene
        if lj.truncation == "truncated":
            changed = lj.model_copy(update={"truncation": "shifted", "tail_corrections": False})
            shifted = scene.model_copy(update={"lennard_jones": changed})
        return lambda frame: _of_pairs(shifted, _positions(frame, scene))
    return lambda frame: _of_hard_spheres(scene, frame)


def _of_all(scene: Scene, positions: Floats) -> float:
    with np.errstate(all="ignore"):
        return float(smooth(scene, positions, extended=False).energy)


def _of_pairs(scene: Scene, positions: Floats) -> float:
    with np.errstate(all="ignore"):  # two particles in one place
        return pair_sum(scene, positions).energy


def _positions(frame: Frame, scene: Scene) -> Floats:
    """Positions (N, d) with the corner of the box at the origin, as scenes have it."""
    lower = np.zeros(3) if frame.box is None else frame.box.lower
    return (frame.positions - lower)[:, : scene.dimension]


def _of_hard_spheres(scene: Scene, frame: Frame) -> float:
    """Of a uniform field, and of square wells."""
    energy = 0.0
    spheres = scene.hard_spheres
    assert spheres is not None
    if scene.acceleration is not None:
        masses = np.broadcast_to(np.asarray(scene.masses, dtype=np.float64), (scene.number,))
        energy -= float(masses @ (_positions(frame, scene) @ np.array(scene.acceleration)))
    if spheres.well is not None:
        diameters = scene.diameters()
        assert diameters is not None
        found = pairs_within(frame, spheres.well.range * float(diameters.max()))
        contact = (diameters[found.first] + diameters[found.second]) / 2
        energy -= spheres.well.depth * int(np.count_nonzero(found.distances < spheres.well.range * contact))
    return energy
