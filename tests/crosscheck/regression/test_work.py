"""Numbers of operations are exact; computing times count beside another engine, beyond their noise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from crosscheck.regression.results import Case, Results
from crosscheck.regression.work import Growth, growth, incomparable, paces


@pytest.mark.parametrize(
    ("old", "new", "grown", "fallen"),
    [
        ({"steps": 200}, {"steps": 200}, [], []),
        ({"steps": 200}, {"steps": 210}, [], []),  # 5 %
        ({"evaluations": 201}, {"evaluations": 401}, ["evaluations"], []),
        ({"evaluations": 401}, {"evaluations": 201}, [], ["evaluations"]),
        ({"steps": 200}, {"steps": 211}, ["steps"], []),
        # what another rounding of a chaotic run changes
        ({"list_builds": 20}, {"list_builds": 30}, [], []),
        ({"events": 10_000}, {"events": 10_600}, [], []),
        ({"predictions": 100_000}, {"predictions": 106_000}, ["predictions"], []),
        ({"stale_events": 0}, {"stale_events": 500}, ["stale_events"], []),
        # not counted by one of them
        ({}, {"comparisons": 9999}, [], []),
        ({"comparisons": 9999}, {}, [], []),
    ],
)
def test_growth(old: dict[str, int], new: dict[str, int], grown: list[str], fallen: list[str]) -> None:
    more, fewer = growth(old, new)
    assert ([one.name for one in more], [one.name for one in fewer]) == (grown, fallen)


def test_growth_in_words() -> None:
    assert str(Growth("evaluations", 201, 401)) == "evaluations 201 -> 401, times 2"
    assert str(Growth("stale_events", 0, 500)) == "stale_events 0 -> 500"


PROVENANCE = {
    "cpu": "a",
    "cores": 2,
    "versions": {"particle-crosscheck": "1", "numba": "1", "numpy": "1", "lammps": "3"},
}


def timed(times: Mapping[str, list[float]], **provenance: Any) -> Results:
    """Results with CPU times of cases, by engine."""
    cases = {
        (f"a/b/{number}", engine): Case("quick", "pass", cpu=seconds)
        for engine, column in times.items()
        for number, seconds in enumerate(column)
    }
    return Results("run", cases, 0, provenance=PROVENANCE | provenance)


def runs(factor: float, number: int, noise: float, seed: int = 0) -> tuple[Results, Results]:
    """Two runs on machines of different speed, in the second of which an engine takes `factor` times as long."""
    random = np.random.default_rng(seed)
    seconds = random.uniform(0.001, 0.01, number)
    found = []
    for machine, own in ((1.0, 1.0), (1.3, factor)):
        scatter = np.exp(noise * random.standard_t(2, (2, number)))
        found.append(
            timed({"refimpl": list(machine * seconds * scatter[0]), "mine": list(own * machine * seconds * scatter[1])})
        )
    return found[0], found[1]


@pytest.mark.parametrize(("factor", "slower", "faster"), [(1.0, False, False), (1.5, True, False), (0.6, False, True)])
def test_the_median_over_cases(factor: float, slower: bool, faster: bool) -> None:
    (found,) = paces(*runs(factor, 100, 0.08), "refimpl")
    assert (found.engine, found.case, found.cases) == ("mine", "", 100)
    assert found.low < found.factor < found.high
    assert (found.slower, found.faster) == (slower, faster)


def test_noise_is_neither_slower_nor_faster() -> None:
    found = [pace for seed in range(200) for pace in paces(*runs(1.0, 30, 0.1, seed), "refimpl")]
    assert len(found) == 200
    assert not any(pace.slower or pace.faster for pace in found)


def test_an_interval_takes_11_cases() -> None:
    assert paces(*runs(3.0, 10, 0.0), "refimpl") == []
    assert len(paces(*runs(3.0, 11, 0.0), "refimpl")) == 1


def test_a_single_case_counts_where_it_is_long() -> None:
    old = timed({"refimpl": [0.1, 0.001], "mine": [0.2, 0.002]})
    new = timed({"refimpl": [0.1, 0.001], "mine": [0.5, 0.02]})
    (found,) = paces(old, new, "refimpl")
    assert (found.case, found.factor, found.slower) == ("a/b/0", pytest.approx(2.5), True)
    (back,) = paces(new, old, "refimpl")
    assert back.faster


def test_what_was_not_judged_has_no_time() -> None:
    old, new = timed({"refimpl": [0.1], "mine": [0.2]}), timed({"refimpl": [0.1], "mine": [0.9]})
    cases = dict(new.cases) | {("a/b/0", "mine"): Case("quick", "error", cpu=0.9)}
    assert paces(old, Results("run", cases, 0, provenance=PROVENANCE), "refimpl") == []
    assert paces(old, timed({"mine": [0.2]}), "refimpl") == []


@pytest.mark.parametrize(
    ("provenance", "beside", "reason"),
    [
        ({}, "refimpl", ""),
        ({"cpu": "b"}, "refimpl", "the runs had other processors"),
        ({"cores": 4}, "refimpl", "the runs had other numbers of cores"),
        ({"versions": PROVENANCE["versions"] | {"numba": "2"}}, "refimpl", "the runs had other versions of refimpl"),
        ({"versions": PROVENANCE["versions"] | {"lammps": "4"}}, "refimpl", ""),
        ({"versions": PROVENANCE["versions"] | {"lammps": "4"}}, "lammps", "the runs had other versions of lammps"),
    ],
)
def test_when_times_say_nothing(provenance: dict[str, Any], beside: str, reason: str) -> None:
    assert incomparable(timed({}), timed({}, **provenance), beside) == reason
