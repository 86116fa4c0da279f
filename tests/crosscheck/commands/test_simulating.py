"""`crosscheck simulate --judge`: what it prints and writes, and its exit status."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from crosscheck import cli
from crosscheck.record import read
from crosscheck.simulate.judging.laws import all_laws

ORBIT = """
name = "an orbit"
dimension = 2
duration = 1.0
masses = [1.0, 0.5]
gravity = { G = 1.0 }
initial = { kind = "kepler", eccentricity = 0.3 }
output = { interval = 0.125, observables = ["kinetic_energy"] }
method = { scheme = "leapfrog", dt = 0.015625 }
"""
KICKED = """
from crosscheck.engines.refimpl import RefimplEngine

class Kicked(RefimplEngine):
    name = "kicked"
    run_from = None

    def run(self, scene, method):
        run = super().run(scene, method)
        run["final_velocities"] = run["final_velocities"] + 1e-7
        return run
"""


class Outcome(NamedTuple):
    """Exit status, output, and errors of one command."""

    status: Any
    out: str
    err: str


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path) -> Any:
    """Judges the orbit, in plain Python, with few laws and without a picture, and writes to out/."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    monkeypatch.setattr("crosscheck.simulate.run.draw_picture", lambda *_: [])
    monkeypatch.chdir(tmp_path)
    Path("orbit.toml").write_text(ORBIT)

    def call(*words: str, laws: str = "end momentum equation-of-state") -> Outcome:
        chosen = tuple(law for law in all_laws() if law.name in laws.split())
        monkeypatch.setattr("crosscheck.simulate.judging.judge.all_laws", lambda: chosen)
        monkeypatch.setattr(sys, "argv", ["crosscheck", "simulate", "orbit.toml", "-o", "out", "--judge", *words])
        with pytest.raises(SystemExit) as end:
            cli.main()
        return Outcome(end.value.code or 0, *capfd.readouterr())

    return call


def test_verdicts_are_printed_and_recorded(judged: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "record.jsonl").write_text("an old one\n")
    done = judged(laws=" ".join(law.name for law in all_laws()))
    assert done.status == 0, done.out + done.err
    assert "extra runs, or some more: less than 1 s of computing time beside compilation" in done.err
    lines = {str(line["variant"]): line for line in read(out)}
    assert set(lines) == {law.name for law in all_laws()}
    assert {line["check"] for line in lines.values()} == {"simulate/an-orbit"}
    for law, line in lines.items():
        assert (f"simulate/an-orbit/{law}" in done.out) is (line["outcome"] != "skip")
        assert (f"not judged: {law}: " in done.out) is (line["outcome"] == "skip")
    assert (out / "previous-record.jsonl").read_text() == "an old one\n"
    assert "A scene, judged by what its parts imply" in (out / "report.html").read_text()
    (head,) = (line for line in done.out.splitlines() if "time step of refimpl" in line)
    rows = done.out.partition(head)[2].splitlines()[1:4]
    assert [float(row.split()[0]) for row in rows] == [1 / 64, 1 / 128, 1 / 256]
    assert [float(row.split()[2]) for row in rows[:2]] == pytest.approx([2, 2], abs=0.1)


def test_a_broken_law_is_status_1(judged: Any, tmp_path: Path) -> None:
    (tmp_path / "kicked.py").write_text(KICKED)
    done = judged("-e", "refimpl", "-e", "kicked.py:Kicked")
    assert done.status == 1
    outcomes = {line["engine"]: line["outcome"] for line in read(tmp_path / "out") if line["variant"] == "momentum"}
    assert outcomes == {"refimpl": "pass", "kicked.py-Kicked": "fail"}


def test_inconclusive_is_status_3_and_can_be_allowed(judged: Any) -> None:
    done = judged("--tolerance", "1e-14", laws="end time-step")
    assert done.status == 3
    assert "1 inconclusive: see --allow-inconclusive" in done.err
    assert judged("--tolerance", "1e-14", "--allow-inconclusive", laws="end time-step").status == 0


def test_that_a_run_ended_judges_nothing(judged: Any) -> None:
    done = judged(laws="end equation-of-state")
    assert done.status == 4
    assert "nothing was judged: 1 skipped (equation-of-state: none is known for [gravity])" in done.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--judge", "--restart", "restart.npz"], "--judge"),
        (["--tolerance", "0.1"], "--tolerance is for verdicts: add --judge"),
        (["--allow-inconclusive"], "--allow-inconclusive is for verdicts: add --judge"),
        (["--judge", "--tolerance", "2"], "give a number between 0 and 1"),
    ],
)
def test_what_cannot_be_judged_is_refused(
    words: list[str], message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("orbit.toml").write_text(ORBIT)
    monkeypatch.setattr(sys, "argv", ["crosscheck", "simulate", "orbit.toml", *words])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 2
    assert message in capsys.readouterr().err.replace("\n", " ")
    assert not Path("crosscheck-out").exists()


def test_the_docs_name_every_law() -> None:
    page = (Path(__file__).parents[3] / "docs" / "simulate.md").read_text(encoding="utf-8")
    assert all(f"| `{name}` |" in page for name in [*(law.name for law in all_laws()), "agreement"])
