"""Lattice gases: closed forms of the sound speed, of the Boltzmann viscosities and of the advection factor.

Units: links and steps. b channels, d = rho/b the mean occupation of one, 0 < d < 1. model: a name of
`references.lattice_models.MODELS`. The viscosities take particles that meet for independent (Boltzmann); in two
dimensions they are not, and the gas has larger ones (L. P. Kadanoff, G. R. McNamara and G. Zanetti, Phys. Rev. A 40,
4527 (1989)).

Literature: U. Frisch et al., Complex Systems 1, 649 (1987) (FHP-I and II, general theory); D. d'Humieres and P.
Lallemand, Complex Systems 1, 599 (1987) (FHP-III); M. Henon, Complex Systems 1, 762 (1987) (viscosity of any table).
"""

from __future__ import annotations

import math

#: By model, links per step: c_s = c/2^(1/2) without a rest particle, (3/7)^(1/2) with one.
SOUND_SPEED = {
    "hpp": math.sqrt(1 / 2),
    "fhp1": math.sqrt(1 / 2),
    "fhp2": math.sqrt(3 / 7),
    "fhp3": math.sqrt(3 / 7),
    "fhp_saturated": math.sqrt(1 / 2),
    "fhp_saturated_identity": math.sqrt(1 / 2),
}


def relaxation_rate(model: str, density: float) -> float:
    """lambda, per step, of the moment c_x c_y (of HPP: c_x^2 - c_y^2) in the linearised collisions at rest.

    model: KeyError if it is not known. density: d, 0 < d < 1. M. Henon (1987); FHP-I, II, III also in the papers named
    above.
    """
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
    """nu = (1/lambda - 1/2)/4 of the FHP models, links^2 per step. ValueError for HPP, which has none.

    model: a name of `lattice_models.MODELS`, else KeyError. density: d, 0 < d < 1.
    """
    if model == "hpp":
        raise ValueError("HPP is not isotropic and has no shear viscosity")
    return (1 / relaxation_rate(model, density) - 0.5) / 4


def bulk_viscosity(model: str, density: float) -> float:
    """zeta/rho, links^2 per step: 0 without a rest particle. D. d'Humieres and P. Lallemand (1987).

    model: a name of `lattice_models.MODELS`. density: d, 0 < d < 1.
    """
    d, hole = density, 1 - density
    if model == "fhp2":
        return 1 / (98 * d * hole**4) - 1 / 28
    if model == "fhp3":
        return 1 / (98 * d * hole * (1 - 2 * d * hole)) - 1 / 28
    return 0.0


def longitudinal_viscosity(model: str, density: float) -> float:
    """nu + zeta/rho, links^2 per step: sound of wave number k is damped by k^2/2 times as much.

    Of HPP along an axis, (1/lambda - 1/2)/2.

    model: a name of `lattice_models.MODELS`, else KeyError. density: d, 0 < d < 1.
    """
    if model == "hpp":
        return (1 / relaxation_rate(model, density) - 0.5) / 2
    return shear_viscosity(model, density) + bulk_viscosity(model, density)


def galilean_factor(model: str, density: float) -> float:
    """g of the term g u.grad u: (1 - 2d)/(2(1 - d)), and 7/6 of it with a rest particle. U. Frisch et al. (1987).

    model: a name of `lattice_models.MODELS`. density: d, 0 < d < 1. ValueError for HPP, whose momentum flux is no
    multiple of u_a u_b.
    """
    if model == "hpp":
        raise ValueError("HPP is not isotropic and has no one factor of advection")
    plain = (1 - 2 * density) / (2 * (1 - density))
    return plain * (7 / 6 if model in ("fhp2", "fhp3") else 1.0)
