"""Which verdicts catch a mutant, by which cases it is judged, and what is left of it."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from types import TracebackType

import pytest

from crosscheck.mutation import trial
from crosscheck.mutation.coverage import Executed
from crosscheck.mutation.draw import Mutant, draw, population
from crosscheck.mutation.judge import Answer
from crosscheck.mutation.operators import Mutation
from crosscheck.mutation.trial import overlay, remove_leftovers, to_be_judged, try_mutant
from crosscheck.runner import Case

FILE = "refimpl/events/rules.py"


def mutant(binds: tuple[str, ...] | None = None) -> Mutant:
    mutation = Mutation("constant", 0, 1, "2", 3, "f", 3, 4, binds)
    return Mutant("refimpl", "events/rules.py", mutation, "a\n", "b\n")


def case(name: str, seconds: float, interpreted: bool = True, lines: tuple[int, ...] = (3,)) -> Executed:
    check, _, variant = name.rpartition("/")
    return Executed(
        Case(check, variant, "refimpl", False), 0, "", "pass", seconds, interpreted, {FILE: frozenset(lines)}, {}
    )


class _Fake:
    """Answers from a table in place of a process."""

    outcomes: dict[str, str] = {}
    asked: list[tuple[str, float]] = []

    def __init__(self, overlay: Path, caches: Path | None) -> None:
        pass

    def __enter__(self) -> _Fake:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def judge(self, case: Case, seed: int, limit: float) -> Answer:
        self.asked.append((case.name, limit))
        return Answer(self.outcomes.get(case.name, "pass"), "why", 1.0)


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> type[_Fake]:
    monkeypatch.setattr(trial, "Judge", _Fake)
    _Fake.outcomes, _Fake.asked = {}, []
    return _Fake


def test_the_cheapest_interpreted_cases_come_first_then_some_compiled_ones_of_each_check() -> None:
    compiled = [case(f"c/slow/{k}", 10.0 + k, False) for k in range(4)] + [
        case(f"c/fast/{k}", 1.0 + k, False) for k in range(4)
    ]
    plain = [case("a/b/c", 9.0), case("a/b/d", 2.0), case("a/b/e", 1.0, lines=(5,))]
    found, left = to_be_judged(mutant(), [*compiled, *plain], 5)
    assert [one.case.name for one in found] == [
        "a/b/d",
        "a/b/c",
        "c/fast/0",
        "c/slow/0",
        "c/fast/1",
        "c/slow/1",
        "c/fast/2",
    ]
    assert len(found) == 2 + 5
    assert left == 3
    others = [case("d/slowest/0", 99.0, False), case("d/slowest/1", 100.0, False)]
    found, _ = to_be_judged(mutant(), [*compiled, *others], 4)
    assert [one.case.name for one in found] == ["c/fast/0", "d/slowest/0", "c/slow/0", "d/slowest/1"]


@pytest.mark.parametrize(
    ("outcome", "caught"),
    [("fail", True), ("error", True), ("inconclusive", False), ("skip", False), ("pass", False)],
)
def test_only_what_makes_a_run_red_catches_a_mutant(fake: type[_Fake], outcome: str, caught: bool) -> None:
    fake.outcomes = {"a/b/c": outcome}
    found = try_mutant(mutant(), [case("a/b/c", 1.0), case("a/b/d", 2.0)], 0, 5)
    assert found is not None
    assert found.caught == caught
    assert found.judged == (1 if caught else 2)
    assert found.by == ("a/b/c [refimpl]" if caught else "")


def test_a_time_limit_is_many_times_what_is_usual(fake: type[_Fake]) -> None:
    cases = [case("a/b/c", 2.0), case("a/b/d", 3.0), case("a/c/e", 4.0, False), case("a/d/f", 5.0, False)]
    try_mutant(mutant(), cases, 0, 5)
    assert fake.asked == [("a/b/c", 85.0), ("a/b/d", 35.0), ("a/c/e", 225.0), ("a/d/f", 175.0)]


def test_a_constant_of_the_module_is_executed_by_who_uses_its_name() -> None:
    number = next(
        number
        for number, line in enumerate(
            (Path(population("refimpl").root) / "events" / "rules.py").read_text().splitlines(), 1
        )
        if "_S11)" in line
    )
    user, other = case("a/b/c", 1.0, lines=(number,)), case("a/b/d", 1.0, lines=(number + 1,))
    assert to_be_judged(mutant(("_S11",)), [user, other], 5)[0] == [user]
    assert to_be_judged(mutant(("no_such_name",)), [user, other], 5)[0] == [user, other]


def test_a_constant_that_another_is_made_from_is_executed_by_who_uses_that() -> None:
    file = "refimpl/stepping/integrate.py"
    lines = (Path(population("refimpl").root).parent / file).read_text().splitlines()
    number = next(number for number, line in enumerate(lines, 1) if "else SCHEMES)[name]" in line)
    user, other = (
        replace(case(f"a/b/{at}", 1.0, lines=()), lines={file: frozenset({at})}) for at in (number, number + 1)
    )
    for name in ("_GEAR5", "SCHEMES"):  # the one is an entry of the other
        assert to_be_judged(mutant((name,)), [user, other], 5)[0] == [user]


def test_a_default_value_is_executed_by_who_calls_its_function_and_by_imports_that_do() -> None:
    constant = mutant(("_S11",))
    default = replace(constant, mutation=replace(constant.mutation, line=2))
    called, other = case("called/a", 1.0), case("other/a", 1.0, lines=(7,))
    by_import = replace(case("import/a", 1.0, lines=(7,)), imported={FILE: frozenset({4})})
    assert [one.case.check for one in to_be_judged(default, [called, other, by_import], 1)[0]] == ["called", "import"]
    assert to_be_judged(constant, [by_import], 1)[0] == []


def test_a_mutant_is_a_copy_that_is_removed() -> None:
    one = draw(population("refimpl", ["events/rules"]), 1, 0)[0]
    with overlay(one) as directory:
        assert (directory / one.package / one.file).read_text() == one.after
        assert not list((directory / "refimpl" / "events" / "__pycache__").glob("rules.*"))
        files = [file.relative_to(directory / "refimpl") for file in (directory / "refimpl").rglob("*.py")]
        others = [file for file in files if file.as_posix() != one.file]
        root = population("refimpl").root
        assert all((root / file).read_bytes() == (directory / "refimpl" / file).read_bytes() for file in others)
    assert not directory.exists()


def test_what_a_killed_process_left_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    gone, own = tmp_path / f"crosscheck-mutant-{2**22 + 1}-x", tmp_path / f"crosscheck-mutant-{os.getpid()}-x"
    gone.mkdir()
    own.mkdir()
    remove_leftovers()
    assert not gone.exists()
    assert own.exists()
