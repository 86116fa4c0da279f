"""What `crosscheck run` prints of a record at its end."""

from __future__ import annotations

from pathlib import Path

import pytest
import synthetic
from rich.console import Console

from crosscheck.commands.running import print_table
from crosscheck.record import read


@pytest.fixture
def printed(tmp_path: Path) -> list[list[str]]:
    console = Console(width=300, record=True, quiet=False, file=(tmp_path / "out").open("w", encoding="utf-8"))
    print_table(console, read(synthetic.write(tmp_path)))
    return [line.split() for line in console.export_text().splitlines()]


@pytest.mark.parametrize(
    "row",
    [
        "events/several/right refimpl 1.020(10) 1 2 σ 0.05 0.31 s pass",
        "events/several/faulty refimpl 1.500(10) 1 50 σ 0.05 0.31 s fail",
        "stepping/stability/euler refimpl 1e40 ≥ 1000 1e-37 tol. 1e37 0.31 s pass",
        "events/inelastic-collapse/hot refimpl 12 s error",
    ],
)
def test_a_row_has_the_numbers_of_the_judgement_that_decides(printed: list[list[str]], row: str) -> None:
    assert row.split() in printed


def test_failures_name_every_red_quantity_and_errors_their_message(printed: list[list[str]]) -> None:
    text = "\n".join(" ".join(words) for words in printed)
    assert "events/several/faulty [refimpl]: pressure; share of fast particles; a box of 1234 disks" in text
    assert "events/inelastic-collapse/hot [refimpl]: refimpl was killed by signal 11" in text
    assert "skipped 3: Mine: no lattice gases" in text


def test_names_in_brackets_are_no_styles(tmp_path: Path) -> None:
    console = Console(width=300, record=True, file=(tmp_path / "out").open("w", encoding="utf-8"))
    lines = read(synthetic.write(tmp_path))
    print_table(console, [line | {"engine": "a[/b]\x1b.py:Class", "variant": "[red]"} for line in lines])
    assert "events/several/[red] a[/b]\\x1b.py:Class" in " ".join(console.export_text().split())
