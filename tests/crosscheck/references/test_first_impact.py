"""First impacts against a march along the path, published geometry, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references.first_impact import Impact, after_impact, first_impact


def marched(apart: np.ndarray, velocity: np.ndarray, sigma: float, period: float, until: float) -> float | None:
    """Sphere tracing: a step as long as the distance to the nearest image allows passes no contact."""
    speed, t = float(np.linalg.norm(velocity)), 0.0
    while t < until:
        r = apart + velocity * t
        gaps = r - period * np.round(r / period)
        # the nearest image is not always the first that is met, but none is met sooner than it could be
        gap = float(np.linalg.norm(gaps)) - sigma
        if gap < 1e-12 * period:
            return t
        t += gap / speed
    return None


@given(seed=st.integers(0, 2**32))
def test_a_march_meets_the_same_contact(seed: int) -> None:
    rng = np.random.default_rng(seed)
    period, sigma, until = 6.0, 1.0, 30.0
    apart = rng.uniform(1.1, 4.9, 2)
    velocity = rng.normal(size=2)
    impact = first_impact(apart.tolist(), velocity.tolist(), sigma, [period, period], until)
    expected = marched(apart, velocity, sigma, period, until)
    if impact is None or expected is None:
        # where one finds a graze and the other does not, the path passes within 1e-9 of it
        assert impact is None or abs(impact.normal @ velocity) < 1e-4
        assert expected is None or impact is None
        return
    assert impact.time == pytest.approx(expected, abs=1e-5)  # a march creeps into a graze
    at = apart + velocity * impact.time
    at -= period * np.round(at / period)
    assert np.linalg.norm(at) == pytest.approx(sigma, abs=1e-13)
    assert impact.normal == pytest.approx(at / sigma, abs=1e-13)


def test_the_second_image() -> None:
    """Flying left from (2, 3) round a box of side 10, past (5, 5) at a distance of 1.09 on its first round."""
    impact = first_impact([-3.0, -2.0], [-1.0, 0.13], 1.0, [10.0, 10.0], 60.0)
    assert impact is not None
    assert impact.time == pytest.approx(16.00324, abs=1e-5)
    assert first_impact([-3.0, -2.0], [-1.0, 0.13], 1.0, [10.0, 10.0], 16.0) is None
    assert first_impact([-3.0, -2.0], [-1.0, 0.13], 1.0, [0.0, 0.0], 60.0) is None


@pytest.mark.parametrize("depth", [1e-20, -1e-20])
def test_digits_beyond_double_precision(depth: float) -> None:
    """A graze by 1e-20 from 1e8: sigma is 1 and the second sphere is aimed at through a height of 3 2^-k exactly."""
    height = 2.0**-30
    # (1, height) flies along x; sigma = height (1 + depth) is not a double: scale the depth into the start instead
    impact = first_impact(
        [-1e8, height], [1.0, 0.0], height * (1 + (2.0**-52 if depth > 0 else -(2.0**-52))), [0, 0], 1e9
    )
    assert (impact is not None) == (depth > 0)
    if impact is not None:
        assert impact.time == pytest.approx(1e8, rel=1e-15)


def test_head_on() -> None:
    impact = first_impact([5.0, 0.0, 0.0], [-2.0, 0.0, 0.0], 1.0, [0.0] * 3, 10.0)
    assert impact is not None
    assert (impact.time, impact.normal.tolist()) == (2.0, [1.0, 0.0, 0.0])


def test_overlap_is_refused() -> None:
    with pytest.raises(ValueError, match="overlap at the start"):
        first_impact([9.5, 0.0], [1.0, 0.0], 1.0, [10.0, 10.0], 1.0)


@given(angle=st.floats(0, 6.3), u=st.tuples(st.floats(-3, 3), st.floats(-3, 3)))
def test_an_elastic_impact_keeps_momentum_and_energy(angle: float, u: tuple[float, float]) -> None:
    v = (0.3, -0.7)
    normal = np.array([np.cos(angle), np.sin(angle)])
    one, other = after_impact(Impact(0.0, normal), u, v)
    assert one + other == pytest.approx(np.add(u, v), abs=1e-14)
    assert one @ one + other @ other == pytest.approx(np.dot(u, u) + np.dot(v, v), abs=1e-13)
    assert (other - one) @ normal == pytest.approx(-np.subtract(v, u) @ normal, abs=1e-14)
