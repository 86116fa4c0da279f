"""Threads that share pieces: each piece is taken once a round, and a round is over when all its pieces are done."""

from __future__ import annotations

import threading
from functools import partial

import numpy as np
import pytest

from refimpl.compilation import compiled
from refimpl.team import (
    FLAGS,
    address,
    begin_round,
    doubles_at,
    helping,
    join_team,
    next_piece,
    piece_done,
    wait_for_pieces,
    wait_for_round,
)


@compiled()
def take(flags: np.ndarray, taken: np.ndarray) -> int:
    """Counts in `taken` how often each piece was done; returns how many were. Slow, so that every thread gets some."""
    piece = next_piece(flags)
    count = 0
    while piece >= 0:
        x = 1.0
        for _ in range(200):
            x = 1.0 / (1.0 + x)
        taken[piece] += 1 + int(x > 2.0)
        count += 1
        piece_done(flags)
        piece = next_piece(flags)
    return count


@compiled(nogil=True)
def serve(flags: np.ndarray, taken: np.ndarray, helped: np.ndarray) -> None:
    join_team(flags)
    last = 0
    while True:
        last = wait_for_round(flags, last)
        if last == 0:
            return
        helped[0] += take(flags, taken)


@compiled()
def lead(flags: np.ndarray, taken: np.ndarray, rounds: int) -> tuple[int, int]:
    """The first round after which not every piece had been done as often as there were rounds, or 0; own pieces."""
    own = 0
    for number in range(1, rounds + 1):
        begin_round(flags, len(taken))
        own += take(flags, taken)
        wait_for_pieces(flags, len(taken))
        for piece in range(len(taken)):
            if taken[piece] != number:
                return number, own
    return 0, own


@pytest.mark.parametrize(("threads", "pieces"), [(1, 5), (2, 1), (2, 7), (3, 2), (5, 16)])
def test_every_piece_is_done_once_a_round(threads: int, pieces: int) -> None:
    flags, taken, helped = np.zeros(FLAGS, dtype=np.int64), np.zeros(pieces, dtype=np.int64), np.zeros(1)
    rounds = 3000
    before = threading.active_count()
    with helping(partial(serve, flags, taken, helped), flags, threads):
        assert threading.active_count() == before + threads - 1
        wrong, own = lead(flags, taken, rounds)
    assert wrong == 0
    assert threading.active_count() == before
    if threads == 1:
        assert own == rounds * pieces
    # the team may work again, with others and without any
    wrong, own = lead(flags, np.zeros(pieces, dtype=np.int64), 10)
    assert (wrong, own) == (0, 10 * pieces)


@compiled()
def halves(flags: np.ndarray, turn: np.ndarray, first: np.ndarray, second: np.ndarray) -> int:
    """A piece of the second half needs all of the first; returns how often one of those was not done."""
    early = 0
    piece = next_piece(flags)
    while piece >= 0:
        if piece < len(first):
            x = 1.0
            for _ in range(300):
                x = 1.0 / (1.0 + x)
            first[piece] = turn[0] + int(x > 2.0)
        else:
            wait_for_pieces(flags, len(first))
            for done in first:
                early += done != turn[0]
            second[piece - len(first)] += 1
        piece_done(flags)
        piece = next_piece(flags)
    return early


@compiled(nogil=True)
def serve_halves(flags: np.ndarray, turn: np.ndarray, first: np.ndarray, second: np.ndarray, early: np.ndarray) -> None:
    join_team(flags)
    last = 0
    while True:
        last = wait_for_round(flags, last)
        if last == 0:
            return
        early[0] += halves(flags, turn, first, second)


@compiled()
def lead_halves(flags: np.ndarray, turn: np.ndarray, first: np.ndarray, second: np.ndarray, rounds: int) -> int:
    early = 0
    for number in range(1, rounds + 1):
        turn[0] = number
        # not as many in every round: who is late must not count with those of the last one
        pieces = len(first) + number % (len(second) + 1)
        begin_round(flags, pieces)
        early += halves(flags, turn, first, second)
        wait_for_pieces(flags, pieces)
    return early


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_a_piece_may_wait_for_those_before_it(threads: int) -> None:
    flags, turn, early = (np.zeros(size, dtype=np.int64) for size in (FLAGS, 1, 1))
    first, second = np.zeros(6, dtype=np.int64), np.zeros(4, dtype=np.int64)
    with helping(partial(serve_halves, flags, turn, first, second, early), flags, threads):
        assert lead_halves(flags, turn, first, second, 1000) == 0
    assert early[0] == 0
    assert second.tolist() == [800, 600, 400, 200]
    assert not flags.any() or threads == 1


@compiled()
def changed_through_its_address(array: np.ndarray) -> None:
    doubles_at(address(array), array.size)[-1] = 7.0


def test_an_array_is_seen_by_its_address() -> None:
    array = np.arange(5.0)
    changed_through_its_address(array)
    assert array.tolist() == [0.0, 1.0, 2.0, 3.0, 7.0]


def test_helpers_go_when_the_leader_fails() -> None:
    flags, taken, helped = np.zeros(FLAGS, dtype=np.int64), np.zeros(3, dtype=np.int64), np.zeros(1)
    before = threading.active_count()
    with pytest.raises(ValueError, match="lost"), helping(partial(serve, flags, taken, helped), flags, 3):
        raise ValueError("lost")
    assert threading.active_count() == before
