"""Forces, energies and virial of springs, gravity and Lennard-Jones particles: sums over all pairs in long double.

Written from the definitions of the scene language, for configurations of some tens of particles: every pair with every
image that can be within the cutoff, in numpy's long double, with a bound on what rounding may do to a sum of 64 bits.
The pair energy is a function u(s) of the squared distance s; the force on i is -2 u'(s) (r_i - r_j), the virial of the
pair -2 s u'(s). Units are those of the scene.

Literature: J. E. Lennard-Jones, Proc. Phys. Soc. 43, 461 (1931); M. P. Allen and D. J. Tildesley, Computer Simulation
of Liquids (1987), sections 1.3-1.5, 2.4 and 5.2; S. J. Aarseth, Mon. Not. R. Astron. Soc. 126, 223 (1963), for
softening; N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), chapter 4, for the rounding of
sums.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.scene import Floats, LennardJones, Scene, State


class Smooth(NamedTuple):
    """Forces, potential energy and virial of one configuration, with bounds on the rounding of a sum in doubles.

    forces: (N, d). energy, virial: of all pairs, images, walls and springs; the virial counts no walls. forces_error:
    (N,), of the largest component. energy_error, virial_error: likewise. All in the units of the scene, long double.
    """

    forces: Floats
    energy: Any
    virial: Any
    forces_error: Floats
    energy_error: float
    virial_error: float


class _Pairs(NamedTuple):
    """u(s), u'(s) and the sum of the sizes of the terms of u, for squared distances s of the pairs."""

    energy: Floats
    slope: Floats
    size: Floats


@lru_cache(maxsize=1)
def _start(scene: Scene) -> State:
    """The initial state, to be read only: the forces of one scene are asked for many times."""
    return scene.initial_state()


def smooth(scene: Scene, positions: Floats, *, extended: bool = True, uncertainty: float = 0.0) -> Smooth:
    """The forces on the particles of `scene` at other positions than those of its start.

    scene: of [spring], [gravity] or [lennard_jones]. positions: (N, d), length. extended: in long double, else in
    double: what another code of this precision would find. uncertainty: of the positions of Lennard-Jones particles
    (length), which then counts in the bounds. See the module for derivation and literature.
    """
    state = _start(scene)
    x = np.asarray(positions, dtype=np.longdouble if extended else np.float64)
    if scene.spring is not None:
        return _spring(scene.spring.k, x)
    if scene.gravity is not None:
        return _attracted(scene, x, np.multiply.outer(state.masses, state.masses))
    lj = scene.lennard_jones
    assert lj is not None
    epsilon, sigma = _mixed(lj, state, x.dtype)
    periods = scene.periods()
    rounding = 4 * float(abs(x).max(initial=0.0) + periods.max()) * EPSILON if periods.any() else 0.0
    found = _summed(
        _images(x, periods, lj.cutoff),
        lambda s, i, j: _lennard_jones(s, epsilon[i, j], sigma[i, j], lj),
        lj.cutoff,
        rounding + 2 * uncertainty,
        float(abs(x).max(initial=0.0)),
    )
    walled = scene.box is not None and scene.box.wall is not None
    return _between_walls(scene, x, found, uncertainty) if walled else found


def accelerations(scene: Scene, positions: Floats, velocities: Floats, *, extended: bool = True) -> Floats:
    """f(r, v)/m of every particle, (N, d), with the friction of springs.

    scene, positions, extended: as for `smooth`. velocities: (N, d), length/time. Newton's second law; bodies without
    mass fall as any other would in their place.
    """
    masses = _start(scene).masses
    if scene.gravity is not None:
        x = np.asarray(positions, dtype=np.longdouble if extended else np.float64)
        return _attracted(scene, x, np.broadcast_to(masses, (masses.size, masses.size))).forces
    forces = smooth(scene, positions, extended=extended).forces
    if scene.spring is not None and scene.spring.gamma is not None:
        forces = forces - scene.spring.gamma * velocities
    return np.asarray(forces / masses[:, None])


