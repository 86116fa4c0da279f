"""Speeds of the particles of a gas: Maxwell's law, few particles at constant energy, relaxation from one speed.

k_B = 1; speed in the caller's unit, temperature T an energy, mass m; T = m = 1 where no argument says otherwise;
dimension, d, is 2 or 3.

Literature: S. Chapman and T. G. Cowling, The Mathematical Theory of Non-uniform Gases, 3rd ed. (1970); G. A. Bird,
Molecular Gas Dynamics and the Direct Simulation of Gas Flows (1994).
"""

from __future__ import annotations

from math import gamma, inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import Estimate, demand_dimension

Floats = NDArray[np.float64]


def maxwell_density(speed: ArrayLike, dimension: int, temperature: float = 1.0, mass: float = 1.0) -> Floats:
    """Probability density of the speed, 2 v^(d-1) exp(-v^2/w^2)/(Gamma(d/2) w^d), w^2 = 2T/m; 0 for v < 0.

    In two dimensions (2 v/V0^2) exp(-v^2/V0^2), with V0^2 = <v^2> = 2T/m.

    speed: v, any shape, length/time. dimension: d, 2 or 3, else ValueError. temperature: T, energy. mass: m. Any
    consistent units; gives time/length. Exact.
    """
    demand_dimension(dimension)
    v, w2 = np.asarray(speed, dtype=np.float64), 2 * temperature / mass
    positive = np.maximum(v, 0.0)
    return np.asarray(
        2 * positive ** (dimension - 1) * np.exp(-(positive**2) / w2) / (gamma(dimension / 2) * w2 ** (dimension / 2))
    )


def maxwell_cumulative(speed: ArrayLike, dimension: int, temperature: float = 1.0, mass: float = 1.0) -> Floats:
    """Probability of a smaller speed: the regularised incomplete gamma function P(d/2, m v^2/2T).

    speed: v, any shape, length/time. dimension: d, 2 or 3, else ValueError. temperature: T, energy. mass: m. Any
    consistent units. Exact.
    """
    from scipy.special import gammainc

    demand_dimension(dimension)
    v = np.maximum(np.asarray(speed, dtype=np.float64), 0.0)
    return np.asarray(gammainc(dimension / 2, 0.5 * mass * v * v / temperature))


def maxwell_mean_speed(dimension: int, temperature: float = 1.0, mass: float = 1.0) -> float:
    """<v> = (2T/m)^(1/2) Gamma((d+1)/2)/Gamma(d/2): sqrt(pi T/2m), sqrt(8T/pi m).

    dimension: d, 2 or 3, else ValueError. temperature: T, energy. mass: m. Any consistent units. Exact.
    """
    demand_dimension(dimension)
    return float((2 * temperature / mass) ** 0.5 * gamma((dimension + 1) / 2) / gamma(dimension / 2))


def moment_ratio(dimension: int, freedoms: float = inf) -> float:
    """<v^4>/<v^2>^2 in equilibrium, f degrees of freedom at constant energy: (1 + 2/d) f/(f + 2); 2, 5/3 for f = inf.

    The velocities are uniform on a sphere in f dimensions (periodic box or hard walls alike).

    dimension: d, 2 or 3, else ValueError. freedoms: f, the velocity components that are free. Exact.
    """
    demand_dimension(dimension)
    return (1 + 2 / dimension) * (1.0 if freedoms == inf else freedoms / (freedoms + 2))


def share_distribution(dimension: int, freedoms: float) -> Any:
    """Distribution of m v^2/2K of one particle at constant energy K: beta with the parameters d/2 and (f - d)/2.

    The scaled velocities are uniform on a sphere in f dimensions, of which the particle has d. Exact; for f to infinity
    f m v^2/2K has the gamma distribution of Maxwell's speeds.

    dimension: d, 1 or more. freedoms: f, more than d, the velocity components that are free. Gives a frozen
    distribution of scipy.stats.
    """
    from scipy.stats import beta

    return beta(dimension / 2, (freedoms - dimension) / 2)


