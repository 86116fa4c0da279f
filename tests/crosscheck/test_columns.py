"""Rows of text become the nearest doubles, and whole words; a bad row is named."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.columns import SAMPLE, printed, read_columns, whole


@given(st.lists(st.tuples(st.floats(allow_nan=False), st.floats(allow_nan=False)), min_size=1, max_size=100))
def test_decimals_become_the_nearest_doubles(rows: list[tuple[float, float]]) -> None:
    found = read_columns([f"{a!r}\t {b!r}\r\n".encode() for a, b in rows], ("a", "b"), ())
    assert np.stack([found["a"], found["b"]], axis=1).tolist() == list(map(list, rows))


def test_words_keep_all_their_letters() -> None:
    words = ["Ar", "a" * 7, "b" * 8, "c" * 40, "ü"]
    found = read_columns([f"{k} {word}".encode() for k, word in enumerate(words)], ("k", "name"), {"name"})
    assert found["name"].tolist() == words
    assert read_columns([], ("k", "name"), {"name"})["k"].shape == (0,)


@pytest.mark.parametrize("row", [0, SAMPLE + 5])
def test_a_row_of_another_length_is_named(row: int) -> None:
    rows = [b"1 2"] * (SAMPLE + 10)
    rows[row] = b"1 2 3"
    with pytest.raises(ValueError, match="'1 2 3' has 3 values for the columns a b"):
        read_columns(rows, ("a", "b"), ())


@pytest.mark.parametrize("word", ["x", "1_0", "0x10", "1d5", "1,5"])
def test_what_is_no_number_is_said(word: str) -> None:
    with pytest.raises(ValueError, match="could not convert"):
        read_columns([b"1 2", f"1 {word}".encode()], ("a", "b"), ())


def test_empty_rows_and_columns_that_are_there_twice() -> None:
    with pytest.raises(ValueError, match="'' has 0 values"):
        read_columns([b"1", b"\n", b"2"], ("a",), ())
    with pytest.raises(ValueError, match="column a is there twice"):
        read_columns([b"1 2"], ("a", "a"), ())


@pytest.mark.parametrize("value", [0.5, np.nan, np.inf, 2.0**53])
def test_whole_numbers_alone_are_whole(value: float) -> None:
    assert whole("id", np.array([3.0, -2.0])).tolist() == [3, -2]
    with pytest.raises(ValueError, match="id must hold whole numbers"):
        whole("id", np.array([value]))


def test_words_as_they_stand() -> None:
    assert printed([b"1.50 x\n", b"2 y"], ("a", "b")) == {"a": ["1.50", "2"], "b": ["x", "y"]}
