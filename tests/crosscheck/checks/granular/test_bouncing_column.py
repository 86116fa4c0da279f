"""Energy and centre of mass of a column of beads, on columns that are known."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.granular.bouncing_column import column_state


def test_column_at_rest_on_the_floor_has_no_energy() -> None:
    state = column_state(0.5 + np.arange(6), np.zeros(6))
    assert state.energy == 0
    assert state.height == 3


def test_column_energy_is_that_of_its_fall() -> None:
    # five beads 2 above the floor, or at the speed that they have gained there
    assert column_state(2.5 + np.arange(5), np.zeros(5)).energy == pytest.approx(10.0)
    assert column_state(0.5 + np.arange(5), np.full(5, -2.0)).energy == pytest.approx(10.0)
