"""What the checks of driven systems share, by a second route."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import t as student

from crosscheck.checks.events.driven import significant, temperature
from crosscheck.verdict import SUSPICIOUS


def test_temperature_leaves_the_mean_motion_out() -> None:
    v = np.random.default_rng(0).normal(size=(1000, 3)) * 2 + [1.0, -3.0, 5.0]
    mass, momentum, kinetic = np.array([1000.0, 0.0]), np.stack([v.sum(axis=0), np.zeros(3)]), np.zeros(2)
    kinetic[0] = 0.5 * np.sum(v**2)
    found = temperature(mass, momentum, kinetic)
    assert found[0] == pytest.approx(v.var(axis=0).mean())
    assert np.isnan(found[1])


def test_differences_are_found_at_the_level_of_all_statistical_judgements() -> None:
    values = np.array([0.9, 1.3, 1.1, 0.7, 1.0, 1.2, 0.8, 1.0])
    found = significant(values, "x")
    assert found.outcome == "pass"
    assert found.control
    # a right code without a difference is beyond it, to either side, with the probability 1e-3
    assert 2 * student.sf(found.expected, 7) == pytest.approx(SUSPICIOUS)
    assert significant(values - 0.9, "x").outcome == "fail"
