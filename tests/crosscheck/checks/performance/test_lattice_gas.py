"""Two threads beside one: judged where two cores are free, and nowhere else."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from crosscheck.checks.performance import lattice_gas, speeds
from crosscheck.scene import Method, Scene
from crosscheck.verdict import Judgement


class Stopwatch:
    """A laboratory whose engine takes one second by one thread, and `share` by two, whatever the scene."""

    def __init__(self, share: float) -> None:
        self.share = share
        self.runs = 0

    def seed(self) -> int:
        return 1

    def run(self, scene: Scene, method: Method) -> Any:
        self.runs += 1
        return SimpleNamespace(cost=SimpleNamespace(wall=self.share if method.threads == 2 else 1.0))


def judged(monkeypatch: pytest.MonkeyPatch, share: float, cores: list[float]) -> tuple[Judgement, int]:
    """cores: that are found free, again and again."""
    turns = iter(cores * 100)
    monkeypatch.setattr(speeds, "_free_cores", lambda: next(turns))
    laboratory: Any = Stopwatch(share)
    return lattice_gas._by_threads(laboratory, "hpp"), laboratory.runs


@pytest.mark.parametrize(("share", "outcome"), [(0.55, "pass"), (0.58, "pass"), (0.59, "fail"), (1.0, "fail")])
def test_two_threads_are_judged_where_two_cores_are_free(
    monkeypatch: pytest.MonkeyPatch, share: float, outcome: str
) -> None:
    found, runs = judged(monkeypatch, share, [1.95])
    assert found.outcome == outcome
    assert found.measured == pytest.approx(1 / share)
    assert runs == 2 * (1 + speeds._COUNTED)


@pytest.mark.parametrize("share", [0.55, 1.0])
@pytest.mark.parametrize("cores", [[1.2], [1.95, 1.2]])
def test_nothing_is_judged_where_cores_are_taken_before_or_after(
    monkeypatch: pytest.MonkeyPatch, share: float, cores: list[float]
) -> None:
    found, runs = judged(monkeypatch, share, cores)
    assert found.outcome == "inconclusive"
    assert "run it where nothing else runs" in found.note
    assert runs == 2 * (1 + speeds._ATTEMPTS)


def test_cores_are_counted() -> None:
    assert speeds._free_cores() > 0
