"""The record survives what may happen to a run: killed in the middle of a line, run again, read by another version."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from crosscheck.errors import UsageError
from crosscheck.record import FILE, SCHEMA, Record, case_name, finished, provenance, read, worst_judgement
from crosscheck.verdict import Outcome, Verdict, findings, round_off

SOURCE = {"seed": 0}


def verdict(check: str, outcome: Outcome = "pass", error: float = 0.5, engine: str = "refimpl") -> Verdict:
    judged = replace(round_off("x", error, 1.0, "why"), outcome=outcome)
    found = findings(judged) if outcome in ("pass", "fail", "inconclusive") else None
    return Verdict(check, "", engine, outcome, found, "", {"seconds": 0.1})


def test_what_is_appended_is_read(tmp_path: Path) -> None:
    record = Record(tmp_path / "new" / "directory", SOURCE)
    lines = [record.append(verdict(name)) for name in ("a/one", "a/two")]
    assert read(tmp_path / "new" / "directory") == read(record.path) == lines
    assert lines[0]["schema"] == SCHEMA
    assert lines[0]["provenance"] == SOURCE
    assert (lines[0]["check"], lines[0]["engine"], lines[0]["outcome"]) == ("a/one", "refimpl", "pass")


def test_each_line_is_on_the_disk_when_append_returns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced = []
    monkeypatch.setattr("os.fsync", lambda descriptor: synced.append(Path(f"/proc/self/fd/{descriptor}").resolve()))
    record = Record(tmp_path, SOURCE)
    for number in (1, 2):
        record.append(verdict(f"a/{number}", error=float("nan")))
        assert synced == [record.path.resolve()] * number
        text = record.path.read_text()
        assert text.endswith("\n")
        assert len(text.splitlines()) == number
        assert "NaN" not in text


def test_a_torn_line_does_not_count_and_the_run_goes_on(tmp_path: Path) -> None:
    record = Record(tmp_path, SOURCE)
    record.append(verdict("a/one"))
    whole = record.path.read_bytes()
    record.append(verdict("a/two"))
    both = record.path.read_bytes()
    for length in range(len(whole), len(both)):
        record.path.write_bytes(both[:length])
        assert [line["check"] for line in read(tmp_path)] == ["a/one"]
    Record(tmp_path, SOURCE).append(verdict("a/three"))
    assert [line["check"] for line in read(tmp_path)] == ["a/one", "a/three"]


def test_a_first_line_that_is_torn(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text('{"schema": 1, "che')
    assert read(tmp_path) == []
    Record(tmp_path, SOURCE)
    assert (tmp_path / FILE).read_bytes() == b""


def test_the_last_verdict_of_a_case_counts(tmp_path: Path) -> None:
    record = Record(tmp_path, SOURCE)
    for case in (verdict("a", "error"), verdict("a", engine="lammps"), verdict("b"), verdict("a")):
        record.append(case)
    assert {(line["check"], line["engine"]): line["outcome"] for line in read(tmp_path)} == {
        ("a", "refimpl"): "pass",
        ("a", "lammps"): "pass",
        ("b", "refimpl"): "pass",
    }


def test_errors_are_not_finished(tmp_path: Path) -> None:
    record = Record(tmp_path, SOURCE)
    for outcome in ("pass", "fail", "inconclusive", "skip", "error"):
        record.append(verdict(outcome, outcome))
    names = {name for name, _ in finished(read(tmp_path))}
    assert names == {"pass", "fail", "inconclusive", "skip"}


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("not json", ":2: not a verdict"),
        ("[]", ":2: not a verdict"),
        ('{"schema": 1}', ":2: not a verdict"),
        (json.dumps({"schema": 999, "check": "a", "engine": "b"}), ":2: schema 999, this version reads 1 to 2"),
    ],
)
def test_a_line_of_another_kind_is_named(tmp_path: Path, line: str, message: str) -> None:
    record = Record(tmp_path, SOURCE)
    record.append(verdict("a"))
    with record.path.open("a") as file:
        file.write(line + "\n")
    record.append(verdict("b"))
    with pytest.raises(UsageError, match=message):
        read(tmp_path)


def test_no_record(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"there is no record.jsonl; give the directory of a run"):
        read(tmp_path / "nowhere")


def test_a_file_in_the_place_of_the_directory(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="file: cannot be a directory for the record"):
        Record(tmp_path / "file", SOURCE)


def test_provenance() -> None:
    source = provenance(7, "crosscheck run")
    assert source.keys() >= {"versions", "cpu", "cores", "system", "seed", "command"}
    assert source["command"] == "crosscheck run"
    assert source["seed"] == 7
    assert source["cores"] > 0
    assert source["versions"].keys() >= {"python", "particle-crosscheck", "numpy", "numba", "lammps", "ase", "rebound"}
    assert all(isinstance(version, str) for version in source["versions"].values())
    json.dumps(source, allow_nan=False)


# -- records of schema 1 -------------------------------------------------------------------------------

_OLD: dict[str, Any] = {
    "schema": 1,
    "check": "stepping/kepler-order/e0.5/leapfrog",
    "engine": "rebound",
    "outcome": "pass",
    "quantity": "order of r",
    "measured": 2.1,
    "uncertainty": None,
    "expected": 2.0,
    "expected_uncertainty": None,
    "deviation": 0.4,
    "deviation_unit": "tolerance",
    "sensitivity": 0.125,
    "criterion": {"kind": "order", "tolerance": 0.25, "why": "whole numbers"},
    "note": "a note",
    "figures": [],
    "message": "",
    "cost": {"seconds": 1.0},
    "time": "2026-01-01T00:00:00+00:00",
    "provenance": SOURCE,
}


def brought(tmp_path: Path, **changes: Any) -> dict[str, Any]:
    (tmp_path / FILE).write_text(json.dumps(_OLD | changes) + "\n")
    (line,) = read(tmp_path)
    return line


def test_an_old_line_has_its_parts_apart(tmp_path: Path) -> None:
    line = brought(tmp_path)
    assert (line["schema"], line["check"], line["variant"]) == (SCHEMA, "stepping/kepler-order", "e0.5/leapfrog")
    assert case_name(line) == _OLD["check"]
    found = worst_judgement(line)
    assert found is not None
    assert (found["quantity"], found["measured"], found["deviation"], found["sigmas"]) == ("order of r", 2.1, 0.4, None)
    assert found["criterion"] == {"kind": "order", "sense": "both", "tolerance": 0.25, "why": "whole numbers"}
    new = Record(tmp_path / "new", SOURCE).append(verdict("a/b"))
    assert new.keys() == line.keys()
    assert new["judgements"][0].keys() == found.keys()


def test_an_old_deviation_in_sigmas_is_a_share_of_the_tolerance(tmp_path: Path) -> None:
    criterion = {"kind": "statistical", "tolerance": 20.0, "why": "4 sigma"}
    found = worst_judgement(
        brought(
            tmp_path,
            uncertainty=3.0,
            expected_uncertainty=4.0,
            deviation=2.0,
            deviation_unit="sigma",
            criterion=criterion,
        )
    )
    assert found is not None
    assert (found["sigmas"], found["deviation"]) == (2.0, 0.5)


@pytest.mark.parametrize("outcome", ["skip", "error"])
def test_an_old_line_without_a_judgement(tmp_path: Path, outcome: str) -> None:
    keys = ("quantity", "measured", "uncertainty", "expected", "expected_uncertainty", "deviation", "sensitivity")
    line = brought(tmp_path, outcome=outcome, criterion=None, deviation_unit=None, **dict.fromkeys(keys))
    assert (line["judgements"], line["worst"], worst_judgement(line)) == ([], None, None)


@pytest.mark.parametrize(
    ("changes", "sense"),
    [
        ({"measured": 2.0, "expected": 4.0, "deviation": 0.5}, "at_most"),
        ({"measured": 8.0, "expected": 4.0, "deviation": 0.5}, "at_least"),
        ({"measured": 0.0, "expected": 4.0, "deviation": 0.0}, "at_most"),
        ({"measured": 0.0, "expected": 4.0, "deviation": None, "outcome": "fail"}, "at_least"),
    ],
)
def test_the_sense_of_an_old_bound(tmp_path: Path, changes: dict[str, Any], sense: str) -> None:
    found = worst_judgement(brought(tmp_path, criterion={"kind": "bound", "tolerance": 4.0, "why": ""}, **changes))
    assert found is not None
    assert found["criterion"]["sense"] == sense
