"""Rows of numbers and words in text, as particles stand in dumps and data files, read by numpy to the last bit."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Characters of a word that are read first.
_SHORT = 8
#: Rows whose decimals tell the rounding of a column.
SAMPLE = 64


def read_columns(rows: Sequence[bytes], names: Sequence[str], words: Collection[str]) -> dict[str, NDArray[Any]]:
    """Columns of a table: name -> (N,) nearest doubles of its decimal numbers, or its words.

    rows: N lines. names: of the columns, in their order. words: names of those that do not hold numbers. ValueError,
    with the row, for one with another number of values, and for a value that is no number.
    """
    twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        raise ValueError(f"column {twice} is there twice")
    _refuse_ragged(rows[:SAMPLE], names)
    width = _SHORT
    while True:
        table = _table(rows, np.dtype([(name, f"U{width}" if name in words else np.float64) for name in names]))
        if not any((np.char.str_len(table[name]) == width).any() for name in names if name in words):
            return {name: np.ascontiguousarray(table[name]) for name in names}
        width *= 4  # a word may have been cut


def _table(rows: Sequence[bytes], kinds: np.dtype[Any]) -> NDArray[Any]:
    """The rows, of these types. ValueError as of `read_columns`."""
    if not rows:
        return np.empty(0, dtype=kinds)
    try:
        table = np.loadtxt(iter(rows), dtype=kinds, ndmin=1, comments=None, encoding="utf-8")
    except ValueError as error:
        _refuse_ragged(rows, kinds.names or ())
        raise ValueError(str(error)) from None
    if len(table) < len(rows):
        raise ValueError(f"{len(rows) - len(table)} of {len(rows)} rows are empty")
    return table


def whole(name: str, values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Numbers that are whole, as integers; ValueError for others. name: of the column. values: (N,)."""
    if not (np.isfinite(values).all() and (values == np.rint(values)).all() and (abs(values) < 2**53).all()):
        raise ValueError(f"{name} must hold whole numbers")
    return values.astype(np.int64)


def printed(rows: Iterable[bytes], names: Sequence[str]) -> dict[str, list[str]]:
    """The words of each column, as they stand in the text. rows: lines. names: of the columns."""
    split = [row.decode("utf-8").split() for row in rows]
    return {name: [row[k] for row in split] for k, name in enumerate(names)}


def _refuse_ragged(rows: Sequence[bytes], names: Sequence[str]) -> None:
    wrong = next((row for row in rows if len(row.split()) != len(names)), None)
    if wrong is not None:
        values = wrong.decode("utf-8", "replace").split()
        text = " ".join(values)
        shown = text if len(text) <= 80 else f"{text[:77]}..."
        raise ValueError(f"'{shown}' has {len(values)} values for the columns {' '.join(names)}")
