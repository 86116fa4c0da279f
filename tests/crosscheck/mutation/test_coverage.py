"""The map of executed lines is kept, and recorded again when a source changes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import TracebackType

import pytest

import refimpl
from crosscheck.checks import all_checks, declared_in
from crosscheck.mutation import coverage
from crosscheck.mutation.coverage import executed_lines, sources_of
from crosscheck.mutation.judge import Answer
from crosscheck.runner import Case

RULES = Path(refimpl.__path__[0]) / "events" / "rules.py"
CASES = [Case("events/haff", "2d-0.9", "refimpl", False), Case("events/maxwell", "2d", "refimpl", False)]


class _Fake:
    """Answers in place of a process: each case executes lines 3 and 5 of the rules, line 1 at the import."""

    asked: list[str] = []

    def __init__(self, *, records: bool = False) -> None:
        pass

    def __enter__(self) -> _Fake:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def judge(self, case: Case, seed: int, limit: float) -> Answer:
        self.asked.append(case.name)
        return Answer("pass", "", 1.0, {"run": {str(RULES): [3, 5]}, "import": {str(RULES): [1]}})


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[str]:
    monkeypatch.setattr(coverage, "Judge", _Fake)
    monkeypatch.setattr(coverage, "kernel_cache", lambda: tmp_path)
    _Fake.asked = []
    return _Fake.asked


def test_what_is_known_is_not_recorded_again(asked: list[str], tmp_path: Path) -> None:
    first = executed_lines(CASES, 0, 2)
    assert [one.case for one in first] == CASES
    assert sorted(asked) == ["events/haff/2d-0.9", "events/maxwell/2d"]
    assert first[0].lines == {"refimpl/events/rules.py": frozenset({3, 5})}
    assert executed_lines(CASES, 0, 1) == first
    assert len(asked) == 2
    executed_lines(CASES[:1], 1, 1)  # another seed of the suite, other scenes
    assert len(asked) == 3
    path = tmp_path / "executed-lines.jsonl"
    path.write_text(path.read_text() + '{"case": ')  # torn
    assert executed_lines(CASES, 0, 1) == first


def test_a_check_whose_sources_changed_is_recorded_again(asked: list[str], tmp_path: Path) -> None:
    executed_lines(CASES, 0, 1)
    path = tmp_path / "executed-lines.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    lines[0]["sources"] = "of another time"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    executed_lines(CASES, 0, 1)
    assert asked == ["events/haff/2d-0.9", "events/maxwell/2d", "events/haff/2d-0.9"]


def test_every_check_is_declared_in_a_file_of_its_group() -> None:
    """Also those whose `judge` is a function of another module, or a partial one."""
    places = declared_in()
    assert sorted(places) == [check.name for check in all_checks()]
    assert all(place.startswith(f"crosscheck.checks.{name.partition('/')[0]}.") for name, place in places.items())


def test_the_sources_of_a_check_are_what_it_imports() -> None:
    assert sources_of("events/haff") != sources_of("lattice/reversal")
    imported = coverage._imported("crosscheck.checks.events.haff")
    assert {"crosscheck.verdict", "crosscheck.scene.parts", "crosscheck.engines.registry"} <= imported
    assert "crosscheck.commands.running" not in imported


def test_lines_of_a_run_and_of_an_import(asked: list[str]) -> None:
    one = executed_lines(CASES, 0, 1)[0]
    file = "refimpl/events/rules.py"
    assert one.executes(file, 4, 9)
    assert one.executes(file, 1, 2)
    assert not one.executes(file, 6, 9)
    assert not replace(one, imported={}).executes(file, 1, 2)
