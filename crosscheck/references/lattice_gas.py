"""Lattice gases: closed forms, and what a thesis of 1991 reports. Units: links and steps.

b channels, d = rho/b the mean occupation of one.

Literature: U. Frisch et al., Complex Systems 1, 649 (1987) (FHP-I and II, general theory); D. d'Humieres and P.
Lallemand, Complex Systems 1, 599 (1987) (FHP-III); M. Henon, Complex Systems 1, 762 (1987) (viscosity of any table); M.
Pliego Diaz, Simulaciones hidrodinamicas bidimensionales usando modelos discretos, thesis, UNAM (1991) (experiments).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

#: c_s = c/2^(1/2) without a rest particle, (3/7)^(1/2) with one.
SOUND_SPEED = {
    "hpp": math.sqrt(1 / 2),
    "fhp1": math.sqrt(1 / 2),
    "fhp2": math.sqrt(3 / 7),
    "fhp3": math.sqrt(3 / 7),
    "fhp_saturated": math.sqrt(1 / 2),
    "fhp_saturated_identity": math.sqrt(1 / 2),
}


def relaxation_rate(model: str, density: float) -> float:
    """lambda of the moment c_x c_y (of HPP: c_x^2 - c_y^2) in the linearised collision matrix. KeyError for others."""
    d, hole = density, 1 - density
    return {
        "hpp": 4 * d * hole,
        "fhp1": 3 * d * hole**3,
        "fhp2": 7 * d * hole**3 * (1 - 4 * d / 7),
        "fhp3": 7 * d * hole * (1 - 8 * d * hole / 7),
        "fhp_saturated": 3 * d * hole * (1 + 2 * d * hole),
        "fhp_saturated_identity": 2 * d * hole * (1 + d * hole),
    }[model]


def shear_viscosity(model: str, density: float) -> float:
    """nu = (1/lambda - 1/2)/4, Boltzmann's, of the FHP models. ValueError for HPP, which has none."""
    if model == "hpp":
        raise ValueError("HPP is not isotropic and has no shear viscosity")
    return (1 / relaxation_rate(model, density) - 0.5) / 4


def bulk_viscosity(model: str, density: float) -> float:
    """zeta/rho, Boltzmann's: 0 without a rest particle."""
    d, hole = density, 1 - density
    if model == "fhp2":
        return 1 / (98 * d * hole**4) - 1 / 28
    if model == "fhp3":
        return 1 / (98 * d * hole * (1 - 2 * d * hole)) - 1 / 28
    return 0.0


def galilean_factor(model: str, density: float) -> float:
    """g of the term g u.grad u: (1 - 2d)/(2(1 - d)), and 7/6 of it with a rest particle."""
    plain = (1 - 2 * density) / (2 * (1 - density))
    return plain * (7 / 6 if model in ("fhp2", "fhp3") else 1.0)


# -- the thesis ------------------------------------------------------------------------------------------

#: Experiment 1 (HPP): period and sound speed. Experiment 2 (FHP with all collisions of 2, 3 and 4 particles): the same.
THESIS_HPP = (412.9, 0.7387)
THESIS_FHP = (787.4, 0.7493)
#: Table 4.1: nu at the crest and at the trough, by density.
THESIS_VISCOSITY = {
    0.1: (140.98, 140.98),
    0.2: (87.03, 88.77),
    0.3: (62.66, 57.44),
    0.4: (48.73, 48.73),
    0.5: (38.29, 36.55),
    0.6: (45.25, 43.51),
}


def channel_sound(speed: float, viscosity: float, wavenumber: float, height: float) -> complex:
    """Complex rate s of sound, exp(s t), along a channel of this height with no-slip walls.

    s^2/(1 - tanh(q)/q) + nu k^2 s + c^2 k^2 = 0, q = (H/2)(s/nu)^(1/2): the momentum along the channel averaged over
    its height, with the boundary layers of an incompressible flow on both walls (G. Kirchhoff, Ann. Phys. 210, 177
    (1868)). Im s is the frequency, -Re s the damping.
    """
    s = complex(0.0, speed * wavenumber)
    for _ in range(200):
        q = height / 2 * np.sqrt(s / viscosity)
        layers = 1 - np.tanh(q) / q
        new = complex(np.sqrt(-layers * (viscosity * wavenumber**2 * s + speed**2 * wavenumber**2)))
        new = new if new.imag > 0 else -new
        if abs(new - s) < 1e-15:
            break
        s = (new + s) / 2
    return s


def half_sine_modes(number: int) -> NDArray[np.float64]:
    """b_n of sin(2 pi x/L) = sum b_n cos(n pi x/L) on 0 ... L: 8/(pi (4 - n^2)) for odd n, 0 for even n."""
    n = np.arange(1, number + 1, dtype=np.float64)
    odd = n % 2 == 1
    return np.where(odd, 8 / (math.pi * np.where(odd, 4 - n**2, 1.0)), 0.0)
