"""Lennard-Jones fluids and mixtures: 12-6 pairs, truncated, shifted or force-shifted; periodic, walled and open boxes.

phi(r) = 4 eps [(sigma/r)^12 - (sigma/r)^6] = eps [(r_m/r)^12 - 2 (r_m/r)^6], r_m = 2^(1/6) sigma. Pairs at or beyond
the cutoff r_c do not interact. Nearer ones have, by `truncation`,

| truncation      | pair energy                                    | pair force           |
|-----------------|------------------------------------------------|----------------------|
| "truncated"     | phi(r), a jump at r_c that no force balances   | -phi'(r)             |
| "shifted"       | phi(r) - phi(r_c)                              | -phi'(r)             |
| "force_shifted" | phi(r) - phi(r_c) - (r - r_c) phi'(r_c)        | -phi'(r) + phi'(r_c) |

Unlike pairs: sigma_ij = (sigma_i + sigma_j)/2, eps_ij = sqrt(eps_i eps_j) (Lorentz-Berthelot). The readable routine is
`plain_forces`, O(N^2); integrators get its fast twin, refimpl.stepping.kernels.lennard_jones, O(N).

Literature: J. E. Lennard-Jones, Proc. Phys. Soc. 43, 461 (1931); L. Verlet, Phys. Rev. 159, 98 (1967); M. P. Allen and
D. J. Tildesley, Computer Simulation of Liquids (1987), sections 1.3, 2.8 and 5.2-5.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from refimpl.compilation import compiled, implements
from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    accelerate,
    energy_and_virial,
    enlarge,
    kinetic_energy,
    periods,
    potential_energy,
    renew,
    status,
    virial,
)
from refimpl.stepping.kernels.lennard_jones import between_walls, tile_accelerations, tile_energy, wall_energy
from refimpl.stepping.kernels.neighbours import (
    BUILDS,
    STATUS,
    VALID,
    Neighbours,
    copy_to_slots,
    enlarge_neighbours,
    neighbours,
    update,
)
from refimpl.stepping.kernels.sums import sum_of_squares

TRUNCATIONS = ("truncated", "shifted", "force_shifted")

#: r_m / sigma, the distance of the minimum.
MINIMUM = 2 ** (1 / 6)

#: Default skin, of the wide lists, over the largest sigma. At rho* = 0.84, T* = 0.7 and dt* = 0.005 the wide lists are
#: then built every 20 steps and the close ones picked every 6; speed hardly changes from 0.6 to 1.
SKIN = 0.8

#: Indices of `LennardJones.counters`.
LIST_BUILDS = 0
FORCE_EVALUATIONS = 1


class Walls(NamedTuple):
    """12-6 walls: a particle at distance s < cutoff has the energy phi(s) - phi(cutoff) with these parameters.

    epsilon: energy. sigma, cutoff: lengths.
    """

    epsilon: float
    sigma: float
    cutoff: float


class Tails(NamedTuple):
    """What the pairs beyond the cutoff would add: energy and virial of all particles, and pressure."""

    energy: float
    virial: float
    pressure: float


class LennardJones(NamedTuple):
    """A Lennard-Jones system; build it with `lennard_jones`. Absent features are None.

    lengths: box sides, 0 if there are none. cutoff: of all pairs. epsilon, sigma: of the only species; or None and
    species: (N,) indices into species_epsilon, species_sigma. slot_size, slot_strength: sigma/2 and sqrt(epsilon) of
    the particle in each slot of the lists, in a mixture. shift_energy, shift_force: True where the truncation asks for
    it. mass: common, not 1; masses: (N,). walls: on the faces 0 and lengths[k] of the axes k that are not periodic.
    neighbours: the lists. counters: (2,), see LIST_BUILDS and FORCE_EVALUATIONS.
    """

    lengths: tuple[float, ...]
    cutoff: float
    shift_energy: bool | None
    shift_force: bool | None
    epsilon: float | None
    sigma: float | None
    species: np.ndarray | None
    species_epsilon: np.ndarray | None
    species_sigma: np.ndarray | None
    slot_size: np.ndarray | None
    slot_strength: np.ndarray | None
    mass: float | None
    masses: np.ndarray | None
    walls: Walls | None
    neighbours: Neighbours
    counters: np.ndarray


def _finite(name: str, value: Any, *, positive: bool = True) -> np.ndarray:
    """`value` as a float array; ValueError that names it unless all is finite and positive (or not negative)."""
    array = np.asarray(value, dtype=np.float64)
    wrong = ~np.isfinite(array) | ((array <= 0) if positive else (array < 0))
    if array.size == 0 or wrong.any():
        raise ValueError(f"{name} must be {'positive' if positive else 'non-negative'} and finite, got {value}")
    return array


def _box(
    dimension: int, lengths: Sequence[float] | None, periodic: Sequence[bool], walls: Walls | None
) -> tuple[float, ...]:
    """Box sides; ValueError unless they suit the boundary conditions."""
    if len(periodic) != dimension:
        raise ValueError(f"periodic must hold {dimension} truth values, one per axis, got {periodic}")
    if lengths is None:
        if any(periodic) or walls is not None:
            raise ValueError("periodic axes and walls need lengths: give the box side of every axis")
        return (0.0,) * dimension
    if len(lengths) != dimension:
        raise ValueError(f"lengths must hold {dimension} box sides, one per axis, got {lengths}")
    return tuple(float(length) for length in _finite("lengths", lengths))


def lennard_jones(
    *,
    number: int,
    dimension: int,
    lengths: Sequence[float] | None,
    periodic: Sequence[bool],
    cutoff: float,
    epsilon: float | Sequence[float] = 1.0,
    sigma: float | Sequence[float] = 1.0,
    species: np.ndarray | None = None,
    length_form: str = "sigma",
    truncation: str = "truncated",
    mass: float | np.ndarray = 1.0,
    walls: Walls | None = None,
    skin: float | None = None,
) -> LennardJones:
    """A Lennard-Jones system of `number` particles in `dimension` 2 or 3, with one cutoff for all pairs.

    lengths: box side of each axis, or None if no axis is periodic or walled. periodic: per axis. epsilon, sigma:
    energy and length of the pairs of like particles, one number or one per species; species: (N,) integers, then.
    length_form: "sigma", or "r_m" if `sigma` holds the distances of the minimum, 2^(1/6) sigma. truncation: one of
    TRUNCATIONS. mass: one number, or (N,). walls: on both faces, 0 and lengths[k], of every axis k that is not
    periodic; without, such an axis is open. skin: of the Verlet lists, by default SKIN times the largest sigma: it
    changes the speed only.

    A periodic side may be shorter than two cutoffs, or than one: then a particle meets all images of the others within
    the cutoff, and its own, each pair of images with half of its energy in the box.

    Units: any consistent set, with lengths, cutoff and skin in the unit of sigma. Raises ValueError for any argument
    out of its range, and for a periodic side so short that the images are too many to be listed.
    """
    if dimension not in (2, 3):
        raise ValueError(f"dimension must be 2 or 3, got {dimension}")
    if number < 1:
        raise ValueError(f"number of particles must be at least 1, got {number}")
    if truncation not in TRUNCATIONS:
        raise ValueError(f"truncation must be one of {', '.join(TRUNCATIONS)}, got {truncation!r}")
    if length_form not in ("sigma", "r_m"):
        raise ValueError(f"length_form must be 'sigma' or 'r_m', got {length_form!r}")
    cutoff = float(_finite("cutoff", cutoff))
    energies = np.atleast_1d(_finite("epsilon", epsilon, positive=False))
    sizes = np.atleast_1d(_finite("sigma", sigma)) / (MINIMUM if length_form == "r_m" else 1.0)
    if energies.ndim > 1 or sizes.ndim > 1 or 1 < len(energies) != len(sizes) > 1:
        raise ValueError(f"epsilon and sigma must hold one number per species, got {epsilon} and {sigma}")
    kinds = max(len(energies), len(sizes))
    energies, sizes = np.broadcast_to(energies, kinds).copy(), np.broadcast_to(sizes, kinds).copy()
    if species is not None:
        species = np.asarray(species)
        if species.shape != (number,) or not np.issubdtype(species.dtype, np.integer):
            raise ValueError(f"species must hold {number} integers, got {species.dtype} of shape {species.shape}")
        if species.min() < 0 or species.max() >= kinds:
            raise ValueError(
                f"species must lie in 0 ... {kinds - 1}, as epsilon and sigma are given for {kinds} species, "
                f"got {species.min()} ... {species.max()}"
            )
        species = species.astype(np.int64)
    elif kinds > 1:
        raise ValueError(f"epsilon and sigma are given for {kinds} species: give the species of every particle")
    masses = _finite("mass", mass)
    if masses.shape not in ((), (number,)):
        raise ValueError(f"mass must be one number or {number}, got shape {masses.shape}")
    if walls is not None:
        _finite("wall epsilon", walls.epsilon, positive=False)
        _finite("wall sigma", walls.sigma)
        _finite("wall cutoff", walls.cutoff)
        if all(periodic):
            raise ValueError("walls stand on axes that are not periodic, but all are: leave them out")
        walls = Walls(*(float(value) for value in walls))
    box = _box(dimension, lengths, periodic, walls)
    sides = [side if around else 0.0 for side, around in zip(box, periodic, strict=True)]
    if skin is None:
        # no more images than a box of two cutoffs or more has: one shell; shorter boxes have as many as they need
        skin = min([SKIN * float(sizes.max())] + [side - cutoff for side in sides if side >= 2 * cutoff])
    lists = neighbours(number, sides, cutoff, float(_finite("skin", skin, positive=False)))
    one_mass = float(masses.flat[0]) if bool((masses == masses.flat[0]).all()) else None
    mixture = kinds > 1
    force = LennardJones(
        lengths=box,
        cutoff=cutoff,
        shift_energy=None if truncation == "truncated" else True,
        shift_force=True if truncation == "force_shifted" else None,
        epsilon=None if mixture else float(energies[0]),
        sigma=None if mixture else float(sizes[0]),
        species=species if mixture else None,
        species_epsilon=energies if mixture else None,
        species_sigma=sizes if mixture else None,
        slot_size=None,
        slot_strength=None,
        mass=None if one_mass == 1.0 else one_mass,
        masses=masses.copy() if one_mass is None else None,
        walls=walls,
        neighbours=lists,
        counters=np.zeros(2, dtype=np.int64),
    )
    return _with_slots(force)


def _with_slots(force: LennardJones) -> LennardJones:
    """The mixture's parameters get a place for every slot of the lists."""
    if force.species is None:
        return force
    slots = len(force.neighbours.packed) // (4 if len(force.lengths) == 3 else 2)
    return force._replace(slot_size=np.zeros(slots), slot_strength=np.zeros(slots))


