"""What the checks of driven systems share, by a second route."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.events.driven import temperature


def test_temperature_leaves_the_mean_motion_out() -> None:
    v = np.random.default_rng(0).normal(size=(1000, 3)) * 2 + [1.0, -3.0, 5.0]
    mass, momentum, kinetic = np.array([1000.0, 0.0]), np.stack([v.sum(axis=0), np.zeros(3)]), np.zeros(2)
    kinetic[0] = 0.5 * np.sum(v**2)
    found = temperature(mass, momentum, kinetic)
    assert found[0] == pytest.approx(v.var(axis=0).mean())
    assert np.isnan(found[1])
