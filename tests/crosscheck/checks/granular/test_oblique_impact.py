"""How oblique impacts are reduced to slips and compared with the hard rule, on impacts by that rule."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.granular.impacts import after, make_impacts, rebound
from crosscheck.checks.granular.oblique_impact import _hard_errors
from crosscheck.engines.protocol import Run
from crosscheck.references import granular
from crosscheck.references.granular import Body
from crosscheck.references.soft_impact import SoftContact, hard_impact


@pytest.mark.parametrize("wall", [False, True])
def test_rebound_and_hard_errors_against_the_hard_rule(wall: bool) -> None:
    contact = SoftContact(0.7, -0.4, 0.3, 0.5)
    impacts = make_impacts(2, np.linspace(0.1, 5, 12), 5, wall=wall, q=contact.q)
    velocities, spins = np.zeros((2, 12, 2, 3))
    for k in range(12):
        one, two = (
            Body(impacts.masses[k, i], impacts.radii[k, i], impacts.velocities[k, i], impacts.spins[k, i], contact.q)
            for i in (0, 1)
        )
        done = granular.impact(one, two, impacts.normals[k], contact.alpha, contact.alpha_t, contact.mu, contact.mu)
        velocities[k], spins[k] = done.velocities, done.spins
    normal, slip = rebound(impacts, velocities, spins)
    np.testing.assert_allclose(normal, contact.alpha)
    np.testing.assert_allclose(slip, hard_impact(np.linspace(0.1, 5, 12), contact).slip, atol=1e-13)
    assert _hard_errors(impacts, contact, velocities, spins) == 0
    # rows of a run are put back in their places
    grains = velocities[:, : 1 if wall else 2].reshape(-1, 3)[:, :2]
    turning = spins[:, : 1 if wall else 2].reshape(-1, 3)[:, 2:]
    run = Run(final_positions=grains, final_velocities=grains, final_angular_velocities=turning)
    for found, expected in zip(after(impacts, run), (velocities, spins), strict=True):
        np.testing.assert_array_equal(found, expected)
