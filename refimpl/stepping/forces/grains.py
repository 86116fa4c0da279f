"""Soft grains: disks or spheres that overlap and push each other apart, with friction, spin, walls and gravity.

Grains i and j that overlap by delta = R_i + R_j - r_ij, with n from j to i, v_n = (v_i - v_j).n and the slip of their
surfaces u = (v_i - v_j) - v_n n - (R_i omega_i + R_j omega_j) x n, exert

    F_n = s k delta - eta_n v_n,        F_t: below, up to Coulomb's limit mu |F_n|,

s = 1 (Hooke) or sqrt(R_eff delta) (Hertz), with 1/R_eff = 1/R_i + 1/R_j and 1/m_eff = 1/m_i + 1/m_j. The dashpots are

    damping = "mass":          eta_n = gamma s m_eff,            eta_t = gamma_t s m_eff   (gamma a rate),
    damping = "restitution":   eta_n = c sqrt(s m_eff k),        eta_t = c_t sqrt(s m_eff k)   (c a number).

Without history F_t = -eta_t u. With history F_t = -s k_t xi - eta_t u, xi the stretch of a tangential spring, xi' = u
since the contact began; at Coulomb's limit xi is what makes F_t that limit. As the contact turns, the component of xi
along n is taken off after each step. `granular`: it is taken off before, and xi keeps its length; the arm of the torque
is then R - delta/2 for pairs, and R otherwise. So the equations are those of LAMMPS's pair styles gran/hooke,
gran/hooke/history and gran/hertz/history ("mass") and of its `pair_style granular` with hooke or hertz, damping
coeff_restitution, and tangential linear_nohistory, linear_history (hooke) or mindlin (hertz) ("restitution", granular).
As there, a dashpot beyond Coulomb's limit does nothing before xi has left zero. Walls have m_eff = m_i, R_eff = R_i and
the arm R.

Coordinates r: N d positions; N angles in the plane, 3 N in space (only their rates matter), of rough grains alone; the
clock; and, with `tallies`, quantities whose rates are integrated. Velocities v: likewise, the clock's is 1, those of
the tallies are the integrals. So any scheme of `refimpl.stepping.schemes` moves clock, spins and tallies along; with
history, only one that asks for the force once a step makes sense. The stretches grow by u times what the clock has
moved since the last evaluation: one that is repeated changes nothing.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); L. E. Silbert et al., Phys. Rev. E 64, 051302
(2001); S. Luding, Granul. Matter 10, 235 (2008).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numba.extending import register_jitable

from refimpl.compilation import implements
from refimpl.stepping.forces.generic import (
    accelerate,
    energy_and_virial,
    enlarge,
    kinetic_energy,
    operations,
    periods,
    renew,
    status,
)
from refimpl.stepping.kernels.contact_lists import (
    BUILDS,
    EVALUATIONS,
    LIST_TESTS,
    LISTED,
    PAIR_TESTS,
    PRUNES,
    STATUS,
    ContactLists,
    contact_lists,
    enlarge_lists,
)
from refimpl.stepping.kernels.contacts import NO_LIMIT, ContactModel, elastic_energy, grain_accelerations

#: Default skin of the wide list of pairs, over the largest diameter.
SKIN = 0.3


class ContactLaw(NamedTuple):
    """The coefficients of a contact, in the module's equations.

    stiffness: k, force/length (Hooke) or force/length^2 (Hertz). damping: gamma, 1/time (Hooke) or 1/(time length)
    (Hertz), or the number c. tangential_stiffness: k_t, as k. tangential_damping: gamma_t or c_t, as `damping`.
    friction: Coulomb's mu, no dimension; infinite for no limit.
    """

    stiffness: float
    damping: float = 0.0
    tangential_stiffness: float = 0.0
    tangential_damping: float = 0.0
    friction: float = 0.0


class SoftPlane(NamedTuple):
    """A soft plane wall across an axis, that moves by sign amplitude cos(frequency t + phase).

    axis: 0 ... d - 1. sign: +1 or -1, the side of the grains. place: mean position along the axis, length. law: of its
    contacts. amplitude: length. frequency: radians/time. phase: radians.
    """

    axis: int
    sign: int
    place: float
    law: ContactLaw
    amplitude: float = 0.0
    frequency: float = 0.0
    phase: float = 0.0


class SoftCylinder(NamedTuple):
    """A soft wall: the inside of a cylinder, which may turn about its axis.

    radius: length. centre: the two coordinates of its axis, in order. law: of its contacts. axis: its direction, 0, 1
    or 2; 2 in two dimensions. angular_velocity: from the first of the two other coordinates to the second,
    radians/time.
    """

    radius: float
    centre: tuple[float, float]
    law: ContactLaw
    axis: int = 2
    angular_velocity: float = 0.0


class Grains(NamedTuple):
    """Soft grains; build them with `grains`. Absent features are None or empty.

    radii, masses, inverse_masses: (N,). inverse_inertias: (N,), None of smooth grains. gravity: acceleration (d,). law,
    walls, cylinder: rows of numbers, see refimpl.stepping.kernels.contacts. model: which equations. auxiliary: number
    of the coordinates after the angles: the clock and, if they are tallied, the number of touching pairs, sum r_ij .
    F_ij, the forces on each wall and on the cylinder (d each), and the torque of the cylinder on the grains. lists: of
    the pairs, with the box sides and the stretches. wall_stretches: (walls + 1, N, 3), of rough grains. clock: (1,), of
    the last evaluation.
    """

    radii: np.ndarray
    masses: np.ndarray
    inverse_masses: np.ndarray
    inverse_inertias: np.ndarray | None
    gravity: np.ndarray
    law: np.ndarray
    model: ContactModel
    walls: np.ndarray
    cylinder: np.ndarray
    auxiliary: int
    lists: ContactLists
    wall_stretches: np.ndarray
    clock: np.ndarray

    @property
    def tallied(self) -> bool:
        """Whether more than the clock is integrated."""
        return self.auxiliary > 1


def _row(law: ContactLaw) -> list[float]:
    if not all(value >= 0 for value in law) or not all(np.isfinite(law[:4])) or law.stiffness == 0:
        raise ValueError(f"a contact law needs a positive stiffness and other numbers that are not negative, got {law}")
    return [*law[:4], min(law.friction, NO_LIMIT)]


def _cylinder_row(cylinder: SoftCylinder) -> np.ndarray:
    across = [axis for axis in range(3) if axis != cylinder.axis]
    numbers = [cylinder.radius, *cylinder.centre, *across, cylinder.angular_velocity]
    return np.array([*numbers, *_row(cylinder.law)], dtype=np.float64)


def _check_surroundings(
    lengths: Sequence[float],
    periodic: Sequence[bool],
    gravity: Sequence[float] | None,
    walls: Sequence[SoftPlane],
    cylinder: SoftCylinder | None,
) -> None:
    """ValueError for a box, a field or walls that cannot be."""
    dimension = len(lengths)
    for length, around in zip(lengths, periodic, strict=True):
        if around and not (np.isfinite(length) and length > 0):
            raise ValueError(f"periodic lengths must be positive and finite, got {lengths}")
    if gravity is not None and (len(gravity) != dimension or not np.isfinite(gravity).all()):
        raise ValueError(f"gravity must have {dimension} finite components, got {gravity}")
    for wall in walls:
        numbers = [wall.place, wall.amplitude, wall.frequency, wall.phase]
        if wall.axis not in range(dimension) or wall.sign not in (1, -1) or not np.isfinite(numbers).all():
            raise ValueError(f"a plane needs an axis below {dimension}, a sign +1 or -1, finite numbers, got {wall}")
    if cylinder is not None:
        numbers = [cylinder.radius, *cylinder.centre, cylinder.angular_velocity]
        axes = (2,) if dimension == 2 else (0, 1, 2)
        if cylinder.axis not in axes or not cylinder.radius > 0 or not np.isfinite(numbers).all():
            raise ValueError(f"a cylinder needs a positive radius, finite numbers and an axis (2D: 2), got {cylinder}")


def grains(
    *,
    radii: np.ndarray,
    masses: np.ndarray,
    lengths: Sequence[float],
    periodic: Sequence[bool],
    law: ContactLaw,
    inertia: float | None = None,
    gravity: Sequence[float] | None = None,
    walls: Sequence[SoftPlane] = (),
    cylinder: SoftCylinder | None = None,
    hertz: bool = False,
    damping: Literal["mass", "restitution"] = "restitution",
    history: bool = True,
    granular: bool = False,
    tallies: bool = False,
    skin: float | None = None,
) -> Grains:
    """Soft grains in a box.

    radii, masses: (N,). lengths, periodic: (d,) box sides, of which only those of periodic axes matter. law: of the
    contacts of pairs. inertia: q in I = q m R^2; None: smooth grains, which do not turn. gravity: acceleration (d,), or
    None. walls, cylinder: what is there of them. hertz, damping, history, granular: which of the module's equations.
    tallies: integrate number of contacts, virial, forces on walls and torque of the cylinder too, see `Grains`. skin:
    of the wide list of pairs, a length, by default SKIN times the largest diameter; it changes the speed only. Units:
    any consistent set.

    Raises ValueError for arrays of unequal sizes, for numbers out of range, and for periodic sides of no more than two
    diameters.
    """
    radii, masses = np.array(radii, dtype=np.float64), np.array(masses, dtype=np.float64)
    dimension, number = len(lengths), radii.size
    if dimension not in (2, 3) or len(periodic) != dimension:
        raise ValueError(f"lengths and periodic must hold 2 or 3 values each, got {lengths} and {periodic}")
    if masses.shape != (number,) or not (np.isfinite([radii, masses]).all() and radii.min() > 0 and masses.min() > 0):
        raise ValueError("radii and masses must be positive and finite, one each for every grain")
    _check_surroundings(lengths, periodic, gravity, walls, cylinder)
    if inertia is not None and not 0 < inertia <= 1:
        raise ValueError(f"inertia is q in I = q m R^2, between 0 and 1, got {inertia}")
    if damping not in ("mass", "restitution"):
        raise ValueError(f"damping must be 'mass' or 'restitution', got {damping!r}")
    if skin is not None and not (np.isfinite(skin) and skin >= 0):
        raise ValueError(f"skin must be finite and not negative, got {skin}")
    sides = tuple(float(length) if around else 0.0 for length, around in zip(lengths, periodic, strict=True))
    diameter = 2 * float(radii.max())
    shortest = min((side for side in sides if side > 0), default=np.inf)
    if shortest <= 2 * diameter:
        raise ValueError(f"periodic sides must exceed two diameters, {2 * diameter}, got {sides}")
    rough = inertia is not None
    rows = [[*wall[:3], *wall[4:], *_row(wall.law)] for wall in walls]
    return Grains(
        radii=radii,
        masses=masses,
        inverse_masses=1 / masses,
        inverse_inertias=1 / (inertia * masses * radii**2) if inertia is not None else None,
        gravity=np.zeros(dimension) if gravity is None else np.array(gravity, dtype=np.float64),
        law=np.array(_row(law)),
        model=ContactModel(hertz, damping == "mass", history, granular),
        walls=np.array(rows, dtype=np.float64).reshape(len(rows), 11),
        cylinder=np.zeros(0) if cylinder is None else _cylinder_row(cylinder),
        auxiliary=1 + (2 + (len(rows) + 1) * dimension + 1 if tallies else 0),
        lists=contact_lists(sides, radii, SKIN * diameter if skin is None else skin, rough),
        wall_stretches=np.zeros((len(rows) + 1, number if rough else 0, 3)),
        clock=np.full(1, np.nan),
    )


def coordinates(
    force: Grains, positions: np.ndarray, velocities: np.ndarray, spins: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Flat r and v of the `force` at time 0, with angles and tallies 0.

    positions, velocities: (N, d). spins: angular velocities, (N, 1) in two dimensions or (N, 3) in three; None: 0.
    """
    turning = () if force.inverse_inertias is None else (3 if len(force.lists.sides) == 3 else 1,)
    angles = np.zeros((force.radii.size, *turning)) if turning else np.zeros(0)
    rest = np.zeros(force.auxiliary)
    clock = rest.copy()
    clock[0] = 1.0
    r = np.concatenate([positions.ravel(), angles.ravel(), rest])
    v = np.concatenate([velocities.ravel(), (angles if spins is None else spins).ravel(), clock])
    return r, v


