"""Mixtures of hard disks or spheres: contact values, equation of state, collision rates of the species.

k_B = 1; T = 1 where no argument says otherwise; dimension, d, is 2 or 3; k species.

Literature: T. Boublik, J. Chem. Phys. 53, 471 (1970); G. A. Mansoori, N. F. Carnahan, K. E. Starling and T. W. Leland,
J. Chem. Phys. 54, 1523 (1971); J. T. Jenkins and F. Mancini, J. Appl. Mech. 54, 27 (1987); A. Santos, S. B. Yuste and
M. Lopez de Haro, Mol. Phys. 96, 1 (1999).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import (
    Estimate,
    carnahan_starling,
    demand_dimension,
    disk_compressibility,
    sphere_compressibility,
)

Floats = NDArray[np.float64]


class Mixture(NamedTuple):
    """Number densities, diameters and masses of the species.

    densities: particles per length^d; diameters: length; masses; each of shape (k,), any consistent units.
    """

    densities: Floats
    diameters: Floats
    masses: Floats

    @property
    def packing_fraction(self) -> tuple[float, float]:
        """Of disks and of spheres with these diameters."""
        n, s = self.densities, self.diameters
        return float(np.pi / 4 * (n * s**2).sum()), float(np.pi / 6 * (n * s**3).sum())


def mixture(densities: ArrayLike, diameters: ArrayLike, masses: ArrayLike = 1.0) -> Mixture:
    """A mixture of k species.

    densities: numbers per length^d, and diameters, length, (k,). masses: (k,) or one of all. ValueError unless
    densities and diameters have one shape (k,).
    """
    n, s = np.asarray(densities, dtype=np.float64), np.asarray(diameters, dtype=np.float64)
    if n.ndim != 1 or n.shape != s.shape:
        raise ValueError(f"one density and one diameter per species, got shapes {n.shape} and {s.shape}")
    return Mixture(n, s, np.broadcast_to(np.asarray(masses, dtype=np.float64), n.shape))


def mixture_contact_values(species: Mixture, dimension: int) -> Floats:
    """g_ij at contact, (k, k).

    Spheres: Boublik; Mansoori et al., 1/(1-x3) + 3 D x2/(1-x3)^2 + 2 D^2 x2^2/(1-x3)^3, D = s_i s_j/(s_i + s_j), x_k =
    (pi/6) sum n s^k. Disks: Jenkins and Mancini, 1/(1-eta) + (9/16) eta/(1-eta)^2 (<s>/<s^2>) s_i s_j/s_ij; close to
    simulation (S. Luding and A. Santos, J. Chem. Phys. 121, 8458 (2004)). Both exact for a point among the others; take
    1 % of doubt at moderate density.

    species: the mixture. dimension: 2 or 3, else ValueError.
    """
    demand_dimension(dimension)
    n, s = species.densities, species.diameters
    product, total = np.outer(s, s), s[:, None] + s[None, :]
    if dimension == 2:
        eta = species.packing_fraction[0]
        width = 2 * product / total * (n * s).sum() / (n * s**2).sum()
        return np.asarray(1 / (1 - eta) + 9 / 16 * eta / (1 - eta) ** 2 * width)
    x2, x3 = (np.pi / 6 * (n * s**k).sum() for k in (2, 3))
    width = product / total
    return np.asarray(1 / (1 - x3) + 3 * width * x2 / (1 - x3) ** 2 + 2 * (width * x2) ** 2 / (1 - x3) ** 3)


def bmcsl(species: Mixture) -> float:
    """Z of a mixture of spheres: x0 Z = x0/(1-x3) + 3 x1 x2/(1-x3)^2 + x2^3 (3 - x3)/(1-x3)^3, x_k = (pi/6) sum n s^k.

    Boublik; Mansoori, Carnahan, Starling and Leland. One species: Carnahan-Starling.

    species: the mixture.
    """
    x0, x1, x2, x3 = (np.pi / 6 * (species.densities * species.diameters**k).sum() for k in range(4))
    return float(1 / (1 - x3) + (3 * x1 * x2 / (1 - x3) ** 2 + x2**3 * (3 - x3) / (1 - x3) ** 3) / x0)


def mixture_compressibility(species: Mixture, dimension: int) -> Estimate:
    """Z of a mixture of hard disks or spheres.

    Disks: Santos, Yuste and Lopez de Haro, Z = (1 - x)/(1 - eta) + x Z_1(eta), x = <s>^2/<s^2>, with Z_1 of one
    species; with Henderson's Z_1 it is the Z of Jenkins and Mancini's contact values. Spheres: `bmcsl` plus what the
    best Z of one species at that eta has over Carnahan-Starling. Doubt: that of Z_1 and 1 % of the departure from
    one species, for diameters within a factor of 3.

    species: the mixture. dimension: 2 or 3, else ValueError.
    """
    demand_dimension(dimension)
    n, s = species.densities, species.diameters
    if dimension == 2:
        eta = species.packing_fraction[0]
        pure = disk_compressibility(eta)
        x = float((n * s).sum() ** 2 / (n.sum() * (n * s**2).sum()))
        value = (1 - x) / (1 - eta) + x * pure.value
    else:
        eta = species.packing_fraction[1]
        pure = sphere_compressibility(eta)
        value = bmcsl(species) + pure.value - carnahan_starling(eta)
    return Estimate(value, doubt=pure.doubt + 0.01 * abs(value - pure.value))


def species_collision_rates(species: Mixture, dimension: int, temperature: float = 1.0) -> Floats:
    """Rate at which one particle of species i collides with those of species j, (k, k).

    n_j s_ij g_ij sqrt(2 pi T/mu_ij) of disks, 2 n_j s_ij^2 g_ij sqrt(2 pi T/mu_ij) of spheres, mu_ij the reduced mass.

    species: the mixture. dimension: 2 or 3. temperature: T, energy. Gives 1/time, as uncertain as g_ij.
    """
    g, n, m = mixture_contact_values(species, dimension), species.densities, species.masses
    distance = 0.5 * (species.diameters[:, None] + species.diameters[None, :])
    speed = (2 * np.pi * temperature * (1 / m[:, None] + 1 / m[None, :])) ** 0.5
    return np.asarray((dimension - 1) * n[None, :] * distance ** (dimension - 1) * g * speed)
