"""The pytest plugin, in sessions of its own: what is collected, what fails, and that nothing green was not judged."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import scipy.stats

from crosscheck import runner
from crosscheck.budget import plan
from crosscheck.budget.loads import CaseLoad, Load
from crosscheck.budget.speeds import Speed
from crosscheck.checks.base import Check, Laboratory, Variant, full, quick, small
from crosscheck.engines.capabilities import Needs
from crosscheck.errors import EngineError, Unsupported
from crosscheck.pytest_plugin import cases
from crosscheck.verdict import Judged, bounded, round_off, statistical, worst

pytest_plugins = "pytester"

#: Loaded by the first statistical judgement: a session within this process must not be the first, whose modules go.
_ = scipy.stats

EXAMPLES = Path(__file__).parents[2] / "examples"

#: An engine that tells its process, and that can hang.
TELLING = """
import os, signal
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run, sample_times

class Engine:
    name = "telling"
    schemes = {"velocity_verlet": Claims((2, 2), (1, 1), True, True)}
    capabilities = (
        capability("gravity", "stepping", words="dimension=2 dimension=3 masses[]", observables="positions velocities"),
    )

    def version(self):
        return "1"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        with open(PIPE, "a") as pipe:
            pipe.write(f"{os.getpid()}\\n")
        signal.pause()
"""


def _passes(laboratory: Laboratory, variant: str) -> Judged:
    one = statistical("pressure [p]", 1.0, 0.01, 1.0, 0.0, "because", samples=100, needed=0.2)
    two = round_off("energy", 1e-16, 1e-15, "rounding")
    return worst([one, two, bounded("steps", 3.0, 5.0, "few")], "a box of disks")


def _judge(laboratory: Laboratory, variant: str) -> Judged:
    if variant == "wrong":
        return worst(
            [round_off("energy", 1.0, 1e-15, "rounding, and no more"), bounded("steps", 3.0, 5.0, "few")], "hot"
        )
    if variant == "refused":
        raise Unsupported("refimpl: no such scene")
    if variant == "broken":
        raise EngineError("refimpl: it fell over\nline 1")
    if variant == "vague":
        return statistical("pressure [p]", 1.0, 0.01, 1.0, 0.0, "because", samples=100, needed=0.001)
    return _passes(laboratory, variant)


def check(name: str, judge: Any = _judge, **changes: Any) -> Check:
    options = {"variants": quick("right"), "faults": (), "needs": Needs("spring")} | changes
    return Check(name, "title", "equation", "criterion", "citation", judge, **options)


@pytest.fixture(autouse=True)
def offered(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Sets the checks that there are: here, none runs an engine."""

    def offer(*checks: Check) -> None:
        monkeypatch.setattr(runner, "all_checks", lambda: checks)

    offer(
        check("a/one", variants=(*quick("right", "wrong", "refused", "broken", "vague"), *full("more"))),
        check("b/two", variants=quick("x", "y")),
    )
    return offer


Session = Callable[..., pytest.RunResult]


@pytest.fixture
def session(pytester: pytest.Pytester) -> Session:
    return lambda *options: pytester.runpytest_inprocess("-p", "no:cacheprovider", "-p", "no:xdist", *options)


# -- the options -------------------------------------------------------------------------------------------------------


