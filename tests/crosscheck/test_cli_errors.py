"""Bad files, damaged records and impossible scenes at the command line: one line, exit status 2, before any run."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from command_line import Command
from scene_files import DISKS, SPRING, changed

from crosscheck import cli, commands
from crosscheck.engines.workers.pool import Worker
from crosscheck.record import FILE, Record
from crosscheck.verdict import Verdict

CASE = "stepping/oscillator-exact/velocity_verlet"


@pytest.fixture
def refused(crosscheck: Command, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """Runs `crosscheck <words>`, which must end with status 2 before an engine starts; gives the line it says."""

    def start(worker: Worker) -> None:
        raise AssertionError("an engine was started")

    monkeypatch.setattr(Worker, "_start", start)

    def call(*words: str | Path) -> str:
        done = crosscheck(*words)
        assert done.status == 2
        assert done.out == ""
        (line,) = done.err.split("\n")[:-1]
        assert line.startswith("crosscheck: ")
        assert line.isprintable()
        return line.removeprefix("crosscheck: ")

    return call


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a file, a directory and a pipe."""
    (tmp_path / "file").write_text("x")
    (tmp_path / "directory").mkdir()
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--junit", "directory"], "directory: is a directory, and a file is to be written"),
        (["--junit", "file/junit.xml"], "file: cannot be a directory for junit.xml (file is a file)"),
        (["--junit", "x" * 300], "File name too long"),
        (["-o", "file"], "file: cannot be a directory for the record (file is a file)"),
        (["-o", "x" * 300], "File name too long"),
        (["--resume", "directory"], "directory: there is no record.jsonl"),
        (["--resume", "nowhere"], "nowhere: there is no record.jsonl"),
        (["--resume", "pipe"], "pipe: cannot be read (it is a pipe)"),
        (["--resume", "/dev/zero"], "/dev/zero: cannot be read (it is a device)"),
    ],
)
def test_a_run_whose_files_cannot_be_written_does_not_start(
    place: Path, refused: Any, words: list[str], message: str
) -> None:
    assert message in refused("run", CASE, "-e", "refimpl", *words)


def test_a_mistake_leaves_the_last_record_where_it_is(place: Path, refused: Any) -> None:
    Record(place / "out", {"seed": 0}).append(Verdict("a/b", "c", "refimpl", "error", None, "", {}))
    refused("run", CASE, "-e", "refimpl", "-o", "out", "--junit", "directory")
    assert os.listdir("out") == [FILE]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pipe", "pipe: cannot be read (it is a pipe); give the path of a scene file"),
        ("directory", "directory: cannot be read (it is a directory)"),
        ("/dev/zero", "/dev/zero: cannot be read (it is a device)"),
        ("nowhere\udcff\n", "nowhere\\udcff\\n: there is no such file, nor a shipped scene"),
        ("x" * 300, "there is no such file"),
        ("file", "file: not valid TOML"),
    ],
)
def test_a_scene_that_is_no_scene(place: Path, refused: Any, name: str, message: str) -> None:
    assert message in refused("simulate", name)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (changed(SPRING, "duration", 1e308), "duration: 1e+308 is out of range"),
        (changed(SPRING, "x\n\x1b[31m", 1), "unknown key 'x\\n\\x1b[31m'; remove it"),
        (changed(SPRING, "method", ...) if "method" in SPRING else SPRING, "scene a: add [method]"),
        (changed(changed(DISKS, "method", {"scheme": "event_driven"}), "initial.positions", [[1.0, 1.0], [1.5, 1.0]]),
         "particles 0 and 1 overlap"),
        (changed(changed(DISKS, "method", {"scheme": "event_driven"}), "initial",
                 {"kind": "lattice", "structure": "square", "number": 2**53, "temperature": 1.0, "seed": 0}),
         "9007199254740992 particles need about"),
    ],
)  # fmt: skip
def test_a_scene_that_cannot_be(place: Path, refused: Any, table: dict[str, Any], message: str) -> None:
    (place / "scene.toml").write_text(tomli_w.dumps(table))
    assert message in refused("simulate", "scene.toml")


