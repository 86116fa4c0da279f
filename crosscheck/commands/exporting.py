"""The command `export`: a record as a table."""

from __future__ import annotations

from pathlib import Path

from crosscheck.commands.console import say_if_torn
from crosscheck.export import check_target, write_table
from crosscheck.files import shown_path
from crosscheck.record import read


def export(record: Path, file: Path) -> None:
    """Writes a record as a table, and says how large it is.

    record: of a run, or its directory. file: to write, .csv or .parquet. UsageError if the record cannot be read, or
    the table not be written.
    """
    check_target(file)
    lines = read(record)
    say_if_torn(record)
    rows, columns = write_table(file, lines)
    print(f"{shown_path(file)}: {rows} rows, {columns} columns, of {len(lines)} cases")
