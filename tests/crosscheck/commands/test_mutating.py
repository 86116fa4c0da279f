"""The command that draws mutants: what it keeps, prints, completes and refuses."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from crosscheck.commands import Sample, mutate, mutating
from crosscheck.engines.workers.ending import Interrupted
from crosscheck.errors import UsageError
from crosscheck.mutation.coverage import Executed
from crosscheck.mutation.draw import Mutant
from crosscheck.mutation.trial import Outcome

SAMPLE = Sample(6, 3, "quick", ("events/maxwell",), ("events/rules",), "refimpl")


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the mutants that are judged; every second one is caught. No process is started."""
    names: list[str] = []

    def judged(mutant: Mutant, executed: Sequence[Executed], seed: int, most_compiled: int) -> Outcome:
        names.append(mutant.name)
        caught = len(mutant.after) % 2 == 0
        return Outcome(caught, "events/maxwell/2d [refimpl]" if caught else "", "red" if caught else "", 1, 0, 0.5)

    monkeypatch.setattr(mutating, "try_mutant", judged)
    monkeypatch.setattr(mutating, "executed_lines", lambda cases, seed, jobs, tell: [])
    return names


def score(directory: Path) -> dict[str, object]:
    record: dict[str, object] = json.loads((directory / mutating.SCORE).read_text())
    return record


def test_each_mutant_is_judged_once_and_the_score_is_kept(
    tried: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert mutate(SAMPLE, 1, tmp_path, None) == 0
    assert len(tried) == len(set(tried)) == 6
    record = score(tmp_path)
    assert record["judged"] == 6
    assert record["seed"] == 3
    options = "--tier quick --population refimpl --module events/rules"
    assert record["command"] == f"crosscheck prove events/maxwell --mutate 6 --seed 3 {options}"
    out = capsys.readouterr().out
    assert "[6/6]" in out
    assert f"{record['caught']} of 6 caught" in out
    assert out.count("\n--- refimpl/events/rules.py") == record["survived"]


def test_an_interrupted_sample_is_completed(
    tried: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mutate(SAMPLE, 1, tmp_path / "whole", None)
    whole = score(tmp_path / "whole")
    say = mutating._say

    def interrupting(text: str) -> None:
        say(text)
        if text.startswith("[2/6]"):
            raise Interrupted(130)

    with monkeypatch.context() as patch:
        patch.setattr(mutating, "_say", interrupting)
        with pytest.raises(Interrupted):
            mutate(SAMPLE, 1, tmp_path / "parts", None)
    assert score(tmp_path / "parts")["judged"] == 2
    assert "--resume" in capsys.readouterr().out
    path = tmp_path / "parts" / mutating.MUTANTS
    path.write_text(path.read_text() + '{"number": 5, "na')  # torn
    tried.clear()
    mutate(SAMPLE, 1, tmp_path / "unused", tmp_path / "parts")
    assert len(tried) == 4
    assert score(tmp_path / "parts") == whole
    mutate(SAMPLE, 1, tmp_path / "unused", tmp_path / "parts")  # nothing is left to be judged
    assert len(tried) == 4
    assert not (tmp_path / "unused").exists()


def test_the_full_tier_judges_again_what_survived_the_quick_one(tried: list[str], tmp_path: Path) -> None:
    mutate(SAMPLE, 1, tmp_path, None)
    quick, lines = score(tmp_path), (tmp_path / mutating.MUTANTS).read_text().splitlines()[1:]
    survivors = [line["name"] for line in map(json.loads, lines) if not line["caught"]]
    assert 0 < len(survivors) < 6
    tried.clear()
    mutate(SAMPLE._replace(tier="full"), 1, tmp_path / "unused", tmp_path)
    assert tried == survivors
    assert score(tmp_path) == quick | {"tier": "full", "command": str(quick["command"]).replace("quick", "full")}
    mutate(SAMPLE._replace(tier="full"), 1, tmp_path / "unused", tmp_path)
    assert tried == survivors
    with pytest.raises(UsageError, match="it has tier full, not quick"):
        mutate(SAMPLE, 1, tmp_path / "unused", tmp_path)


def test_another_sample_is_not_completed(tried: list[str], tmp_path: Path) -> None:
    mutate(SAMPLE, 1, tmp_path, None)
    with pytest.raises(UsageError, match="it has seed 3, not 4: draw a new sample"):
        mutate(SAMPLE._replace(seed=4), 1, tmp_path, tmp_path)
    with pytest.raises(UsageError, match="there is no sample to be completed"):
        mutate(SAMPLE, 1, tmp_path, tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("sample", "message"),
    [
        (SAMPLE._replace(tier="slow"), "--tier slow: unknown"),
        (SAMPLE._replace(population="tests"), "--population tests: unknown"),
        (SAMPLE._replace(modules=("nowhere",)), "--module nowhere: no file of refimpl matches"),
        (SAMPLE._replace(checks=("nothing/*",)), "no check matches nothing/"),
    ],
)
def test_bad_usage_is_refused_before_anything_is_made(sample: Sample, message: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=message):
        mutate(sample, 1, tmp_path / "out", None)
    assert not (tmp_path / "out" / mutating.MUTANTS).exists()
