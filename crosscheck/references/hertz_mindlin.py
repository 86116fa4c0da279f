"""Contact of two spheres of given elastic moduli: Hertz's normal force, and Mindlin's tangential stiffness.

Bodies of Young's modulus E and Poisson's ratio nu, shear modulus G = E/(2 (1 + nu)), of radii R_i, 1/R = 1/R_1 + 1/R_2
(a wall: 1/R_2 = 0), pressed together by delta, touch on a circle of radius a = sqrt(R delta):

    F_n = (4/3) E_eff a delta,          1/E_eff = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2,
    dF_n/d delta = 2 E_eff a,           dF_t/d xi = 8 G_eff a,     1/G_eff = (2 - nu_1)/G_1 + (2 - nu_2)/G_2,

the last for a small tangential displacement xi at which nothing slips. For one material their ratio is
2 (1 - nu)/(2 - nu), from 1 at nu = 0 to 2/3 at nu = 1/2.

Literature: H. Hertz, J. reine angew. Math. 92, 156 (1881); R. D. Mindlin, J. Appl. Mech. 16, 259 (1949); K. L. Johnson,
Contact Mechanics, sections 4.2 and 7.2 (Cambridge, 1985).
"""

from __future__ import annotations

import math
from typing import NamedTuple


class Material(NamedTuple):
    """An isotropic elastic material. young: E, force/area. poisson: nu, above -1 and at most 1/2."""

    young: float
    poisson: float

    @property
    def shear(self) -> float:
        """G = E/(2 (1 + nu)), force/area."""
        return self.young / (2 * (1 + self.poisson))


def normal_modulus(one: Material, other: Material) -> float:
    """E_eff, force/area. one, other: what the two bodies are made of."""
    return 1 / ((1 - one.poisson**2) / one.young + (1 - other.poisson**2) / other.young)


def tangential_modulus(one: Material, other: Material) -> float:
    """G_eff, force/area. one, other: what the two bodies are made of."""
    return 1 / ((2 - one.poisson) / one.shear + (2 - other.poisson) / other.shear)


class Pressed(NamedTuple):
    """Two bodies of one material, pressed together. material: theirs. radius: R, length. overlap: delta, length."""

    material: Material
    radius: float
    overlap: float

    @property
    def circle(self) -> float:
        """Radius a of the circle of contact, length."""
        return math.sqrt(self.radius * self.overlap)

    @property
    def force(self) -> float:
        """F_n = (4/3) E_eff a delta."""
        return 4 / 3 * normal_modulus(self.material, self.material) * self.circle * self.overlap

    @property
    def normal_stiffness(self) -> float:
        """dF_n/d delta = 2 E_eff a, force/length."""
        return 2 * normal_modulus(self.material, self.material) * self.circle

    @property
    def tangential_stiffness(self) -> float:
        """dF_t/d xi = 8 G_eff a, force/length, of a small displacement without slip."""
        return 8 * tangential_modulus(self.material, self.material) * self.circle


def overlap_under(force: float, material: Material, radius: float) -> float:
    """Overlap of two bodies of one material pressed by a force, length.

    force: F_n. material: theirs. radius: R, length.
    """
    return float((0.75 * force / (normal_modulus(material, material) * math.sqrt(radius))) ** (2 / 3))
