"""Damped harmonic oscillators about the origin."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from refimpl.stepping.forces.generic import (
    accelerate,
    derivatives,
    implements,
    kinetic_energy,
    potential_energy,
    virial,
)
from refimpl.stepping.kernels.sums import sum_of_squares


class Spring(NamedTuple):
    """m a = -k r - gamma v, every coordinate on its own; `gamma` None leaves the damping out of the kernel.

    k: stiffness, force/length. gamma: friction coefficient, mass/time. mass: of every particle.
    """

    k: float
    mass: float
    gamma: float | None


def spring(k: float, mass: float = 1.0, gamma: float | None = None) -> Spring:
    """A `Spring`; ValueError unless k > 0, mass > 0 and gamma >= 0 are finite.

    Literature: any text on mechanics, e.g. Landau and Lifshitz, Mechanics, section 25.
    """
    if not (np.isfinite(k) and k > 0):
        raise ValueError(f"spring stiffness k must be positive and finite, got {k}")
    if not (np.isfinite(mass) and mass > 0):
        raise ValueError(f"mass must be positive and finite, got {mass}")
    if gamma is not None and not (np.isfinite(gamma) and gamma >= 0):
        raise ValueError(f"friction gamma must be non-negative and finite, got {gamma}")
    return Spring(float(k), float(mass), None if not gamma else float(gamma))


@register_jitable
def _spring_acceleration(r: np.ndarray, v: np.ndarray, k: float, mass: float, gamma: float | None) -> np.ndarray:
    if gamma is None:
        return -(k / mass) * r
    return -(k / mass) * r - (gamma / mass) * v


@implements(accelerate, Spring)
def _accelerate(force: Spring, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _spring_acceleration(r, v, force.k, force.mass, force.gamma)


@implements(potential_energy, Spring)
def _potential_energy(force: Spring, r: np.ndarray) -> float:
    return 0.5 * force.k * sum_of_squares(r)


@implements(virial, Spring)
def _virial(force: Spring, r: np.ndarray) -> float:
    return -force.k * sum_of_squares(r)


@implements(kinetic_energy, Spring)
def _kinetic_energy(force: Spring, v: np.ndarray) -> float:
    return 0.5 * force.mass * sum_of_squares(v)


@register_jitable
def _spring_derivatives(
    r: np.ndarray, v: np.ndarray, count: int, k: float, mass: float, gamma: float | None
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
