"""CSV files with a column `time`, of `simulate` and of others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, Series
from crosscheck.trajectories.reading import open_results


def opened(tmp_path: Path, text: str) -> Series:
    (tmp_path / "a.csv").write_text(text)
    found = open_results(tmp_path / "a.csv")
    assert isinstance(found, Series)
    return found


def test_comments_and_missing_numbers(tmp_path: Path) -> None:
    found = opened(tmp_path, "# scene: a\n# E = energy\ntime,E,p\n0.0,1.5,\n0.1,-2.5e-3,nan\n")
    assert found.time.tolist() == [0, 0.1]
    assert found.columns["E"].tolist() == [1.5, -0.0025]
    assert np.isnan(found.columns["p"]).all()


def test_decimals_tell_the_rounding(tmp_path: Path) -> None:
    values = np.random.default_rng(1).normal(size=(40, 2))
    rows = "".join(f"{k},{a!r},{b:.6f}\n" for k, (a, b) in enumerate(values.tolist()))
    found = opened(tmp_path, f"time,a,b\n{rows}")
    assert found.columns["a"].tolist() == values[:, 0].tolist()
    assert found.rounding["a"] == DOUBLE
    assert found.rounding["b"].absolute == 5e-7


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,E\n0,1\n", "there is no column 'time'"),
        ("", "there is no column 'time'"),
        ("time,E\n0,1\n1\n", "row 2 has 1 values for 2 columns"),
        ("time,E\n0,1\n1,two\n", "column E has 'two' in row 2, which is no number"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        opened(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "a.csv" in str(caught.value)
