"""Draws of thermal walls: right ones are green, of a temperature 2 % too high, or another law, red."""

from __future__ import annotations

import numpy as np
import pytest
from gases import drawn, gas, trial

from crosscheck.engines.protocol import Run
from crosscheck.scene import Box, Face
from crosscheck.simulate.judging.laws import all_laws
from crosscheck.verdict import findings

(LAW,) = (law for law in all_laws() if law.name == "thermal-walls")
WALLS = {"x-": Face(temperature=2.0), "x+": Face(temperature=1.0)}
SCENE = gas(box=Box(lengths=(12.0, 12.0), boundaries=("hard", "periodic"), faces=WALLS))
NUMBER = 80_000


def judged(hot=1.0, shape=1.0):
    """Findings on draws of the wall x-: its temperature times `hot`, and normal velocities to another power."""
    rng = np.random.default_rng(7)
    one = trial(SCENE, lambda attempt: drawn(SCENE, attempt, 4))
    one.run["wall_collisions"] = np.array([[NUMBER, NUMBER, 0.0, 0.0]])
    velocities, partners = np.zeros((2 * NUMBER, 2, 2)), np.zeros((2 * NUMBER, 2))
    for face, temperature in enumerate((2.0 * hot, 1.0)):
        here = slice(face, None, 2)
        partners[here, 1] = -1 - face
        velocities[here, 0, 0] = np.sqrt(
            2 * temperature * rng.exponential(size=NUMBER) ** (shape if face == 0 else 1.0)
        )
        velocities[here, 0, 1] = rng.normal(scale=temperature**0.5, size=NUMBER)
    one.make = lambda extra: Run(event_partners=partners, event_velocities=velocities)
    return findings(LAW.judge(one))


def test_right_draws_are_green_and_two_per_cent_would_be_seen():
    found = judged()
    assert found.outcome == "pass"
    assert [one.quantity.rpartition("T = ")[2][:1] for one in found.judgements] == ["1", "1", "2", "2"]
    assert max(one.sensitivity for one in found.judgements[::2]) < 0.02


@pytest.mark.parametrize(("hot", "shape", "red"), [(1.02, 1.0, [2]), (1.0, 0.97, [3]), (0.97, 1.0, [2, 3])])
def test_wrong_draws_are_red(hot, shape, red):
    found = judged(hot, shape)
    assert set(red) <= {k for k, one in enumerate(found.judgements) if one.outcome == "fail"} <= {2, 3}


def test_it_is_of_walls_with_a_temperature_and_a_trace():
    one = trial(gas(), lambda attempt: drawn(gas(), attempt, 4))
    assert LAW.excuse(one) == "no walls with a temperature"
    walled = trial(SCENE, lambda attempt: drawn(SCENE, attempt, 4))
    assert LAW.excuse(walled) == "no particle has hit them"
