"""Tables in time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crosscheck.compare.tables import compare_tables
from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, Floats, Rounding, Series


def table(seed: int, rows: int = 200, shift: float = 0.0, name: str = "log") -> Series:
    rng = np.random.default_rng(seed)
    columns: dict[str, Floats] = {
        "energy": rng.standard_normal(rows) - 5,
        "pressure": rng.standard_normal(rows) + shift,
    }
    return Series(Path(name), "table", np.arange(rows) * 0.5, columns, dict.fromkeys(columns, DOUBLE))


def test_the_same_bits_and_the_same_within_rounding() -> None:
    one = table(1)
    assert compare_tables(one, one).classed == "same_bits"
    rounded = {name: np.array([float(f"{x:.4f}") for x in values]) for name, values in one.columns.items()}
    other = replace(one, columns=rounded, rounding=dict.fromkeys(rounded, Rounding(5e-5, 2e-16, "4 decimals")))
    found = compare_tables(one, other)
    assert found.classed == "same_within_rounding"
    assert found.bits is not None
    assert found.beyond is None
    assert found.tested is None


def test_the_first_number_that_differs_and_the_statistics() -> None:
    one, other = table(1), table(2)
    for name in one.columns:
        other.columns[name][:30] = one.columns[name][:30]
    other.columns["pressure"][20] += 1e-9
    found = compare_tables(one, other)
    assert found.classed == "same_statistics"
    assert found.beyond is not None
    assert (found.beyond.time, found.beyond.column) == (10.0, "pressure")
    assert found.bits == found.beyond
    other.columns["energy"][5] += 1e-9  # earlier, in a column that comes first
    earlier = compare_tables(one, other)
    assert earlier.bits is not None
    assert (earlier.bits.time, earlier.bits.column) == (2.5, "energy")
    other.columns["pressure"][3] += 1e-9
    earliest = compare_tables(one, other)
    assert earliest.bits == earliest.beyond
    assert earliest.bits is not None
    assert (earliest.bits.time, earliest.bits.column) == (1.5, "pressure")
    other.columns["energy"][3] += 1e-9  # of one time, the first column
    both = compare_tables(one, other)
    assert both.bits == both.beyond
    assert both.bits is not None
    assert (both.bits.time, both.bits.column) == (1.5, "energy")
    shifted = compare_tables(one, table(3, shift=0.8))
    assert shifted.classed == "different_statistics"
    assert "pressure" in shifted.sentence


def test_few_rows_are_inconclusive_and_missing_numbers_are_equal() -> None:
    assert compare_tables(table(1, 10), table(2, 10)).classed == "inconclusive"
    one = table(1)
    one.columns["energy"][3] = np.nan
    assert compare_tables(one, one).classed == "same_bits"


def test_tables_without_a_common_column_are_refused() -> None:
    other = replace(table(1), columns={"volume": np.ones(200)}, path=Path("other"))
    with pytest.raises(UsageError, match=r"no column of one is in the other \(energy, pressure; volume\)"):
        compare_tables(table(1), other)
