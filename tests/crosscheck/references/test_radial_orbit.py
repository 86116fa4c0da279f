"""The fall of two bodies into each other, against the limit of ellipses and against a quadrature."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from crosscheck.references.kepler import relative_orbit
from crosscheck.references.radial_orbit import collision_time, separation


@given(share=st.floats(0.0, 1.0), start=st.floats(0.1, 10.0), mu=st.floats(0.1, 10.0))
def test_the_time_of_a_distance_by_quadrature(share: float, start: float, mu: float) -> None:
    """dt = dr/(2 mu (1/r - 1/r_0))^(1/2), with r = r_0 cos^2 x to take the singularity out."""
    time = share * collision_time(start, mu)
    r = separation(time, start, mu)
    x = math.acos(math.sqrt(min(1.0, r / start)))
    found, _ = quad(lambda y: 2 * math.cos(y) ** 2, 0.0, x)
    assert found * (start**3 / (2 * mu)) ** 0.5 == pytest.approx(time, abs=1e-7 * collision_time(start, mu))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_it_is_the_limit_of_thin_ellipses(share: float) -> None:
    time = share * collision_time(2.0, 3.0)
    r, _ = relative_orbit(time, 1 - 1e-9, 1.0, 3.0)
    assert math.hypot(*r) == pytest.approx(separation(time, 2.0, 3.0), rel=1e-6)


def test_ends() -> None:
    assert separation(0.0, 2.0, 1.0) == 2.0
    assert separation(collision_time(2.0, 1.0), 2.0, 1.0) == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(ValueError, match="not within the fall"):
        separation(1.01 * collision_time(2.0, 1.0), 2.0, 1.0)
