"""What a run within a budget says at its end, and that what it left out can be run later."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from command_line import Command

from crosscheck.commands.budgeting import summary_of_left_out
from crosscheck.record import case_name, is_left_out, read
from crosscheck.verdict import LEFT_OUT

EXAMPLE = Path(__file__).parents[3] / "examples" / "my_engine.py"


def line(name: str, outcome: str = "skip", seconds: float = 0.0, predicted: float | None = None) -> dict[str, Any]:
    group, phenomenon, variant = name.split("/")
    message = f"{LEFT_OUT}: not finished after {seconds:g} s" if seconds else f"{LEFT_OUT}: predicted"
    cost = {"seconds": seconds} | ({} if predicted is None else {"predicted": predicted})
    return {
        "check": f"{group}/{phenomenon}", "variant": variant, "engine": "e", "outcome": outcome,
        "message": message if outcome == "skip" else "", "cost": cost,
    }  # fmt: skip


def test_the_summary_names_the_cheapest_and_what_was_lost() -> None:
    assert summary_of_left_out([line("a/b/c", "pass")]) == ""
    lines = [
        line("a/b/c", "pass"),
        line("a/b/slow", predicted=340.0),
        *(line(f"a/d/{number}", predicted=10.0 * number) for number in (5, 2, 4)),
        line("a/e/unknown"),
        line("a/f/hung", seconds=15.0, predicted=0.1),
    ]
    assert summary_of_left_out(lines) == (
        f"{LEFT_OUT}: 6 cases, predicted 450 s; cheapest: a/d/2 [e] 20 s, a/d/4 [e] 40 s, a/d/5 [e] 50 s; "
        "not finished: a/f/hung [e] (after 15 s); checks of which nothing was judged: a/d, a/e, a/f"
    )


def test_a_run_without_time_judges_nothing_and_can_be_completed(crosscheck: Command, tmp_path: Path) -> None:
    """So little time that the speed alone takes it: not green. Then the rest, with what was left out."""
    words = ["run", "stepping/kepler-order/e0/*", "--engine", f"{EXAMPLE}:MyEngine", "--jobs", "1"]
    done = crosscheck(*words, "--out", tmp_path, "--budget", "0.01", "--junit", tmp_path / "junit.xml")
    lines = read(tmp_path)
    assert done.status == 4, done.out
    assert lines
    assert all(is_left_out(line) for line in lines)
    assert f"nothing was judged: {len(lines)} skipped ({LEFT_OUT})" in done.err
    assert f"{LEFT_OUT}: {len(lines)} case, predicted" in done.out
    skipped = [one.attrib["message"] for one in ET.parse(tmp_path / "junit.xml").getroot().iter("skipped")]
    assert len(skipped) == len(lines)
    assert all(message.startswith(LEFT_OUT) for message in skipped)

    words += ["stepping/gravity-steps", "--resume", str(tmp_path), "--budget", "100"]
    rest = crosscheck(*words)
    completed = {case_name(line): line for line in read(tmp_path)}
    assert rest.status == 0, rest.out
    assert set(completed) > {case_name(line) for line in lines}
    assert {line["outcome"] for line in completed.values()} == {"pass"}
    assert all(line["cost"]["predicted"] > 0 for line in completed.values())
    assert "fit, predicted" in rest.out
    assert LEFT_OUT not in rest.out
