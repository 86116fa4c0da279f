"""Each difference is in its category, and the exit status follows from these."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from two_results import ENGINE, KEY, NAME, bound, by_tolerance, judged, results, statistical

from crosscheck.record import Line, Record, read
from crosscheck.regression.baseline import accept, read_baseline
from crosscheck.regression.difference import Category, Difference, Entry, compare
from crosscheck.regression.results import Case, Number, Results, of_lines
from crosscheck.runner import Case as ToRun
from crosscheck.runner import close_pools, judge
from crosscheck.status import Status

SKIP, ERROR = Case("quick", "skip", "no gravity"), Case("quick", "error", "it crashed\nwith a trace")
GREEN, RED, VAGUE = by_tolerance(0.1), by_tolerance(2.0, "fail"), statistical(0.5, 1.0, "inconclusive")


def found(old: Case | None, new: Case | None, seed: int = 0) -> list[tuple[str, str]]:
    """Category and quantity of what differs."""
    return [(one.category, one.quantity) for one in compare(results(old), results(new, seed)).entries]


NUMBERS: list[tuple[Number | None, Number | None, str | None]] = [
    (GREEN, GREEN, None),
    (GREEN, RED, "new_failure"),
    (None, RED, "new_failure"),
    (VAGUE, statistical(0.6, 1.0, "fail"), "new_failure"),
    (RED, RED, "known"),
    (RED, by_tolerance(9.0, "fail"), "new_failure"),
    (RED, GREEN, "fixed"),
    (VAGUE, statistical(0.5, 1.0), "fixed"),
    (GREEN, by_tolerance(0.9), "changed"),
    (statistical(0.5, 1.0), statistical(99.0, 1.0), "changed"),
    (statistical(0.5, 1.0), statistical(99.0, 1.0, "inconclusive"), "changed"),
    (statistical(0.5, 1.0), VAGUE, "inconclusive"),
    (None, VAGUE, "inconclusive"),
    (VAGUE, VAGUE, "known"),
    (statistical(0.5, 1.0, "fail"), VAGUE, "known"),
    (bound(0.1, 1.0), bound(0.55, 1.0), None),
    (bound(0.1, 1.0), bound(0.65, 1.0), "nearer"),
    (bound(10.0, 1.0, sense="at_least"), bound(1.5, 1.0, sense="at_least"), "nearer"),
    (bound(0.65, 1.0), bound(0.1, 1.0), None),
]


@pytest.mark.parametrize(("old", "new", "category"), NUMBERS)
def test_categories_of_judgements(old: Number | None, new: Number | None, category: str | None) -> None:
    numbers = [{"y": GREEN} | ({} if one is None else {"x": one}) for one in (old, new)]
    assert found(*(judged(**one) for one in numbers)) == ([] if category is None else [(category, "x")])


@pytest.mark.parametrize(
    ("old", "new", "category"),
    [
        (judged(x=GREEN), None, "no_longer_tested"),
        (judged(x=RED), None, "no_longer_tested"),
        (ERROR, None, "no_longer_tested"),
        (SKIP, None, None),
        (judged(x=GREEN), SKIP, "no_longer_tested"),
        (judged(x=RED), SKIP, "no_longer_tested"),
        (SKIP, SKIP, None),
        (None, SKIP, None),
        (ERROR, SKIP, "known"),
        (judged(x=GREEN), ERROR, "could_not_run"),
        (SKIP, ERROR, "could_not_run"),
        (None, ERROR, "could_not_run"),
        (ERROR, ERROR, "known"),
        (ERROR, judged(x=GREEN), "fixed"),
        (SKIP, judged(x=GREEN), "newly_tested"),
        (None, judged(x=GREEN), "newly_tested"),
        (judged(x=GREEN, y=GREEN), judged(x=GREEN), "no_longer_tested"),
        (judged(x=GREEN), judged(x=GREEN, y=GREEN), "newly_tested"),
    ],
)
def test_categories_of_cases(old: Case | None, new: Case | None, category: str | None) -> None:
    assert found(old, new) == ([] if category is None else [(category, "")])


def test_a_failure_of_a_case_that_is_new_or_was_an_error_is_new() -> None:
    for before in (None, SKIP, ERROR):
        assert found(before, judged(x=RED, y=GREEN)) == [("new_failure", "x")]


def test_a_run_that_now_ends_early_is_one_failure_and_says_what_is_gone() -> None:
    difference = compare(results(judged(x=GREEN, y=GREEN, z=GREEN)), results(judged(early=RED)))
    assert [one.category for one in difference.entries] == ["new_failure", "no_longer_tested"]
    assert difference.entries[1].message == "3 of 3 judgements are not there: x; y; z"
    assert difference.status() == Status.FAILED


def test_scenes_that_are_refused_now_are_no_longer_tested_though_the_case_is_green() -> None:
    old = replace(judged(x=GREEN), refused=1, counters={"steps": 100})
    new = replace(old, refused=4, counters={"steps": 40})
    (one,) = compare(results(old), results(new)).entries
    assert (one.category, one.message) == ("no_longer_tested", "scenes that the engine refuses: 1 before, 4 now")
    assert found(new, old) == []
    assert found(replace(old, refused=None), new) == [("fewer_operations", "")]


def test_operations_where_the_seed_is_the_same() -> None:
    old, new = (replace(judged(x=GREEN), counters={"evaluations": n}) for n in (201, 401))
    assert found(old, new) == [("more_operations", "")]
    assert found(new, old) == [("fewer_operations", "")]
    assert found(old, new, seed=1) == []
    assert compare(results(old), results(new, 1)).remarks == (
        "numbers of operations are not compared: the seeds are 0 and 1",
        "computing times are not compared: there are too few cases of other engines beside refimpl",
    )


@pytest.mark.parametrize(
    ("categories", "status"),
    [
        ([], Status.PASSED),
        (["known", "nearer", "slower", "fewer_operations", "faster", "fixed", "newly_tested"], Status.PASSED),
        (["known", "inconclusive"], Status.INCONCLUSIVE),
        (["inconclusive", "no_longer_tested"], Status.UNJUDGED),
        (["inconclusive", "could_not_run"], Status.UNJUDGED),
        (["no_longer_tested", "new_failure"], Status.FAILED),
        (["changed"], Status.FAILED),
        (["more_operations", "could_not_run"], Status.FAILED),
    ],
)
def test_the_status_is_that_of_the_category_that_counts_first(categories: list[Category], status: Status) -> None:
    entries = tuple(Entry(category, NAME, ENGINE) for category in categories)
    made = replace(compare(results(None), results(None)), entries=entries)
    assert made.status() == status
    assert made.status(allow_inconclusive=True) == (Status.PASSED if status == Status.INCONCLUSIVE else status)


def test_nothing_in_common_is_nothing_judged() -> None:
    empty = Results("run", {}, 0)
    assert compare(results(None), results(None)).status() == Status.PASSED
    assert compare(empty, results(None)).status() == Status.UNJUDGED
    assert compare(Results("run", {KEY: SKIP}, 0), Results("run", {KEY: SKIP}, 0)).status() == Status.UNJUDGED


def test_the_level_is_shared_by_all_numbers_that_are_compared() -> None:
    """7 errors are too much for one number, and not for one of 5000."""
    far, near = {"x": statistical(7.0, 1.0)}, {"x": statistical(0.0, 1.0)}
    assert found(judged(**near), judged(**far)) == [("changed", "x")]
    many = {f"y{number}": statistical(0.0, 1.0) for number in range(50_000)}
    difference = compare(results(judged(**near, **many)), results(judged(**far, **many)))
    assert difference.errors == 50_001
    assert difference.entries == ()


def test_the_same_bits_are_expected_of_the_same_seed_versions_and_processor() -> None:
    source = {"versions": {"numpy": "2"}, "cpu": "a"}
    old, new = results(None, provenance=source), results(None, provenance=source | {"cores": 4})
    assert "same seed, versions and processor: an engine that has not changed" in compare(old, new).remarks[0]
    other = results(None, provenance=source | {"cpu": "b"})
    assert not any("same seed" in one for one in compare(old, other).remarks)


# -- real runs ------------------------------------------------------------------------------------------------

STATISTICAL = (("events/ideal-gas", "n0.05"), ("events/random-walls", "thermal-2d"), ("lattice/outcomes", "fhp1-3"))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[list[Line]]:
    """Records of statistical checks, with the seeds 1, 2 and again 1."""
    found = []
    for seed in (1, 2, 1):
        directory = tmp_path_factory.mktemp(f"seed-{seed}")
        record = Record(directory, {"seed": seed, "versions": {}, "cpu": "a", "cores": 2})
        for check, variant in STATISTICAL:
            record.append(judge(ToRun(check, variant, "refimpl", False), seed))
        found.append(read(directory))
    close_pools()
    return found


def difference(old: list[Line], new: list[Line]) -> Difference:
    return compare(of_lines(old, "old"), of_lines(new, "new"))


def test_two_right_runs_with_other_random_numbers_do_not_differ(runs: list[list[Line]]) -> None:
    found = difference(runs[0], runs[1])
    assert found.entries == ()
    assert found.status() == Status.PASSED
    assert (found.cases, found.errors) == (3, 2)
    assert found.same < found.judgements / 2
    assert found.false_alarms.startswith("false alarms: 2 numbers are compared by standard errors")


def test_two_runs_with_one_seed_have_the_same_bits(runs: list[list[Line]]) -> None:
    found = difference(runs[0], runs[2])
    assert found.entries == ()
    assert found.same == found.judgements > 20


def test_a_run_and_its_own_baseline_do_not_differ(runs: list[list[Line]], tmp_path: Path) -> None:
    run = of_lines(runs[0], "run")
    path = tmp_path / "baseline.txt"
    path.write_text(accept(None, run, run.cases).text)
    for one in (runs[0], runs[1]):
        assert compare(read_baseline(path).results, of_lines(one, "run")).entries == ()
    same = compare(read_baseline(path).results, run)
    assert same.same == same.judgements


def test_an_impulse_that_is_off_by_two_per_cent_has_changed(runs: list[list[Line]]) -> None:
    """Though it is within the tolerance, as one with a large systematic doubt might be."""
    changed = [
        line | {"judgements": [_times(one, 1.02) for one in line["judgements"]]}
        if line["check"] == "events/ideal-gas"
        else line
        for line in runs[1]
    ]
    found = difference(runs[0], changed)
    assert ("changed", "impulse of a hit") in {(one.category, one.quantity) for one in found.entries}
    assert found.status() == Status.FAILED


def _times(judgement: dict[str, object], factor: float) -> dict[str, object]:
    if judgement["criterion"]["kind"] != "statistical":  # type: ignore[index]
        return judgement
    return judgement | {"measured": judgement["measured"] * factor}  # type: ignore[operator]
