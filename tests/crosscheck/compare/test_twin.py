"""The rate of chaos of a scene, by a disturbed twin."""

from __future__ import annotations

import numpy as np
import pytest
from pairs_of_runs import from_state, liquid, run, trajectory

from crosscheck.compare.trajectories import compare_trajectories
from crosscheck.compare.twin import twin_rate
from crosscheck.errors import UsageError
from crosscheck.simulate.run import load


def test_the_rate_is_that_of_two_runs() -> None:
    scene = liquid()
    rate = twin_rate(scene, "refimpl", 120.0)
    start = scene.own_start()
    positions = start.positions.copy()
    positions[3, 1] = np.nextafter(positions[3, 1], 9)
    pair = [trajectory(scene, run(one), "run") for one in (scene, from_state(scene, positions, start.velocities))]
    found = compare_trajectories(pair[0], pair[1])
    assert found.growth is not None
    law = found.growth.law
    assert law is not None
    assert law.error is not None
    assert rate.freedom > 20
    assert rate.value == pytest.approx(law.rate, abs=5 * law.error)
    assert rate.scatter > 0


def test_a_scene_without_chaos_has_no_rate() -> None:
    scene = load("kepler")
    with pytest.raises(UsageError, match="do not part as chaos does"):
        twin_rate(scene, "refimpl", 120.0)


def test_a_scene_needs_a_method() -> None:
    with pytest.raises(UsageError, match="needs a \\[method\\]"):
        twin_rate(liquid().changed(method=None), "refimpl", 120.0)
