"""Newton's gravity between all pairs of bodies, softened on request, in two or three dimensions."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import partial
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from refimpl.compilation import compiled, implements
from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    accelerate,
    bodies_in_registers,
    energy_and_virial,
    in_registers,
    kinetic_energy,
    status,
    team,
)
from refimpl.stepping.kernels import few_bodies
from refimpl.stepping.kernels import gravity as kernels
from refimpl.stepping.kernels.registers import all_finite, from_array
from refimpl.team import helping

#: Up to so many bodies the plain double loop, which copies nothing, is as fast as the kernel for many; and a long run
#: has them in registers, with the bits of the plain loop.
FEW_BODIES = 16


class Gravity(NamedTuple):
    """m_i a_i = -G sum_j m_i m_j (r_i - r_j)/(r_ij^2 + s^2)^(3/2).

    mass: shape (N,). z: place of the third coordinate among those of a body, 2; None in the plane. G:
    gravitational constant, length^3/(mass time^2). softening: the length s, or None. None leaves the feature
    out of the kernels. outcome: shape (1,), the status of the last evaluation. work: of the kernel for many bodies.
    threads: that share its work.
    """

    mass: np.ndarray
    z: int | None
    G: float
    softening: float | None
    outcome: np.ndarray
    work: kernels.Work
    threads: int


def gravity(
    mass: np.ndarray, dimension: int, G: float = 1.0, softening: float | None = None, threads: int = 1
) -> Gravity:
    """A `Gravity` force of N bodies.

    mass: shape (N,), copied; zero for test particles, which feel forces and exert none. dimension: 2 or 3; in
    the plane the law is still the inverse square. G: in the same units. softening: the length s of a Plummer sphere,
    S. J. Aarseth, Mon. Not. R. Astron. Soc. 126, 223 (1963); 0 counts as None. threads: that share the pairs of more
    than FEW_BODIES bodies while `integrate` runs; no bit depends on their number.

    Bodies in the same place without softening have no acceleration: it comes out as not finite, and `status`
    as DIVERGED.

    Raises ValueError for a mass that is negative or not finite, for a mass array that is not flat or is
    empty, and for a dimension, G, softening or threads out of range. Evaluation raises ValueError if the coordinates
    are not N*d in number.
    """
    mass = np.array(mass, dtype=np.float64)
    if mass.ndim != 1 or mass.size == 0:
        raise ValueError(f"mass must be a flat array with one value per body, got shape {mass.shape}")
    wrong = np.flatnonzero(~(np.isfinite(mass) & (mass >= 0)))
    if wrong.size:
        raise ValueError(
            f"masses must be finite and >= 0 (0 for test particles), got {mass[wrong[0]]} for body {wrong[0]}"
        )
    if dimension not in (2, 3):
        raise ValueError(f"dimension must be 2 or 3, got {dimension}")
    if not (np.isfinite(G) and G > 0):
        raise ValueError(f"gravitational constant G must be positive and finite, got {G}")
    if softening is not None and not (np.isfinite(softening) and softening >= 0):
        raise ValueError(f"softening must be a finite length >= 0, or None for no softening, got {softening}")
    if threads < 1:
        raise ValueError(f"threads must be at least 1, got {threads}")
    return Gravity(
        mass,
        None if dimension == 2 else 2,
        float(G),
        float(softening) if softening else None,
        np.full(1, GOOD, dtype=np.int64),
        kernels.work(mass.size),
        threads,
    )


@compiled(cache=True)
def plain_acceleration(r: np.ndarray, mass: np.ndarray, z: int | None, G: float, softening: float | None) -> np.ndarray:
    """a_i = -G sum_j m_j (r_i - r_j)/(r_ij^2 + s^2)^(3/2), shape (N*d,), each pair once.

    r: shape (N*d,). mass: shape (N,). z: 2 in space, None in the plane. softening: s, or None.

    Every component is within (N/2 + 6) eps of the exact one, relative to the sum of the absolute values of
    its terms, as long as the cubes of the distances neither overflow nor underflow; `kernels.acceleration`
    likewise. The forces of a pair are opposite up to the rounding of two products, so that momentum is
    conserved to |sum_i m_i a_i| <= (N + 12) eps sum_i sum_j |F_ij|.
    """
    n = mass.size
    d = 2 if z is None else 3
    a = np.zeros(d * n)
    for i in range(n):
        p = d * i
        for j in range(i):
            q = d * j
            dx = r[q] - r[p]
            dy = r[q + 1] - r[p + 1]
            square = dx * dx + dy * dy
            if z is not None:
                dz = r[q + z] - r[p + z]
                square += dz * dz
            if softening is not None:
                square += softening * softening
            inverse_cube = G / (square * sqrt(square))
            from_j = inverse_cube * mass[j]
            from_i = inverse_cube * mass[i]
            a[p] += from_j * dx
            a[p + 1] += from_j * dy
            a[q] -= from_i * dx
            a[q + 1] -= from_i * dy
            if z is not None:
                a[p + z] += from_j * dz
                a[q + z] -= from_i * dz
    return a


@register_jitable
def _require_coordinates(r: np.ndarray, mass: np.ndarray, z: int | None) -> None:
    """ValueError unless `r` has d coordinates per body."""
    d = 2 if z is None else 3
    if r.size != d * mass.size:
        raise ValueError("r and v must be flat, with as many coordinates per body as the force has dimensions")


@register_jitable
def _acceleration(
    r: np.ndarray,
    mass: np.ndarray,
    z: int | None,
    G: float,
    softening: float | None,
    outcome: np.ndarray,
    work: kernels.Work,
) -> np.ndarray:
    _require_coordinates(r, mass, z)
    if mass.size <= FEW_BODIES:
        a = plain_acceleration(r, mass, z, G, softening)
    else:
        a = kernels.acceleration(r, mass, z, G, softening, work)
    outcome[0] = GOOD if kernels.all_finite(a) else DIVERGED
    return a


@register_jitable
def _energy_and_virial(
    r: np.ndarray, mass: np.ndarray, z: int | None, G: float, softening: float | None
) -> tuple[float, float]:
    _require_coordinates(r, mass, z)
    return kernels.energy_and_virial(r, mass, z, G, softening)


@implements(accelerate, Gravity)
def _accelerate(force: Gravity, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _acceleration(r, force.mass, force.z, force.G, force.softening, force.outcome, force.work)


class FewBodies(NamedTuple):
    """A `Gravity` of bodies whose coordinates are in registers.

    mass: of the bodies, as `registers.Coordinates`. z, G, softening, outcome: as there.
    """

    mass: Any
    z: int | None
    G: float
    softening: float | None
    outcome: np.ndarray


@implements(bodies_in_registers, Gravity)
def _bodies_in_registers(force: Gravity, count: int) -> int:
    return force.mass.size if force.mass.size <= FEW_BODIES else 0


@implements(in_registers, Gravity)
def _in_registers(force: Gravity, bodies: tuple[int, ...]) -> FewBodies:
    return FewBodies(from_array(force.mass, (0,), bodies), force.z, force.G, force.softening, force.outcome)


@implements(accelerate, FewBodies)
def _accelerate_in_registers(force: FewBodies, r: Any, v: Any) -> Any:
    a = few_bodies.acceleration(r, force.mass, force.z, force.G, force.softening)
    force.outcome[0] = GOOD if all_finite(a) else DIVERGED
    return a


@implements(team, Gravity)
def _team(force: Gravity) -> AbstractContextManager[None]:
    if force.mass.size <= FEW_BODIES:
        return nullcontext()
    arguments = force.mass.size, force.z, force.softening, force.work
    return helping(partial(kernels.serve, *arguments), force.work.flags, force.threads)


@implements(status, FewBodies)
def _status_in_registers(force: FewBodies) -> int:
    return force.outcome[0]


@implements(energy_and_virial, Gravity)
def _energies(force: Gravity, r: np.ndarray) -> tuple[float, float]:
    return _energy_and_virial(r, force.mass, force.z, force.G, force.softening)


@implements(kinetic_energy, Gravity)
def _kinetic_energy(force: Gravity, v: np.ndarray) -> float:
    _require_coordinates(v, force.mass, force.z)
    d = v.size // force.mass.size
    total = 0.0
    for q in range(v.size):
        total += 0.5 * force.mass[q // d] * v[q] ** 2
    return total


@implements(status, Gravity)
def _status(force: Gravity) -> int:
    return int(force.outcome[0])
