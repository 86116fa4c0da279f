"""Laws of what walls draw at random, as distribution functions: each draw of a right code is a uniform number in them.

A thermal wall of temperature T gives a particle of mass m velocities from the flux of a gas at rest beyond the wall. Of
the Maxwell distribution exp(-m v^2/2T), as many pass a plane in a time as v_n > 0 says: the normal component has the
density proportional to v_n exp(-m v_n^2/2T), and the components along the wall are those of the gas, Gaussian of
variance T/m. Nothing depends on the velocity before.

A wall that vibrates at random has the velocity V = V0 cos(phi) into the box, phi uniform, where a particle of the
normal velocity v < 0 meets it; it meets only walls with V > v. "uniform": nothing else. "flux": in a time, as many meet
as V - v says, which is then a factor of the density. With the antiderivatives arcsin(V/V0) and -sqrt(V0^2 - V^2) of
1/sqrt(V0^2 - V^2) and of V times it,

    F(V | v) = (G(V) - G(V1))/(G(V0) - G(V1)),    V1 = max(v, -V0),
    G = arcsin(V/V0) ("uniform"),                 G = -sqrt(V0^2 - V^2) - v arcsin(V/V0) ("flux").

Of independent numbers that are uniform in (0, 1): Kolmogorov-Smirnov for one of them, chi^2 of a table of quarters for
what they may depend on. Probabilities are those of a deviation at least as large, if the code is right.

Literature: R. Tehver et al., Phys. Rev. E 57, R17 (1998) (thermal walls); S. McNamara and J.-L. Barrat, Phys. Rev. E
55, 7767 (1997), R. Soto, Phys. Rev. E 69, 061305 (2004) (walls of random phase); M. Rosenblatt, Ann. Math. Stat. 23,
470 (1952) (draws made uniform by their distribution function).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Parts of each axis of a table, in the test of independence.
_PARTS = 4


def flux_of_maxwell(normal: ArrayLike, temperature: ArrayLike, mass: ArrayLike) -> Floats:
    """Distribution function of the normal velocity, > 0, that a thermal wall gives: 1 - exp(-m v^2/2T).

    normal: velocity into the box. temperature: of the wall, energy. mass: of the particle.
    """
    return np.asarray(-np.expm1(-np.asarray(mass) * np.asarray(normal) ** 2 / (2 * np.asarray(temperature))))


def maxwell_component(velocity: ArrayLike, temperature: ArrayLike, mass: ArrayLike) -> Floats:
    """Distribution function of one component of Maxwell's velocities, Gaussian of variance T/m.

    velocity: the component. temperature: energy. mass: of the particle.
    """
    from scipy.special import ndtr

    return np.asarray(ndtr(np.asarray(velocity) * np.sqrt(np.asarray(mass) / np.asarray(temperature))))


def random_direction_component(component: ArrayLike, dimension: int) -> Floats:
    """Distribution function of a component of a random unit vector: (1 + x)/2 in space, 1 - arccos(x)/pi in the plane.

    component: x, rounded to within -1 and 1. dimension: 2 or 3.
    """
    x = np.clip(np.asarray(component, dtype=float), -1.0, 1.0)
    return np.asarray((1 + x) / 2 if dimension == 3 else 1 - np.arccos(x) / np.pi)


def random_phase(wall: ArrayLike, incoming: ArrayLike, largest: ArrayLike, law: Literal["uniform", "flux"]) -> Floats:
    """Distribution function F(V | v) of the velocity of a wall of random phase that a particle meets.

    wall: V, velocity into the box. incoming: v < 0, of the particle along the same normal. largest: V0. law: of the
    phase.
    """
    v, top = np.asarray(incoming, dtype=float), np.asarray(largest, dtype=float)

    def primitive(speed: Floats) -> Floats:
        share = np.clip(speed / top, -1.0, 1.0)
        phase = np.arcsin(share)
        return np.asarray(phase if law == "uniform" else -top * np.sqrt(1 - share**2) - v * phase)

    least, most = primitive(np.maximum(v, -top)), primitive(top * np.ones_like(v))
    return np.asarray((primitive(np.asarray(wall, dtype=float)) - least) / (most - least))


def uniform(draws: ArrayLike) -> float:
    """Probability, by Kolmogorov and Smirnov, that uniform numbers are as uneven as these; NaN and others: 0.

    draws: any shape.
    """
    from scipy.stats import kstest

    flat = np.ravel(draws)
    if not flat.size or not ((flat >= 0) & (flat <= 1)).all():
        return 0.0
    return float(kstest(flat, "uniform").pvalue)


def uniform_in_groups(draws: Floats, groups: ArrayLike) -> float:
    """Probability that the means of uniform numbers differ from 1/2 as much in any groups: chi^2 of the means.

    draws, groups: (n,); groups: a number for each draw. A mean of n draws has the variance 1/(12 n).
    """
    from scipy.stats import chi2

    names = np.unique(groups)
    parts = [draws[np.asarray(groups) == name] for name in names]
    square = sum(12 * part.size * (float(part.mean()) - 0.5) ** 2 for part in parts)
    return float(chi2.sf(square, len(parts)))


def independent(draws: Floats, other: Floats) -> float:
    """Probability that uniform numbers depend as much on something else: chi^2 of a table of quarters of both.

    draws: (n,), uniform. other: (n,), of any distribution, without many equal values; its quarters are by rank. In each
    quarter the draws are expected to fill theirs alike, as their distribution is known.
    """
    from scipy.stats import chi2

    order = np.empty(other.size, dtype=int)
    order[np.argsort(other, kind="stable")] = np.arange(other.size)
    rows, columns = order * _PARTS // other.size, np.clip((draws * _PARTS).astype(int), 0, _PARTS - 1)
    table = np.zeros((_PARTS, _PARTS))
    np.add.at(table, (rows, columns), 1.0)
    expected = table.sum(axis=1, keepdims=True) / _PARTS
    return float(chi2.sf(((table - expected) ** 2 / expected).sum(), _PARTS * (_PARTS - 1)))


def repeats(draws: ArrayLike) -> int:
    """How many draws are the same number as another one: of doubles, none of some thousand. draws: any shape."""
    flat = np.ravel(draws)
    return int(flat.size - np.unique(flat).size)
