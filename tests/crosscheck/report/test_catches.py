"""The tables of what the suite catches."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

from crosscheck.checks import all_checks
from crosscheck.checks.base import FeatureRows
from crosscheck.pairs import Pair, Row
from crosscheck.report import html
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


def test_the_page_shows_the_score_its_date_its_command_and_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    bug = {"name": "refimpl/a.py:3 sign", "function": "f", "reason": "", "diff": "-a < b\n+a <= b"}
    score = {
        "date": "2026-01-02",
        "command": "crosscheck prove --mutate 10 --seed 5",
        "population": "refimpl",
        "modules": [],
        "tier": "quick",
        "confidence": 0.95,
        "caught": 9,
        "survived": 1,
        "equivalent": 2,
        "interval": [0.555, 0.9975],
        "not_caught": [bug],
    }
    check = replace(all_checks()[0], features=FeatureRows(FACTORS, rows))
    monkeypatch.setattr(html, "scores", lambda: [score])
    monkeypatch.setattr(html, "together", lambda checks: together([check]))
    page = html.render([], "a run")
    section = page[page.index('<h2 id="catches">') : page.index("<footer>")]
    text = re.sub(r"<[^>]*>", " ", section)
    for words in ("2026-01-02", "crosscheck prove --mutate 10 --seed 5", "90.0 %", "55.5 to 99.8 %", "a &lt; b", "5/5"):
        assert words in text, words
    assert "10 scenes" in text


def test_a_page_without_score_and_features_has_no_such_section(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(html, "scores", list)
    assert "catches" not in html.render([], "a run")
