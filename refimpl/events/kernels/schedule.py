"""Which event is next: queues over the particles, and the stores of the predicted events of each particle.

A queue answers `first` (the particle whose next event is the earliest; of equal ones the lowest number) and takes
`update` (a particle's next event has changed). `Tree`: complete binary tree, O(log N) (Marin, Risso and Cordero, J.
Comput. Phys. 103, 306 (1993); Marin and Cordero, Comput. Phys. Commun. 92, 214 (1995)). `Calendar`: buckets of one
small span of time each, O(1) while their width fits the rate of events (Brown, Commun. ACM 31, 1220 (1988); Paul, J.
Comput. Phys. 221, 615 (2007)).

A store keeps the predicted events of each owner. `Lists`: all of them, in a linked list in order of time, as
Marin, Risso and Cordero have it. `Earliest`: the first one only; the others are found again when they are needed
(Lubachevsky, J. Comput. Phys. 94, 255 (1991)).
"""

from typing import Any, NamedTuple

import numpy as np

from refimpl.compilation import dispatched, implements
from refimpl.events.kernels.compiled import INTERNAL, inline_internal, kernel
from refimpl.events.kernels.memory import prefetch
from refimpl.events.prediction import NEVER

#: Columns of `ints`.
PARTNER, PARTNER_COUNT, COUNT, CELL, OWN, STREAK = 0, 1, 2, 3, 6, 7
#: Columns of `rows`.
SPEED, TIME, NEXT = 3, 6, 7
#: Entries of the operation counts.
COMPARISONS, MOVES, PREDICTIONS, CROSSINGS, INVALID, WALL_EVENTS, RENEWALS, LIST_BUILDS, LIST_TESTS = range(9)
OPERATIONS = 9
#: Where `rival` begins.
FIRST_NODE = 1
#: So many nodes stay in the first two caches.
NEAR_NODES = 1 << 13


class Tree(NamedTuple):
    """nodes, keys: (2N,) the winner below each node, and its time; 1 is the root, N + i the leaf of particle i.

    A comparison reads two neighbours in memory: an update of a large tree costs one cache line a level.
    """

    keys: Any
    nodes: Any


class Calendar(NamedTuple):
    """keys: (N,). day: (N,) index of the bucket in time, not wrapped. after, before: (N,) links within a bucket.

    heads: (buckets,), a power of two. today: (1,). per_time: (1,) buckets in a unit of time.
    """

    keys: Any
    day: Any
    after: Any
    before: Any
    heads: Any
    today: Any
    per_time: Any


class Earliest(NamedTuple):
    """A store without arrays of its own: `rows` and `ints` hold each particle's earliest event."""

    nothing: int


class Lists(NamedTuple):
    """heads: (N,). time, partner, count, after: (nodes,). free: (2,) the first unused node, and how many there are."""

    heads: Any
    time: Any
    partner: Any
    count: Any
    after: Any
    free: Any


@inline_internal
def tick(counts: Any, what: int, number: int) -> None:
    """Counts operations; nothing at all where they are not counted."""
    if counts is not None:
        counts[what] += number


# -- the interface of queues -----------------------------------------------------------------------


@dispatched(**INTERNAL)
def update(queue: Any, counts: Any, i: int, key: float) -> None:
    """Particle i's next event is at `key` from now on."""
    raise TypeError("not a queue")


@dispatched(**INTERNAL)
def first(queue: Any, counts: Any) -> int:
    """The particle with the earliest event."""
    raise TypeError("not a queue")


@dispatched(**INTERNAL)
def prefetch_entry(queue: Any, i: int) -> None:
    """Hints to the processor that particle i's entry is about to change."""
    raise TypeError("not a queue")


@dispatched(**INTERNAL)
def rival(queue: Any, node: int, i: int) -> tuple[int, int, float]:
    """One that may be next after i, which is the first, and when; and what to ask with for another one.

    node: `FIRST_NODE`, and then what the answer before said.
    """
    raise TypeError("not a queue")


# -- the tree --------------------------------------------------------------------------------------


@implements(update, Tree)
def _tree_update(queue: Any, counts: Any, i: int, key: float) -> None:
    keys, nodes = queue.keys, queue.nodes
    node = nodes.size // 2 + i
    keys[node] = key
    winner, steps = np.int32(i), 0
    while node > 1:
        # the winner so far stays in a register: which of two wins is no branch, and loads do not wait for stores
        other, another = keys[node ^ 1], nodes[node ^ 1]
        wins = (key < other) | ((key == other) & (winner < another))
        key = key if wins else other
        winner = winner if wins else another
        node >>= 1
        steps += 1
        if nodes[node] == winner and winner != i:
            break
        nodes[node] = winner
        keys[node] = key
    tick(counts, COMPARISONS, steps)


