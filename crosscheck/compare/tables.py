"""Compares two tables in time, as of log files: bits, rounding, and the statistics of each column."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck.compare.outcome import Class, statistics_sentence
from crosscheck.compare.pairing import matched_rows
from crosscheck.compare.samples import FEWEST, START, Tested, compare_series
from crosscheck.errors import UsageError
from crosscheck.files import shown_path
from crosscheck.trajectories.frames import Series


class Cell(NamedTuple):
    """A number of a table that differs. time: of its row. column: its name. first, second: the numbers. rounding: by
    how much the files' rounding lets them differ."""

    time: float
    column: str
    first: float
    second: float
    rounding: float


@dataclass(frozen=True)
class TableComparison:
    """Two tables, and what they are to each other.

    first, second: their names. formats: of the files. classed, sentence: the class and why. rows: number of rows that
    both have. columns: that both have. bits, beyond: the first number whose bits differ, and the first one beyond the
    rounding of the files. tested: statistics, or None. remarks: whole sentences.
    """

    first: str
    second: str
    formats: tuple[str, str]
    classed: Class
    sentence: str
    rows: int
    columns: tuple[str, ...]
    bits: Cell | None
    beyond: Cell | None
    tested: list[Tested] | None
    remarks: tuple[str, ...]


def compare_tables(one: Series, other: Series) -> TableComparison:
    """Compares the columns that two tables have in common, row by row at the same times, and their means.

    one, other: the tables. UsageError if they have no column or no time in common.
    """
    columns = [name for name in one.columns if name in other.columns]
    if not columns:
        raise UsageError(
            f"{shown_path(one.path)} and {shown_path(other.path)}: no column of one is in the other "
            f"({', '.join(one.columns)}; {', '.join(other.columns)})"
        )
    mine, yours, remarks = matched_rows(one, other)
    bits = beyond = None
    for name in columns:
        a, b = one.columns[name][mine], other.columns[name][yours]
        allowed = one.rounding[name].of(a) + other.rounding[name].of(b)
        unequal = (a != b) & ~(np.isnan(a) & np.isnan(b))
        for wrong, which in ((unequal, "bits"), (unequal & ~(np.abs(a - b) <= allowed), "beyond")):
            if not wrong.any():
                continue
            row = int(np.argmax(wrong))
            cell = Cell(float(one.time[mine[row]]), name, float(a[row]), float(b[row]), float(allowed[row]))
            if which == "bits" and (bits is None or cell.time < bits.time):
                bits = cell
            if which == "beyond" and (beyond is None or cell.time < beyond.time):
                beyond = cell
    tested = None
    begin = int(np.ceil(START * len(mine)))
    if beyond is not None and len(mine) - begin >= FEWEST:
        tested = compare_series(
            {name: one.columns[name][mine[begin:]] for name in columns},
            {name: other.columns[name][yours[begin:]] for name in columns},
        )
    classed, sentence = _classify(len(mine), bits, beyond, tested)
    told = (*(f"{table.path.name}: {text}" for table in (one, other) for text in table.remarks), *remarks)
    formats = (one.format, other.format)
    names = (str(one.path), str(other.path))
    return TableComparison(*names, formats, classed, sentence, len(mine), tuple(columns), bits, beyond, tested, told)


def _classify(rows: int, bits: Cell | None, beyond: Cell | None, tested: list[Tested] | None) -> tuple[Class, str]:
    if bits is None:
        return "same_bits", f"same bits: all {rows} common rows."
    if beyond is None:
        return "same_within_rounding", "same within the files' rounding: all common rows."
    numbers = f"{beyond.first!r} against {beyond.second!r}"
    parts = f"{beyond.column} is {numbers} at t = {beyond.time:g}, the first beyond rounding."
    if tested is None:
        return "inconclusive", f"inconclusive: {parts} A table shows no particles, and this one too few rows."
    classed, sentence = statistics_sentence(tested)
    return classed, f"{sentence} {parts[:1].upper()}{parts[1:]}"
