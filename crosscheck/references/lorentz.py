"""The Lorentz gas: a point that flies among fixed disks or spheres; free path and diffusion.

dimension, d, is 2 or 3; density, n, scatterers per length^d; radius, R, of a scatterer for the point; speed, v.

Literature: C. Bruin, Phys. Rev. Lett. 29, 1670 (1972); J. M. J. van Leeuwen and A. Weijland, Physica 36, 457 (1967) and
38, 35 (1968).
"""

from __future__ import annotations

import numpy as np

from crosscheck.references.hard_spheres import Estimate, demand_dimension


def free_path(density: float, radius: float, dimension: int, overlapping: bool = False) -> float:
    """Mean free path of a point among fixed disks or spheres of that radius; exact for any arrangement.

    By the invariant measure it is pi A/l of the free area and its perimeter in two dimensions, 4 V/S in three: (1 - pi
    n R^2)/(2 n R), (1 - 4 pi n R^3/3)/(pi n R^2) without overlaps, on a lattice or at random; 1/(2 n R), 1/(pi n R^2)
    for centres placed at random with overlaps, where free volume and surface shrink alike. Time average over
    collisions; on a lattice with open corridors the mean exists, too. ValueError if the scatterers fill all.

    density: n, 1/length^d. radius: R, length. dimension: d, 2 or 3, else ValueError. overlapping: whether scatterers
    may overlap. Any consistent units; gives a length.
    """
    demand_dimension(dimension)
    cross_section = 2 * radius if dimension == 2 else np.pi * radius**2
    filled = density * (np.pi * radius**2 if dimension == 2 else 4 / 3 * np.pi * radius**3)
    if overlapping:
        return float(1 / (density * cross_section))
    if filled >= 1:
        raise ValueError(f"scatterers of volume fraction {filled} leave no room")
    return float((1 - filled) / (density * cross_section))


def boltzmann_diffusion(density: float, radius: float, dimension: int, speed: float = 1.0) -> float:
    """D in the dilute limit, v/(d n sigma_tr): 3 v/(16 n R) of disks (sigma_tr = 8R/3), v/(3 pi n R^2) of spheres.

    The transport cross-section is the integral of (1 - cos of the angle of deflection) over the impact parameter;
    spheres scatter isotropically.

    density: n, 1/length^d. radius: R, length. dimension: d, 2 or 3, else ValueError. speed: v, length/time. Any
    consistent units; gives length^2/time. To first order in the density.
    """
    demand_dimension(dimension)
    transport = 8 * radius / 3 if dimension == 2 else np.pi * radius**2
    return float(speed / (dimension * density * transport))


#: D/D_Boltzmann of a point among overlapping scatterers placed at random, by dimension and n R^d: own runs, slope of
#: the mean-square displacement from 20 to 40 mean free paths, 10^4 points in each of 96 (disks) or 16 (spheres) boxes
#: of side 60 R or more. Standard errors over the boxes; from 10 to 30 paths the slopes are the same within them.
DIFFUSION = {
    2: {0.02: Estimate(0.9103, 0.0029), 0.05: Estimate(0.8094, 0.0027), 0.1: Estimate(0.6660, 0.0024)},
    3: {0.02: Estimate(0.9722, 0.0021), 0.05: Estimate(0.9357, 0.0034), 0.1: Estimate(0.8703, 0.0033)},
}


def diffusion_series(density: float, radius: float = 1.0) -> float:
    """D/D_Boltzmann of a point among overlapping disks at random, 1/(1 - (4/3) x ln x - 0.8775 x + 4.519 (x ln x)^2).

    x = n R^2 <= 0.05. Van Leeuwen and Weijland (1967, 1968), Bruin (1972): from memory of the literature, checked
    against `DIFFUSION` only: 1.5 and 2 % low at x = 0.02 and 0.05, 3 % high at 0.1.

    density: n, 1/length^2. radius: R, length.
    """
    x = density * radius**2
    y = x * np.log(x)
    return float(1 / (1 - 4 / 3 * y - 0.8775 * x + 4.519 * y * y))
