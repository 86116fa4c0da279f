"""The tables of what the suite catches."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from pathlib import Path

from crosscheck.checks import all_checks
from crosscheck.checks.base import FeatureRows
from crosscheck.pairs import Pair, Row
from crosscheck.report.catches import scores, together

FACTORS = {"walls": ("none", "hard", "soft"), "friction": ("no", "yes"), "field": ("no", "yes")}
IMPOSSIBLE: Pair = (("walls", "none"), ("friction", "yes"))


def rows() -> tuple[list[Row], set[Pair]]:
    """All rows but those with the pair that no scene has."""
    found = [dict(zip(FACTORS, levels, strict=True)) for levels in product(*FACTORS.values())]
    return [row for row in found if not set(IMPOSSIBLE) <= set(row.items())], {IMPOSSIBLE}


def test_a_table_counts_pairs_that_occur_among_those_that_can() -> None:
    check = replace(all_checks()[0], features=FeatureRows(FACTORS, rows))
    (table,) = together([check, replace(check, features=None)])
    assert table.features == ("walls", "friction", "field")
    assert table.levels == (("hard", "soft"), ("yes",), ("yes",))
    assert table.cells[0] == ((3, 3), (5, 5), (6, 6))
    assert table.cells[1] == ((5, 5), (2, 2), (4, 4))
    assert (table.rows, table.never) == (10, 1)
    (table,) = together([replace(check, features=FeatureRows(FACTORS, lambda: (rows()[0][:1], {IMPOSSIBLE})))])
    assert table.cells[0] == ((1, 3), (1, 5), (1, 6))


def test_scores_are_read_in_the_order_of_their_names(tmp_path: Path) -> None:
    for name in ("b", "a"):
        (tmp_path / f"{name}.json").write_text(json.dumps({"population": name}))
    assert [one["population"] for one in scores(tmp_path)] == ["a", "b"]


def test_every_score_that_comes_with_the_suite_says_when_and_how_it_was_measured() -> None:
    for one in scores():
        assert {"date", "command", "seed", "tier", "population", "sources", "interval", "not_caught"} <= set(one)
        assert one["caught"] + one["survived"] + one["equivalent"] == one["judged"]