def orbit(scene: Scene, time: float) -> tuple[Floats, Floats]:
    """Positions and velocities, (N, d) each, of the particles of `scene` after a time, in the units of the scene.

    Dormand and Prince's method of order 8 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 1993,
    section II.5), relative and absolute tolerance 1e-13 a step.
    """
    from scipy.integrate import solve_ivp

    state = scene.initial_state()
    shape = state.positions.shape

    def derivative(_: float, now: Floats) -> Floats:
        r, v = now.reshape(2, *shape)
        return np.concatenate([v.ravel(), accelerations(scene, r, v, extended=False).ravel()])

    start = np.concatenate([state.positions.ravel(), state.velocities.ravel()])
    done = solve_ivp(derivative, (0.0, time), start, "DOP853", [time], rtol=1e-13, atol=1e-13)
    r, v = done.y[:, -1].reshape(2, *shape)
    return r, v


def kinetic_energy(masses: Floats, velocities: Floats) -> tuple[Any, float]:
    """sum m v^2/2 in long double, and a bound on its rounding in doubles. masses: (N,). velocities: (N, d).

    All terms are positive, so a sum of n of them loses at most n roundings of itself (Higham 2002).
    """
    v = np.asarray(velocities, dtype=np.longdouble)
    total = 0.5 * (masses[:, None] * v**2).sum()
    return total, float(total) * (v.size + 4) * EPSILON


def _spring(k: float, x: Floats) -> Smooth:
    square = (x**2).sum()
    error = float(square) * k * (x.size + 4) * EPSILON
    return Smooth(-k * x, 0.5 * k * square, -k * square, k * abs(x).max(axis=1) * 4 * EPSILON, 0.5 * error, error)


def _attracted(scene: Scene, x: Floats, weights: Floats) -> Smooth:
    """Gravity with weights[i, j] in place of the product of the masses of i and j."""
    assert scene.gravity is not None
    strength = scene.gravity.G * weights.astype(x.dtype)
    softening = x.dtype.type(scene.gravity.softening or 0.0)

    def plummer(s: Floats, i: Floats, j: Floats) -> _Pairs:
        energy = -strength[i, j] / np.sqrt(s + softening**2)
        return _Pairs(energy, -0.5 * energy / (s + softening**2), abs(energy))

    return _summed((x[:, None] - x)[None], plummer, np.inf, 0.0, float(abs(x).max()))


def _mixed(lj: LennardJones, state: State, kind: Any) -> tuple[Floats, Floats]:
    """epsilon_ij and sigma_ij of all pairs, (N, N) each, by the rules of Lorentz and Berthelot."""
    number = len(state.masses)
    species = np.zeros(number, dtype=int) if state.species is None else state.species
    one = [np.asarray(np.atleast_1d(of), dtype=kind) for of in (lj.epsilon, lj.length)]
    epsilon, sigma = (of[species] if of.size > 1 else np.full(number, of[0]) for of in one)
    if lj.length_form == "r_m":
        sigma = sigma / kind.type(2) ** (kind.type(1) / 6)
    return np.sqrt(np.multiply.outer(epsilon, epsilon)), np.add.outer(sigma, sigma) / 2


def _images(x: Floats, periods: Floats, cutoff: float) -> Floats:
    """r_i - r_j for all images of j within the cutoff and more, (images, N, N, d); the first image is the nearest."""
    apart = x[:, None, :] - x[None, :, :]
    sides = periods.astype(x.dtype)
    turns = np.rint(np.divide(apart, sides, out=np.zeros_like(apart), where=sides > 0))
    # the nearest image is within half a side, the n-th one beyond it no nearer than n - 1/2 sides
    shells = [int(np.floor(cutoff / side + 0.5 + 1e-9)) if side > 0 else 0 for side in periods]
    boxes = sorted(product(*(range(-n, n + 1) for n in shells)), key=lambda box: sum(map(abs, box)))
    return (apart - turns * sides) + np.array(boxes)[:, None, None, :] * sides


