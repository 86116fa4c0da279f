"""Conduction of heat in fluids of hard disks and spheres.

Literature: D. M. Gass, J. Chem. Phys. 54, 1898 (1971); S. Chapman and T. G. Cowling, The Mathematical Theory of
Non-Uniform Gases, 3rd ed. (1970); B. J. Alder, D. M. Gass and T. E. Wainwright, J. Chem. Phys. 53, 3813 (1970);
R. Garcia-Rojo, S. Luding and J. J. Brey, Phys. Rev. E 74, 061305 (2006); M. H. Ernst, E. H. Hauge and J. M. J. van
Leeuwen, J. Stat. Phys. 15, 7 (1976) (long-time tails).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import collision_rate, compressibility, contact_value, packing_fraction
from crosscheck.references.transport import enskog_viscosity

Floats = NDArray[np.float64]


def enskog_conductivity(density: float, temperature: float, dimension: int) -> float:
    """Thermal conductivity of hard disks or spheres of mass and diameter 1 in Enskog's theory, k_B = 1.

    lambda = lambda_0 b n (1/y + c_1 + c_2 y), y = b n g = Z - 1. Disks: lambda_0 = 1.02925 (2/sqrt(pi)) sqrt(T), c_1 =
    3/2, c_2 = 0.8718 (Gass 1971); spheres: 1.02513 (75/64) sqrt(T/pi), 6/5, 0.7574 (Chapman and Cowling). What it
    leaves out: `beyond_enskog`. density: number per area or volume, of a fluid. temperature: in units of energy.
    dimension: 2 or 3, else ValueError.
    """
    g = contact_value(packing_fraction(density, dimension), dimension).value
    bn = math.pi / 2 * density if dimension == 2 else 2 * math.pi / 3 * density
    y = bn * g
    if dimension == 2:
        return 1.02925 * 2 * math.sqrt(temperature / math.pi) * bn * (1 / y + 1.5 + 0.8718 * y)
    return 1.02513 * 75 / 64 * math.sqrt(temperature / math.pi) * bn * (1 / y + 1.2 + 0.7574 * y)


def beyond_enskog(density: float, temperature: float, dimension: int, length: float) -> float:
    """Share of the conductivity that correlated collisions may add to Enskog's: its long-time tail, a bound.

    Heat that a shear wave carries along comes back to the particles that it left: the current correlates as c_p T
    (d-1)/d (4 pi (nu + D_T) t)^(-d/2), nu = viscosity/(n m), D_T = kappa/(n c_p), c_p = d/2 + Z^2/(d(eta Z)/d eta) a
    particle (Ernst, Hauge and van Leeuwen 1976). Integrated from the mean time between a particle's collisions, before
    which nothing is correlated, to the decay of the longest wave across a slab of this length in two dimensions, and to
    infinity in three. Enskog's viscosity and conductivity are taken; that of disks: 1.022 sqrt(T/pi)/2 bn (1/y + 1 +
    0.8729 y) (Gass 1971). density, temperature, dimension: as in `enskog_conductivity`. length: in diameters.
    """
    eta, d = packing_fraction(density, dimension), dimension
    if d == 2:
        bn = math.pi / 2 * density
        y = bn * contact_value(eta, 2).value
        viscosity = 1.022 * math.sqrt(temperature / math.pi) / 2 * bn * (1 / y + 1 + 0.8729 * y)
    else:
        viscosity = enskog_viscosity(eta, temperature)
    h = 1e-3 * eta
    low, z, high = (compressibility(eta + s * h, d).value for s in (-1, 0, 1))
    heat = d / 2 + z**2 / (((eta + h) * high - (eta - h) * low) / (2 * h))
    kappa = enskog_conductivity(density, temperature, d)
    spreading = viscosity / density + kappa / (density * heat)
    tail = heat * temperature * (d - 1) / d / (4 * math.pi * spreading) ** (d / 2)
    start = 1 / collision_rate(eta, d, temperature).value
    if d == 2:
        return tail * math.log(max(1.0, length**2 / (4 * math.pi**2 * spreading) / start)) / kappa
    return 2 * tail / math.sqrt(start) / kappa


def fourier_profile(
    places: ArrayLike, density: ArrayLike, temperature: ArrayLike, flux: float, middle: float, dimension: int
) -> tuple[Floats, Floats]:
    """Temperature along x, dT/dx = -q/kappa(n, T), with Enskog's kappa of the given state, from the middle outwards.

    places: (cells,), ascending. density, temperature: (cells,), between which n and T are taken linear; at x = `middle`
    the result is T. flux: q, energy per time and area (of disks: length). dimension: 2 or 3. Gives x and T, (401,).

    middle: a place, within `places`, length.
    """
    x, n, t = (np.asarray(values, dtype=np.float64) for values in (places, density, temperature))
    fine = np.linspace(x[0], x[-1], 401)
    rates = [
        -flux / enskog_conductivity(float(one), float(warm), dimension)
        for one, warm in zip(np.interp(fine, x, n), np.interp(fine, x, t), strict=True)
    ]
    curve = np.concatenate([[0.0], np.cumsum(0.5 * (np.array(rates)[1:] + np.array(rates)[:-1]) * np.diff(fine))])
    curve += np.interp(middle, x, t) - np.interp(middle, fine, curve)
    return fine, curve
