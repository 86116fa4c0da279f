"""The matrix of extreme cases: what its rows demand, how answers are compared, and that every case has rows."""

from __future__ import annotations

import math
from typing import Any

import pytest

from crosscheck.checks import all_checks
from crosscheck.checks.base import Laboratory
from crosscheck.checks.extreme.matrix import (
    GROUP,
    RAN,
    Answer,
    Bound,
    Case,
    Mean,
    Measured,
    Row,
    Trial,
    Value,
    for_each,
    judge,
)
from crosscheck.engines.protocol import Claims, Run
from crosscheck.errors import EngineError, Unsupported, UsageError
from crosscheck.scene import Explicit, Scene, Spring

CHECKS = [check for check in all_checks() if check.name.startswith(GROUP)]


class Worker:
    """An engine that returns a run, or raises what it is given."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def worker(self, name: str, interpreted: bool = False) -> Worker:
        return self

    def run(self, scene: Scene, method: Any, **more: Any) -> Run:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer  # type: ignore[no-any-return]


def trial(answer: Any = None, engine: str = "refimpl") -> Trial:
    return Trial(Laboratory(engine, {"leapfrog": Claims()}, Worker(answer), "x/y"), "leapfrog")  # type: ignore[arg-type]


def scene() -> Scene:
    return Scene(name="s", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (Run(), RAN),
        (Run(diverged=True), "diverged"),
        (Run(stopped="a reason"), "stopped: a reason"),
        (Run(remarks=("One.", "Two.")), "remarked: One. Two."),
        (Unsupported("no"), "refused: no"),
        (UsageError("mend it"), "refused: mend it"),
        (EngineError("ERROR: what\nlast lines"), "failed: ERROR: what"),
    ],
)
def test_answers_in_words(answer: Any, words: str) -> None:
    found, run = trial(answer).answer(scene, 0.1)
    assert found == words
    assert (run is None) == isinstance(answer, Exception)


def test_a_scene_that_cannot_be_made_is_refused() -> None:
    found, run = trial(Run()).answer(
        lambda: Scene(name="s", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=())), 0.1
    )
    assert found == "refused: scene: initial.positions is empty: give at least one particle"
    assert run is None


@pytest.mark.parametrize(
    ("expected", "measured", "green"),
    [
        (Value("q", 1.0, 0.1, "w"), 1.05, True),
        (Value("q", 1.0, 0.1, "w"), 1.2, False),
        (Value("q", 1.0, 0.1, "w"), math.nan, False),
        (Bound("q", 2.0, "w"), 2.0, True),
        (Bound("q", 2.0, "w"), 2.1, False),
        (Bound("q", 2.0, "w"), math.nan, False),
        (Bound("q", 2.0, "w", at_least=True), 1.9, False),
    ],
)
def test_numbers(expected: Any, measured: float, green: bool) -> None:
    assert (expected.judged(Measured({"q": measured})).outcome == "pass") == green


def test_a_mean_is_judged_by_its_standard_error() -> None:
    for number, outcome in ((0.52, "pass"), (0.9, "fail")):
        measured = Measured({"q": number}, errors={"q": (0.02, 30.0)})
        assert Mean("q", 0.5, "w").judged(measured).outcome == outcome


@pytest.mark.parametrize(
    ("found", "shipped", "green"),
    [
        ("refused: no", True, True),
        ("refused: never", True, False),
        ("refused: never", False, True),
        (RAN, False, False),
        ("diverged", True, False),
    ],
)
def test_words_are_exact_for_the_engines_of_the_suite(found: str, shipped: bool, green: bool) -> None:
    judgement = Answer("refused: no", "w").judged(Measured({}, found, shipped=shipped))
    assert (judgement.outcome == "pass") == green
    assert found in judgement.note


def test_without_a_colon_the_kind_counts() -> None:
    assert Answer("failed", "w").judged(Measured({}, "failed: by LAMMPS")).outcome == "pass"
    assert Answer(RAN, "w").judged(Measured({}, "remarked: something")).outcome == "fail"


def test_an_engine_may_have_expectations_of_its_own() -> None:
    rows = {**for_each(("leapfrog",), Bound("q", 1.0, "w")), "leapfrog@lammps": (Bound("q", 2.0, "w"),)}
    case = Case("c", "what", lambda one: {"q": 1.5}, rows)
    assert case.methods == ["leapfrog"]
    for engine, outcome in (("refimpl", "fail"), ("lammps", "pass")):
        assert judge(trial(engine=engine).laboratory, Row(case, "leapfrog")).outcome == outcome


def test_a_quantity_that_was_not_measured_is_no_success() -> None:
    case = Case("c", "what", lambda one: {}, for_each(("leapfrog",), Bound("q", 1.0, "w")))
    with pytest.raises(KeyError):
        judge(trial().laboratory, Row(case, "leapfrog"))


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)
def test_rows_have_expectations_with_reasons(check: Any) -> None:
    from crosscheck.engines.registry import engine_class, shipped_engines

    rows = [variant.value for engine in shipped_engines() for variant in check.offered(engine_class(engine).schemes)]
    assert rows
    for row in rows:
        for engine in shipped_engines():
            expected = row.case.expectations(row.method, engine)
            assert expected
            quantities = [one.quantity for one in expected if not isinstance(one, Answer)]
            assert len(set(quantities)) == len(quantities)
            assert all(one.why.strip() and one.text.strip() for one in expected)
