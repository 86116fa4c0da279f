"""Shares and their intervals."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from scipy.stats import binom

from crosscheck.mutation.draw import Mutant, draw, population
from crosscheck.mutation.equivalents import ANY, Equivalent
from crosscheck.mutation.score import Count, as_record, by_operator, counted, counted_by, judged, write
from crosscheck.mutation.trial import Outcome

CAUGHT = Outcome(True, "events/haff/2d [refimpl]", "red", 1, 0, 2.0)
SURVIVED = Outcome(False, "", "", 3, 1, 4.0)


def mutants(number: int) -> list[Mutant]:
    return draw(population("refimpl", ["events/rules"]), number, 0)


def test_the_ends_of_the_interval_are_those_of_clopper_and_pearson() -> None:
    low, high = Count(180, 20).interval
    assert binom.sf(179, 200, low) == pytest.approx(0.025, rel=1e-6)
    assert binom.cdf(180, 200, high) == pytest.approx(0.025, rel=1e-6)
    assert Count(180, 20, 7).share == 0.9
    assert Count(0, 0).interval == (0.0, 1.0)
    assert math.isnan(Count(0, 0, 3).share)


def test_a_survivor_is_equivalent_only_if_an_entry_says_so() -> None:
    one, other = mutants(2)
    entry = Equivalent("refimpl/events/rules.py", one.mutation.function, one.lines[0], one.lines[1], "a reason")
    assert judged(one, SURVIVED, [entry]).state == "equivalent"
    assert judged(one, CAUGHT, [entry]).state == "caught"
    assert judged(other, SURVIVED, [entry]).state == "survived"
    anything = Equivalent(entry.file, entry.function, entry.before, ANY, "a reason")
    assert anything.matches(one)


def test_tables_add_up() -> None:
    found = [judged(one, CAUGHT if k % 3 else SURVIVED, []) for k, one in enumerate(mutants(9))]
    assert counted(found) == Count(6, 3, 0)
    by = counted_by(found, by_operator)
    assert sum(one.caught for one in by.values()) == 6
    assert sum(one.survived for one in by.values()) == 3


def test_the_record_is_json_with_the_diffs_of_those_that_were_not_caught(tmp_path: Path) -> None:
    found = [judged(one, SURVIVED, []) for one in mutants(2)]
    write(tmp_path / "score.json", as_record(found, {"date": "2020-01-01", "command": "crosscheck prove"}))
    record = json.loads((tmp_path / "score.json").read_text())
    assert record["survived"] == 2
    assert record["interval"][0] == 0.0
    assert [one["diff"].startswith("--- refimpl/events/rules.py") for one in record["not_caught"]] == [True, True]