@register_jitable
def pair_energy(r: Any, epsilon: Any, sigma: Any) -> Any:
    """phi(r) = 4 epsilon [(sigma/r)^12 - (sigma/r)^6], elementwise, without truncation; sigma, r: lengths."""
    s6 = (sigma / r) ** 6
    return 4.0 * epsilon * (s6 * s6 - s6)


@register_jitable
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


def tail_corrections(force: LennardJones) -> Tails:
    """Energy, virial and pressure of the pairs of `force` beyond the cutoff, if they are distributed uniformly (g = 1).

    U = (1/2V) sum_ij int_rc^inf phi_ij(r) S r^(d-1) dr, W = -(1/2V) sum_ij int_rc^inf r phi_ij'(r) S r^(d-1) dr, with
    S = 4 pi in three dimensions and 2 pi in two, sums over all i and j; p = W/(d V). Allen & Tildesley (1987), 2.8.
    Raises ValueError unless all axes are periodic and the truncation is "truncated": a shifted potential differs from
    phi within the cutoff too.
    """
    if not all(force.neighbours.sides):
        raise ValueError("tail corrections need a periodic box: they assume a uniform fluid beyond the cutoff")
    if force.shift_energy:
        raise ValueError("tail corrections belong to truncation 'truncated', not to a shifted potential")
    dimension = len(force.lengths)
    volume = float(np.prod(force.lengths))
    epsilon, sigma = _parameters(force)
    kinds, counts = np.unique(np.stack([epsilon, sigma]), axis=1, return_counts=True)
    eps = np.sqrt(np.outer(kinds[0], kinds[0]))
    s6 = (0.5 * np.add.outer(kinds[1], kinds[1])) ** 6
    pairs = np.outer(counts, counts) / (2 * volume) * (4 * np.pi if dimension == 3 else 2 * np.pi)
    repulsion = 4 * eps * s6**2 * force.cutoff ** (dimension - 12) / (12 - dimension)
    attraction = 4 * eps * s6 * force.cutoff ** (dimension - 6) / (6 - dimension)
    energy = float((pairs * (repulsion - attraction)).sum())
    work = float((pairs * (12 * repulsion - 6 * attraction)).sum())
    return Tails(energy, work, work / (dimension * volume))