def test_a_scene_is_not_started_where_its_files_cannot_be(place: Path, refused: Any) -> None:
    assert "cannot be a directory for the files (file is a file)" in refused(
        "simulate", "damped-oscillator", "-o", "file"
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-f", "pdb\n"], "--format pdb\\n: unknown; take dump, extxyz, gsd, npz"),
        (["-f", "gsd", "-f", "dump"], "--format gsd: scene a records no trajectory: set output.trajectory = true, "),
    ],
)
def test_a_trajectory_that_cannot_be_written(place: Path, refused: Any, words: list[str], message: str) -> None:
    (place / "scene.toml").write_text(tomli_w.dumps(SPRING))
    assert refused("simulate", "scene.toml", *words).startswith(message)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([".", "table.xlsx"], "table.xlsx: its suffix says the format: give a file .csv or .parquet"),
        ([".", "directory/no/table.csv"], ".: there is no record.jsonl"),
        (["file", "file/table.csv"], "file: cannot be a directory for table.csv (file is a file)"),
        (["nowhere", "table.csv"], "nowhere: there is no record.jsonl"),
        (["pipe", "table.csv"], "pipe: cannot be read (it is a pipe)"),
    ],
)
def test_a_table_that_cannot_be_written(place: Path, refused: Any, words: list[str], message: str) -> None:
    assert message in refused("export", *words)


@pytest.mark.parametrize(
    "words", [["report", "."], ["export", ".", "t.csv"], ["run", CASE, "-e", "refimpl", "--resume", "."]]
)
def test_a_damaged_record_is_one_line(place: Path, refused: Any, words: list[str]) -> None:
    line = Record(place, {"seed": 0}).append(Verdict("a/b", "c", "refimpl", "error", None, "", {"seconds": 0.1}))
    for name, number in (("cost", 2), ("message", 3)):
        damaged = {key: value for key, value in line.items() if key != name}
        whole = [json.dumps(line)] * (number - 1)
        (place / FILE).write_text("\n".join([*whole, json.dumps(damaged)]) + "\n")
        assert f"{FILE}:{number}: not a verdict: '{name}' is missing" in refused(*words)


def test_the_torn_line_of_an_interrupted_run_is_said(
    place: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    record = Record(place, {"seed": 0})
    record.append(Verdict("a/b", "c", "refimpl", "error", None, "", {"seconds": 0.1}))
    with record.path.open("a") as file:
        file.write('{"schema"')
    commands.report(place)
    assert capfd.readouterr().err == f"crosscheck: {place / FILE}: its last line is incomplete, and does not count\n"


def _fails(error: BaseException) -> Callable[..., None]:
    def command(*words: Any) -> None:
        raise error

    return command


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (PermissionError(13, "Permission denied", "a\nfile"), "a\\nfile: Permission denied"),
        (OSError(28, "No space left on device"), "output: No space left on device"),
        (OSError("something"), "output: something"),
        (MemoryError(), "not enough memory"),
    ],
)
def test_an_error_of_the_system_is_one_line_wherever_it_comes_from(
    refused: Any, monkeypatch: pytest.MonkeyPatch, error: BaseException, message: str
) -> None:
    monkeypatch.setattr(commands, "engines", _fails(error))
    monkeypatch.setattr(cli, "_drop_output", lambda: None)
    assert message in refused("engines")


@pytest.mark.parametrize(
    ("command", "err"),
    [
        ("list --json | head -c 10", "141\n"),
        ("show events/haff > /dev/full", "crosscheck: output: No space left on device\n2\n"),
    ],
)
def test_output_that_ends_early(command: str, err: str) -> None:
    """A closed pipe is the reader's wish, a full disk is not; what it says ends with the exit status."""
    command, *reader = command.split(" | ")
    words = " | ".join([f'{{ "{sys.executable}" -m crosscheck.cli {command}; echo $? >&2; }}', *reader])
    done = subprocess.run(["sh", "-c", words], capture_output=True, text=True, check=False)
    assert done.stderr == err


def test_names_that_are_not_utf8_are_printed(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    directory = Path("o\udcff")
    Record(directory, {"seed": 0}).append(Verdict("a/b", "\udcff", "refimpl", "error", None, "\ud800", {}))
    output = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", output)
    monkeypatch.setattr(sys, "argv", ["crosscheck", "report", str(directory)])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert not end.value.code
    assert output.buffer.getvalue() == b"o\\udcff/report.html\n"  # type: ignore[attr-defined]
    page = (directory / "report.html").read_text(encoding="utf-8")
    assert "\\ud800" in page
