"""The lists against all pairs: nothing missed, nothing doubled, through displacements on either side of the skin."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refimpl.stepping.forces.generic import DIVERGED, GOOD, NEEDS_CAPACITY
from refimpl.stepping.kernels.neighbours import (
    BUILDS,
    CLOSE,
    FAR,
    LOST,
    PRUNES,
    SLOTS,
    STATUS,
    Neighbours,
    copy_to_slots,
    enlarge_neighbours,
    neighbours,
    share_of,
    update,
)
from refimpl.stepping.kernels.simd import WIDTH


def updated(lists: Neighbours, r: np.ndarray) -> Neighbours:
    """Lists for r, enlarged as often as they ask for it."""
    while update(lists, r) == NEEDS_CAPACITY:
        lists = enlarge_neighbours(lists)
    assert lists.bookkeeping[STATUS] == GOOD
    return lists


def listed_distances(lists: Neighbours, radius: float) -> list[tuple[int, int, float]]:
    """(i, j, distance) of the listed images nearer than `radius`, and of the members of each tile, sorted."""
    dimension = len(lists.sides)
    number = len(lists.order)
    slots = lists.packed.reshape(-1, 4 if dimension == 3 else 2)[: lists.bookkeeping[SLOTS], :dimension]
    tagged = np.full(lists.bookkeeping[SLOTS], np.nan)
    copy_to_slots(lists, np.arange(number, dtype=float), tagged)
    found = []
    for tile in range(len(lists.first)):
        members = range(tile * WIDTH, min((tile + 1) * WIDTH, number))
        entries = lists.entries[lists.first[tile] : lists.end[tile]].astype(int)
        assert len(set(entries)) == len(entries)
        for slot in members:
            others = np.concatenate([entries, [m for m in members if m != slot]]).astype(int)
            distances = np.linalg.norm(slots[others] - slots[slot], axis=1)
            near = distances < radius
            found += [
                (int(lists.order[slot]), int(j), float(distance))
                for j, distance in zip(tagged[others[near]], distances[near], strict=True)
            ]
    return sorted(found)


def all_distances(r: np.ndarray, sides: tuple[float, ...], radius: float) -> list[tuple[int, int, float]]:
    """The same from all pairs and all their images."""
    box = np.array(sides)
    x = r.reshape(-1, len(sides))
    nearest = x[:, None] - x
    nearest -= box * np.rint(nearest / np.where(box > 0, box, np.inf))
    found = []
    shells = [int(np.ceil(radius / side)) if side > 0 else 0 for side in sides]
    for shift in product(*[range(-shell, shell + 1) for shell in shells]):
        distances = np.linalg.norm(nearest + np.array(shift) * box, axis=2)
        if not any(shift):
            np.fill_diagonal(distances, np.inf)
        found += [(int(i), int(j), float(distances[i, j])) for i, j in np.argwhere(distances < radius)]
    return sorted(found)


def assert_complete(lists: Neighbours, r: np.ndarray) -> None:
    # round numbers put images at the cutoff itself, where rounding decides
    radius = lists.cutoff * (1 - 3e-12)
    listed, expected = listed_distances(lists, radius), all_distances(r, lists.sides, radius)
    assert [pair[:2] for pair in listed] == [pair[:2] for pair in expected]
    # a coordinate of an image is rounded like the box side
    rounding = max(1e-13, 4 * 2.0**-52 * max(lists.sides))
    np.testing.assert_allclose([pair[2] for pair in listed], [pair[2] for pair in expected], rtol=1e-12, atol=rounding)


def wide(lists: Neighbours) -> Neighbours:
    """The wide lists, as if they were the close ones."""
    return lists._replace(
        first=lists.wide_first, end=lists.wide_end, entries=lists.wide_entries, cutoff=lists.cutoff + lists.skin
    )


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    number=st.integers(1, 60),
    periodic=st.lists(st.booleans(), min_size=2, max_size=3),
    stretch=st.lists(st.floats(2.0, 6.0), min_size=3, max_size=3),
    skin=st.floats(0.0, 0.8),
    offset=st.sampled_from([0.0, 5.0, 300.0]),
    clustered=st.booleans(),
    step=st.floats(0.0, 0.5),
    short=st.sampled_from([None, 0, 1, 2]),
)
def test_no_pair_is_missed(seed, number, periodic, stretch, skin, offset, clustered, step, short):
    rng = np.random.default_rng(seed)
    dimension = len(periodic)
    # one side or all of them shorter than the list radius: images in several shells, also of a particle itself
    stretch = [side / 6 if short in (axis, 2) else side for axis, side in enumerate(stretch)]
    sides = [s if p else 0.0 for s, p in zip(stretch[:dimension], periodic, strict=True)]
    spans = np.array(stretch[:dimension]) * (0.2 if clustered else 1.5)
    r = (rng.uniform(-offset, offset, dimension) + rng.uniform(0, spans, (number, dimension))).ravel()
    lists = updated(neighbours(number, sides, 1.0, skin), r)
    assert_complete(wide(lists), r)
    assert_complete(lists._replace(cutoff=lists.cutoff + CLOSE * skin), r)
    for _ in range(4):
        r = r + step * skin * rng.uniform(-1, 1, r.size)
        lists = updated(lists, r)
        assert_complete(lists, r)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("side", [1.9, 2.6, 5.0, 7.3])
def test_pairs_just_within_reach_across_the_faces_are_listed(dimension, side):
    rng = np.random.default_rng(9)
    reach = 1.8
    ends = rng.uniform(0, side, (100, dimension))
    axes = np.eye(dimension)[np.arange(100) % dimension]
    ends -= axes * ends * (1 - 10 ** rng.uniform(-4, -0.5, (100, 1)))
    r = np.concatenate([ends, ends - 0.99999 * reach * axes]).ravel()
    lists = updated(neighbours(200, [side] * dimension, 1.0, reach - 1.0), r)
    assert_complete(wide(lists), r)


@pytest.mark.parametrize("dimension", [2, 3])
def test_lists_are_renewed_when_half_the_skin_is_passed_and_not_before(dimension):
    rng = np.random.default_rng(1)
    skin = 0.8
    r = rng.uniform(0, 9, 50 * dimension)
    lists = updated(neighbours(50, [9.0] * dimension, 2.0, skin), r)
    one = np.zeros(r.size)
    one[7] = 1.0
    for displacement, builds, prunes in [
        (0.499 * CLOSE * skin, 1, 1),
        (0.501 * CLOSE * skin, 1, 2),
        (0.499 * (1 - CLOSE) * skin, 1, 3),
        (0.501 * (1 - CLOSE) * skin, 1, 3),  # the close lists were renewed a moment ago
        (0.501 * (1 - CLOSE) * skin + 0.501 * CLOSE * skin, 2, 4),
    ]:
        lists = updated(lists, r + displacement * one)
        assert (lists.bookkeeping[BUILDS], lists.bookkeeping[PRUNES]) == (builds, prunes)
        assert_complete(lists, r + displacement * one)


def test_two_particles_that_approach_from_beyond_the_lists_are_found():
    lists = neighbours(2, [0.0, 0.0], 1.0, 0.4)
    for gap in np.arange(2.0, 0.5, -0.03):
        r = np.array([-gap / 2, 0.0, gap / 2, 0.0])
        lists = updated(lists, r)
        assert len(listed_distances(lists, 1.0)) == (2 if gap < 1 else 0)
    assert 1 < lists.bookkeeping[BUILDS] < 10


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300, -1.01 * LOST])
def test_a_lost_particle_is_divergence_at_first_and_later(dimension, bad):
    r = np.random.default_rng(2).uniform(0, 5, 30 * dimension)
    lost = r.copy()
    lost[11] = bad
    for sides in ([5.0] * dimension, [0.0] * dimension):
        lists = neighbours(30, sides, 1.0, 0.5)
        assert update(lists, lost) == DIVERGED
        lists = updated(lists, r)
        assert update(lists, lost) == DIVERGED
        lists = updated(lists, r)
        assert_complete(lists, r)


@pytest.mark.parametrize("sides", [[5.0] * 3, [0.0] * 3])
def test_a_particle_that_leaps_is_lost_however_near_the_origin_it_is(sides):
    """More than FAR list radii from one update to the next; a little less is no divergence, nor is it at the start."""
    r = np.random.default_rng(2).uniform(0, 5, 90)
    for share, outcome in ((0.99, GOOD), (1.01, DIVERGED)):
        leap = r.copy()
        leap[11] -= share * FAR * 1.5
        lists = updated(neighbours(30, sides, 1.0, 0.5), r)
        assert update(lists, leap) == outcome
        assert update(lists, leap) == GOOD
        assert update(lists, r) == outcome


@pytest.mark.parametrize("boxes", [2**17, 2**30, 10**9])
def test_far_but_finite_coordinates_are_served(boxes):
    """In steps of 2^-20 of a side that is a power of two, so that wrapping rounds nothing."""
    r = np.random.default_rng(3).integers(0, 2**20, 90) * 2.0**-18
    r[::9] += 4.0 * (boxes // 2)
    r[1] -= 4.0 * boxes
    lists = updated(neighbours(30, [4.0] * 3, 1.0, 0.5), r)
    listed, expected = listed_distances(lists, 1.0), all_distances(r, lists.sides, 1.0)
    assert [pair[:2] for pair in listed] == [pair[:2] for pair in expected]


@settings(max_examples=100, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    sides=st.lists(st.sampled_from([0.0, 0.7, 3.1, 2e7]), min_size=2, max_size=3),
    magnitude=st.floats(0, 99),
    together=st.booleans(),
)
def test_anywhere_below_the_limit_nothing_is_missed(seed, sides, magnitude, together):
    """All pairs of the coordinates as rounding has left them: those of the slots. Far means 1e6 ... 1e99 list radii."""
    rng = np.random.default_rng(seed)
    r = rng.uniform(0, 6, (20, len(sides)))
    r += 10**magnitude * (rng.uniform(-1, 1, len(sides)) if together else rng.integers(-1, 2, r.shape))
    lists = updated(neighbours(20, sides, 1.0, 0.5), r.ravel())
    record = 4 if len(sides) == 3 else 2
    wrapped = lists.packed.reshape(-1, record)[:20, : len(sides)][np.argsort(lists.order)]
    assert_complete(lists, np.ascontiguousarray(wrapped).ravel())
    for axis, side in enumerate(sides):
        assert side == 0 or (abs(wrapped[:, axis] - side / 2) <= side / 2 * (1 + 1e-5)).all()


@pytest.mark.parametrize(
    "positions",
    [np.zeros((40, 3)), np.arange(40.0)[:, None] * [[1.0, 0, 0]], np.arange(40.0)[:, None] ** 3 * [[1.0, 0.5, 0]]],
    ids=["one point", "a line", "a long jet"],
)
def test_degenerate_open_systems(positions):
    lists = updated(neighbours(40, [0.0, 0.0, 0.0], 1.5, 0.3), positions.ravel())
    assert_complete(lists, positions.ravel())


def test_clustering_asks_for_capacity_and_gets_it():
    number = 1200
    r = np.random.default_rng(4).uniform(0, 6, number * 3)
    lists = neighbours(number, [60.0] * 3, 2.5, 0.5)
    assert update(lists, r) == NEEDS_CAPACITY
    assert_complete(updated(lists, r)._replace(cutoff=0.5), r)


@pytest.mark.parametrize("number", [1, 8, 9, 64, 500, 4000, 32001])
def test_pieces_and_shares_hold_every_tile_and_slot_once(number):
    lists = neighbours(number, [0.0, 0.0], 1.0, 0.1)
    edges, shares = lists.shared.edges, len(lists.shared.shares)
    assert edges[0] == 0
    assert edges[-1] == len(lists.first) == -(-number // WIDTH)
    assert (np.diff(edges) > 0).all()
    # long pieces first: a thread that comes last to a round waits for a short one
    assert (np.diff(edges)[:-2] >= np.diff(edges)[1:-1]).all()
    held = [range(*share_of.py_func(index, number, shares)) for index in range(shares)]
    assert [slot for part in held for slot in part] == list(range(number))


def test_a_piece_that_lacks_room_asks_for_enough():
    """All particles of one piece of seventeen are in one place, and the others far apart."""
    number = 600
    r = 40.0 * np.arange(number * 2.0).reshape(-1, 2)
    r[:32] = 0.01 * np.random.default_rng(5).uniform(size=(32, 2))
    lists = neighbours(number, [0.0, 0.0], 1.0, 0.5)
    lists = lists._replace(entries=lists.entries[:300].copy(), wide_entries=lists.wide_entries[:300].copy())
    assert update(lists, r.ravel()) == NEEDS_CAPACITY
    assert_complete(updated(lists, r.ravel()), r.ravel())


def test_wrong_sizes_are_refused():
    with pytest.raises(ValueError, match="number of particles"):
        neighbours(0, [5.0, 5.0], 1.0, 0.1)
    with pytest.raises(ValueError, match="2 or 3 box sides"):
        neighbours(3, [5.0], 1.0, 0.1)
    with pytest.raises(ValueError, match="cutoff must be positive"):
        neighbours(3, [5.0, 5.0], float("nan"), 0.1)
    with pytest.raises(ValueError, match="skin must be non-negative"):
        neighbours(3, [5.0, 5.0], 1.0, -0.1)
    with pytest.raises(ValueError, match="shorten the cutoff"):
        neighbours(30, [5.0, 1e-3, 1e-3], 10.0, 0.6)
    with pytest.raises(ValueError, match="sides and cutoff"):
        neighbours(3, [5.0, np.inf], 1.0, 0.6)
    with pytest.raises(ValueError, match="number \\* dimension"):
        update(neighbours(3, [5.0, 5.0], 1.0, 0.1), np.zeros(5))
