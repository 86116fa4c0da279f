"""Steps with impulses: closed forms, conservation, images, and spheres whose order would decide."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from crosscheck.references.collision_steps import Moved, Spheres, after_steps

_SIDE = 10.0


def head_on(alpha: float, masses: tuple[float, float], side: float = 0.0, shift: float = 0.0) -> Moved:
    """Two spheres of diameters 1 and 3, 5 apart along x, that meet after 4 of 6 steps of 0.25, at a speed of 3."""
    x = np.array([[shift, 0.0, 0.0], [shift + 5.0, 0.0, 0.0]])
    v = np.array([[2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    return after_steps(Spheres(masses, (1.0, 3.0), alpha, (side,) * 3), x, v, 0.25, 6)


@pytest.mark.parametrize("alpha", [0.1, 0.7, 1.0])
def test_head_on(alpha: float) -> None:
    moved = head_on(alpha, (1.0, 4.0))
    centre, relative = (2.0 - 4.0) / 5.0, 3.0
    first, second = centre - alpha * relative * 0.8, centre + alpha * relative * 0.2
    assert_allclose(moved.velocities[:, 0], [first, second], atol=1e-15)
    # at contact after 1, found after the step to 1.25, at a distance of 1.25
    assert_allclose(moved.positions[:, 0], [2.5 + 0.25 * first, 3.75 + 0.25 * second], atol=1e-15)
    assert (moved.impulses, moved.most, moved.closest, moved.crowded) == (1, 1, 1.25, False)


@given(shift=st.integers(-40, 40).map(float), images=st.integers(-3, 3))
def test_images(shift: float, images: int) -> None:
    """The same in a box, wherever it begins, and with another image of the second sphere."""
    plain, boxed = head_on(0.7, (1.0, 4.0)), head_on(0.7, (1.0, 4.0), _SIDE, shift)
    assert_allclose(boxed.positions[:, 0] - shift, plain.positions[:, 0], atol=1e-13)
    assert_allclose(boxed.velocities, plain.velocities, atol=1e-13)
    x = np.array([[0.0, 0.0], [5.0 + images * _SIDE, 0.0]])
    v = np.array([[2.0, 0.0], [-1.0, 0.0]])
    moved = after_steps(Spheres((1.0, 4.0), (1.0, 3.0), 0.7, (_SIDE, 0.0)), x, v, 0.25, 6)
    assert_allclose(moved.positions[:, 0] - [0.0, images * _SIDE], plain.positions[:, 0], atol=1e-13)


@given(seed=st.integers(0, 2**32), alpha=st.floats(0, 1))
def test_conservation(seed: int, alpha: float) -> None:
    rng = np.random.default_rng(seed)
    masses, v = rng.uniform(0.5, 2.0, 8), rng.normal(size=(8, 2))
    spheres = Spheres(masses.tolist(), rng.uniform(0.2, 1.0, 8).tolist(), alpha, (4.0, 4.0))
    moved = after_steps(spheres, rng.uniform(0, 4, (8, 2)), v, 0.1, 20)
    assert_allclose(masses @ moved.velocities, masses @ v, atol=1e-13)
    before, after = masses @ v**2, masses @ moved.velocities**2
    assert after.sum() <= before.sum() * (1 + 1e-13)
    if alpha == 1.0:
        assert_allclose(after.sum(), before.sum(), rtol=1e-13)


def test_crowded() -> None:
    """Three together; and three of which no two approach."""
    x = np.array([[0.0, 0.0], [0.9, 0.0], [0.45, 0.7]])
    spheres = Spheres((1.0,) * 3, (1.0,) * 3, 1.0, (0.0, 0.0))
    assert after_steps(spheres, x, -1e-3 * x, 1e-3, 1).crowded
    apart = after_steps(spheres, x, x, 1e-3, 1)
    assert (apart.impulses, apart.most, apart.closest, apart.crowded) == (0, 0, np.inf, False)