@implements(first, Tree)
def _tree_first(queue: Any, counts: Any) -> int:
    return np.int64(queue.nodes[1])


@implements(rival, Tree)
def _tree_rival(queue: Any, node: int, i: int) -> tuple[int, int, float]:
    # the winner of the half of the tree, of its quarter ..., that i is not in
    nodes = queue.nodes
    child = 2 * node + np.int64(nodes[2 * node] != i)
    other = child ^ 1
    return child, np.int64(nodes[other]), queue.keys[other]


@implements(prefetch_entry, Tree)
def _tree_prefetch(queue: Any, i: int) -> None:
    # the nodes that an update will visit are known well before it starts; the upper levels are in the cache anyway
    place = queue.nodes.size // 2 + i
    while place > NEAR_NODES:
        prefetch(queue.keys, place * 8)
        prefetch(queue.nodes, place * 4)
        place >>= 1


@kernel
def build_tree(queue: Any, times: Any) -> None:
    """Fills all nodes from the leaves up; with one particle the root is its leaf."""
    keys, nodes = queue.keys, queue.nodes
    number = times.size
    for i in range(number):
        keys[number + i], nodes[number + i] = times[i], i
    for node in range(number - 1, 0, -1):
        left = 2 * node
        a, b = keys[left], keys[left + 1]
        first_wins = a < b or (a == b and nodes[left] < nodes[left + 1])
        keys[node] = a if first_wins else b
        nodes[node] = nodes[left] if first_wins else nodes[left + 1]


# -- the calendar ----------------------------------------------------------------------------------


@inline_internal
def _day_of(queue: Any, key: float) -> int:
    day = key * queue.per_time[0]
    # events that never happen, or very late, belong to the last day that an integer can hold
    return np.int64(day) if day < 4e18 else np.int64(4_000_000_000_000_000_000)


@inline_internal
def _put(queue: Any, i: int, key: float) -> None:
    day = max(_day_of(queue, key), queue.today[0])
    slot = day & (queue.heads.size - 1)
    follower = queue.heads[slot]
    queue.keys[i], queue.day[i] = key, day
    queue.before[i], queue.after[i] = -1, follower
    if follower >= 0:
        queue.before[follower] = i
    queue.heads[slot] = i


@implements(update, Calendar)
def _calendar_update(queue: Any, counts: Any, i: int, key: float) -> None:
    before, after = queue.before[i], queue.after[i]
    if before >= 0:
        queue.after[before] = after
    else:
        queue.heads[queue.day[i] & (queue.heads.size - 1)] = after
    if after >= 0:
        queue.before[after] = before
    _put(queue, i, key)


@implements(first, Calendar)
def _calendar_first(queue: Any, counts: Any) -> int:
    mask, today = queue.heads.size - 1, queue.today[0]
    empty = 0
    while True:
        i = np.int64(queue.heads[today & mask])
        best, found = NEVER * 1e5, np.int64(-1)
        while i >= 0:
            if queue.day[i] <= today:
                key = queue.keys[i]
                tick(counts, COMPARISONS, 1)
                if key < best or (key == best and i < found):
                    best, found = key, i
            i = np.int64(queue.after[i])
        if found >= 0:
            queue.today[0] = today
            return found
        today += 1
        empty += 1
        if empty > mask:  # no event in any bucket of this round: go to the day of the next event
            today = queue.day[0]
            for k in range(1, queue.day.size):
                today = min(today, queue.day[k])
            tick(counts, COMPARISONS, queue.day.size)
            empty = 0


@kernel
def build_calendar(queue: Any, times: Any, now: float) -> None:
    """Puts every time into its bucket."""
    queue.heads[:] = -1
    queue.today[0] = _day_of(queue, max(now, 0.0))
    for i in range(times.size):
        _put(queue, i, times[i])


@implements(rival, Calendar)
def _calendar_rival(queue: Any, node: int, i: int) -> tuple[int, int, float]:
    return node, np.int64(i), NEVER  # nobody: to find the next one is what costs the calendar its time


@implements(prefetch_entry, Calendar)
def _calendar_prefetch(queue: Any, i: int) -> None:
    if queue.keys.size > NEAR_NODES:
        prefetch(queue.day, i * 8)
        prefetch(queue.keys, i * 8)
        prefetch(queue.after, i * 4)
        prefetch(queue.before, i * 4)


# -- the interface of stores -----------------------------------------------------------------------


@dispatched(**INTERNAL)
def drop_events(store: Any, rows: Any, ints: Any, counts: Any, i: int) -> None:
    """Drops every pair event that i owns."""
    raise TypeError("not a store")


