"""`crosscheck diff`, `baseline accept` and `run --baseline` as their user meets them."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from command_line import Command

from crosscheck import runner
from crosscheck.commands.regressing import Against
from crosscheck.record import Record, read
from crosscheck.report.markdown import VARIABLE
from crosscheck.verdict import LEFT_OUT, Judged, Verdict, bounded, findings, round_off, statistical, worst

CHECK = "stepping/oscillator-exact"
EULER, VERLET = f"{CHECK}/euler", f"{CHECK}/velocity_verlet"


@pytest.fixture
def crosscheck(crosscheck: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Command:
    """Runs `crosscheck <words>` in this process, in a directory of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(VARIABLE, raising=False)
    return crosscheck


def green(x: float = 0.1) -> Judged:
    return worst([round_off("x", x, 1.0, "why"), bounded("y", 1.0, 2.0, "why")])


def red(x: float = 3.0) -> Judged:
    return worst([round_off("x", x, 1.0, "why"), bounded("y", 1.0, 2.0, "why")])


def vague() -> Judged:
    return worst([round_off("x", 0.1, 1.0, "why"), statistical("y", 0.0, 1.0, 0.0, 0.0, "why", samples=2.0)])


def verdict(name: str, judged: Judged | str, engine: str = "refimpl", steps: int = 200, tier: str = "quick") -> Verdict:
    """judged: what was judged, or the outcome of a case that was not."""
    check, _, variant = name.rpartition("/")
    cost = {"seconds": 0.1, "cpu": 0.1, "steps": steps}
    if isinstance(judged, str):
        outcome: Any = judged
        return Verdict(check, variant, engine, outcome, None, "it is Monday", cost, tier)
    found = findings(judged)
    return Verdict(check, variant, engine, found.outcome, found, "", cost, tier)


def record(directory: Path, *verdicts: Verdict, seed: int = 0) -> Path:
    made = Record(directory, {"seed": seed, "versions": {}, "cpu": "a", "cores": 2})
    for one in verdicts:
        made.append(one)
    return directory


