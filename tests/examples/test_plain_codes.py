"""The plain codes of the examples are judged within a budget: right as they are, and red with a bug planted in them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from crosscheck.record import case_name, is_left_out, read

EXAMPLES = Path(__file__).parents[2] / "examples"


def _with_a_bug(file: str, old: str, new: str, directory: Path) -> Path:
    text = (EXAMPLES / file).read_text(encoding="utf-8")
    assert text.count(old) == 1
    copy = directory / file
    copy.write_text(text.replace(old, new), encoding="utf-8")
    return copy


@pytest.mark.parametrize(
    ("engine", "patterns", "old", "new", "judged", "left"),
    [
        (
            "plain_events.py:PlainEvents",
            ["events/audit-samples/gas-2d", "events/ideal-gas/n0.05*"],
            "self.wall_impulse[face, axis] += 2 *",
            "self.wall_impulse[face, axis] += 2.01 *",
            "events/ideal-gas/n0.05-N64",
            "events/ideal-gas/n0.05",
        ),
        (
            "plain_lennard_jones.py:PlainLennardJones",
            ["stepping/lennard-jones-forms/truncated", "stepping/lennard-jones-equation-of-state/rho0.5*"],
            "(2 * six * six - six)  #",
            "(2 * six * six - 1.0001 * six)  #",
            "stepping/lennard-jones-forms/truncated",
            "stepping/lennard-jones-equation-of-state/rho0.5-T2.0",
        ),
    ],
)
def test_a_plain_code_is_judged_in_seconds(
    tmp_path: Path, engine: str, patterns: list[str], old: str, new: str, judged: str, left: str
) -> None:
    file, _, name = engine.partition(":")
    right, wrong = f"{EXAMPLES / file}:{name}", f"{_with_a_bug(file, old, new, tmp_path)}:{name}"
    command = ["run", *patterns, "--engine", right, "--engine", wrong, "--budget", "40", "--out", str(tmp_path / "out")]
    done = subprocess.run(
        [sys.executable, "-P", "-m", "crosscheck.cli", *command],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    lines = {(case_name(line), line["engine"]): line for line in read(tmp_path / "out")}
    assert done.returncode == 1, done.stdout
    assert lines[judged, right]["outcome"] == "pass"
    assert lines[judged, wrong]["outcome"] == "fail"
    assert is_left_out(lines[left, right])
    assert f"{left} [{right}]" in done.stdout
    assert {line["outcome"] for (_, who), line in lines.items() if who == right and not is_left_out(line)} == {"pass"}