@dispatched(**INTERNAL)
def keeps_all(store: Any) -> bool:
    """Whether the store keeps every event of an owner, not the earliest alone."""
    raise TypeError("not a store")


@dispatched(**INTERNAL)
def has_room(store: Any, number: int) -> bool:
    """Whether the store can take so many events more."""
    raise TypeError("not a store")


@dispatched(**INTERNAL)
def add(store: Any, rows: Any, ints: Any, counts: Any, i: int, time: float, j: int) -> None:
    """Event of i with j at `time`."""
    raise TypeError("not a store")


@dispatched(**INTERNAL)
def pop(store: Any, rows: Any, ints: Any, counts: Any, i: int) -> None:
    """Drops i's next event from a store that keeps the others; elsewhere all are predicted anew."""
    raise TypeError("not a store")


# -- the earliest event of each owner --------------------------------------------------------------


@implements(drop_events, Earliest)
def _earliest_drop_events(store: Any, rows: Any, ints: Any, counts: Any, i: int) -> None:
    rows[i, NEXT] = NEVER
    ints[i, PARTNER] = -1


@implements(keeps_all, Earliest)
def _earliest_keeps_all(store: Any) -> bool:
    return False


@implements(has_room, Earliest)
def _earliest_has_room(store: Any, number: int) -> bool:
    return True


@implements(add, Earliest)
def _earliest_add(store: Any, rows: Any, ints: Any, counts: Any, i: int, time: float, j: int) -> None:
    # where the partner has an earlier event, this one will be predicted again after that, if it is still due
    if time < rows[j, NEXT] and (time < rows[i, NEXT] or (time == rows[i, NEXT] and j < ints[i, PARTNER])):
        rows[i, NEXT] = time
        ints[i, PARTNER], ints[i, PARTNER_COUNT] = j, ints[j, COUNT]


@implements(pop, Earliest)
def _earliest_pop(store: Any, rows: Any, ints: Any, counts: Any, i: int) -> None:
    pass


# -- all events of each owner ----------------------------------------------------------------------


@inline_internal
def _lists_drop(store: Any, counts: Any, i: int) -> None:
    node = store.heads[i]
    if node >= 0:
        last, steps = node, 1
        while store.after[last] >= 0:
            last = store.after[last]
            steps += 1
        store.after[last] = store.free[0]
        store.free[0] = node
        store.free[1] += steps
        store.heads[i] = -1
        tick(counts, MOVES, steps)


@inline_internal
def _lists_add(store: Any, counts: Any, i: int, time: float, j: int, count: int) -> None:
    node = store.free[0]
    store.free[0] = store.after[node]
    store.free[1] -= 1
    store.time[node], store.partner[node], store.count[node] = time, j, count
    previous, following, steps = np.int32(-1), store.heads[i], 1
    while following >= 0 and store.time[following] <= time:
        previous, following = following, store.after[following]
        steps += 1
    store.after[node] = following
    if previous < 0:
        store.heads[i] = node
    else:
        store.after[previous] = node
    tick(counts, MOVES, steps)


@inline_internal
def _lists_publish_head(store: Any, rows: Any, ints: Any, i: int) -> None:
    """The head of i's list becomes its next event."""
    node = store.heads[i]
    if node < 0:
        rows[i, NEXT], ints[i, PARTNER] = NEVER, -1
    else:
        rows[i, NEXT], ints[i, PARTNER] = store.time[node], store.partner[node]
        ints[i, PARTNER_COUNT] = store.count[node]


@implements(pop, Lists)
def _lists_pop(store: Any, rows: Any, ints: Any, counts: Any, i: int) -> None:
    node = store.heads[i]
    store.heads[i] = store.after[node]
    store.after[node] = store.free[0]
    store.free[0] = node
    store.free[1] += 1
    tick(counts, MOVES, 1)
    _lists_publish_head(store, rows, ints, i)


@implements(drop_events, Lists)
def _lists_drop_events(store: Any, rows: Any, ints: Any, counts: Any, i: int) -> None:
    _lists_drop(store, counts, i)
    _lists_publish_head(store, rows, ints, i)


@implements(keeps_all, Lists)
def _lists_keep_all(store: Any) -> bool:
    return True


@implements(has_room, Lists)
def _lists_have_room(store: Any, number: int) -> bool:
    return store.free[1] >= number


@implements(add, Lists)
def _lists_add_event(store: Any, rows: Any, ints: Any, counts: Any, i: int, time: float, j: int) -> None:
    _lists_add(store, counts, i, time, j, ints[j, COUNT])
    _lists_publish_head(store, rows, ints, i)
