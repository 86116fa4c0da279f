"""Queues against a sorted reference, lists of events against Python's lists, and the tree's operation counts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refimpl.events.kernels.compiled import kernel
from refimpl.events.kernels.schedule import (
    COMPARISONS,
    COUNT,
    MOVES,
    NEXT,
    PARTNER,
    PARTNER_COUNT,
    Calendar,
    Lists,
    Tree,
    add,
    build_calendar,
    build_tree,
    drop_events,
    first,
    has_room,
    pop,
    update,
)
from refimpl.events.prediction import NEVER

ADD, FORGET, POP = range(3)


@kernel
def play_queue(queue: Any, counts: Any, who: Any, keys: Any, firsts: Any) -> None:
    """Updates in turn, and who was first after each."""
    for turn in range(who.size):
        update(queue, counts, who[turn], keys[turn])
        firsts[turn] = first(queue, counts)


@kernel
def play_store(store: Any, rows: Any, ints: Any, counts: Any, what: int, i: int, time: float, j: int) -> None:
    """One operation on a store."""
    if what == ADD:
        add(store, rows, ints, counts, i, time, j)
    elif what == FORGET:
        drop_events(store, rows, ints, counts, i)
    else:
        pop(store, rows, ints, counts, i)


@kernel
def room(store: Any, number: int) -> bool:
    """`has_room`, from Python."""
    return has_room(store, number)


def tree(keys: np.ndarray) -> Tree:
    queue = Tree(np.zeros(2 * keys.size), np.zeros(2 * keys.size, np.int32))
    build_tree(queue, keys)
    return queue


def calendar(keys: np.ndarray, buckets: int = 16, per_time: float = 1.0, now: float = 0.0) -> Calendar:
    n = keys.size
    queue = Calendar(
        np.zeros(n), np.zeros(n, np.int64), np.zeros(n, np.int32), np.zeros(n, np.int32), np.zeros(buckets, np.int32),
        np.zeros(1, np.int64), np.array([per_time]),
    )  # fmt: skip
    build_calendar(queue, keys, now)
    return queue


def expected_firsts(keys: np.ndarray, who: np.ndarray, new: np.ndarray) -> list[int]:
    """The earliest after each update, of equal ones the lowest number."""
    keys, found = keys.copy(), []
    for i, key in zip(who, new, strict=True):
        keys[i] = key
        found.append(int(np.argmin(keys)))
    return found


def played(queue: Any, who: np.ndarray, keys: np.ndarray) -> list[int]:
    firsts = np.zeros(who.size, np.int64)
    play_queue(queue, None, who, keys, firsts)
    return firsts.tolist()


# a few equal times, times in between and beyond a year of the calendar, and none at all
times = st.one_of(st.integers(0, 5).map(float), st.floats(0, 1e3), st.sampled_from([1e12, NEVER]))


@settings(max_examples=300)
@given(st.lists(times, min_size=1, max_size=17), st.data())
def test_queues_keep_the_earliest_first(start: list[float], data: st.DataObject) -> None:
    keys = np.array(start)
    moves = data.draw(st.lists(st.tuples(st.integers(0, keys.size - 1), times), min_size=1, max_size=40))
    who, new = np.array([i for i, _ in moves]), np.array([key for _, key in moves])
    expected = expected_firsts(keys, who, new)
    assert played(tree(keys), who, new) == expected
    for per_time in (0.01, 1.0, 100.0):
        assert played(calendar(keys, per_time=per_time), who, new) == expected


@pytest.mark.parametrize("number", [1, 2, 3, 64, 100])
def test_queues_over_a_long_run(number: int) -> None:
    """As in a simulation: the first one gets a later time, and sometimes another one too; the clock goes on."""
    rng = np.random.default_rng(number)
    keys = rng.exponential(size=number)
    now, who, new, current = 0.0, [], [], keys.copy()
    for turn in range(3000):
        i = int(np.argmin(current))
        now = current[i]
        for one in (i, int(rng.integers(number)))[: 1 + turn % 2]:
            # some at the same time, some in a clear gap
            later = rng.choice([0.0, rng.exponential(), 1e4]) if turn % 10 == 0 else rng.exponential()
            who.append(one)
            new.append(now + later)
            current[one] = now + later
    updates, times_of = np.array(who), np.array(new)
    expected = expected_firsts(keys, updates, times_of)
    assert played(tree(keys), updates, times_of) == expected
    assert played(calendar(keys, buckets=4 * 128, per_time=4.0 * number), updates, times_of) == expected


def test_calendar_that_starts_late() -> None:
    keys = np.array([1e9 + 3, 1e9 + 1, NEVER])
    queue = calendar(keys, per_time=10.0, now=1e9)
    assert played(queue, np.array([1, 0]), np.array([1e9 + 5, 1e9 + 6])) == [0, 1]


def test_comparisons_of_the_tree() -> None:
    """A winner is played up to the root; a loser goes on as long as winners change."""
    queue, counts = tree(np.arange(8.0)), np.zeros(6, np.int64)

    def comparisons(i: int, key: float) -> int:
        counts[COMPARISONS] = 0
        play_queue(queue, counts, np.array([i]), np.array([key]), np.zeros(1, np.int64))
        return int(counts[COMPARISONS])

    assert comparisons(0, 0.5) == 3  # stays first: log2 8 games
    assert comparisons(7, 7.5) == 1  # loses again to 6 where it lost before
    assert comparisons(2, 3.5) == 2  # 3 wins in its place, and loses to 0 as 2 did
    assert comparisons(5, -1.0) == 3  # a new first
    assert comparisons(5, 9.0) == 3  # and back
    assert first_of(queue) == 0
    sizes = [2**power for power in range(1, 12)]
    for size in sizes:  # the first one's time moves on: its path is played to the end, log2 N
        queue, counts[:] = tree(np.arange(float(size))), 0
        assert comparisons(0, 0.5) == math.log2(size)


def first_of(queue: Tree) -> int:
    return int(queue.nodes[1])


# -- lists ----------------------------------------------------------------------------------------


def empty_lists(owners: int, nodes: int) -> Lists:
    after = np.arange(1, nodes + 1, dtype=np.int32)
    after[-1] = -1
    return Lists(
        np.full(owners, -1, np.int32), np.zeros(nodes), np.zeros(nodes, np.int32), np.zeros(nodes, np.int32), after,
        np.array([0, nodes], np.int32),
    )  # fmt: skip


def content(store: Lists, i: int) -> list[tuple[float, int, int]]:
    found, node = [], store.heads[i]
    while node >= 0:
        found.append((float(store.time[node]), int(store.partner[node]), int(store.count[node])))
        node = store.after[node]
    return found


def unused(store: Lists) -> int:
    number, node = 0, store.free[0]
    while node >= 0:
        number, node = number + 1, store.after[node]
    return number


OWNERS, NODES = 3, 40
operations = st.tuples(
    st.sampled_from([ADD, ADD, ADD, FORGET, POP]), st.integers(0, OWNERS - 1), st.integers(0, 4).map(float),
    st.integers(0, OWNERS - 1),
)  # fmt: skip


@settings(max_examples=200)
@given(st.lists(operations, max_size=NODES))
def test_lists_of_events(sequence: list[tuple[int, int, float, int]]) -> None:
    store, rows, ints = empty_lists(OWNERS, NODES), np.zeros((OWNERS, 8)), np.zeros((OWNERS, 8), np.int32)
    ints[:, COUNT] = [5, 6, 7]
    counts = np.zeros(6, np.int64)
    lists: list[list[tuple[float, int, int]]] = [[] for _ in range(OWNERS)]
    moves = 0
    for what, i, time, j in sequence:
        mine = lists[i]
        if what == POP and not mine:
            continue
        play_store(store, rows, ints, counts, what, i, time, j)
        if what == ADD:
            earlier = sum(other[0] <= time for other in mine)  # behind those of the same time
            mine.insert(earlier, (time, j, int(ints[j, COUNT])))
            moves += earlier + 1
        elif what == FORGET:
            moves += len(mine)
            mine.clear()
        else:
            moves += 1
            mine.pop(0)
        assert [content(store, owner) for owner in range(OWNERS)] == lists
        assert store.free[1] == unused(store) == NODES - sum(map(len, lists))
        if mine:
            assert (rows[i, NEXT], ints[i, PARTNER], ints[i, PARTNER_COUNT]) == mine[0]
        else:
            assert (rows[i, NEXT], ints[i, PARTNER]) == (NEVER, -1)
    assert counts[MOVES] == moves
    assert room(store, int(store.free[1]))
    assert not room(store, int(store.free[1]) + 1)


def test_a_full_store_grows_with_its_events() -> None:
    from refimpl.events.simulation import _with_more_nodes

    store, rows, ints = empty_lists(2, 4), np.zeros((2, 8)), np.zeros((2, 8), np.int32)
    for time in (3.0, 1.0, 2.0):
        play_store(store, rows, ints, None, ADD, 1, time, 0)
    longer = _with_more_nodes(store)
    assert content(longer, 1) == content(store, 1)
    assert longer.free[1] == unused(longer) == 5
    for time in np.arange(5.0):
        play_store(longer, rows, ints, None, ADD, 0, time, 1)
    assert longer.free.tolist() == [-1, 0]
    assert content(longer, 1) == [(1.0, 0, 0), (2.0, 0, 0), (3.0, 0, 0)]
