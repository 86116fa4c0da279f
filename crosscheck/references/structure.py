"""Structure of fluids of hard disks: long density waves, and neighbours within a short distance.

Literature: J.-P. Hansen and I. R. McDonald, Theory of Simple Liquids, 3rd ed. (2006), sections 2.6, 3.5.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import contact_value, disk_compressibility, packing_fraction

Floats = NDArray[np.float64]


def structure_factor(density: float, wave_number: ArrayLike) -> Floats:
    """S(k) of disks of diameter 1 at small k: 1/(1 - n c(k)), 1 - n c(0) = d(eta Z)/deta, c(k)/c(0) = 2 J_1(k)/k.

    Exact at k = 0, where it is the compressibility; the shape of c(k) is that of its lowest order in the density.
    density: number per area. wave_number: k, any shape, positive.
    """
    from scipy.special import j1

    eta = packing_fraction(density, 2)
    h = 1e-3 * eta
    stiffness = sum(s * (eta + s * h) * disk_compressibility(eta + s * h).value for s in (-1, 1)) / (2 * h)
    k = np.asarray(wave_number, dtype=np.float64)
    return np.asarray(1 / (1 + (stiffness - 1) * 2 * j1(k) / k))


def neighbour_share(density: float, reach: float) -> float:
    """Share of the disks (diameter 1) of a dilute fluid with another centre within `reach`, to second order.

    n int g d2r - (n^2/2) int int e(r_12) d2r1 d2r2 over 1 < r < reach, with g = 1 + n A(r), A the lens that two unit
    circles share, scaled to the known g at contact; e = 0 for r_12 < 1. The third order is left out: about 1 % at a
    density of 0.1 and a reach of 1.2. density: number of the others per area. reach: distance of centres, 1 to 2.
    """
    x, w = np.polynomial.legendre.leggauss(40)
    r, w = 1 + 0.5 * (reach - 1) * (x + 1), 0.5 * (reach - 1) * w
    lens = 2 * np.arccos(r / 2) - 0.5 * r * np.sqrt(4 - r * r)
    contact = contact_value(packing_fraction(density, 2), 2).value
    scale = contact / (1 + density * (2 * math.pi / 3 - 0.5 * 3**0.5))
    one = density * 2 * math.pi * float(np.sum(w * r * (1 + density * lens))) * scale
    cosine = (r[:, None] ** 2 + r[None, :] ** 2 - 1) / (2 * r[:, None] * r[None, :])
    free = 2 * (math.pi - np.arccos(np.clip(cosine, -1, 1)))
    two = 0.5 * density**2 * 2 * math.pi * float(np.einsum("i,j,ij->", w * r, w * r, free))
    return one - two
