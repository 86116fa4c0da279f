"""Operations counted where they are written: texts whose operations are known, and the same in plain Python."""

from __future__ import annotations

import sys
import types

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.performance.counted_sources import counting_all

TEXT = '''
from math import sqrt


def first(n):
    """A loop, a choice and a call."""
    total = 0
    for k in range(n):
        if k % 2 == 0:
            total += sqrt(k)
        else:
            total -= 1
    return total


def prefetch_all(n):
    while n > 1:
        n >>= 1
    return n
'''


def counted(text: str, function: str, n: int, monkeypatch: pytest.MonkeyPatch) -> tuple[int, int]:
    """Operations of a call, in the copy of the text that counts, and those that fetch memory ahead."""
    done = {"add_work": 0, "add_ahead": 0}
    module = types.ModuleType("refimpl.work")
    for name in done:
        setattr(module, name, lambda number, name=name: done.__setitem__(name, done[name] + number))
    monkeypatch.setitem(sys.modules, "refimpl.work", module)
    names: dict[str, object] = {}
    exec(counting_all(text), names)
    plain: dict[str, object] = {}
    exec(text, plain)
    assert names[function](n) == plain[function](n)  # type: ignore[operator]
    return done["add_work"], done["add_ahead"]


@given(n=st.integers(0, 40))
def test_every_passage_of_a_block_counts_what_is_written_in_it(n: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        # total = 0, range(n); each turn: itself, %, ==; even ones: +=, sqrt(); odd ones: -=
        assert counted(TEXT, "first", n, patch) == (2 + 3 * n + 2 * ((n + 1) // 2) + n // 2, 0)


def test_the_test_of_a_while_counts_at_each_passage(monkeypatch: pytest.MonkeyPatch) -> None:
    assert counted(TEXT, "prefetch_all", 16, monkeypatch) == (0, 4 * 2)  # > and >>=


def test_a_statement_done_again_is_more_operations(monkeypatch: pytest.MonkeyPatch) -> None:
    again = TEXT.replace("    total = 0\n", "    total = 0\n    total = 0\n")
    assert counted(again, "first", 5, monkeypatch) == (counted(TEXT, "first", 5, monkeypatch)[0] + 1, 0)


def test_a_text_without_functions_stays_without_a_counter() -> None:
    assert counting_all("x = 1 + 2\n") == "x = 1 + 2\n"
