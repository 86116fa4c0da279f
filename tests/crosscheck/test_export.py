"""A record as a table: every number of it in its place, to the last bit."""

from __future__ import annotations

import csv
import importlib
import json
import struct
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import synthetic
from hypothesis import given
from hypothesis import strategies as st

from crosscheck import export
from crosscheck.errors import UsageError
from crosscheck.export import check_target, columns, rows, write_table
from crosscheck.record import FILE, Record, read
from crosscheck.record_form import leaves
from crosscheck.text import printable
from crosscheck.verdict import Criterion, Findings, Judgement, Verdict

SOURCE = {"seed": 3, "versions": {"python": "3.11", "numpy": "2.0"}, "cpu": "one, two", "cores": 2}


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """Lines of every outcome, as a run writes them."""
    return read(synthetic.write(tmp_path_factory.mktemp("record")))


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def read_parquet(path: Path) -> list[dict[str, Any]]:
    parquet = importlib.import_module("pyarrow.parquet")
    found: list[dict[str, Any]] = parquet.read_table(path).to_pylist()
    return found


READ: dict[str, Callable[[Path], list[dict[str, Any]]]] = {".csv": read_csv, ".parquet": read_parquet}
PARQUET = pytest.param(
    ".parquet",
    marks=pytest.mark.skipif(find_spec("pyarrow") is None, reason="needs the package pyarrow: pip install pyarrow"),
)
SUFFIXES = pytest.mark.parametrize("suffix", [".csv", PARQUET])


def at(line: dict[str, Any], number: int | None, column: str) -> Any:
    """The value of a column by the path that it is called by, in the record itself."""
    if column == "judgement.number":
        return number
    group, _, rest = column.partition(".")
    if group == "judgement":
        if number is None:
            return None
        value: Any = line["judgements"][number]
        for name in rest.split("."):
            value = value.get(name)
        return value
    if column.startswith(("cost.", "provenance.versions.")):
        owner, _, name = column.rpartition(".")
        value = line
        for part in owner.split("."):
            value = value.get(part, {})
        return value.get(name)
    return line.get(group) if not rest else line[group].get(rest)


def expected(lines: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [
        {column: shown(at(line, number, column)) for column in columns(lines)}
        for line in lines
        for number in (range(len(line["judgements"])) if line["judgements"] else [None])
    ]


def shown(value: Any) -> Any:
    """A text without control characters but for ends of lines and tabs."""
    return printable(value, keep="\n\t") if isinstance(value, str) else value


def bits(number: float) -> bytes:
    return struct.pack("d", number)


def test_a_row_for_each_judgement_and_for_each_case_without(lines: list[dict[str, Any]], tmp_path: Path) -> None:
    assert {line["outcome"] for line in lines} == {"pass", "fail", "inconclusive", "skip", "error"}
    count = sum(max(1, len(line["judgements"])) for line in lines)
    kinds = columns(lines)
    assert write_table(tmp_path / "t.csv", lines) == (count, len(kinds))
    wanted = expected(lines)
    table = read_csv(tmp_path / "t.csv")
    assert len(table) == len(wanted)
    for row, values in zip(table, wanted, strict=True):
        assert list(row) == list(kinds)
        for name, kind in kinds.items():
            value = values[name]
            if value is None:
                assert row[name] == ""
            elif kind is float:
                assert bits(float(row[name])) == bits(float(value))
            elif kind is bool:
                assert row[name] == ("true" if value else "false")
            else:
                assert row[name] == str(value)


@pytest.mark.parametrize("suffix", [PARQUET])
def test_parquet_holds_the_same_values_with_their_types(
    lines: list[dict[str, Any]], tmp_path: Path, suffix: str
) -> None:
    write_table(tmp_path / f"t{suffix}", lines)
    kinds = columns(lines)
    for row, values in zip(read_parquet(tmp_path / f"t{suffix}"), expected(lines), strict=True):
        for name, kind in kinds.items():
            assert row[name] is None or type(row[name]) is kind
            assert row[name] == values[name], name


def test_columns_are_the_fields_of_the_record(lines: list[dict[str, Any]]) -> None:
    """All that a line may hold, and nothing that none can; the case first."""
    names = list(columns(lines))
    assert names[:5] == ["check", "variant", "engine", "tier", "outcome"]
    fixed = [name.replace("judgements.", "judgement.") for name in leaves() if "*" not in name]
    assert set(fixed) <= set(names)
    assert all(name in (*fixed, "judgement.number") or name.startswith(("cost.", "provenance.")) for name in names)
    groups = [name.partition(".")[0] if "." in name else "" for name in names]
    assert list(dict.fromkeys(groups)) == ["", "judgement", "cost", "provenance"]
    # a record of skips alone has the same ones, but for costs and versions
    assert [name for name in columns([]) if name in names] == list(columns([]))


def test_nothing_of_a_judgement_is_left_out(lines: list[dict[str, Any]]) -> None:
    held = {name for row in rows(lines) for name in row}
    for line in lines:
        for judgement in line["judgements"]:
            names = {f"judgement.{name}" for name in judgement} - {"judgement.criterion"}
            assert names | {f"judgement.criterion.{name}" for name in judgement["criterion"]} <= held
    assert held <= set(columns(lines))


number = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=True)


