"""A fault changes one place of a copy, never the installed source."""

from __future__ import annotations

from pathlib import Path

import pytest

import refimpl
from crosscheck.errors import UsageError
from crosscheck.faults import Fault

SOURCE = Path(refimpl.__path__[0])
FAULT = Fault(
    "first-order", "stepping/schemes.py", "return r, add_to(v_half, 0.5 * dt, a), (a,)", "return r, v, (a,)", "all"
)


def test_a_fault_changes_one_place_of_a_copy(tmp_path: Path) -> None:
    before = {path: path.read_bytes() for path in SOURCE.rglob("*.py")}
    FAULT.apply(tmp_path)
    for path, text in before.items():
        copy = (tmp_path / "refimpl" / path.relative_to(SOURCE)).read_bytes()
        if path == SOURCE / FAULT.file:
            assert copy == text.replace(FAULT.old.encode(), FAULT.new.encode())
            assert copy != text
        else:
            assert copy == text
        assert path.read_bytes() == text
    assert not list(tmp_path.rglob("__pycache__"))


@pytest.mark.parametrize(
    ("file", "old", "count"),
    [("stepping/schemes.py", "no such text", 0), ("stepping/schemes.py", "accelerate", None), ("nowhere.py", "x", 0)],
)
def test_a_text_that_is_not_there_once_is_an_error(tmp_path: Path, file: str, old: str, count: int | None) -> None:
    times = (SOURCE / file).read_text().count(old) if count is None else count
    fault = Fault("stale", file, old, "y", "nothing")
    with pytest.raises(UsageError, match=rf"fault 'stale': its text occurs {times} times in refimpl/{file}, not once"):
        fault.apply(tmp_path)
