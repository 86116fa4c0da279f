"""`crosscheck export`: a record becomes a table, and what it says."""

from __future__ import annotations

from pathlib import Path

import pytest

from crosscheck import commands
from crosscheck.record import FILE, Record
from crosscheck.verdict import Verdict, findings, round_off


@pytest.mark.parametrize("name", ["run", f"run/{FILE}"])
def test_a_record_is_exported_and_its_torn_line_said(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    record = Record(Path("run"), {"seed": 0})
    record.append(Verdict("a/b", "c", "refimpl", "error", None, "", {"seconds": 0.1}))
    judged = findings(round_off("x", 0.5, 1.0, "why"))
    record.append(Verdict("a/b", "d", "refimpl", "pass", judged, "", {"seconds": 0.1}))
    with record.path.open("a") as file:
        file.write('{"schema"')
    commands.export(Path(name), Path("new/table.csv"))
    said = capfd.readouterr()
    header, *rows = Path("new/table.csv").read_text().splitlines()
    assert said.out == f"new/table.csv: 2 rows, {len(header.split(','))} columns, of 2 cases\n"
    assert said.err == f"crosscheck: run/{FILE}: its last line is incomplete, and does not count\n"
    assert [row.split(",")[:5] for row in rows] == [
        ["a/b", "c", "refimpl", "quick", "error"],
        ["a/b", "d", "refimpl", "quick", "pass"],
    ]
