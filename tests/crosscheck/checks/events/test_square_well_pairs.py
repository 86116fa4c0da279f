"""Pairs in a square well: what their paths conserve, and that all events occur."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks.events import square_well_pairs
from crosscheck.references.square_well import WIDTH, pair_path

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.sampled_from([2, 3]))
@settings(max_examples=10, deadline=None)
def test_a_pair_keeps_energy_and_angular_momentum(seed: int, dimension: int) -> None:
    """Also backwards: the reversed path ends where it began."""
    relative, velocity = square_well_pairs.pair_starts(dimension, seed)
    for r, v in zip(relative[::8], velocity[::8], strict=True):
        path = pair_path(r, v, 3.0, WIDTH)
        energies = [0.25 * u @ u - float(x @ x < WIDTH**2) for x, u in ((r, v), (path.position, path.velocity))]
        assert energies[1] == pytest.approx(energies[0], abs=1e-12)
        momenta = [np.outer(x, u) - np.outer(u, x) for x, u in ((r, v), (path.position, path.velocity))]
        assert np.abs(momenta[1] - momenta[0]).max() < 1e-12


def test_pairs_do_everything() -> None:
    relative, velocity = square_well_pairs.pair_starts(3, 1)
    paths = [pair_path(r, v, 5.0, WIDTH) for r, v in zip(relative, velocity, strict=True)]
    assert np.array([path[2:] for path in paths]).sum(axis=0).min() > 10
