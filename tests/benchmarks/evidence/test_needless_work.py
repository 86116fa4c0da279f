"""benchmarks/evidence/needless_work.py: where work can be put, and what the sources then are."""

from __future__ import annotations

import ast
from typing import Any

import pytest
from benchmark_modules import benchmark_named


@pytest.fixture(scope="module")
def script() -> Any:
    return benchmark_named("evidence/needless_work")


def test_every_kind_has_places_and_gives_python(script: Any) -> None:
    statements = script.places()
    assert len(statements) > 500
    for kind in (script.AGAIN, *script.LOOPS):
        where = list(script.candidates(statements, kind))
        assert where
        valid = 0
        for place, array in where[:: max(1, len(where) // 8)]:
            fault = script.with_more(place, kind, array)
            assert len(fault.new) > len(fault.old)
            valid += script._compiles(fault.new)
        assert valid >= 6  # an elif has no place before it


def test_a_loop_stands_before_its_statement(script: Any) -> None:
    place, array = next(
        (place, array)
        for place, array in script.candidates(script.places(), "all particles")
        if place.function == "own_event"
    )
    fault = script.with_more(place, "all particles", array)
    line = place.statement.lineno
    assert fault.new.splitlines()[line - 1].lstrip().startswith("for _k in range(particles.rows.shape[0]):")
    assert fault.new.splitlines()[line + 2] == fault.old.splitlines()[line - 1]


def test_counts_alone_are_no_work(script: Any) -> None:
    function = ast.parse("def f(counts):\n    tick(counts, 0, 1)\n    update(counts)\n").body[0]
    first, second = function.body  # type: ignore[attr-defined]
    where = [script.Place("f.py", "f", frozenset({"counts"}), one) for one in (first, second)]
    assert [script.repeatable(one) for one in where] == [False, True]


def test_growth_is_by_scheduler(script: Any) -> None:
    usual = {variant: [("a", 100)] * len(known) for variant, known in script.KNOWN.items()}
    found = usual | {"spheres": [("a", 100), ("a", 150)]}
    more = script.growth(usual, found)
    assert more["event_driven_neighbours"] == 0.5
    assert more["event_driven"] == 0.0
