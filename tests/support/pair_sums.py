"""An independent Lennard-Jones evaluation that the engines are held against: every pair, minimum image, plain numpy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.scene import Floats, Scene


class Evaluation(NamedTuple):
    forces: Floats
    energy: float
    virial: float


def evaluate(scene: Scene) -> Evaluation:
    """Forces, potential energy and virial of a Lennard-Jones scene at its start."""
    lj, state = scene.lennard_jones, scene.initial_state()
    assert lj is not None
    n, r = scene.number, state.positions
    species = np.zeros(n, dtype=int) if state.species is None else state.species
    sigmas = np.atleast_1d(lj.length)[species % np.size(lj.length)] * (2 ** (-1 / 6) if lj.length_form == "r_m" else 1)
    epsilons = np.atleast_1d(lj.epsilon)[species % np.size(lj.epsilon)]
    forces, energy, virial = np.zeros_like(r), 0.0, 0.0
    for i in range(n):
        for j in range(i):
            apart = r[i] - r[j]
            for axis, boundary in enumerate(scene.boundaries):
                if boundary == "periodic":
                    assert state.lengths is not None
                    apart[axis] -= state.lengths[axis] * np.round(apart[axis] / state.lengths[axis])
            distance = float(np.linalg.norm(apart))
            if distance > lj.cutoff:
                continue
            shape = float(np.sqrt(epsilons[i] * epsilons[j])), float((sigmas[i] + sigmas[j]) / 2)
            u, slope = _phi(distance, *shape)
            u_cut, slope_cut = _phi(lj.cutoff, *shape)
            if lj.truncation != "truncated":
                u -= u_cut
            if lj.truncation == "force_shifted":
                u, slope = u - (distance - lj.cutoff) * slope_cut, slope - slope_cut
            force = -slope * apart / distance
            forces[i] += force
            forces[j] -= force
            energy += u
            virial += float(apart @ force)
    wall = None if scene.box is None else scene.box.wall
    if wall is not None:
        assert state.lengths is not None
        for axis in [axis for axis, boundary in enumerate(scene.boundaries) if boundary == "wall"]:
            for i in range(n):
                for distance, sign in ((r[i, axis], 1.0), (state.lengths[axis] - r[i, axis], -1.0)):
                    if distance <= wall.cutoff:
                        u, slope = _phi(distance, wall.epsilon, wall.sigma)
                        energy += u - _phi(wall.cutoff, wall.epsilon, wall.sigma)[0]
                        forces[i, axis] -= sign * slope
    return Evaluation(forces, energy, virial)


def _phi(r: float, epsilon: float, sigma: float) -> tuple[float, float]:
    """4 epsilon ((sigma/r)^12 - (sigma/r)^6) and its derivative."""
    s6 = (sigma / r) ** 6
    return 4 * epsilon * (s6**2 - s6), -24 * epsilon * (2 * s6**2 - s6) / r
