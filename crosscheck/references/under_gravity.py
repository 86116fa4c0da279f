"""Hard disks under gravity: an elastic column at rest on a floor, and the stress in a channel.

Mass, diameter and k_B are 1; in the column gravity is 1 too. The density is taken to change little over a diameter.
Literature: hydrostatics, dp = -n m g dz, with the compressibility Z(eta) of `hard_spheres`; the microcanonical ensemble
of an ideal gas under gravity, F. L. Roman, J. A. White and S. Velasco, Eur. J. Phys. 16, 83 (1995).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import disk_compressibility

Floats = NDArray[np.float64]


def mean_compressibility(pressure: float, temperature: float) -> float:
    """(1/p0) int_0^p0 Z dp of disks at one temperature: U/(N T) of a column whose floor bears the pressure p0.

    From dp = -n m g dz: U = int n m g z dz = int p dz = int p dp/(n m g), and p = n T Z. pressure: p0, the weight per
    length of floor. temperature: T. ValueError if the floor is denser than a packing fraction of 0.3.
    """
    eta = np.linspace(0.0, 0.3, 3001)
    z = np.array([disk_compressibility(x).value for x in eta])
    p = eta * 4 / math.pi * temperature * z
    if not p[-1] > pressure:
        raise ValueError(f"a floor that bears {pressure:g} is denser than eta = 0.3 at T = {temperature:g}")
    grid = np.linspace(0.0, pressure, 2001)
    return float(np.trapezoid(np.interp(grid, p, z), grid) / pressure)


def column_profile(mass_below: ArrayLike, pressure: float, temperature: float) -> Floats:
    """Height z below which a share of a column of disks is: z = T int_p^p0 Z dp/p.

    mass_below: the shares, any shape, from 0 up to 1 - 1e-6, above which the height no longer rises. pressure: p0, the
    weight per length of floor, at which the packing fraction must be below 0.3. temperature: T.
    """
    eta = np.linspace(0.0, 0.3, 3001)
    z = np.array([disk_compressibility(x).value for x in eta])
    p = eta * 4 / math.pi * temperature * z
    grid = np.geomspace(1e-6, 1.0, 20001) * pressure
    integrand = np.interp(grid, p, z)
    depth = np.concatenate([[0.0], np.cumsum(0.5 * (integrand[1:] + integrand[:-1]) * np.diff(np.log(grid)))])
    heights = temperature * (depth[-1] - depth)
    return np.asarray(np.interp(1 - np.asarray(mass_below), grid / pressure, heights))


def fixed_energy(height: ArrayLike, number: int, temperature: float) -> Floats:
    """Share of an ideal column below a height, at fixed energy less that at fixed temperature.

    (1 - z/E)^(2N - 3/2), E = (2N - 1/2) T, in place of exp(-z/T), in two dimensions and without momentum sideways.
    height: z, any shape. number: N. temperature: T.
    """
    z, power = np.asarray(height, dtype=np.float64), 2 * number - 1.5
    return np.asarray(np.exp(-z / temperature) - np.maximum(1 - z / ((power + 1) * temperature), 0.0) ** power)


def floor_layer(pressure: float, temperature: float) -> float:
    """What the layer of disks at the floor changes, relative to the number of disks: (4/3) p0/T^2, an uncertainty.

    Next to the floor a disk has fewer neighbours in its way: to first order in the density, (2/3) n^2 disks per length
    are there, n = p0/T, which are not higher up; over the p0 disks per length, and taken twice. pressure: p0, the
    weight per length of floor. temperature: T.
    """
    return 4 / 3 * (pressure / temperature) / temperature


def channel_stress(mass: ArrayLike, total: float, pull: float) -> Floats:
    """Shear stress times length in a channel whose walls drag alike: g (mass below - M/2), where layers meet.

    The momentum balance of a steady flow along x: d(stress)/dy = g rho. mass: (..., layers), of the layers from the
    lower wall up. total: M, of all of them. pull: g, along the channel. Gives (..., layers - 1).
    """
    return np.asarray(pull * (np.cumsum(np.asarray(mass), axis=-1)[..., :-1] - 0.5 * total))
