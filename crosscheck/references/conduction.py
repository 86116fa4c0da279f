"""Conduction of heat in fluids of hard disks and spheres.

Literature: D. M. Gass, J. Chem. Phys. 54, 1898 (1971); S. Chapman and T. G. Cowling, The Mathematical Theory of
Non-Uniform Gases, 3rd ed. (1970); B. J. Alder, D. M. Gass and T. E. Wainwright, J. Chem. Phys. 53, 3813 (1970);
R. Garcia-Rojo, S. Luding and J. J. Brey, Phys. Rev. E 74, 061305 (2006).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import Estimate, contact_value, packing_fraction

Floats = NDArray[np.float64]


def enskog_conductivity(density: float, temperature: float, dimension: int) -> Estimate:
    """Thermal conductivity of hard disks or spheres of mass and diameter 1 in Enskog's theory, k_B = 1.

    lambda = lambda_0 b n (1/y + c_1 + c_2 y), y = b n g = Z - 1. Disks: lambda_0 = 1.02925 (2/sqrt(pi)) sqrt(T), c_1 =
    3/2, c_2 = 0.8718 (Gass 1971); spheres: 1.02513 (75/64) sqrt(T/pi), 6/5, 0.7574 (Chapman and Cowling). Uncertain by
    3 % and 2 %: what correlated collisions change at these densities (Alder, Gass and Wainwright 1970; Garcia-Rojo,
    Luding and Brey 2006). density: number per area or volume, of a fluid. temperature: in units of energy. dimension:
    2 or 3, else ValueError.
    """
    g = contact_value(packing_fraction(density, dimension), dimension).value
    bn = math.pi / 2 * density if dimension == 2 else 2 * math.pi / 3 * density
    y = bn * g
    if dimension == 2:
        value = 1.02925 * 2 * math.sqrt(temperature / math.pi) * bn * (1 / y + 1.5 + 0.8718 * y)
        return Estimate(value, 0.03 * value)
    value = 1.02513 * 75 / 64 * math.sqrt(temperature / math.pi) * bn * (1 / y + 1.2 + 0.7574 * y)
    return Estimate(value, 0.02 * value)


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
        -flux / enskog_conductivity(float(one), float(warm), dimension).value
        for one, warm in zip(np.interp(fine, x, n), np.interp(fine, x, t), strict=True)
    ]
    curve = np.concatenate([[0.0], np.cumsum(0.5 * (np.array(rates)[1:] + np.array(rates)[:-1]) * np.diff(fine))])
    curve += np.interp(middle, x, t) - np.interp(middle, fine, curve)
    return fine, curve
