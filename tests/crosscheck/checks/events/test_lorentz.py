"""The arrangements of the Lorentz gas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from crosscheck.checks.events import lorentz

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.sampled_from([(2, 0.1), (3, 0.05)]))
@settings(max_examples=10, deadline=None)
def test_scatterers_are_apart_and_points_outside_them(seed: int, case: tuple[int, float]) -> None:
    dimension, x = case
    gas = lorentz.arrangement(dimension, x, 60, 30, seed, overlapping=False)
    assert (gas.centres.shape, gas.places.shape) == ((60, dimension), (30, dimension))
    assert 60 / gas.length**dimension == pytest.approx(x)
    tree = cKDTree(gas.centres, boxsize=gas.length)
    assert len(tree.query_pairs(2.0)) == 0
    assert tree.query(gas.places)[0].min() >= 1
    assert np.linalg.norm(gas.velocities, axis=1) == pytest.approx(1)