WHY = 'a, b\n"c"'


@SUFFIXES
@given(st.lists(st.tuples(number, st.none() | number, number), min_size=1, max_size=5), number, st.text(max_size=20))
def test_every_number_reads_back_to_the_same_bits(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, judged: list[tuple[Any, ...]], cost: float, text: str
) -> None:
    directory = tmp_path_factory.mktemp("export")
    judgements = tuple(
        Judgement("pass", text, measured, error, 1.0, None, 0.5, 0.1, Criterion("bound", "at_most", limit, WHY))
        for measured, error, limit in judged
    )
    record = Record(directory, SOURCE)
    record.append(Verdict("a/b", "c", "e", "pass", Findings(judgements), "", {"seconds": cost, "steps": 7}))
    write_table(directory / f"t{suffix}", read(directory))
    table = READ[suffix](directory / f"t{suffix}")
    assert len(table) == len(judged)
    for row, (measured, error, limit) in zip(table, judged, strict=True):
        assert bits(float(row["judgement.measured"])) == bits(measured)
        assert bits(float(row["judgement.criterion.tolerance"])) == bits(limit)
        assert bits(float(row["cost.seconds"])) == bits(cost)
        assert float(row["cost.steps"]) == 7
        assert row["judgement.quantity"] == shown(text)
        found = row["judgement.uncertainty"]
        assert found in ("", None) if error is None else bits(float(found)) == bits(error)
        assert row["judgement.criterion.why"] == WHY
        assert row["provenance.cpu"] == "one, two"
        assert row["provenance.versions.numpy"] == "2.0"


@SUFFIXES
def test_a_message_of_bytes_that_are_no_text(tmp_path: Path, suffix: str) -> None:
    """Half a surrogate pair is no character: it is written as an escape; an end of a line stays one."""
    record = Record(tmp_path, SOURCE)
    record.append(Verdict("a/b", "c", "e", "error", None, "one\ntwo \udcff \r\x00", {"seconds": 0.1}))
    write_table(tmp_path / f"t{suffix}", read(tmp_path))
    (row,) = READ[suffix](tmp_path / f"t{suffix}")
    assert row["message"] == "one\ntwo \\udcff \\r\\x00"
    assert row["judgement.measured"] in ("", None)


def test_an_older_record_is_read(tmp_path: Path, lines: list[dict[str, Any]]) -> None:
    """Lines of the same schema that lack the newer fields."""
    line = next(line for line in lines if line["judgements"])
    older = json.loads(json.dumps(line))
    for judgement in older["judgements"]:
        del judgement["freedom"]
    (tmp_path / FILE).write_text(json.dumps(older) + "\n")
    write_table(tmp_path / "t.csv", read(tmp_path))
    assert {row["judgement.freedom"] for row in read_csv(tmp_path / "t.csv")} == {""}


@pytest.mark.parametrize("name", ["t", "t.json", "record.jsonl", "t.csv.gz"])
def test_other_suffixes_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match=r"its suffix says the format: give a file \.csv or \.parquet"):
        check_target(tmp_path / name)


def test_without_pyarrow_there_is_csv(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(export, "find_spec", lambda name: None)
    check_target(tmp_path / "T.CSV")
    with pytest.raises(UsageError, match=r"needs the package pyarrow: pip install 'particle-crosscheck\[export\]'"):
        check_target(tmp_path / "t.parquet")


def test_a_place_that_cannot_be_written_to_is_refused(tmp_path: Path) -> None:
    (tmp_path / "t.csv").mkdir()
    with pytest.raises(UsageError, match=r"t\.csv: "):
        check_target(tmp_path / "t.csv")