@implements(accelerate, Grains)
def _accelerate(force: Grains, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    a = np.empty(r.size)
    grain_accelerations(force, r, v, a)
    return a


@register_jitable
def _turning(inverse_inertias, dimension, number, v):  # type: ignore[no-untyped-def]
    energy = 0.0
    if inverse_inertias is not None:
        components = 3 if dimension == 3 else 1
        for k in range(components * number):
            energy += 0.5 * v[dimension * number + k] ** 2 / inverse_inertias[k // components]
    return energy


@implements(kinetic_energy, Grains)
def _kinetic_energy(force: Grains, v: np.ndarray) -> float:
    """With the rotation."""
    d, number = len(force.lists.sides), len(force.radii)
    energy = _turning(force.inverse_inertias, d, number, v)
    for k in range(d * number):
        energy += 0.5 * force.masses[k // d] * v[k] ** 2
    return energy


@implements(energy_and_virial, Grains)
def _energy_and_virial(force: Grains, r: np.ndarray) -> tuple[float, float]:
    """Of gravity and of the normal springs. The virial is NaN: `tallies` integrates it."""
    energy = elastic_energy(force, r)
    d = len(force.lists.sides)
    for k in range(d * len(force.radii)):
        energy -= force.masses[k // d] * force.gravity[k % d] * r[k]
    return energy, np.nan


@implements(status, Grains)
def _status(force: Grains) -> int:
    return force.lists.bookkeeping[STATUS]


@implements(enlarge, Grains)
def _enlarge(force: Grains) -> Grains:
    # the smaller force may be used again: nothing that an evaluation changes is shared with it
    own = {name: getattr(force, name).copy() for name in ("clock", "wall_stretches")}
    return force._replace(lists=enlarge_lists(force.lists), **own)


@implements(operations, Grains)
def _operations(force: Grains) -> dict[str, int]:
    return {
        "evaluations": int(force.lists.bookkeeping[EVALUATIONS]),
        "pair_tests": int(force.lists.bookkeeping[PAIR_TESTS]),
        "list_builds": int(force.lists.bookkeeping[BUILDS]),
        "list_prunings": int(force.lists.bookkeeping[PRUNES]),
        "list_tests": int(force.lists.bookkeeping[LIST_TESTS]),
    }


@implements(periods, Grains)
def _periods(force: Grains) -> np.ndarray | None:
    """None along gravity, whose energy is that of the place and not of the place in the box."""
    sides = np.where(force.gravity == 0, force.lists.sides, 0.0)
    if not sides.any():
        return None
    number = len(force.radii)
    turning = 0 if force.inverse_inertias is None else number * (3 if len(sides) == 3 else 1)
    return np.concatenate([np.tile(sides, number), np.zeros(turning + force.auxiliary)])


@implements(renew, Grains)
def _renew(force: Grains) -> None:
    force.lists.bookkeeping[LISTED] = 0
