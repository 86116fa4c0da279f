"""Isotropy of what the velocities of lattice gases are summed to: E^(n) = sum_i c_i c_i ... c_i, n factors.

The thesis is M. Pliego Diaz, Simulaciones hidrodinamicas bidimensionales usando modelos discretos, UNAM (1991). Where
its formulas are wrong the test says so; S. Wolfram, J. Stat. Phys. 45, 471 (1986) (polygons).
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from numpy.typing import ArrayLike

from crosscheck.references.lattice_models import MODELS, VELOCITIES

#: Thesis, table 1: corners for which E^(n) is isotropic, n = 2 ... 7. No error found in it.
THESIS_TABLE = {
    2: lambda m: m > 2,
    3: lambda m: m >= 2 and m != 3,
    4: lambda m: m > 2 and m != 4,
    5: lambda m: m >= 2 and m not in (3, 5),
    6: lambda m: m > 4 and m != 6,
    7: lambda m: m >= 2 and m not in (3, 5, 7),
}
#: Unit vectors of the plane, more than the order of any tensor here.
DIRECTIONS = np.column_stack([np.cos(np.arange(23.0)), np.sin(np.arange(23.0))])


def polygon(corners: int) -> np.ndarray:
    """Unit vectors at the angles 2 pi i/M, (M, 2)."""
    angles = 2 * math.pi * np.arange(corners) / corners
    return np.column_stack([np.cos(angles), np.sin(angles)])


def is_isotropic(vectors: ArrayLike, order: int, directions: np.ndarray = DIRECTIONS) -> bool:
    """Whether sum_i (c_i.e)^n is the same for all unit vectors e: that says all of a symmetric tensor."""
    sums = ((np.asarray(vectors) @ directions.T) ** order).sum(axis=0)
    return bool(np.ptp(sums) < 1e-12)


@pytest.mark.parametrize("corners", range(1, 16))
def test_isotropy_of_polygons(corners: int) -> None:
    """E^(n) is isotropic if and only if M divides none of n, n - 2, ... > 0.

    The text of the thesis has both of its sentences the wrong way round: "n, n - 2, ... do not divide M", which would
    forbid M = 6 for n = 2, and "isotropic whenever n > M", where M > n is right.
    """
    for n, condition in THESIS_TABLE.items():
        found = is_isotropic(polygon(corners), n)
        assert found == condition(corners)
        assert found == all(j % corners for j in range(n, 0, -2))
        assert found or corners <= n


def test_the_literal_rule_of_the_thesis_fails() -> None:
    def printed(corners: int, n: int) -> bool:
        return all(corners % j for j in range(n, 0, -2))

    pairs = product(range(3, 16), THESIS_TABLE)
    wrong = [(m, n) for m, n in pairs if printed(m, n) != THESIS_TABLE[n](m)]
    assert (6, 2) in wrong
    assert (8, 4) in wrong
    # n > M is not enough
    assert not is_isotropic(polygon(4), 6)


def test_isotropic_tensors_have_the_coefficient_of_the_appendix() -> None:
    """(A.4): M/(D (D + 2) ...) Delta^(2n); (A.8) in components: (2n - 1)!!/(D (D + 2) ...)."""
    v = np.array([0.3, -1.1])
    for n, expected in ((2, 1 / 2), (4, 3 / 8), (6, 15 / 48)):
        contracted = ((polygon(7) @ v) ** n).sum()
        assert contracted == pytest.approx(7 * expected * (v @ v) ** (n // 2), rel=1e-13)


def test_isotropy_of_the_velocities() -> None:
    """To fourth order but for HPP, as a viscosity and a factor of advection need it; to sixth of none."""
    for name in MODELS:
        c = VELOCITIES[name].cartesian
        assert [is_isotropic(c, n) for n in range(1, 7)] == [True, True, True, name != "hpp", True, False]
    # three dimensions: the twelve corners of an icosahedron, isotropic to fifth order
    golden = (1 + 5**0.5) / 2
    corners = [np.roll((0.0, s, t * golden), r) for s, t, r in product((1, -1), (1, -1), range(3))]
    directions = np.random.default_rng(1).normal(size=(40, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    found = [is_isotropic(np.array(corners) / golden, n, directions) for n in range(1, 7)]
    assert found == [True] * 5 + [False]
