"""The numbers of the thesis against one another, and the modes of its starting state against their sum."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.references import lattice_thesis as known


def test_modes_of_half_a_sine_sum_to_it() -> None:
    number = 2000
    x = np.linspace(0, 1, 201)
    b = known.half_sine_modes(number)
    cosines = np.cos(np.pi * np.arange(1, number + 1) * x[:, None])
    # what is left out is less than the sum of 8/(pi n^2) over odd n
    np.testing.assert_allclose(cosines @ b, np.sin(2 * np.pi * x), rtol=0, atol=4 / (math.pi * (number - 2)))


def test_modes_of_half_a_sine_are_its_projections() -> None:
    from scipy.integrate import quad

    for n, b in enumerate(known.half_sine_modes(7), start=1):
        projection = 2 * quad(lambda x, n=n: math.sin(2 * math.pi * x) * math.cos(n * math.pi * x), 0, 1)[0]
        assert b == pytest.approx(projection, abs=1e-12)
    np.testing.assert_allclose(known.half_sine_modes(3), [0.849, 0, -0.509], atol=5e-4)


def test_viscosities_of_the_thesis_are_whole_slopes() -> None:
    """nu = 2 L^2/pi^2 alpha with slopes in whole 1e-4: multiples of 1.7405, to the last digits of both."""
    slopes = {d: [round(nu / 1.7405) for nu in pair] for d, pair in known.VISCOSITY.items()}
    assert slopes == {0.1: [81, 81], 0.2: [50, 51], 0.3: [36, 33], 0.4: [28, 28], 0.5: [22, 21], 0.6: [26, 25]}
    for d, pair in known.VISCOSITY.items():
        for nu, slope in zip(pair, slopes[d], strict=True):
            assert abs(nu - 1.7405 * slope) <= 0.005 + 5e-5 * slope + 1e-9
    assert math.sqrt(1.7405e4 * math.pi**2 / 2) == pytest.approx(293, abs=0.5)


def test_periods_and_speeds_of_the_thesis_are_consistent() -> None:
    period, speed = known.FHP
    assert 2 * 295 / period == pytest.approx(speed, abs=1e-4)
    assert period == pytest.approx(10240 / 13, rel=1e-3)
    period, speed = known.HPP
    assert 305 / period == pytest.approx(speed, abs=1e-4)