@compiled(cache=True)
def _copy_parameters_to_slots(  # type: ignore[no-untyped-def]
    lists, species, species_epsilon, species_sigma, slot_size, slot_strength
):
    """Parameters of the particles to their slots, after these have changed."""
    number = len(species)
    size = np.empty(number)
    strength = np.empty(number)
    for i in range(number):
        size[i] = 0.5 * species_sigma[species[i]]
        strength[i] = np.sqrt(species_epsilon[species[i]])
    copy_to_slots(lists, size, slot_size)
    copy_to_slots(lists, strength, slot_strength)


@register_jitable
def _lists_are_valid(  # type: ignore[no-untyped-def]
    lists, counters, walls, lengths, species, species_epsilon, species_sigma, slot_size, slot_strength, r
):
    """Brings the lists up to date for `r`; False, with the reason in their bookkeeping, if that cannot be done."""
    # numba prunes a test for None only if it stands alone.
    if walls is not None:  # noqa: SIM102
        if not between_walls(lists.sides, lengths, r):
            lists.bookkeeping[STATUS] = DIVERGED
            return False
    if update(lists, r) != GOOD:
        return False
    if counters[LIST_BUILDS] != lists.bookkeeping[BUILDS]:
        counters[LIST_BUILDS] = lists.bookkeeping[BUILDS]
        if species is not None:
            _copy_parameters_to_slots(lists, species, species_epsilon, species_sigma, slot_size, slot_strength)
    return True


