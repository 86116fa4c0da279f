"""What operations that grow with the number of particles would be judged, from made-up counts."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from crosscheck.checks.performance import written_operations
from crosscheck.checks.performance.counted_sources import Work
from crosscheck.checks.performance.written_operations import KNOWN, _at_faces, _judge_growth, _judge_known, _Queue
from crosscheck.scene.observables import OPERATIONS
from crosscheck.verdict import findings

SIZES = tuple(2**k for k in range(7, 17))


class _Laboratory:
    """Sources, seeds, and nothing that is refused."""

    pool = SimpleNamespace(overlay=None)

    def seed(self) -> int:
        return 1

    def demand(self, scene: Any, method: Any) -> None:
        pass


def judged(growth: Any, climbs: bool, monkeypatch: pytest.MonkeyPatch, fetched: float = 100.0) -> str:
    """The outcome for an event of so many operations more, beside those that the algorithm needs.

    fetched: operations of an event that fetch memory ahead.
    """
    chance = np.random.default_rng(1)

    def made(sources: Any, runs: Any, **options: bool) -> list[Work]:
        found = []
        for scene, _ in runs:
            n = scene.number
            predictions = 40 + 10 * chance.random()
            comparisons = np.log2(n)
            work = 2400 + 43 * predictions + 800 * _at_faces(np.array([float(n)]))[0]
            work += 20 * comparisons if climbs else 0.0
            work *= 1 + 0.002 * chance.normal()  # what other events need
            counts = dict.fromkeys(OPERATIONS, 0.0) | {"predictions": predictions, "tree_comparisons": comparisons}
            totals = [[0] * len(OPERATIONS)] * 2 + [[round(1e6 * counts[name]) for name in OPERATIONS]]
            all_work, ahead = round(1e6 * (work + growth(n))), round(1e6 * fetched)
            found.append(Work([0, 0, all_work], [0, 0, ahead], totals, [0, 0, 1_000_000], ""))
        return found

    monkeypatch.setattr(written_operations, "work_of", made)
    queue = _Queue("event_driven", SIZES, climbs=climbs)
    return str(findings(_judge_growth(_Laboratory(), queue)).outcome)  # type: ignore[arg-type]


@pytest.mark.parametrize("climbs", [True, False])
@pytest.mark.parametrize(
    ("growth", "outcome"),
    [
        (lambda n: 0.0, "pass"),
        (lambda n: 300.0, "pass"),  # constant work is for the known numbers to see
        (lambda n: 3 * n**0.5, "fail"),
        (lambda n: 0.02 * n, "fail"),
    ],
)
def test_work_that_grows_is_red(growth: Any, outcome: str, climbs: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    assert judged(growth, climbs, monkeypatch) == outcome


@pytest.mark.parametrize(("fetched", "outcome"), [(300.0, "pass"), (900.0, "fail")])
def test_fetching_ahead_must_be_little(fetched: float, outcome: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert judged(lambda n: 0.0, True, monkeypatch, fetched) == outcome


@pytest.mark.parametrize(("more", "outcome"), [(0, "pass"), (1, "fail"), (-1, "fail")])
def test_one_operation_more_than_known_is_red(more: int, outcome: str, monkeypatch: pytest.MonkeyPatch) -> None:
    known = KNOWN["schedulers"]
    works = [Work([one.operations + more - 5], [5], [], [1], "") for one in known]
    monkeypatch.setattr(written_operations, "work_of", lambda *arguments, **options: works)
    assert findings(_judge_known(_Laboratory(), known)).outcome == outcome  # type: ignore[arg-type]
