"""A record as a flat table, for analysis with other programs: a row a judgement. Columns: docs/record.md."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from crosscheck.errors import UsageError
from crosscheck.files import naming, refuse_unwritable, shown_path
from crosscheck.record import Line
from crosscheck.record_form import leaves
from crosscheck.text import printable

#: Columns that come first: which case it is.
_CASE = ("check", "variant", "engine", "tier", "outcome")
#: What the other columns begin with, in their order; "": fields of the case itself.
_GROUPS = ("", "judgement.", "cost.", "provenance.")
#: The number of a judgement in its case, from 0.
_NUMBER = "judgement.number"

Row = dict[str, Any]


def columns(lines: Sequence[Line]) -> dict[str, type]:
    """The columns of the table of a record, in their order, with the type of their values: str, bool, int or float.

    A column is called as the path of its field in the record; "judgement.measured" is `measured` of the judgement.
    Every field is there, also if the record has no value of it; of dictionaries (costs, versions) the names that occur.
    lines: of the record, see `crosscheck.record.read`.
    """
    found: dict[str, type] = {_NUMBER: int}
    for path, kind in leaves().items():
        name = path.replace("judgements.", "judgement.")
        if name.endswith(".*"):
            start = name.removesuffix("*")
            found |= dict.fromkeys((key for line in lines for key in _flat(line) if key.startswith(start)), kind)
        else:
            found[name] = kind

    def place(name: str) -> tuple[int, int]:
        if name in _CASE:
            return -1, _CASE.index(name)
        return max(number for number, start in enumerate(_GROUPS) if name.startswith(start)), 0

    return {name: found[name] for name in sorted(found, key=place)}


def rows(lines: Sequence[Line]) -> Iterator[Row]:
    """The rows of the table: values by the names of their columns; what is null, or not there, is None or left out.

    A case without judgements (skipped, or ended in error) has one row. lines: of the record.
    """
    for line in lines:
        case = _flat(line)
        for number, judgement in enumerate(line["judgements"]):
            yield case | {_NUMBER: number} | _flat(judgement, "judgement.")
        if not line["judgements"]:
            yield case


def _flat(entries: dict[str, Any], start: str = "") -> Row:
    """The values of nested dictionaries by their paths, without lists."""
    found: Row = {}
    for name, value in entries.items():
        if isinstance(value, dict):
            found |= _flat(value, f"{start}{name}.")
        elif isinstance(value, str):
            found[start + name] = printable(value, keep="\n\t")  # some bytes of a message are no text
        elif not isinstance(value, list):
            found[start + name] = value
    return found


def check_target(path: Path) -> None:
    """UsageError if no table can be written to `path`: by its suffix, for want of a package, or of a place."""
    if path.suffix.lower() not in _WRITERS:
        raise UsageError(f"{shown_path(path)}: its suffix says the format: give a file .csv or .parquet")
    if path.suffix.lower() == ".parquet" and find_spec("pyarrow") is None:
        raise UsageError(
            f"{shown_path(path)}: needs the package pyarrow: pip install 'particle-crosscheck[export]', or give a .csv"
        )
    refuse_unwritable(path)


def write_table(path: Path, lines: Sequence[Line]) -> tuple[int, int]:
    """Writes the table of a record; every number reads back to the same bits. Returns its numbers of rows and columns.

    path: of the file, CSV or Parquet by its suffix: see `check_target`; its directory is made if it is not there.
    lines: of the record.
    """
    table, kinds = list(rows(lines)), columns(lines)
    with naming(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        _WRITERS[path.suffix.lower()](path, table, kinds)
    return len(table), len(kinds)


def _write_csv(path: Path, table: list[Row], kinds: dict[str, type]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(kinds)
        writer.writerows([_cell(row.get(name)) for name in kinds] for row in table)


def _cell(value: Any) -> str:
    """null is an empty cell; a number is the shortest text that reads back to it."""
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _write_parquet(path: Path, table: list[Row], kinds: dict[str, type]) -> None:
    import pyarrow
    import pyarrow.parquet

    types = {str: pyarrow.string(), bool: pyarrow.bool_(), int: pyarrow.int64(), float: pyarrow.float64()}

    def array(name: str, kind: type) -> Any:
        values = (row.get(name) for row in table)
        return pyarrow.array([None if value is None else kind(value) for value in values], types[kind])

    pyarrow.parquet.write_table(pyarrow.table({name: array(name, kind) for name, kind in kinds.items()}), path)


_WRITERS = {".csv": _write_csv, ".parquet": _write_parquet}