@pytest.fixture
def offers(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Puts verdicts in the place of those of a run."""

    def put(*verdicts: Verdict) -> None:
        def run(cases: list[runner.Case], *_: Any) -> Iterator[Verdict]:
            wanted = {(case.name, case.engine) for case in cases}
            return iter([one for one in verdicts if (one.name, one.engine) in wanted])

        monkeypatch.setattr(runner, "run", run)

    return put


RUN = ("run", CHECK, "-e", "refimpl", "--baseline", "crosscheck-baseline.txt")


def accepted(crosscheck: Command, tmp_path: Path, *verdicts: Verdict) -> None:
    assert crosscheck("baseline", "accept", "--from", record(tmp_path / "before", *verdicts)).status == 0


# -- run --baseline -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("before", "now", "status", "text", "junit"),
    [
        (green(), green(), 0, "2 judgements of 1 cases compared, 2 the same number", None),
        (green(), green(0.9), 1, "changed beyond uncertainty: 1\n", "failure"),
        (green(), red(), 1, "new failures: 1\n", "failure"),
        (red(), red(), 0, "not green, as before: 1\n", "skipped"),
        (red(3.0), red(4.0), 1, "new failures: 1\n", "failure"),
        (red(), green(), 0, "fixed: 1\n", None),
        (green(), vague(), 3, "became inconclusive: 1\n", "failure"),
        (vague(), vague(), 0, "not green, as before: 1\n", "skipped"),
        (green(), "skip", 4, "no longer tested: 1\n", "error"),
        (green(), "error", 4, "could not run: 1\n", "error"),
        ("error", "error", 0, "not green, as before: 1\n", "skipped"),
        ("skip", green(), 0, "newly tested: 1\n", None),
        ("skip", red(), 1, "new failures: 1\n", "failure"),
    ],
)
def test_a_run_is_red_only_for_what_is_worse_than_its_baseline(
    crosscheck: Command,
    offers: Any,
    tmp_path: Path,
    before: Judged | str,
    now: Judged | str,
    status: int,
    text: str,
    junit: str | None,
) -> None:
    always = verdict(EULER, green())
    accepted(crosscheck, tmp_path, always, verdict(VERLET, before))
    offers(always, verdict(VERLET, now))
    done = crosscheck(*RUN, "--junit", "junit.xml")
    if text.startswith("2 judgements"):
        text = "4 judgements of 2 cases compared, 4 the same number"
    assert (done.status, text in done.out) == (status, True), done.out
    case = ET.parse("junit.xml").find(".//testcase[@name='velocity_verlet[refimpl]']")
    assert case is not None
    assert [child.tag for child in case] == ([] if junit is None else [junit])


def test_what_became_inconclusive_is_status_3_unless_it_is_allowed(
    crosscheck: Command, offers: Any, tmp_path: Path
) -> None:
    def measured(samples: float) -> Judged:
        return statistical("x", 0.0, 1.0, 0.0, 0.0, "why", samples=samples)

    accepted(crosscheck, tmp_path, verdict(EULER, measured(100.0)))
    offers(verdict(EULER, measured(2.0)))
    done = crosscheck(*RUN)
    assert done.status == 3
    assert "became inconclusive: 1\n" in done.out
    assert done.err == "crosscheck: 1 inconclusive: see --allow-inconclusive\n"
    assert crosscheck(*RUN, "--allow-inconclusive").status == 0


def test_more_operations_are_red_and_accepted_by_one_command(crosscheck: Command, offers: Any, tmp_path: Path) -> None:
    accepted(crosscheck, tmp_path, verdict(EULER, green()))
    offers(verdict(EULER, green(), steps=400))
    done = crosscheck(*RUN)
    assert done.status == 1
    assert (
        "slower: more operations: 1\n  stepping/oscillator-exact/euler [refimpl]: steps 200 -> 400, times 2\n"
        in done.out
    )
    (hint,) = (line for line in done.out.splitlines() if line.startswith("what is meant: "))
    words = hint.removeprefix("what is meant: crosscheck ").replace("[CHECK ...] ", "").split()
    assert crosscheck(*words).status == 0
    assert crosscheck(*RUN).status == 0


def test_a_case_of_the_baseline_that_the_run_no_longer_has_is_status_4(
    crosscheck: Command, offers: Any, tmp_path: Path
) -> None:
    gone = f"{CHECK}/an_old_scheme"
    accepted(crosscheck, tmp_path, verdict(EULER, green()), verdict(gone, green()))
    offers(verdict(EULER, green()))
    done = crosscheck(*RUN, "--junit", "junit.xml")
    assert done.status == 4
    assert f"no longer tested: 1\n  {gone} [refimpl]: pass before; the case is not there\n" in done.out
    error = ET.parse("junit.xml").find("testsuite[@name='crosscheck']/testcase/error")
    assert error is not None
    assert gone in error.attrib["message"]


@pytest.mark.parametrize(
    ("name", "engine", "tier", "words", "covered"),
    [
        (f"{CHECK}/old", "refimpl", "quick", [CHECK, "-e", "refimpl"], True),
        (f"{CHECK}/old", "refimpl", "quick", ["stepping/oscillator-e*", "-e", "refimpl"], True),
        (f"{CHECK}/old", "refimpl", "quick", [EULER, "-e", "refimpl"], False),
        (f"{CHECK}/old", "refimpl", "quick", [EULER, f"{CHECK}/o*", "-e", "refimpl"], True),
        ("events/old/one", "refimpl", "quick", [CHECK, "-e", "refimpl"], False),
        (f"{CHECK}/old", "lammps", "quick", [CHECK, "-e", "refimpl"], False),
        (f"{CHECK}/old", "not_installed_any_more", "quick", [CHECK], True),
        (f"{CHECK}/old", "refimpl", "full", [CHECK, "-e", "refimpl"], False),
        (f"{CHECK}/old", "refimpl", "full", [CHECK, "-e", "refimpl", "--tier", "full"], True),
    ],
)
def test_only_what_the_run_covers_is_compared(
    crosscheck: Command,
    offers: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    engine: str,
    tier: str,
    words: list[str],
    covered: bool,
) -> None:
    known = runner.select
    monkeypatch.setattr(
        runner, "select", lambda patterns, *more, **named: known([CHECK], *more, **named)
    )  # "old" is no case any more
    accepted(crosscheck, tmp_path, verdict(EULER, green()), verdict(name, green(), engine, tier=tier))
    offers(verdict(EULER, green()))
    done = crosscheck("run", *words, "--baseline", "crosscheck-baseline.txt")
    assert done.status == (4 if covered else 0), done.out
    assert ("no longer tested" in done.out) == covered


def test_a_baseline_that_cannot_be_read_is_known_before_the_run(crosscheck: Command, tmp_path: Path) -> None:
    for text, message in ((None, "no baseline (No such file or directory)"), ("# particle-crosscheck\n", ":1: not a")):
        if text is not None:
            Path("crosscheck-baseline.txt").write_text(text)
        done = crosscheck(*RUN)
        assert (done.status, done.out) == (2, "")
        assert message in done.err
        assert len(done.err.splitlines()) == 1
        assert not Path("crosscheck-out").exists()


def test_an_engine_that_was_named_must_be_judged_whatever_is_known(
    crosscheck: Command, offers: Any, tmp_path: Path
) -> None:
    accepted(crosscheck, tmp_path, verdict(EULER, "skip"))
    offers(verdict(EULER, "skip"))
    done = crosscheck(*RUN)
    assert done.status == 4
    assert done.err == "crosscheck: nothing was judged: 1 skipped (it is Monday)\n"


def test_the_summary_of_a_run(
    crosscheck: Command, offers: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    accepted(crosscheck, tmp_path, verdict(EULER, green()), verdict(VERLET, red()))
    offers(verdict(EULER, red()), verdict(VERLET, red()))
    monkeypatch.setenv(VARIABLE, "server.md")
    assert crosscheck(*RUN, "--summary", "own.md").status == 1
    text = Path("own.md").read_text()
    assert Path("server.md").read_text() == text
    assert text.startswith("## particle-crosscheck\n\n**2 fail**\n")
    assert text.index("### Not green") < text.index("### new failures: 1") < text.index("### not green, as before: 1")
    assert "<code>crosscheck run stepping/oscillator-exact -e refimpl" in text


@pytest.mark.parametrize("words", [RUN[:-2], ("diff", "before", "before")])
def test_a_summary_that_cannot_be_written_is_known_before_the_run(
    crosscheck: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    record(tmp_path / "before", verdict(EULER, green()))
    done = crosscheck(*words, "--summary", tmp_path)
    assert (done.status, done.out) == (2, "")
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    assert crosscheck(*words).status == 2
    assert not Path("crosscheck-out").exists()


# -- baseline accept ------------------------------------------------------------------------------------------


def test_accept_takes_what_there_is_and_says_what_is_not_green(crosscheck: Command, tmp_path: Path) -> None:
    record(
        tmp_path / "crosscheck-out",
        verdict(EULER, green()),
        verdict(VERLET, red()),
        verdict(VERLET, vague(), "lammps"),
        verdict("a/b/c", "error"),
        verdict("a/b/d", "skip"),
    )
    done = crosscheck("baseline", "accept")
    assert (done.status, done.err) == (0, "")
    assert done.out.splitlines() == [
        "crosscheck-baseline.txt: 1 pass, 1 fail, 1 inconclusive, 1 error, 1 skip accepted; 11 lines added, 0 removed",
        "  known from now on: error a/b/c [refimpl]: it is Monday",
        "  known from now on: skip a/b/d [refimpl]: it is Monday",
        f"  known from now on: inconclusive {VERLET} [lammps]: y",
        f"  known from now on: fail {VERLET} [refimpl]: x",
    ]


def test_accept_changes_the_lines_of_the_named_checks_alone(crosscheck: Command, tmp_path: Path) -> None:
    names = (EULER, VERLET, "events/haff/2d")
    record(tmp_path / "old", *(verdict(name, green(), engine) for name in names for engine in ("refimpl", "lammps")))
    record(tmp_path / "new", *(verdict(name, red(), engine) for name in names for engine in ("refimpl", "lammps")))
    words = ["baseline", "accept", "--baseline", "new/dir/known.txt"]
    assert crosscheck(*words, "--from", "old").status == 0
    old = Path("new/dir/known.txt").read_text().splitlines()
    done = crosscheck(*words, "--from", "new", CHECK, "events/*", "-e", "lammps")
    assert done.out.startswith("new/dir/known.txt: 3 fail accepted; 3 lines added, 3 removed\n")
    new = Path("new/dir/known.txt").read_text().splitlines()
    changed = [(one, other) for one, other in zip(old, new, strict=True) if one != other]
    assert {other.split("\t")[0] for _, other in changed} == set(names)
    assert all(other.split("\t")[1:5] == ["lammps", "quick", "x", "fail"] for _, other in changed)
    crosscheck(*words, "--from", "new", VERLET)
    assert Path("new/dir/known.txt").read_text().count("\tfail\t") == 4


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["events/*"], "there: the run has no case that matches events/*"),
        (["-e", "lammps"], "there: the run has no case of the engine lammps"),
        (["--from", "nowhere"], "nowhere: there is no record.jsonl"),
        (["--baseline", "there"], "there: is a directory"),
        (["--baseline", "there/record.jsonl"], "there/record.jsonl:1: not a baseline"),
    ],
)
def test_what_cannot_be_accepted(crosscheck: Command, tmp_path: Path, words: list[str], message: str) -> None:
    record(tmp_path / "there", verdict(EULER, green()))
    done = crosscheck("baseline", "accept", *([] if "--from" in words else ["--from", "there"]), *words)
    assert (done.status, done.out) == (2, "")
    assert done.err.startswith(f"crosscheck: {message}")
    assert not Path("crosscheck-baseline.txt").exists()


# -- diff -----------------------------------------------------------------------------------------------------


def test_diff_of_directories_records_and_baselines(crosscheck: Command, tmp_path: Path) -> None:
    record(tmp_path / "old", verdict(EULER, green()), verdict(VERLET, green()))
    record(tmp_path / "new", verdict(EULER, red()), verdict(VERLET, green()))
    crosscheck("baseline", "accept", "--from", "old")
    for old in ("old", "old/record.jsonl", "crosscheck-baseline.txt"):
        done = crosscheck("diff", old, "new")
        assert done.status == 1
        assert f"new beside {old}: 4 judgements of 2 cases compared, 3 the same number" in done.out
        assert f"new failures: 1\n  {EULER} [refimpl] x: pass 0.1 (of 0 ± 1) -> fail 3 (of 0 ± 1)" in done.out
        back = crosscheck("diff", "new", old)
        assert back.status == 0
        assert "fixed: 1\n" in back.out


def test_diff_in_json_and_on_the_page_of_the_server(
    crosscheck: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record(tmp_path / "old", verdict(EULER, green()))
    record(tmp_path / "new", verdict(EULER, "skip"))
    monkeypatch.setenv(VARIABLE, "server.md")
    done = crosscheck("diff", "old", "new", "--json")
    assert done.status == 4
    document = json.loads(done.out)
    assert (document["status"], document["counts"]["no_longer_tested"]) == (4, 1)
    assert "### no longer tested: 1\n\n| case | engine |" in Path("server.md").read_text()


@pytest.mark.parametrize(("old", "new"), [("old", "nowhere"), ("nowhere", "old"), ("old", "engine.py")])
def test_diff_of_what_is_no_result(crosscheck: Command, tmp_path: Path, old: str, new: str) -> None:
    record(tmp_path / "old", verdict(EULER, green()))
    Path("engine.py").write_text("print()\n")
    done = crosscheck("diff", old, new)
    assert (done.status, done.out) == (2, "")
    assert len(done.err.splitlines()) == 1


# -- an engine that changes -----------------------------------------------------------------------------------

EXAMPLE = Path(__file__).parents[3] / "examples" / "my_engine.py"


def test_an_engine_that_refuses_what_it_was_judged_by_is_seen(crosscheck: Command, tmp_path: Path) -> None:
    """No promise is asked for: each refusal is a skip, or a scene less in a case that stays green."""
    text = EXAMPLE.read_text(encoding="utf-8")
    engine = tmp_path / "my_engine.py"
    words = ["run", "stepping/spring-features", "stepping/oscillator-exact", "-e", "my_engine.py:MyEngine"]
    engine.write_text(text)
    assert crosscheck(*words).status == 0
    assert crosscheck("baseline", "accept").status == 0
    refuses = "        if scene.spring is not None and scene.dimension != 2:\n            return 'in the plane alone'\n"
    old = "        return None if scene.number"
    assert text.count(old) == 1
    engine.write_text(text.replace(old, refuses + old))
    assert crosscheck(*words).status == 0, "nobody sees it"
    done = crosscheck(*words, "--baseline", "crosscheck-baseline.txt")
    assert done.status == 4
    assert "no longer tested: 2\n" in done.out
    assert "oscillator-exact/velocity_verlet [my_engine.py:MyEngine]: pass before; skipped: " in done.out
    assert "spring-features/rows-0 [my_engine.py:MyEngine]: scenes that the engine refuses: 0 before, " in done.out


def test_what_a_budget_left_out_is_not_compared_with_the_baseline(tmp_path: Path, crosscheck: Command) -> None:
    old = record(tmp_path / "old", verdict(EULER, green()), verdict(VERLET, green()))
    assert crosscheck("baseline", "accept", "--from", old, "--baseline", tmp_path / "known").status == 0
    against = Against(tmp_path / "known", [], "quick", [])
    for reason, status in ((f"{LEFT_OUT}: predicted 340 s", 0), ("the engine has no springs", 4)):
        left = Verdict(CHECK, "velocity_verlet", "refimpl", "skip", None, reason)
        new = record(tmp_path / str(status), verdict(EULER, green()), left)
        assert against.difference(read(new), new).status() == status
