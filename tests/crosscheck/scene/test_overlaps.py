"""The search for overlaps against the sum over all pairs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.scene import overlaps
from crosscheck.scene.overlaps import Overlap, find_overlap, wrapped


def test_wrapped_into_the_box_and_never_on_its_far_side() -> None:
    given = np.array([[-1e-30, -1e-30], [7.5, 7.5], [-0.5, -0.5], [3.0, 3.0]])
    kept = given.copy()
    np.testing.assert_array_equal(wrapped(given, np.array([3.0, 0.0])), [[0, -1e-30], [1.5, 7.5], [2.5, -0.5], [0, 3]])
    np.testing.assert_array_equal(given, kept)


def all_pairs(positions: Any, diameters: Any, fixed: Any, periods: Any) -> Any:
    """Gaps between the surfaces of all pairs, (N, N), infinite for those that may be anywhere."""
    apart = positions[:, None] - positions[None]
    wraps = periods > 0
    apart[..., wraps] -= np.round(apart[..., wraps] / periods[wraps]) * periods[wraps]
    contacts = 0.5 * (diameters[:, None] + diameters[None])
    gaps = np.linalg.norm(apart, axis=-1) - contacts
    gaps[(fixed[:, None] & fixed[None]) | (contacts == 0) | np.eye(len(positions), dtype=bool)] = np.inf
    return gaps


@given(
    seed=st.integers(0, 2**32),
    number=st.integers(1, 60),
    dimension=st.sampled_from([2, 3]),
    sizes=st.sampled_from([(1.0,), (0.0, 1.0), (0.3, 1.0, 4.0), (0.0,)]),
    some_fixed=st.booleans(),
    wraps=st.tuples(st.booleans(), st.booleans(), st.booleans()),
    room=st.floats(9, 60),
    soft=st.booleans(),
    trees=st.booleans(),
)
def test_finds_an_overlap_where_there_is_one(
    seed: int,
    number: int,
    dimension: int,
    sizes: tuple[float, ...],
    some_fixed: bool,
    wraps: Any,
    room: float,
    soft: bool,
    trees: bool,
) -> None:
    """Of soft particles, one by more than the smaller radius. Few particles are searched for in trees too."""
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-room, 2 * room, (number, dimension))
    diameters = rng.choice(sizes, number) * rng.choice([1.0, 0.9], number)
    fixed = rng.random(number) < 0.5 * some_fixed
    periods = np.where(wraps[:dimension], room, 0.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(overlaps, "ALL_PAIRS", 0 if trees else number)
        found = find_overlap(positions, diameters, fixed, periods, 1e-9, soft)
    gaps = all_pairs(positions, diameters, fixed, periods)
    allowed = 0.5 * np.minimum(diameters[:, None], diameters[None]) * soft
    if found is None:
        assert (gaps + allowed).min() >= -1e-9 - 1e-12
        return
    assert found.i < found.j
    assert gaps[found.i, found.j] + allowed[found.i, found.j] < -1e-9 + 1e-12
    assert found.distance - found.contact == pytest.approx(gaps[found.i, found.j], abs=1e-12)
    assert found.contact == 0.5 * (diameters[found.i] + diameters[found.j])


@pytest.mark.parametrize("most", [0, 2])
def test_points_in_one_place_and_fixed_ones_are_let_be(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overlaps, "ALL_PAIRS", most)
    free, none = np.zeros(2), np.zeros(2, dtype=bool)
    together = np.array([[1.0, 1.0], [1.0, 1.0]])
    assert find_overlap(together, np.zeros(2), none, free, 0.0) is None
    assert find_overlap(together, np.ones(2), ~none, free, 0.0) is None
    assert find_overlap(together, np.ones(2), none, free, 0.0) == Overlap(0, 1, 0.0, 1.0)


def test_many_in_one_place_are_found_at_once() -> None:
    # a list of all pairs would not fit into memory
    number = 100_000
    found = find_overlap(np.ones((number, 2)), np.full(number, 0.7), np.zeros(number, dtype=bool), np.zeros(2), 0.0)
    assert found is not None
    assert found.distance == 0