def moment_ratio_fluctuation(number: int, dimension: int) -> float:
    """Standard deviation of one sample of <v^4>/<v^2>^2 in equilibrium: (8 (d+2)/(d^3 N))^(1/2), 2/sqrt(N) for disks.

    To leading order in 1/N, at constant energy: var x^2 - cov(x^2, x)^2/var x for x = v^2/<v^2>.

    number: N, of particles. dimension: d, 2 or 3, else ValueError.
    """
    demand_dimension(dimension)
    return float((8 * (dimension + 2) / (dimension**3 * number)) ** 0.5)


#: What pairs that meet again change of the moment ratio while it relaxes, over n sigma^d: own event-driven runs at n =
#: 0.1 depart by 0.010 at most from Boltzmann's gas.
MEETING_AGAIN = 0.1


class Relaxation(NamedTuple):
    """<v^4>/<v^2>^2 of a dilute gas that starts with one speed, after C collisions of pairs among N particles.

    collisions_per_particle: C/N. moment_ratio: the value then, and standard_error: of it.
    """

    collisions_per_particle: float
    moment_ratio: float
    standard_error: float


#: From direct simulation of the homogeneous Boltzmann equation: 12 runs of 10^6 particles, pairs drawn at random and
#: accepted in proportion to their relative speed. The standard error is that of the mean of the 12.
MONO_SPEED: dict[int, tuple[Relaxation, ...]] = {
    2: (
        Relaxation(0.05, 1.02823, 0.00004),
        Relaxation(0.1, 1.05603, 0.00005),
        Relaxation(0.25, 1.13664, 0.00010),
        Relaxation(0.5, 1.26098, 0.00014),
        Relaxation(1.0, 1.47132, 0.00029),
        Relaxation(1.5, 1.63181, 0.00029),
        Relaxation(2.0, 1.74863, 0.00037),
        Relaxation(3.0, 1.88765, 0.00038),
        Relaxation(5.0, 1.97939, 0.00033),
        Relaxation(10.0, 1.99960, 0.00065),
    ),
    3: (
        Relaxation(0.05, 1.02254, 0.00003),
        Relaxation(0.1, 1.04461, 0.00007),
        Relaxation(0.25, 1.10784, 0.00006),
        Relaxation(0.5, 1.20243, 0.00012),
        Relaxation(1.0, 1.35345, 0.00017),
        Relaxation(1.5, 1.46081, 0.00018),
        Relaxation(2.0, 1.53368, 0.00027),
        Relaxation(3.0, 1.61361, 0.00026),
        Relaxation(5.0, 1.65878, 0.00034),
        Relaxation(10.0, 1.66622, 0.00032),
    ),
}


def mono_speed_moment_ratio(collisions_per_particle: float, number: float, dimension: int) -> Estimate:
    """<v^4>/<v^2>^2 of one run of N particles after C/N collisions, with what one run fluctuates by.

    Boltzmann limit. The fluctuation is that of equilibrium, an upper bound before: at the start it is zero. ValueError
    if C/N is not in the table.

    collisions_per_particle: C/N. number: N, or infinity for the gas itself. dimension: 2 or 3, else ValueError. G. A.
    Bird's method (1994).
    """
    demand_dimension(dimension)
    for row in MONO_SPEED[dimension]:
        if row.collisions_per_particle == collisions_per_particle:
            spread = 0.0 if number == inf else moment_ratio_fluctuation(int(number), dimension)
            return Estimate(row.moment_ratio, float(np.hypot(row.standard_error, spread)))
    known = ", ".join(str(row.collisions_per_particle) for row in MONO_SPEED[dimension])
    raise ValueError(f"no value after {collisions_per_particle} collisions a particle; there are {known}")


def mono_speed_temperature(speed: float, dimension: int, mass: float = 1.0) -> float:
    """T = m V0^2/d of a gas whose particles all have speed V0.

    speed: V0, length/time. dimension: d, 2 or 3, else ValueError. mass: m. Any consistent units. Exact: the definition
    of T.
    """
    demand_dimension(dimension)
    return mass * speed**2 / dimension
