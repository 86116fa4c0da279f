"""Lennard-Jones forces the plain way, every pair and all images: what the fast force of `refimpl` must give."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from refimpl.stepping.forces.lennard_jones import LennardJones


def pair_energy(r: Any, epsilon: Any, sigma: Any) -> Any:
    """phi(r) = 4 epsilon [(sigma/r)^12 - (sigma/r)^6], elementwise, without truncation; sigma, r: lengths."""
    s6 = (sigma / r) ** 6
    return 4.0 * epsilon * (s6 * s6 - s6)


def pair_slope(r: Any, epsilon: Any, sigma: Any) -> Any:
    """phi'(r) = -(24 epsilon/r) [2 (sigma/r)^12 - (sigma/r)^6], elementwise; the force is -phi'(r) r_ij/r."""
    s6 = (sigma / r) ** 6
    return -24.0 * epsilon * (2.0 * s6 * s6 - s6) / r


def _parameters(force: LennardJones) -> tuple[np.ndarray, np.ndarray]:
    """epsilon and sigma of every particle."""
    if force.species is None or force.species_epsilon is None or force.species_sigma is None:
        number = len(force.neighbours.order)
        return np.full(number, force.epsilon), np.full(number, force.sigma)
    return force.species_epsilon[force.species], force.species_sigma[force.species]


def plain_forces(force: LennardJones, r: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Forces (N*d,), potential energy and virial at the coordinates `r`, (N*d,): every pair, all images.

    force: the system. A pair is that of a particle and one image of another one or of itself, with half of phi and of
    r . F a particle. The virial W = sum over pairs of r_ij . F_ij counts pairs only, not walls. O(N^2) time, O(N)
    memory; the lists are not used.
    """
    dimension = len(force.lengths)
    x = np.asarray(r, dtype=np.float64).reshape(-1, dimension)
    sides = np.array(force.neighbours.sides)
    epsilon, sigma = _parameters(force)
    forces = np.zeros_like(x)
    energy = 0.0
    work = 0.0
    # the nearest image is within half a side; further ones that may be within the cutoff, by their numbers of sides
    shells = [int(np.ceil(force.cutoff / side - 0.5)) if side > 0 else 0 for side in sides]
    boxes = np.array(list(product(*(range(-shell, shell + 1) for shell in shells))))
    for i in range(len(x)):
        nearest = x[i] - x
        nearest -= sides * np.rint(np.divide(nearest, sides, out=np.zeros_like(nearest), where=sides > 0))
        for box in boxes:
            d = nearest + box * sides
            distance = np.sqrt((d**2).sum(axis=1))
            j = np.flatnonzero((distance < force.cutoff) & ((np.arange(len(x)) != i) | box.any()))
            d, distance = d[j], distance[j]
            eps = np.sqrt(epsilon[i] * epsilon[j])
            sig = 0.5 * (sigma[i] + sigma[j])
            phi = pair_energy(distance, eps, sig)
            slope = pair_slope(distance, eps, sig)
            if force.shift_energy:
                phi -= pair_energy(force.cutoff, eps, sig)
            if force.shift_force:
                slope_at_cutoff = pair_slope(force.cutoff, eps, sig)
                phi -= (distance - force.cutoff) * slope_at_cutoff
                slope -= slope_at_cutoff
            forces[i] -= ((slope / distance)[:, None] * d).sum(axis=0)
            energy += 0.5 * phi.sum()
            work -= 0.5 * (slope * distance).sum()
    if force.walls is not None:
        for k in np.flatnonzero(sides == 0):
            for distance, sign in ((x[:, k], 1), (force.lengths[k] - x[:, k], -1)):
                near = np.flatnonzero(distance < force.walls.cutoff)
                phi = pair_energy(distance[near], force.walls.epsilon, force.walls.sigma)
                phi -= pair_energy(force.walls.cutoff, force.walls.epsilon, force.walls.sigma)
                forces[near, k] -= sign * pair_slope(distance[near], force.walls.epsilon, force.walls.sigma)
                energy += phi.sum()
    return forces.ravel(), float(energy), float(work)
