"""The reviewed list of equivalent mutations follows the sources."""

from __future__ import annotations

from pathlib import Path

import pytest

from crosscheck.errors import UsageError
from crosscheck.mutation.equivalents import Equivalent, equivalents, unmatched


def test_each_entry_has_a_line_in_the_sources() -> None:
    assert unmatched(equivalents()) == []


def test_an_entry_whose_line_is_gone_is_found() -> None:
    gone = Equivalent("refimpl/events/rules.py", "f", "no such line", "*", "a reason")
    nowhere = Equivalent("refimpl/nowhere.py", "f", "", "*", "a reason")
    assert unmatched([gone]) == [gone]
    assert unmatched([nowhere]) in ([nowhere], [])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[equivalent]]\nfile = "a"\n', "entry 1: .*missing"),
        ('[[equivalent]]\nfile="a"\nfunction="f"\nbefore="x"\nafter="y"\nreason=" "\n', "entry 1: it has no reason"),
    ],
)
def test_an_entry_without_a_reason_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "equivalents.toml"
    path.write_text(text)
    with pytest.raises(UsageError, match=message):
        equivalents(path)