def test_each_case_is_a_test(session: Session, pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_own(): pass")
    found = session("--crosscheck-engine=refimpl", "-v", "-rs", "--junitxml=junit.xml", "--color=no")
    found.assert_outcomes(passed=4, failed=3, skipped=1)
    assert found.ret == pytest.ExitCode.TESTS_FAILED
    text = found.stdout.str()
    assert "crosscheck: 7 cases of refimpl" in text
    assert "collected 8 items" in text
    assert re.search(r"crosscheck/b/two::x\[refimpl\] +PASSED", text) or "crosscheck/b/two" in text
    assert "refimpl: no such scene" in text
    for part in (
        "fail: a/one/wrong[refimpl]\n  fail: energy: measured 1, expected 0, off by 1e15 tol.\n"
        "    rounding, and no more\n  1 more pass\n  hot\n"
        "  again: crosscheck run a/one/wrong --engine refimpl --seed 0",
        "inconclusive: a/one/vague[refimpl]\n  inconclusive: pressure [p]: measured 1.000(10), expected 1, off by 0 σ",
        "error: a/one/broken[refimpl]\n  refimpl: it fell over\nline 1",
    ):
        assert part in text
    assert "Traceback" not in text
    assert "cases.py" not in text.partition("short test summary")[0]


def test_all_numbers_are_properties(session: Session, pytester: pytest.Pytester) -> None:
    session("--crosscheck-engine=refimpl", "--junitxml=junit.xml", "--crosscheck-checks=a/one/[rw]*")
    found = {test.attrib["name"]: test for test in ET.parse(pytester.path / "junit.xml").getroot().iter("testcase")}
    assert set(found) == {"right[refimpl]", "wrong[refimpl]", "refused[refimpl]"}
    assert {test.attrib["classname"] for test in found.values()} == {"crosscheck.a.one"}

    def properties(name: str) -> dict[str, str]:
        return {one.attrib["name"]: one.attrib["value"] for one in found[name].iter("property")}

    assert properties("right[refimpl]") == {
        "crosscheck outcome": "pass",
        "crosscheck case": "a/one/right",
        "crosscheck engine": "refimpl",
        "pressure [p]": "pass: measured 1.000(10), expected 1, off by 0 σ, sensitivity 0.051",
        "energy": "pass: measured 1e-16, expected 0, off by 0.1 tol., sensitivity 1e-15 abs.",
        "steps": "pass: measured 3, expected ≤ 5, off by 0.6 tol., sensitivity 0.4",
    }
    assert properties("wrong[refimpl]")["crosscheck outcome"] == "fail"
    assert properties("refused[refimpl]")["crosscheck outcome"] == "skip"


@pytest.mark.parametrize(
    ("options", "outcomes"),
    [
        (["--crosscheck-checks=b/*"], {"passed": 2}),
        (["--crosscheck-checks=b/*", "--crosscheck-checks=a/one/right"], {"passed": 3}),
        (["--crosscheck-checks=a/one/[mr]*", "--crosscheck-tier=full"], {"passed": 2, "skipped": 1}),
        (["--crosscheck-checks=a/one/vague", "--crosscheck-allow-inconclusive"], {"skipped": 1}),
        (["-k", "two and not x"], {"passed": 1, "deselected": 6}),
        (["-m", "not crosscheck"], {"deselected": 7}),
        (["crosscheck/b/two::y[refimpl]", "crosscheck/a/one::right[refimpl]"], {"passed": 2}),
    ],
)
def test_what_is_asked_for_is_run(session: Session, options: list[str], outcomes: dict[str, int]) -> None:
    session("--crosscheck-engine=refimpl", *options).assert_outcomes(**outcomes)


def test_the_seed_is_the_suite_s(
    session: Session, offered: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    seeds: list[tuple[str, int]] = []

    def note(laboratory: Laboratory, variant: str) -> Judged:
        seeds.append((laboratory.case, laboratory.suite_seed))
        return _passes(laboratory, variant)

    offered(check("a/b", note))
    session("--crosscheck-engine=refimpl", "--crosscheck-seed=7").assert_outcomes(passed=1)
    assert seeds == [("a/b/right", 7)]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--crosscheck-checks=a/*"], "there is no engine to judge: add --crosscheck-engine"),
        (["--crosscheck-budget=10"], "there is no engine to judge"),
        (["--crosscheck-engine=nothing"], "unknown engine 'nothing'"),
        (["--crosscheck-engine=no.py:X"], "there is no file"),
        (["--crosscheck-engine=refimpl", "--crosscheck-checks=c/*"], "no check matches c/*"),
        (["--crosscheck-engine=refimpl", "--crosscheck-checks=a/one/more"], "add --tier full"),
        (["--crosscheck-engine=refimpl", "--crosscheck-tier=slow"], "tier slow: unknown; take small, quick or full"),
        (["--crosscheck-engine=refimpl", "--crosscheck-seed=-1"], "seed = -1"),
        (["--crosscheck-engine=refimpl", "--crosscheck-budget=0"], "budget = 0"),
        (["--crosscheck-engine=refimpl", "--crosscheck-time-limit=0"], "time limit = 0"),
        (["--crosscheck-engine=refimpl", "crosscheck/b/two::z[refimpl]"], "no case crosscheck/b/two::z[refimpl]"),
    ],
)
def test_mistakes_are_one_line_and_a_status_of_usage(session: Session, options: list[str], message: str) -> None:
    found = session(*options)
    assert found.ret == pytest.ExitCode.USAGE_ERROR
    (line,) = (line for line in found.stderr.lines if line)
    assert line.startswith("ERROR: --crosscheck: ")
    assert message in line


def test_an_engine_that_no_case_matches_is_a_mistake(session: Session, offered: Callable[..., None]) -> None:
    offered(check("a/b"), check("c/d", needs=Needs("lattice_gas", ("lattice",))))
    found = session("--crosscheck-engine=refimpl", "--crosscheck-engine=rebound")
    assert found.ret == pytest.ExitCode.USAGE_ERROR
    assert "rebound: no case matches what it declares" in found.stderr.str()


@pytest.mark.parametrize("marked", [True, False])
def test_nothing_judged_is_not_green(session: Session, pytester: pytest.Pytester, marked: bool) -> None:
    pytester.makepyfile(
        """
        import pytest
        def test_own(): pass
        @pytest.mark.crosscheck(engine="refimpl", checks="a/one/refused")
        def test_marked(): pass
        """
        if marked
        else "def test_own(): pass"
    )
    options = [] if marked else ["--crosscheck-engine=refimpl", "--crosscheck-checks=a/one/refused"]
    found = session(*options)
    found.assert_outcomes(passed=1, skipped=1)
    assert found.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert "crosscheck: nothing was judged of refimpl: 1 skipped" in found.stdout.str()


# -- the marker --------------------------------------------------------------------------------------------------------


def test_a_marked_test_is_run_for_each_case(session: Session, pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import pytest

        ran = []

        @pytest.mark.crosscheck(engine="refimpl", checks="a/one")
        def test_plain():
            ran.append("plain")

        @pytest.mark.crosscheck("refimpl", checks=["b/*"], seed=3)
        def test_more(crosscheck_verdict):
            ran.append(crosscheck_verdict.variant)
            assert crosscheck_verdict.outcome == "pass"
            assert crosscheck_verdict.findings.judgements[0].quantity == "pressure [p]"
            assert crosscheck_verdict.variant == "x", "its own assertion"

        @pytest.mark.crosscheck(engine="refimpl", checks="a/one/vague", allow_inconclusive=True)
        def test_allowed():
            ran.append("allowed")

        class TestClass:
            pytestmark = pytest.mark.crosscheck(engine="refimpl", checks="a/one/wrong")
            def test_method(self):
                ran.append("method")

        @pytest.mark.crosscheck(engine="refimpl", checks="b/two/x")
        @pytest.mark.crosscheck(engine="refimpl", checks="a/one/right")
        @pytest.mark.parametrize("number", [1, 2])
        def test_stacked(number, crosscheck_verdict):
            ran.append((number, crosscheck_verdict.variant))

        def test_what_ran():
            assert ran == ["plain", "x", "y", *[(n, v) for v in ("x", "right") for n in (1, 2)]]
        """
    )
    found = session("-v", "--junitxml=junit.xml", "--color=no")
    text = found.stdout.str()
    found.assert_outcomes(passed=1 + 1 + 4 + 1, failed=3 + 1 + 1, skipped=1 + 1)
    assert "test_plain[a/one/right[refimpl]] PASSED" in text
    assert "test_plain[a/one/wrong[refimpl]] FAILED" in text
    assert "test_more[b/two/y[refimpl]] FAILED" in text
    assert "its own assertion" in text
    assert "test_method[a/one/wrong[refimpl]] FAILED" in text
    junit = ET.parse(pytester.path / "junit.xml").getroot()
    noted = [one.attrib["value"] for one in junit.iter("property") if one.attrib["name"] == "crosscheck outcome"]
    assert sorted(noted) == sorted(["pass"] * 7 + ["fail"] * 2 + ["skip", "error"] + ["inconclusive"] * 2)


@pytest.mark.parametrize(
    ("needed", "outcome", "text"),
    [
        ("0.1", "passed", ""),
        ("0.01", "failed", "inconclusive: pressure [p]: measured 1.000(10), expected 1, off by 0 σ"),
        ("0.01", "failed", "a deviation of 0.01 must be seen, and 0.051 would be"),
        ("{'pressure*': 0.1}", "passed", ""),
        ("{'pressure [p]': 0.01}", "failed", "a deviation of 0.01 must be seen"),
        ("{'energy': 1e-16}", "failed", "a deviation of 1e-16 must be seen, and 1e-15 would be"),
        ("{'heat': 0.1}", "failed", "no quantity with a sensitivity is called 'heat'; there are: pressure [p]; energy"),
        ("{'steps': 0.1}", "failed", "no quantity with a sensitivity is called 'steps'"),
    ],
)
def test_what_must_be_seen_is_asked_for(
    session: Session, pytester: pytest.Pytester, needed: str, outcome: str, text: str
) -> None:
    pytester.makepyfile(
        f"""
        import pytest
        @pytest.mark.crosscheck(engine="refimpl", checks="b/two/x", needed={needed})
        def test_needed(): pass
        """
    )
    found = session("--color=no")
    found.assert_outcomes(**{outcome: 1})
    assert text in found.stdout.str()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ('engine="refimpl", checks="c/*"', "no check matches c/*"),
        ('engine="refimpl", check="b/*"', "the marker has no argument check; it takes engine, checks"),
        ('checks="b/*"', "the marker needs an engine"),
        ('"refimpl", "b/*"', "the marker takes one argument without a name, the engine"),
        ('"refimpl", engine="refimpl"', "the marker takes one argument without a name, the engine"),
        ("engine=3", "engine = 3: give a text, or a list of texts"),
        ("engine=[3]", "engine = [3]: give a text, or a list of texts"),
        ('engine="refimpl", seed="1"', "seed = '1'"),
        ('engine="refimpl", tier="slow"', "tier slow: unknown"),
        ('engine="refimpl", needed=0', "needed = 0: give a relative deviation above 0"),
        ('engine="refimpl", needed={"x": "y"}', "needed = {'x': 'y'}"),
        ('engine="no.py:X"', "there is no file"),
    ],
)
def test_mistakes_of_a_marker_name_the_test(
    session: Session, pytester: pytest.Pytester, arguments: str, message: str
) -> None:
    pytester.makepyfile(f"import pytest\n@pytest.mark.crosscheck({arguments})\ndef test_it(): pass")
    found = session()
    assert found.ret == pytest.ExitCode.USAGE_ERROR
    (line,) = (line for line in found.stderr.lines if line)
    assert line.startswith(f"ERROR: {Path(pytester._name).name}.py::test_it: ")
    assert message in line


def test_a_marker_that_has_no_effect_is_a_mistake(session: Session, pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import pytest, unittest
        class TestIt(unittest.TestCase):
            @pytest.mark.crosscheck(engine="refimpl")
            def test_it(self): pass
        """
    )
    found = session()
    assert found.ret == pytest.ExitCode.USAGE_ERROR
    assert "only functions, and methods of plain classes, take the marker" in found.stderr.str()


def test_the_fixture_alone_is_a_mistake(session: Session, pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_it(crosscheck_verdict): pass")
    found = session()
    found.assert_outcomes(errors=1)
    assert "is for tests with the marker @pytest.mark.crosscheck" in found.stdout.str()


# -- time --------------------------------------------------------------------------------------------------------------


def test_a_budget_leaves_out_what_does_not_fit(
    session: Session, offered: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    steps = {"a/b/much": 1e6, "a/b/few": 10, "c/d/few": 20, "c/d/large": 30, "e/f/measured": 1e5}
    units = {name: (Load("spring", "stepping", 1, 1, 0, int(number)),) for name, number in steps.items()}
    monkeypatch.setattr(plan, "load_of", lambda check, variant: CaseLoad("", units[f"{check}/{variant}"], 0.0))
    monkeypatch.setattr(plan, "measured", lambda *key, time_limit: Speed((1,), (0.0,), (1e-3,)))
    offered(
        check("a/b", variants=quick("much", "few")),
        check("c/d", variants=(*quick("large"), small("few", "few", "large"), Variant("more", "more", "full"))),
    )
    found = session("--crosscheck-engine=refimpl", "--crosscheck-budget=100", "-rs")
    found.assert_outcomes(passed=2, skipped=2)
    text = found.stdout.str()
    assert "crosscheck: budget: 2 of 4 cases fit, predicted 0.04 s" in text
    assert "left out by --budget: predicted 1e+03 s" in text
    assert "c/d/large is run in its place" in text


def test_workers_of_xdist_are_told_what_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    one, two = (runner.Case("a/one", name, "refimpl", False) for name in ("right", "wrong"))
    settings = cases.Settings((one, two), {"refimpl": "refimpl"})
    times = cases.Times(
        deadline=0.0, limits={"a/one/right[refimpl]": 3.0}, predicted={settings.name(c): 1.0 for c in (one, two)}
    )
    told = settings.with_times(times)
    # its time is over; the other one was never chosen
    for case in (one, two):
        verdict = cases._verdict(told, case, beside_others=True)
        assert (verdict.outcome, verdict.message) == ("skip", "left out by --budget: predicted 1 s")
    late = told.with_times({**times, "deadline": 1e9})
    asked: dict[str, float] = {}
    monkeypatch.setattr(runner, "judge", lambda case, seed, **more: asked.update(more) or verdict)
    monkeypatch.setattr("time.monotonic", lambda: 50.0)
    cases._verdict(late, one, beside_others=True)
    assert asked["deadline"] == 53.0


def test_computing_times_are_not_measured_beside_others() -> None:
    case = runner.Case("a/one", "right", "refimpl", True)
    verdict = cases._verdict(cases.Settings((case,), {"refimpl": "refimpl"}), case, beside_others=True)
    assert verdict.outcome == "skip"
    assert "without pytest-xdist" in verdict.message


# -- processes ---------------------------------------------------------------------------------------------------------


def _command(*options: str) -> list[str]:
    return [sys.executable, "-P", "-m", "pytest", "-p", "no:cacheprovider", *options]


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> tuple[str, ...]:
    """Options for a session that loads no other plugins, which take most of its time."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    return ("-p", "xdist", "-p", "crosscheck.pytest_plugin")


@pytest.fixture
def telling(tmp_path: Path) -> tuple[Path, Path]:
    """A file with an engine that hangs, and the pipe that it tells its process through."""
    file, pipe = tmp_path / "telling.py", tmp_path / "pipe"
    os.mkfifo(pipe)
    file.write_text(f"PIPE = {str(pipe)!r}\n{TELLING}")
    return file, pipe


def test_an_interrupt_leaves_no_process(telling: tuple[Path, Path], alone: tuple[str, ...]) -> None:
    file, pipe = telling
    asked = f"--crosscheck-engine={file}:Engine", "--crosscheck-checks=stepping/gravity-steps"
    command = _command(*alone, "-n0", *asked)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=file.parent) as process:
        number = int(pipe.read_text().splitlines()[0])  # waits for the engine
        assert Path(f"/proc/{number}").exists()
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=60)
    assert process.returncode == pytest.ExitCode.INTERRUPTED, said
    assert not Path(f"/proc/{number}").exists()


def test_processes_of_xdist_share_the_cases(tmp_path: Path, alone: tuple[str, ...]) -> None:
    """By files, so that a check stays in one process; paths are relative to where pytest is called."""
    text = (EXAMPLES / "my_engine.py").read_text(encoding="utf-8")
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "mine.py").write_text(text, encoding="utf-8")
    checks = [f"--crosscheck-checks=stepping/{name}" for name in ("gravity-steps", "gravity-features")]
    asked = "--crosscheck-engine=mine.py:MyEngine", "-v", *checks, "--rootdir=.."
    command = _command(*alone, "-n2", "--dist=loadfile", *asked)
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path / "inner", timeout=300)
    names = re.findall(r"\[gw(\d)\].* PASSED \.\./(crosscheck/[^:]*)::(\S*)\[inner/mine.py:MyEngine\]", done.stdout)
    assert done.returncode == 0, done.stdout
    assert len(names) == len(set(names)) >= 3
    by_check = {(check, worker) for worker, check, _ in names}
    assert len(by_check) == len({check for check, _ in by_check})


def test_mistakes_of_markers_are_errors_of_collection_in_workers_of_xdist(
    session: Session, pytester: pytest.Pytester
) -> None:
    """A worker cannot end the session; what is wrong is told by its reports."""
    pytester.makeconftest(
        """
        import pytest

        @pytest.hookimpl(tryfirst=True)
        def pytest_collection(session):
            session.config.workerinput = {}
        """
    )
    pytester.makepyfile(
        test_a="import pytest\n@pytest.mark.crosscheck(engine='refimpl', check='x')\ndef test_it(): pass",
        test_b="""
        import pytest, unittest
        class TestIt(unittest.TestCase):
            @pytest.mark.crosscheck(engine="refimpl")
            def test_it(self): pass
        """,
    )
    found = session("--continue-on-collection-errors", "--color=no")
    found.assert_outcomes(errors=2)
    text = found.stdout.str()
    assert "test_a.py::test_it: the marker has no argument check" in text
    assert "only functions, and methods of plain classes, take the marker crosscheck" in text
    assert "Traceback" not in text


def test_a_session_that_asks_for_nothing_pays_nothing(tmp_path: Path) -> None:
    """The plugin is loaded in every session where the package is installed."""
    (tmp_path / "conftest.py").write_text(
        "import sys\n\n"
        "def pytest_unconfigure():\n"
        "    print(sorted(name for name in sys.modules if name.startswith('crosscheck')))\n"
    )
    (tmp_path / "test_it.py").write_text("def test_it(): pass\n")
    done = subprocess.run(_command("-q", "-s"), capture_output=True, text=True, check=False, cwd=tmp_path, timeout=300)
    loaded = ["crosscheck", "crosscheck.pytest_plugin", "crosscheck.pytest_plugin.names"]
    assert done.stdout.splitlines()[-1] == str(loaded)