def _lennard_jones(s: Floats, epsilon: Floats, sigma: Floats, lj: LennardJones) -> _Pairs:
    """u(s) = A s^-6 - B s^-3, cut and shifted at s_c = cutoff^2 as the truncation says."""
    b = 4 * epsilon * (sigma * sigma * sigma) * (sigma * sigma * sigma)
    a = b * b / (4 * epsilon)

    def u(t: Any) -> tuple[Any, Any, Any]:
        """A t^-6 and B t^-3, and the derivative of their difference."""
        q = 1 / (t * t * t)
        return a * q * q, b * q, (3 * b * q - 6 * a * q * q) / t

    repulsion, attraction, slope = u(s)
    energy, size = repulsion - attraction, repulsion + attraction
    if lj.truncation == "truncated":
        return _Pairs(energy, slope, size)
    edge = s.dtype.type(lj.cutoff)
    repulsion, attraction, slope_there = u(edge * edge)
    energy, size = energy - (repulsion - attraction), size + repulsion + attraction
    if lj.truncation == "force_shifted":
        # phi'(r) = 2 r u'(r^2): the line through phi'(r_c) is linear in r = sqrt(s)
        distance, steep = np.sqrt(s), 2 * edge * slope_there
        energy, slope = energy - (distance - edge) * steep, slope - steep / (2 * distance)
        size = size + edge * abs(steep)
    return _Pairs(energy, slope, size)


def _summed(
    apart: Floats, pairs: Callable[[Floats, Floats, Floats], _Pairs], cutoff: float, rounding: float, farthest: float
) -> Smooth:
    """Sums over images and partners; a particle with an image of another one, or of itself, has half of the energy.

    apart: (images, N, N, d), of which the first image is that itself. pairs: of s and the partners i and j. rounding:
    bound on that of a distance (length). farthest: largest coordinate (length): who sums r_i . F_i for the virial
    rounds by that.
    """
    s = (apart * apart).sum(axis=-1)
    near = s < s.dtype.type(cutoff) ** 2
    number = s.shape[1]
    near[0, np.arange(number), np.arange(number)] = False
    _, i, j = np.nonzero(near)
    s, apart = s[near], apart[near]
    found = pairs(s, i, j)
    forces = np.zeros((number, apart.shape[-1]), dtype=s.dtype)
    np.add.at(forces, i, -2 * found.slope[:, None] * apart)
    # a power law r^-n changes by n dr/r of itself, n at most 14; a term has some 16 roundings, a sum one for each term
    r = np.asarray(np.sqrt(s), dtype=np.float64)
    terms = np.bincount(i, minlength=number)
    strength = np.asarray(found.size, dtype=np.float64) * (14 * rounding / r + (terms.max(initial=0) + 16) * EPSILON)
    # u is at least r phi'/12: where the terms of phi' cancel, their own sizes count
    return Smooth(
        forces,
        found.energy.sum() / 2,
        -(found.slope * s).sum(),
        np.bincount(i, 12 * strength / r, number).astype(np.float64),
        float(strength.sum()) / 2,
        6 * float(strength.sum()) + 12 * farthest * EPSILON * float((np.asarray(found.size) / r).sum()),
    )


def _between_walls(scene: Scene, x: Floats, found: Smooth, uncertainty: float) -> Smooth:
    """With the energy and the forces of 12-6 walls on both faces of each axis with walls."""
    assert scene.box is not None
    wall, lengths = scene.box.wall, scene.lengths()
    assert wall is not None
    assert lengths is not None
    potential = LennardJones(epsilon=wall.epsilon, length=wall.sigma, cutoff=wall.cutoff, truncation="shifted")
    epsilon, sigma = x.dtype.type(wall.epsilon), x.dtype.type(wall.sigma)
    forces, energy = found.forces.copy(), found.energy
    forces_error, energy_error = found.forces_error.copy(), found.energy_error
    for axis in [axis for axis, boundary in enumerate(scene.boundaries) if boundary == "wall"]:
        for inward, distance in ((1, x[:, axis]), (-1, x.dtype.type(lengths[axis]) - x[:, axis])):
            near = distance < wall.cutoff
            z = np.where(near, distance, 1)
            pair = _lennard_jones(z**2, epsilon, sigma, potential)
            forces[:, axis] += np.where(near, -2 * pair.slope * z * inward, 0)
            energy = energy + np.where(near, pair.energy, 0).sum()
            relative = 14 * (lengths[axis] * EPSILON + uncertainty) / z + (16 + len(x)) * EPSILON
            error = np.where(near, pair.size * relative, 0)
            forces_error += np.asarray(12 * error / z, dtype=np.float64)
            energy_error += float(error.sum())
    return found._replace(forces=forces, energy=energy, forces_error=forces_error, energy_error=energy_error)
