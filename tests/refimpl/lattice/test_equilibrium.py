"""Equilibria of Fermi and Dirac: their sums and their form, up to the edge of what there is."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from lattice_gases import every_set, mass_and_momentum, mean_state
from scipy.special import xlogy

from refimpl.lattice.equilibrium import fermi_dirac
from refimpl.lattice.velocities import TRIANGULAR, VelocitySet

occupation = st.floats(0.001, 0.999)


@every_set
@given(data=st.data())
def test_fermi_dirac_has_the_sums_asked_for_and_the_right_form(velocities: VelocitySet, data: st.DataObject) -> None:
    given_f = data.draw(arrays(np.float64, (3, velocities.channels), elements=occupation))
    d, u = mean_state(velocities, given_f)
    f = fermi_dirac(velocities, d, u)
    np.testing.assert_allclose(
        mass_and_momentum(velocities, f), mass_and_momentum(velocities, given_f), rtol=0, atol=1e-14
    )
    invariants = np.column_stack([np.ones(velocities.channels), velocities.cartesian])
    exponents = np.log(f / (1 - f))
    outside = exponents.T - invariants @ np.linalg.lstsq(invariants, exponents.T)[0]
    # a rounding of f moves its logarithm by 1/(f (1 - f)) as much; the sums above are met to 1e-14
    assert np.abs(outside).max() <= max(1e-8, 1e-13 / float((f * (1 - f)).min()))


@every_set
@given(h=st.floats(-12, 12), q=st.tuples(st.floats(-12, 12), st.floats(-12, 12)))
def test_fermi_dirac_finds_the_occupations_of_any_h_and_q(
    velocities: VelocitySet, h: float, q: tuple[float, float]
) -> None:
    f = 1 / (1 + np.exp(h + velocities.cartesian @ q))
    d, u = mean_state(velocities, f)
    if 0 < d < 1:
        np.testing.assert_allclose(fermi_dirac(velocities, d, u), f, rtol=0, atol=3e-15)


@every_set
def test_fermi_dirac_at_the_edge_of_what_is_feasible(velocities: VelocitySet) -> None:
    """Bisection to the largest speed in a direction; there the sums must still be met, relative to the mass."""
    for d, angle in product((1e-300, 0.2, 1 - 1e-9), (0.0, 1.1)):
        direction = np.array([math.cos(angle), math.sin(angle)])
        low, high = 0.0, 2.0
        for _ in range(60):
            speed = (low + high) / 2
            try:
                fermi_dirac(velocities, d, speed * direction)
                low = speed
            except ValueError:
                high = speed
        assert low > 0.4 * min(1, 1 / d - 1)
        for speed in (low, low * (1 - 1e-12), low * (1 - 1e-4), 1e-12 * low):
            u = speed * direction
            f = fermi_dirac(velocities, d, u)
            expected = velocities.channels * d * np.array([1, *u])
            np.testing.assert_allclose(mass_and_momentum(velocities, f), expected, rtol=0, atol=3e-15 * expected[0])


@every_set
def test_fermi_dirac_at_rest_and_broadcast(velocities: VelocitySet) -> None:
    b = velocities.channels
    np.testing.assert_array_equal(fermi_dirac(velocities, 0.3, (0, 0)), np.full(b, 0.3))
    d, u = np.array([[0.2], [0.5]]), np.array([[0.0, 0.0], [0.1, -0.2], [0.3, 0.0]])
    f = fermi_dirac(velocities, d, u)
    assert f.shape == (2, 3, b)
    for i, j in np.ndindex(2, 3):
        np.testing.assert_allclose(f[i, j], fermi_dirac(velocities, d[i, 0], u[j]), rtol=1e-14)
    many = np.linspace(0.2, 0.7, 10_000)
    np.testing.assert_allclose(fermi_dirac(velocities, many, (0.2, 0.1))[-1], fermi_dirac(velocities, 0.7, (0.2, 0.1)))


def test_fermi_dirac_at_half_filling_by_hand() -> None:
    """f_i + f_-i = 1 and f_i - f_-i = tanh(q.c_i/2): the momentum is a sum of three terms."""
    q = 0.8
    u = (2 * math.tanh(q / 2) + 2 * math.tanh(q / 4)) / 6
    expected = 1 / (1 + np.exp(-q * TRIANGULAR.cartesian[:, 0]))
    np.testing.assert_allclose(fermi_dirac(TRIANGULAR, 0.5, (u, 0)), expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("density", "velocity", "message"),
    [
        (-0.1, (0, 0), "between 0 and 1, got -0.1"),
        ([0.3, 1.1], (0, 0), "between 0 and 1, got 1.1"),
        (0.0, (0.1, 0), r"mean 0.0 and velocity \(0.1, 0.0\)"),
        ([0.3, 1.0], (0, 0.1), r"mean 1.0 and velocity \(0.0, 0.1\)"),
        (math.nan, (0, 0), "between 0 and 1, got nan"),
        (0.5, (0.67, 0), r"mean 0.5 and velocity \(0.67, 0.0\)"),
        ([0.5, 0.1], [(0.1, 0.1), (0.0, -0.87)], r"mean 0.1 and velocity \(0.0, -0.87\)"),
        (0.125, (1, 0), r"mean 0.125 and velocity \(1.0, 0.0\)"),
        (0.125, (0.75, -(3**0.5) / 4), r"mean 0.125 and velocity \(0.75, -0.43"),
        (0.5, (math.nan, 0), r"velocity \(nan, 0.0\)"),
        (0.5, 0.1, "two components"),
        (0.5, (0.1, 0.1, 0.1), "two components"),
    ],
)
def test_states_that_there_are_not(density: float, velocity: tuple[float, ...], message: str) -> None:
    """Half filling has at most three of six channels full, along one another: u < 2/3 along an axis."""
    with pytest.raises(ValueError, match=message):
        fermi_dirac(TRIANGULAR, density, velocity)
    fermi_dirac(TRIANGULAR, 0.5, (0.66, 0))


@every_set
def test_empty_and_full_lattices_are_at_rest(velocities: VelocitySet) -> None:
    found = fermi_dirac(velocities, [0.0, 0.5, 1.0], [0.0, 0.0])
    np.testing.assert_array_equal(found, np.repeat([[0.0], [0.5], [1.0]], velocities.channels, axis=1))


@every_set
@given(data=st.data())
def test_equilibrium_has_the_least_h(velocities: VelocitySet, data: st.DataObject) -> None:
    f = data.draw(arrays(np.float64, (velocities.channels,), elements=occupation))

    def h(occupations: np.ndarray) -> float:
        return float((xlogy(occupations, occupations) + xlogy(1 - occupations, 1 - occupations)).sum())

    assert h(fermi_dirac(velocities, *mean_state(velocities, f))) <= h(f) + 1e-13
