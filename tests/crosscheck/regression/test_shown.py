"""A difference as a user, a page and a script see it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from two_results import ENGINE, KEY, bound, by_tolerance, judged, results, statistical

from crosscheck.regression import shown
from crosscheck.regression.difference import CATEGORIES, Difference, Entry, compare
from crosscheck.regression.results import Case, Number, Results

MOST = "what two right runs differ by at most"
PAGE = Path(__file__).parents[3] / "docs" / "regression.md"


@pytest.fixture
def difference() -> Difference:
    old = judged(
        slope=by_tolerance(0.01, tolerance=0.25),
        red=by_tolerance(2.0, "fail"),
        u=statistical(1.0, 0.01, expected=1.0),
        gone=bound(1.0, 2.0),
    )
    new = judged(
        slope=by_tolerance(1.0, "fail", 0.25),
        red=by_tolerance(2.0, "fail"),
        u=statistical(1.5, 0.02, expected=1.0),
    )
    others = {(f"a/many/{number}", ENGINE): judged(x=bound(1.0, 2.0)) for number in range(6)}
    refused = {key: Case("quick", "skip", "it is Monday") for key in others}
    return compare(
        replace(results(old), name="old", cases={KEY: old, **others}),
        replace(results(new), name="new", cases={KEY: new, **refused}),
    )


def test_lines(difference: Difference) -> None:
    assert list(shown.lines(difference)) == [
        "new beside old: 3 judgements of 1 cases compared, 1 the same number to the last bit",
        "new failures: 1",
        "  a/b/c [mine] slope: pass 0.01 (of 0 ± 0.25) -> fail 1 (of 0 ± 0.25)",
        "changed beyond uncertainty: 1",
        f"  a/b/c [mine] u: pass 1.000(10) (of 1) -> pass 1.500(20) (of 1); moved by 6.8 times {MOST}",
        "no longer tested: 7",
        "  a/b/c [mine]: 1 of 4 judgements are not there: gone",
        "  a/many: 0, 1, 2 and 3 more [mine]: pass before; skipped: it is Monday",
        "not green, as before: 1",
        "  a/b/c [mine] red: fail 2 (of 0 ± 1) -> fail 2 (of 0 ± 1)",
        "computing times are not compared: there are too few cases of other engines beside refimpl",
        "false alarms: 1 numbers are compared by standard errors: of two right runs with other random numbers, any of "
        "them changes beyond uncertainty with the probability 0.001",
    ]


def test_sections(difference: Difference) -> None:
    found = {one.title: one for one in shown.sections(difference)}
    assert list(found) == [
        "new failures: 1",
        "changed beyond uncertainty: 1",
        "no longer tested: 7",
        "not green, as before: 1",
    ]
    assert found["no longer tested: 7"].rows[1] == (
        "a/many: 0, 1, 2 and 3 more", ENGINE, "", "", "", "pass before; skipped: it is Monday",
    )  # fmt: skip
    assert not any(one.folded for one in found.values())


def test_long_lists_end_with_a_number() -> None:
    old = {f"x{number}": by_tolerance(0.1) for number in range(60)}
    new = {name: by_tolerance(2.0, "fail") for name in old}
    found = list(shown.lines(compare(results(judged(**old)), results(judged(**new)))))
    assert found[52] == "  and 10 more"
    fixed = list(shown.lines(compare(results(judged(**new)), results(judged(**old)))))
    assert "  and 55 more" in fixed


def test_nothing_in_common() -> None:
    nothing = Results("nothing", {}, 0)
    assert next(iter(shown.lines(compare(nothing, nothing)))) == "nothing beside nothing: no case was judged in both"


def test_numbers_without_a_value() -> None:
    difference = compare(results(judged(x=by_tolerance(2.0, "fail"))), results(judged(x=by_tolerance(None, "fail"))))
    (line,) = (one for one in shown.lines(difference) if "->" in one)
    assert line == (
        f"  a/b/c [mine] x: fail 2 (of 0 ± 1) -> fail not finite (of 0 ± 1); moved by more than {MOST}; it failed "
        "otherwise before"
    )


def test_json_is_as_the_page_says(difference: Difference) -> None:
    document: dict[str, Any] = json.loads(json.dumps(shown.as_json(difference), allow_nan=False))
    assert document["form"] == 1
    assert (document["old"], document["new"], document["status"]) == ("old", "new", 1)
    assert document["compared"] == {"cases": 1, "judgements": 3, "same": 1, "by_standard_errors": 1}
    assert {name: count for name, count in document["counts"].items() if count} == {
        "new_failure": 1, "changed": 1, "no_longer_tested": 7, "known": 1,
    }  # fmt: skip
    first = document["entries"][0]
    assert first["case"] == "a/b/c"
    assert first["new"]["measured"] == 1.0
    assert first["share"] == pytest.approx(7.92)
    text = PAGE.read_text(encoding="utf-8")
    section = text[text.index("## For scripts") : text.index("## CI")]
    named = set(re.findall("`([a-z_]+)`", section.replace("entries[].", "").replace("`.", "`")))
    for part in (document, document["compared"], first, first["new"]):
        assert set(part) <= named
    assert set(first["new"]) == set(Number._fields)
    assert set(first) == set(Entry._fields)


def test_the_page_has_every_category_with_its_status() -> None:
    text = PAGE.read_text(encoding="utf-8")
    rows = [row for row in text.splitlines() if row.startswith("| ") and "(`" in row]
    found = {name: int(row.rstrip("| ").rpartition("| ")[2]) for row in rows for name in re.findall("`([a-z_]+)`", row)}
    assert {name: found[name] for name in CATEGORIES} == {name: int(kind.status) for name, kind in CATEGORIES.items()}
    order = [name for row in rows for name in re.findall("`([a-z_]+)`", row) if name in CATEGORIES]
    assert set(order) == set(CATEGORIES)
