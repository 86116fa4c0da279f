"""Tables in time: observables-<engine>.csv of `crosscheck simulate`, and other CSV files with a column `time`."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from crosscheck.columns import SAMPLE
from crosscheck.trajectories.frames import Floats, Series
from crosscheck.trajectories.rounding import of_decimals

FORMAT = "CSV with a column time"
HOLDS = "table"


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    return path.suffix == ".csv"


def open_file(path: Path, topology: Path | None) -> Series:
    """Opens the table. path: of the file. topology: not used. ValueError without a column `time`, for a row of another
    length, and for a word that is no number."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    if not rows or "time" not in rows[0]:
        raise ValueError("there is no column 'time'")
    names, body = rows[0], rows[1:]
    wrong = next((number for number, row in enumerate(body) if len(row) != len(names)), None)
    if wrong is not None:
        raise ValueError(f"row {wrong + 1} has {len(body[wrong])} values for {len(names)} columns")
    words = {name: [row[k] for row in body] for k, name in enumerate(names)}
    columns = {name: _numbers(name, column) for name, column in words.items()}
    time = columns.pop("time")
    rounding = {name: of_decimals([word for word in words[name][-SAMPLE:] if word]) for name in columns}
    return Series(path, FORMAT, time, columns, rounding)


def _numbers(name: str, words: list[str]) -> Floats:
    """The numbers of a column; NaN where there is none. ValueError, with the row, for a word that is no number."""
    try:
        return np.array([float(word) if word else np.nan for word in words])
    except ValueError:
        row = next(k for k, word in enumerate(words) if word and not _is_number(word))
        raise ValueError(f"column {name} has '{words[row][:40]}' in row {row + 1}, which is no number") from None


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
