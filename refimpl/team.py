"""Threads that share the pieces of a kernel's work, without Python between two rounds of it.

A kernel that runs in one thread, the leader, cuts its work into pieces and opens a round: from then on the leader and
the helpers take one piece after the other until none is left. What a piece computes depends on its number alone, never
on who takes it, so results are the same to the last bit for any number of threads; without a helper the leader takes
them all. A round costs some ten atomic operations. Helpers wait for the next one by spinning, which is what makes a
round of some microseconds worth sharing, and give their core away after a while.

    begin_round(flags, pieces)                  # the leader; what pieces read must be ready
    while (piece := next_piece(flags)) >= 0:    # leader and helpers
        ...
        piece_done(flags)
    wait_for_pieces(flags, pieces)              # the leader

Pieces are given out in the order of their numbers, so a piece may wait with `wait_for_pieces` until those before it are
done: two kinds of work, of which the second needs all of the first, take one round. What is not the same in each round,
as arrays that come and go, a helper must read after it has got a piece; it sees them by their `address`.

`flags`: shape (FLAGS,), int64, zeros at first. A helper is a thread in a compiled function that releases the lock of
Python, and calls `join_team` and then `wait_for_round` until it returns 0.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.ir as ir
import numba
import numpy as np
from numba import types
from numba.core import cgutils

from refimpl.compilation import INTERPRETED, compiled, instruction

# Places in `flags`, each on a cache line of its own: rounds begun, or -1 for the end; pieces that nobody has taken, or
# less than none; pieces done; helpers that have come; pieces of the round.
_ROUND, _LEFT, _DONE, _COME, _PIECES = 0, 8, 16, 24, 32
#: Size of `flags`.
FLAGS = 40
#: Looks at a flag before a waiting thread gives its core away between two looks: some tens of microseconds.
_PATIENCE = 2000


def _pointer(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array = context.make_array(signature.args[0])(context, builder, value=arguments[0])
    return builder.gep(array.data, [arguments[1]])


@instruction(lambda flags, i: int(flags[i]))
def _look(context, flags, i):  # type: ignore[no-untyped-def]
    """The flag i, after which everything is seen that the thread that set it had written."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load_atomic(_pointer(context, builder, signature, arguments), "acquire", 8)

    return types.int64(flags, types.int64), generate


def _plain_set(flags: np.ndarray, i: int, value: int) -> None:
    flags[i] = value


@instruction(_plain_set)
def _set(context, flags, i, value):  # type: ignore[no-untyped-def]
    """Sets the flag i, once everything is written that comes before."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store_atomic(arguments[2], _pointer(context, builder, signature, arguments), "release", 8)
        return context.get_dummy_value()

    return types.void(flags, types.int64, types.int64), generate


def _plain_add(flags: np.ndarray, i: int, number: int) -> int:
    flags[i] += number
    return int(flags[i]) - number


@instruction(_plain_add)
def _add(context, flags, i, number):  # type: ignore[no-untyped-def]
    """Adds a number to the flag i, and returns what it was; no two threads find the same."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.atomic_rmw("add", _pointer(context, builder, signature, arguments), arguments[2], "acq_rel")

    return types.int64(flags, types.int64, types.int64), generate


@instruction(lambda: None)
def _give_way(context):  # type: ignore[no-untyped-def]
    """Lets another thread have the core (POSIX sched_yield)."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.IntType(32), [])
        builder.call(cgutils.get_or_insert_function(builder.module, kind, "sched_yield"), [])
        return context.get_dummy_value()

    return types.void(), generate


@instruction(lambda array: 0)
def address(context, array):  # type: ignore[no-untyped-def]
    """Where an array of doubles is in memory; 0 in plain Python, where there are no helpers."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, value=arguments[0]).data
        return builder.ptrtoint(data, ir.IntType(64))

    return types.int64(array), generate


def _no_pointer(place: int) -> Any:
    raise AssertionError("in plain Python there are no helpers")


@instruction(_no_pointer)
def _pointer_to(context, place):  # type: ignore[no-untyped-def]
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(types.int64), generate


@compiled(cache=True)
def doubles_at(place: int, number: int) -> np.ndarray:
    """The array of `number` doubles at `place`, its `address`, as long as its owner keeps it. In helpers only."""
    array: np.ndarray = numba.carray(_pointer_to(place), (number,))  # type: ignore[attr-defined]
    return array


@compiled(cache=True)
def begin_round(flags: np.ndarray, pieces: int) -> None:
    """Opens a new round of so many pieces to the helpers; everything that they read must be written."""
    # a helper that is late from the last round may take a piece as soon as the number of those left is set
    _set(flags, _DONE, 0)
    _set(flags, _PIECES, pieces)
    _set(flags, _LEFT, pieces)
    _add(flags, _ROUND, 1)


@compiled(cache=True)
def next_piece(flags: np.ndarray) -> int:
    """The first piece that nobody has taken, 0 ... pieces - 1, or -1 if there is none left."""
    left = _add(flags, _LEFT, -1)
    # who holds a piece knows that its round is not over
    return _look(flags, _PIECES) - left if left > 0 else -1


@compiled(cache=True)
def piece_done(flags: np.ndarray) -> None:
    """Says that a piece that was taken is done."""
    _add(flags, _DONE, 1)


@compiled(cache=True)
def wait_for_pieces(flags: np.ndarray, pieces: int) -> None:
    """Returns once the first `pieces` of the round are done; called by who holds a later one, or by the leader."""
    looks = 0
    while _look(flags, _DONE) < pieces:
        looks += 1
        if looks > _PATIENCE:
            _give_way()


@compiled(cache=True)
def join_team(flags: np.ndarray) -> None:
    """Says that a helper is here, and needs Python no more."""
    _add(flags, _COME, 1)


@compiled(cache=True)
def wait_for_round(flags: np.ndarray, last: int) -> int:
    """Returns the number of a round after `last` once it is open; 0 when no more will be.

    last: 0 for the first one.
    """
    looks = 0
    while True:
        now = _look(flags, _ROUND)
        if now < 0:
            return 0
        if now > last:
            return now
        looks += 1
        if looks > _PATIENCE:
            _give_way()


@contextmanager
def helping(serve: Callable[[], None], flags: np.ndarray, threads: int) -> Iterator[None]:
    """While it lasts, threads - 1 helpers run `serve`, which must return when `wait_for_round` has returned 0.

    flags: of the team. threads: with the leader; 1: nothing is started. In plain Python there are no helpers.
    """
    if INTERPRETED or threads == 1:
        yield
        return
    flags[_ROUND] = -1
    serve()  # compiles it, before somebody waits
    helpers = [threading.Thread(target=serve, daemon=True) for _ in range(threads - 1)]
    flags[:] = 0
    for helper in helpers:
        helper.start()
    while flags[_COME] < len(helpers):  # the leader will not let Python's lock go
        time.sleep(0)
    try:
        yield
    finally:
        flags[_ROUND] = -1
        for helper in helpers:
            helper.join()
        flags[:] = 0  # how often helpers looked in vain is nobody's business
