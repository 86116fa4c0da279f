"""The pairs that are made to collide."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.events.oblique_impact import APART, CONTACT, pairs_at_all_angles
from crosscheck.references import granular as reference


@pytest.mark.parametrize("dimension", [2, 3])
def test_pairs_touch_at_every_angle(dimension: int) -> None:
    pairs = pairs_at_all_angles(dimension, 1)
    cosines = []
    for pair in pairs:
        one, two = pair.bodies
        assert np.linalg.norm(pair.normal) == pytest.approx(1)
        assert np.linalg.norm(pair.touching[0] - pair.touching[1]) == pytest.approx(one.radius + two.radius)
        g = reference.contact_velocity(one, two, pair.normal)
        assert np.linalg.norm(g) == pytest.approx(1)
        cosines.append(-g @ pair.normal)
        # nobody comes near another pair
        for body in pair.bodies:
            assert np.linalg.norm(body.velocity) * CONTACT + 1 < APART / 2
            if dimension == 2:
                assert body.velocity[2] == body.spin[0] == body.spin[1] == 0
    angles = np.degrees(np.arccos(cosines))
    np.testing.assert_allclose(np.diff(angles), 90 / len(pairs))
