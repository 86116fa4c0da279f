"""Lennard-Jones fluids and mixtures: 12-6 pairs, truncated, shifted or force-shifted; periodic, walled and open boxes.

phi(r) = 4 eps [(sigma/r)^12 - (sigma/r)^6] = eps [(r_m/r)^12 - 2 (r_m/r)^6], r_m = 2^(1/6) sigma. Pairs at or beyond
the cutoff r_c do not interact. Nearer ones have, by `truncation`,

| truncation      | pair energy                                    | pair force           |
|-----------------|------------------------------------------------|----------------------|
| "truncated"     | phi(r), a jump at r_c that no force balances   | -phi'(r)             |
| "shifted"       | phi(r) - phi(r_c)                              | -phi'(r)             |
| "force_shifted" | phi(r) - phi(r_c) - (r - r_c) phi'(r_c)        | -phi'(r) + phi'(r_c) |

Unlike pairs: sigma_ij = (sigma_i + sigma_j)/2, eps_ij = sqrt(eps_i eps_j) (Lorentz-Berthelot). The sums over pairs are
in refimpl.stepping.kernels.lennard_jones, O(N).

Literature: J. E. Lennard-Jones, Proc. Phys. Soc. 43, 461 (1931); L. Verlet, Phys. Rev. 159, 98 (1967); M. P. Allen and
D. J. Tildesley, Computer Simulation of Liquids (1987), sections 1.3, 2.8 and 5.2-5.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
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
    operations,
    periods,
    renew,
    status,
    team,
)
from refimpl.stepping.kernels.lennard_jones import between_walls, serve, tile_accelerations, tile_energy, wall_energy
from refimpl.stepping.kernels.neighbours import (
    BUILDS,
    PRUNES,
    STATUS,
    TESTS,
    VALID,
    Neighbours,
    copy_to_slots,
    enlarge_neighbours,
    neighbours,
    update,
)
from refimpl.stepping.kernels.simd import WIDTH
from refimpl.stepping.kernels.sums import sum_of_squares
from refimpl.team import helping

TRUNCATIONS = ("truncated", "shifted", "force_shifted")

#: r_m / sigma, the distance of the minimum.
MINIMUM = 2 ** (1 / 6)

#: Default skin, of the wide lists, over the largest sigma. At rho* = 0.84, T* = 0.7 and dt* = 0.005 the wide lists are
#: then built every 20 steps and the close ones picked every 6; speed hardly changes from 0.6 to 1.
SKIN = 0.8

#: Indices of `LennardJones.counters`.
LIST_BUILDS = 0
FORCE_EVALUATIONS = 1
PAIR_TESTS = 2  # distances computed by these evaluations


class Walls(NamedTuple):
    """12-6 walls: a particle at distance s < cutoff has the energy phi(s) - phi(cutoff) with these parameters.

    epsilon: energy. sigma, cutoff: lengths.
    """

    epsilon: float
    sigma: float
    cutoff: float


class LennardJones(NamedTuple):
    """A Lennard-Jones system; build it with `lennard_jones`. Absent features are None.

    lengths: box sides, 0 if there are none. cutoff: of all pairs. epsilon, sigma: of the only species; or None and
    species: (N,) indices into species_epsilon, species_sigma. slot_size, slot_strength: sigma/2 and sqrt(epsilon) of
    the particle in each slot of the lists, in a mixture. shift_energy, shift_force: True where the truncation asks for
    it. mass: common, not 1; masses: (N,). walls: on the faces 0 and lengths[k] of the axes k that are not periodic.
    neighbours: the lists. forces: on the particles of the tiles, as `neighbours.tiles`; energies: (tiles, 2), of the
    pairs of each tile, and r F. counters: (3,), see LIST_BUILDS and the names after it. threads: that share the work.
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
    forces: np.ndarray
    energies: np.ndarray
    counters: np.ndarray
    threads: int


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
    threads: int = 1,
) -> LennardJones:
    """A Lennard-Jones system of `number` particles in `dimension` 2 or 3, with one cutoff for all pairs.

    lengths: box side of each axis, or None if no axis is periodic or walled. periodic: per axis. epsilon, sigma:
    energy and length of the pairs of like particles, one number or one per species; species: (N,) integers, then.
    length_form: "sigma", or "r_m" if `sigma` holds the distances of the minimum, 2^(1/6) sigma. truncation: one of
    TRUNCATIONS. mass: one number, or (N,). walls: on both faces, 0 and lengths[k], of every axis k that is not
    periodic; without, such an axis is open. skin: of the Verlet lists, by default SKIN times the largest sigma: it
    changes the speed only. threads: that share the work while `integrate` runs; no bit depends on their number.

    A periodic side may be shorter than two cutoffs, or than one: then a particle meets all images of the others within
    the cutoff, and its own, each pair of images with half of its energy in the box.

    Units: any consistent set, with lengths, cutoff and skin in the unit of sigma. Raises ValueError for any argument
    out of its range, and TooManyImages for a periodic side so short that the images are too many to be listed.
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
    if threads < 1:
        raise ValueError(f"threads must be at least 1, got {threads}")
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
        forces=np.zeros(lists.tiles.size),
        energies=np.zeros((len(lists.first), 2)),
        counters=np.zeros(3, dtype=np.int64),
        threads=threads,
    )
    return _with_slots(force)


def _with_slots(force: LennardJones) -> LennardJones:
    """The mixture's parameters get a place for every slot of the lists."""
    if force.species is None:
        return force
    slots = len(force.neighbours.packed) // (4 if len(force.lengths) == 3 else 2)
    return force._replace(slot_size=np.zeros(slots), slot_strength=np.zeros(slots))


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
    force.counters[PAIR_TESTS] += tile_accelerations(force, r, a)
    force.counters[FORCE_EVALUATIONS] += 1
    return a


@implements(energy_and_virial, LennardJones)
def _energies(force: LennardJones, r: np.ndarray) -> tuple[float, float]:
    if not _lists_are_valid_for(force, r):
        return np.nan, np.nan
    energy, work = tile_energy(force, r)
    return energy + _wall_energy(force.walls, force.neighbours.sides, force.lengths, r), work


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


@implements(team, LennardJones)
def _team(force: LennardJones) -> AbstractContextManager[None]:
    shared = force.neighbours.shared
    if len(shared.edges) == 2:  # one piece, which nobody can share
        return nullcontext()
    return helping(partial(serve, force), shared.flags, force.threads)


@implements(renew, LennardJones)
def _renew(force: LennardJones) -> None:
    force.neighbours.bookkeeping[VALID] = 0


@implements(enlarge, LennardJones)
def _enlarge(force: LennardJones) -> LennardJones:
    # counters of its own: those that it shared would say that the new, empty slots have been filled
    larger = force._replace(neighbours=enlarge_neighbours(force.neighbours), counters=force.counters.copy())
    return _with_slots(larger)


@implements(operations, LennardJones)
def _operations(force: LennardJones) -> dict[str, int]:
    bookkeeping = force.neighbours.bookkeeping
    return {
        "evaluations": int(force.counters[FORCE_EVALUATIONS]),
        "pair_tests": int(force.counters[PAIR_TESTS]),
        "list_builds": int(bookkeeping[BUILDS]),
        "list_prunings": int(bookkeeping[PRUNES]),
        "list_tests": WIDTH * int(bookkeeping[TESTS]),
    }


@implements(periods, LennardJones)
def _periods(force: LennardJones) -> np.ndarray | None:
    return np.tile(force.neighbours.sides, len(force.neighbours.order)) if any(force.neighbours.sides) else None
