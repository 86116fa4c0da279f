"""Hard disks and spheres between hard walls: ideal pressure, hits, surface tension, pressure of disks in a box.

k_B = 1; the diameter sigma, the mass m and the temperature T (an energy) are 1 where no argument says otherwise;
dimension, d, is 2 or 3; density, n, particles per length^d; number, N, of particles.

Literature: H. Reiss, H. L. Frisch and J. L. Lebowitz, J. Chem. Phys. 31, 369 (1959) (scaled-particle theory); the other
equations are exact or derived in the docstrings.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import (
    Estimate,
    demand_dimension,
    disk_compressibility,
    finite_speed_factor,
    number_correction,
    packing_fraction,
    smooth_compressibility,
)

Floats = NDArray[np.float64]


def ideal_wall_pressure(
    number: int, length: float, dimension: int, temperature: float = 1.0, diameter: float = 0.0
) -> float:
    """Force per wall area L^(d-1) of particles that meet only the walls: n T L/(L - sigma), n = N/L^d.

    Centres are confined to (L - sigma)^d. With T = m V0^2/d it holds for a gas of one speed in all directions, too.

    number: N. length: L, the side of the box. dimension: d, 2 or 3, else ValueError. temperature: T, energy. diameter:
    sigma, below L. Any consistent units; gives energy/length^d. Exact.
    """
    demand_dimension(dimension)
    return number * temperature / ((length - diameter) * length ** (dimension - 1))


def wall_hit_rate(density: float, temperature: float = 1.0, mass: float = 1.0) -> float:
    """Hits per time and wall area in equilibrium, n <|v_x|>/2 = n sqrt(T/2 pi m); n is the density at the wall.

    density: n, 1/length^d. temperature: T, energy. mass: m. Any consistent units; gives 1/(time length^(d-1)). Exact.
    """
    return float(density * (temperature / (2 * np.pi * mass)) ** 0.5)


#: Surface term of the third cluster integral of disks at a hard wall, in sigma^5: -(1/6) times the integral of f12 f13
#: + f12 f23 + f13 f23 + f12 f13 f23 times the depth of the cluster; by Monte Carlo, error 1.3e-4.
_SURFACE_CLUSTER = -1.47764


def disk_wall_tension(density: float) -> float:
    """gamma sigma/T of disks at a flat hard wall, per length of the line where centres stop.

    -(n^2/3) (1 + 1.850 n + ...) from the second and third cluster integrals, resummed as (n^2/3)/(1 - 1.850 n/2)^2, the
    form of scaled-particle theory. The adsorption is Gamma = -d gamma/d mu = (2/3) n^2 - 0.244 n^3 + ...

    density: n, 1/length^2 in diameters, tested for pi n/4 <= 0.1.
    """
    third = 4 / 3 * (np.pi / 2) + _SURFACE_CLUSTER
    return float(-(density**2) / 3 / (1 - 1.5 * third * density) ** 2)


def disk_box_pressure(number: int, length: float, temperature: float = 1.0) -> Estimate:
    """Mean force per length L on the hard walls of a square box with N disks of diameter 1; eta <= 0.1, L >= 10.

    Centres live in a square of side l = L - 1, with bulk density n: N = n l^2 + 4 l Gamma, and from the work done when
    l grows, p = (l/L) (n T Z_N(n) - 2 gamma/l): the adsorption Gamma = -d gamma/d mu lowers n, and the corners, where
    contact is likelier, give back a quarter of that. Z_N holds the correction for finite N of `finite_compressibility`.
    Doubt 1.2e-3 (eta/0.1)^2 of p: it covers what event-driven runs gave for p L^2/(N T), 1.07473(5) and 1.3341(2)
    for N = 25 at N pi/4L^2 = 0.02 and 0.1, 1.2862(3) for N = 100 at 0.1, 1.0498(2) and 1.2620(2) for N = 400 at 0.02
    and 0.1, against 1.07478, 1.3326, 1.2855, 1.0498, 1.2610. Z at the mean density, pi N/4L^2, is low by 2 to 7 %.

    number: N. length: L in diameters. temperature: T, energy. Gives energy/length^2.
    """
    side = length - 1
    mean = number / side**2

    def adsorption(n: float) -> float:
        h = 1e-4
        slope = (disk_wall_tension(n + h) - disk_wall_tension(n - h)) / (2 * h)
        low, high = ((n + k * h) * smooth_compressibility(packing_fraction(n + k * h, 2), 2) for k in (-1, 1))
        return float(-slope * n * 2 * h / (high - low))

    n = mean
    for _ in range(50):
        n = mean - 4 * adsorption(n) / side
    eta = packing_fraction(n, 2)
    z = disk_compressibility(eta).value - number_correction(eta, number, 2)
    pressure = temperature * side / length * (n * z - 2 * disk_wall_tension(n) / side)
    return Estimate(pressure, doubt=1.2e-3 * (eta / 0.1) ** 2 * pressure)


def impulse_of_a_hit(temperature: float, freedoms: int, mass: float = 1.0) -> float:
    """Mean momentum that a hit gives to a wall, 2 m <v_x^2>/<|v_x|> = sqrt(2 pi m T), at constant energy.

    freedoms: velocity components of the system, f, with T = 2K/f. The velocities are uniform on a sphere in f
    dimensions: <v_x^2> = T/m, and <|v_x|> is that of Maxwell times `finite_speed_factor` of f.

    temperature: T, energy. mass: m of a particle. Exact.
    """
    return float((2 * np.pi * mass * temperature) ** 0.5 / finite_speed_factor(freedoms))


def between_walls(way: ArrayLike, room: float) -> Floats:
    """Place, from 0 to `room`, of a point that flies to and fro between two walls, after a way (any shape) from 0.

    way: length flown since the wall at 0, any shape; room: between the walls, in the same unit. By derivation: a
    triangular wave.
    """
    phase = np.asarray(way) % (2 * room)
    return np.where(phase < room, phase, 2 * room - phase)
