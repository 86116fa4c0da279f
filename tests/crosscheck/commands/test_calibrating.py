"""The command `crosscheck calibrate` on checks that draw their numbers themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosscheck.checks.base import Check, Laboratory, quick
from crosscheck.commands import calibrate
from crosscheck.engines.capabilities import Needs
from crosscheck.errors import UsageError
from crosscheck.verdict import Judged, round_off, statistical, worst


def drawn(laboratory: Laboratory, scale: float) -> Judged:
    """A mean of 25 numbers, its error `scale` times too large, and a number that is not random."""
    row = np.random.default_rng(laboratory.seed()).normal(size=25)
    mean, error = float(row.mean()), scale * float(row.std(ddof=1)) / 5
    return worst([round_off("y", 0.0, 1.0, "why"), statistical("x", mean, error, 0.0, 0.0, "why", samples=25)])


def exact(laboratory: Laboratory, value: Any) -> Judged:
    return round_off("y", 0.0, 1.0, "why")


def broken(laboratory: Laboratory, value: Any) -> Judged:
    raise ValueError("it broke")


def offered(monkeypatch: pytest.MonkeyPatch, judge: Any, value: float = 1.0) -> None:
    check = Check("a/b", "t", "e", "c", "l", judge, quick(one=value), (), Needs("spring"))
    monkeypatch.setattr("crosscheck.runner.all_checks", lambda: (check,))


def test_the_table_is_printed_and_written(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    offered(monkeypatch, drawn)
    out = tmp_path / "table.md"
    assert calibrate([], "quick", ["refimpl"], 200, 1, out) == 0
    printed, written = capsys.readouterr().out, out.read_text()
    row = next(line for line in printed.splitlines() if line.startswith("| a/b/one [refimpl] | x | 200 | 24 |"))
    assert row in written
    assert "1 quantities, 200 judgements: " in written
    assert "p-values of 0 too small, of 0 too large to be uniform" in written
    assert written.startswith("`crosscheck")


@pytest.mark.parametrize(("scale", "status", "word"), [(0.5, 1, "small"), (2.0, 0, "large")])
def test_errors_that_are_too_small_or_too_large_are_found(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    scale: float,
    status: int,
    word: str,
) -> None:
    offered(monkeypatch, drawn, scale)
    assert calibrate([], "quick", ["refimpl"], 200, 1, tmp_path / "table.md") == status
    assert f"p-values too {word}: x" in capsys.readouterr().out


def test_an_error_is_no_calibration(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    offered(monkeypatch, broken)
    assert calibrate([], "quick", ["refimpl"], 5, 1, tmp_path / "table.md") == 4
    assert "a/b/one [refimpl]: the check failed: ValueError: it broke" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("tier", "seeds", "message"),
    [
        ("fast", 10, "--tier fast: unknown"),
        ("quick", 4, "--seeds 4: too few"),
    ],
)
def test_what_cannot_be_calibrated_is_said(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, tier: str, seeds: int, message: str
) -> None:
    offered(monkeypatch, exact)
    with pytest.raises(UsageError, match=message):
        calibrate([], tier, ["refimpl"], seeds, 1, tmp_path / "table.md")


def test_nothing_statistical_is_nothing_judged(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    offered(monkeypatch, exact)
    assert calibrate([], "quick", ["refimpl"], 5, 1, tmp_path / "table.md") == 4
    assert "nothing is judged statistically" in capsys.readouterr().err
