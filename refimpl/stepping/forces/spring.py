"""Damped harmonic oscillators about the origin."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from refimpl.compilation import implements
from refimpl.stepping.forces.generic import (
    accelerate,
    bodies_in_registers,
    derivatives,
    energy_and_virial,
    kinetic_energy,
)
from refimpl.stepping.kernels.registers import MOST
from refimpl.stepping.kernels.sums import sum_in_order, sum_of_squares


class Spring(NamedTuple):
    """m a = -k r - gamma v, every coordinate on its own; `gamma` None leaves the damping out of the kernel.

    k: stiffness, force/length. gamma: friction coefficient, mass/time. mass: of every particle; where they differ, of
    every coordinate, (N*d,).
    """

    k: float
    mass: Any
    gamma: float | None


def spring(k: float, mass: float | np.ndarray = 1.0, gamma: float | None = None) -> Spring:
    """A `Spring`; ValueError unless k > 0, all masses > 0 and gamma >= 0 are finite.

    k: stiffness, force/length. mass: of every particle, or of every coordinate, (N*d,). gamma: friction coefficient,
    mass/time; None: no damping.

    Literature: any text on mechanics, e.g. Landau and Lifshitz, Mechanics, section 25.
    """
    if not (np.isfinite(k) and k > 0):
        raise ValueError(f"spring stiffness k must be positive and finite, got {k}")
    masses = np.array(mass, dtype=np.float64)
    if masses.ndim > 1 or not (masses.size and np.isfinite(masses).all() and masses.min() > 0):
        raise ValueError(f"mass must be positive and finite, got {mass}")
    if gamma is not None and not (np.isfinite(gamma) and gamma >= 0):
        raise ValueError(f"friction gamma must be non-negative and finite, got {gamma}")
    one = bool((masses == masses.flat[0]).all())
    return Spring(float(k), float(masses.flat[0]) if one else masses, None if not gamma else float(gamma))


@register_jitable
def _spring_acceleration(r: np.ndarray, v: np.ndarray, k: float, mass: Any, gamma: float | None) -> np.ndarray:
    if gamma is None:
        return -(k / mass) * r
    return -(k / mass) * r - (gamma / mass) * v


@implements(accelerate, Spring)
def _accelerate(force: Spring, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _spring_acceleration(r, v, force.k, force.mass, force.gamma)


@implements(bodies_in_registers, Spring)
def _bodies_in_registers(force: Spring, count: int) -> int:
    return count if isinstance(force.mass, float) and count <= MOST else 0


@implements(energy_and_virial, Spring)
def _energy_and_virial(force: Spring, r: np.ndarray) -> tuple[float, float]:
    squares = force.k * sum_of_squares(r)
    return 0.5 * squares, -squares


@implements(kinetic_energy, Spring)
def _kinetic_energy(force: Spring, v: np.ndarray) -> float:
    return 0.5 * sum_in_order(force.mass * (v * v))


@register_jitable
def _spring_derivatives(
    r: np.ndarray, v: np.ndarray, count: int, k: float, mass: Any, gamma: float | None
) -> np.ndarray:
    higher = np.empty((count, r.size))
    below, last = v, _spring_acceleration(r, v, k, mass, gamma)
    for q in range(count):
        # r_{q+2} = -(k r_q + gamma r_{q+1})/m: the equation of motion, differentiated q times
        below, last = last, _spring_acceleration(below, last, k, mass, gamma)
        higher[q] = last
    return higher


@implements(derivatives, Spring)
def _derivatives(force: Spring, r: np.ndarray, v: np.ndarray, count: int) -> np.ndarray:
    return _spring_derivatives(r, v, count, force.k, force.mass, force.gamma)