@register_jitable
def _lists_are_valid_for(force: LennardJones, r: np.ndarray) -> bool:
    return _lists_are_valid(
        force.neighbours,
        force.counters,
        force.walls,
        force.lengths,
        force.species,
        force.species_epsilon,
        force.species_sigma,
        force.slot_size,
        force.slot_strength,
        r,
    )


@register_jitable
def _wall_energy(walls, sides, lengths, r):  # type: ignore[no-untyped-def]
    if walls is not None:
        return wall_energy(walls, sides, lengths, r)
    return 0.0


@implements(accelerate, LennardJones)
def _accelerate(force: LennardJones, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    if not _lists_are_valid_for(force, r):
        return np.full(r.size, np.nan)
    a = np.empty(r.size)
    tile_accelerations(force, r, a)
    force.counters[FORCE_EVALUATIONS] += 1
    return a


@register_jitable
def _pair_sums(force: LennardJones, r: np.ndarray) -> tuple[float, float]:
    if not _lists_are_valid_for(force, r):
        return np.nan, np.nan
    return tile_energy(force)


@implements(energy_and_virial, LennardJones)
def _energies(force: LennardJones, r: np.ndarray) -> tuple[float, float]:
    energy, work = _pair_sums(force, r)
    return energy + _wall_energy(force.walls, force.neighbours.sides, force.lengths, r), work


@implements(potential_energy, LennardJones)
def _potential_energy(force: LennardJones, r: np.ndarray) -> float:
    return _pair_sums(force, r)[0] + _wall_energy(force.walls, force.neighbours.sides, force.lengths, r)


@implements(virial, LennardJones)
def _virial(force: LennardJones, r: np.ndarray) -> float:
    return _pair_sums(force, r)[1]


@register_jitable
def _kinetic(v: np.ndarray, mass: float | None, masses: np.ndarray | None) -> float:
    if masses is not None:
        dimension = v.size // masses.size
        energy = 0.0
        for i in range(v.size):
            energy += 0.5 * masses[i // dimension] * v[i] ** 2
        return energy
    if mass is not None:
        return 0.5 * mass * sum_of_squares(v)
    return 0.5 * sum_of_squares(v)


@implements(kinetic_energy, LennardJones)
def _kinetic_energy(force: LennardJones, v: np.ndarray) -> float:
    return _kinetic(v, force.mass, force.masses)


@implements(status, LennardJones)
def _status(force: LennardJones) -> int:
    return force.neighbours.bookkeeping[STATUS]


@implements(renew, LennardJones)
def _renew(force: LennardJones) -> None:
    force.neighbours.bookkeeping[VALID] = 0


@implements(enlarge, LennardJones)
def _enlarge(force: LennardJones) -> LennardJones:
    return _with_slots(force._replace(neighbours=enlarge_neighbours(force.neighbours)))


@implements(periods, LennardJones)
def _periods(force: LennardJones) -> np.ndarray | None:
    return np.tile(force.neighbours.sides, len(force.neighbours.order)) if any(force.neighbours.sides) else None
