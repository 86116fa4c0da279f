"""Mean-square displacements of particles that fly straight."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.events import self_diffusion


def test_squares_of_straight_flight() -> None:
    rng = np.random.default_rng(3)
    velocities = rng.normal(size=(50, 3))
    positions = rng.normal(size=(50, 3)) + 0.1 * np.arange(30)[:, None, None] * velocities
    expected = (velocities**2).sum(axis=1).mean() * (0.1 * 7) ** 2
    assert self_diffusion._squares(positions, 7, 20) == pytest.approx(np.full(20, expected))
