"""Vectors of particles and of boxes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.trajectories.vectors import from_cosines, in_space, moved


@given(st.lists(st.floats(1, 50), min_size=3, max_size=3), st.lists(st.floats(65, 105), min_size=3, max_size=3))
def test_edges_have_the_lengths_and_angles_that_they_are_made_of(lengths: list[float], angles: list[float]) -> None:
    cosines = np.cos(np.radians(angles))
    edges = from_cosines(lengths, cosines)
    assert np.allclose(np.linalg.norm(edges, axis=1), lengths, rtol=1e-12)
    units = edges / np.linalg.norm(edges, axis=1)[:, None]
    pairs = [units[1] @ units[2], units[0] @ units[2], units[0] @ units[1]]
    assert np.allclose(pairs, cosines, rtol=0, atol=1e-12)
    assert edges[0, 1] == edges[0, 2] == edges[1, 2] == 0


@pytest.mark.parametrize("angles", [(30, 30, 100), (150, 150, 150), (90, 90, 0)])
def test_no_box_has_any_angles(angles: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="no box has edges with the cosines"):
        from_cosines([1, 1, 1], np.cos(np.radians(angles)))


def test_right_angles_leave_no_rounding() -> None:
    assert from_cosines([1.1, 2.2, 3.3], [0, 0, 0]).tolist() == np.diag([1.1, 2.2, 3.3]).tolist()


@given(st.integers(0, 2**32 - 1))
def test_positions_are_moved_by_edges(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start, numbers, edges = rng.normal(size=(5, 3)), rng.integers(-9, 9, (5, 3)), rng.normal(size=(3, 3))
    assert np.allclose(moved(start, numbers, edges), start + numbers @ edges, rtol=0, atol=1e-13)
    straight = np.diag(rng.uniform(1, 9, 3))
    assert np.array_equal(moved(start, numbers, straight), start + numbers * np.diag(straight))


def test_fewer_components_are_completed() -> None:
    assert in_space(np.array([[1, 2], [3, 4]])).tolist() == [[1, 2, 0], [3, 4, 0]]
    assert in_space(np.array([1.0, 2.0])).tolist() == [[1, 0, 0], [2, 0, 0]]
    assert in_space(np.empty((0, 2))).shape == (0, 3)
