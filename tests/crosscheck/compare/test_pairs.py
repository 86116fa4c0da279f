"""Pairs that MDAnalysis finds, against all pairs and all images in double precision."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.compare.pairs import largest_reach, pairs_within
from crosscheck.trajectories.frames import Box, Frame

BOXES = {
    "cube": Box(np.diag([5.0, 5.0, 5.0]), np.array([-1.0, 2.0, 0.3]), np.ones(3, dtype=bool)),
    "slab": Box(np.diag([5.0, 6.0, 7.0]), np.zeros(3), np.array([True, True, False])),
    "plane": Box(np.diag([5.0, 5.0, 0.0]), np.zeros(3), np.array([True, True, False])),
    "skewed": Box(np.array([[5.0, 0, 0], [1.2, 5.0, 0], [-0.7, 0.9, 5.0]]), np.zeros(3), np.ones(3, dtype=bool)),
    "thin": Box(np.diag([5.0, 5.0, 1.0]), np.array([0.0, 0.0, -0.5]), np.ones(3, dtype=bool)),
    "none": None,
}


def frame_of(name: str, seed: int, number: int = 40) -> Frame:
    rng = np.random.default_rng(seed)
    x = rng.uniform(-7, 12, (number, 3))
    if name in ("plane", "thin"):
        x[:, 2] = 0.0
    return Frame(0.0, 0, np.arange(1, number + 1), x, box=BOXES[name])


def all_pairs(frame: Frame, reach: float) -> dict[tuple[int, int], float]:
    """The distance to the nearest image of every pair within the reach."""
    box, found = frame.box, {}
    turns = range(-6, 7)
    active = np.zeros(3, dtype=bool) if box is None else box.periodic & (np.ptp(frame.positions, axis=0) > 0)
    images = np.array(list(product(*(turns if one else (0,) for one in active))))
    shifts = images @ (np.zeros((3, 3)) if box is None else box.vectors)
    for i in range(len(frame.ids)):
        for j in range(i):
            distance = np.linalg.norm(frame.positions[i] - frame.positions[j] + shifts, axis=1).min()
            if distance < reach:
                found[j, i] = distance
    return found


@settings(max_examples=15, deadline=None)
@given(name=st.sampled_from(sorted(BOXES)), seed=st.integers(0, 1000))
def test_pairs_are_those_of_all_images(name: str, seed: int) -> None:
    frame, reach = frame_of(name, seed), 2.2
    found = pairs_within(frame, reach)
    pairs = {
        (min(i, j), max(i, j)): d
        for i, j, d in zip(found.first.tolist(), found.second.tolist(), found.distances.tolist(), strict=True)
    }
    expected = all_pairs(frame, reach)
    assert pairs.keys() == expected.keys()
    assert len(found.first) == len(pairs)
    for pair, distance in expected.items():
        assert pairs[pair] == pytest.approx(distance, abs=1e-13)


@pytest.mark.parametrize("name", sorted(BOXES))
def test_chosen_rows_have_all_their_neighbours(name: str) -> None:
    frame, reach = frame_of(name, 3), 2.2
    chosen = np.array([4, 17, 30])
    found = pairs_within(frame, reach, chosen)
    expected = all_pairs(frame, reach)
    for row in chosen.tolist():
        neighbours = sorted(found.second[found.first == row].tolist())
        assert neighbours == sorted(sum(pair) - row for pair in expected if row in pair)


def test_the_reach_is_half_the_distance_of_opposite_faces() -> None:
    for name in ("cube", "slab", "plane", "thin"):
        assert largest_reach(frame_of(name, 1)) == pytest.approx(2.5, abs=1e-4)
    assert largest_reach(frame_of("none", 1)) == np.inf
    skewed = BOXES["skewed"]
    areas = [np.linalg.norm(np.cross(skewed.vectors[k - 2], skewed.vectors[k - 1])) for k in range(3)]
    heights = np.linalg.det(skewed.vectors) / np.array(areas)
    assert largest_reach(frame_of("skewed", 1)) == pytest.approx(heights.min() / 2, abs=1e-4)


@pytest.mark.parametrize("name", ["cube", "slab", "plane", "thin", "skewed"])
@pytest.mark.parametrize("number", [2, 40, 2000])
def test_the_largest_reach_can_be_asked_for(name: str, number: int) -> None:
    """Few particles are searched by all pairs, many by cells, which refuse more than half of a box."""
    frame = frame_of(name, 2, number)
    reach = largest_reach(frame)
    assert pairs_within(frame, reach).distances.max(initial=0.0) <= reach
    assert pairs_within(frame, reach, np.array([0, 1])).distances.max(initial=0.0) <= reach


def test_a_pair_that_touches_to_the_last_bits_is_measured_in_doubles() -> None:
    x = np.array([[0.1, 0.1, 0.1], [1.1 - 1e-12, 0.1, 0.1]])
    frame = Frame(0.0, 0, np.array([1, 2]), x, box=BOXES["cube"])
    assert pairs_within(frame, 1.0).distances == pytest.approx([1 - 1e-12], abs=1e-15)
    x[1, 0] = 1.1 + 1e-12
    assert not pairs_within(frame, 1.0).distances.size
