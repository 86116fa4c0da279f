"""Velocity tensors: isotropy by the rule of polygons, and the coefficients of isotropic ones.

The thesis is M. Pliego Diaz, Simulaciones hidrodinamicas bidimensionales usando modelos discretos, UNAM (1991). Where
its formulas are wrong the test says so.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from lattice_gases import SETS

from refimpl.lattice import theory
from refimpl.lattice.velocities import SQUARE

#: Thesis, table 1: corners for which E^(n) is isotropic, n = 2 ... 7. No error found in it.
THESIS_TABLE = {
    2: lambda m: m > 2,
    3: lambda m: m >= 2 and m != 3,
    4: lambda m: m > 2 and m != 4,
    5: lambda m: m >= 2 and m not in (3, 5),
    6: lambda m: m > 4 and m != 6,
    7: lambda m: m >= 2 and m not in (3, 5, 7),
}


@pytest.mark.parametrize("corners", range(1, 16))
def test_isotropy_of_polygons(corners: int) -> None:
    """E^(n) is isotropic if and only if M divides none of n, n - 2, ... > 0.

    The text of the thesis has both of its sentences the wrong way round: "n, n - 2, ... do not divide M", which would
    forbid M = 6 for n = 2, and "isotropic whenever n > M", where M > n is right.
    """
    vectors = theory.polygon(corners)
    for n, condition in THESIS_TABLE.items():
        found = theory.is_isotropic(theory.velocity_tensor(vectors, n))
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
    assert not theory.is_isotropic(theory.velocity_tensor(theory.polygon(4), 6))


def test_isotropic_tensors_have_the_coefficient_of_the_appendix() -> None:
    """(A.4): M/(D (D + 2) ...) Delta^(2n); (A.8) in components: (2n - 1)!!/(D (D + 2) ...)."""
    v = np.array([0.3, -1.1])
    for n, expected in ((2, 1 / 2), (4, 3 / 8), (6, 15 / 48)):
        tensor = theory.velocity_tensor(theory.polygon(7), n)
        assert tensor.shape == (2,) * n
        assert tensor[(0,) * n] == pytest.approx(7 * expected, rel=1e-13)
        for _ in range(n):
            tensor = tensor @ v
        assert tensor == pytest.approx(7 * expected * (v @ v) ** (n // 2), rel=1e-13)
        np.testing.assert_array_equal(theory.velocity_tensor([[2.0, 0.5]], 1), [2.0, 0.5])


def test_isotropy_of_the_velocity_sets() -> None:
    for velocities in SETS.values():
        tensors = [theory.velocity_tensor(velocities.cartesian, n) for n in range(1, 7)]
        up_to_four = [True, True, True, velocities is not SQUARE, True, False]
        assert [theory.is_isotropic(tensor) for tensor in tensors] == up_to_four
    # three dimensions: the twelve corners of an icosahedron, isotropic to fifth order
    golden = (1 + 5**0.5) / 2
    corners = [np.roll((0.0, s, t * golden), r) for s, t, r in product((1, -1), (1, -1), range(3))]
    assert [theory.is_isotropic(theory.velocity_tensor(corners, n)) for n in range(1, 7)] == [True] * 5 + [False]


def test_tensors_that_there_are_not() -> None:
    with pytest.raises(ValueError, match="order 1 or more"):
        theory.velocity_tensor(theory.polygon(6), 0)
    with pytest.raises(ValueError, match="at least one corner"):
        theory.polygon(0)
