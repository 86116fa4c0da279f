"""Runs of both modes compared: one bit, one NaN, one shape that differs is seen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from crosscheck.checks.both_modes import same_bits, same_to_rounding
from crosscheck.engines.protocol import Cost, Run


class Modes:
    """A laboratory whose interpreted runs differ from the compiled ones by `change`."""

    def __init__(self, change: Callable[[np.ndarray], np.ndarray]) -> None:
        self.change = change
        self.values = np.array([1.0, -3.0, np.nan, 0.0])
        self.costs = {False: Cost(cpu=1.0, pair_tests=5), True: Cost(cpu=2.0, pair_tests=5)}

    def run(self, scene: Any, method: Any, *, interpreted: bool) -> Run:
        velocities = self.change(self.values) if interpreted else self.values
        return Run(velocities=velocities, positions=np.ones(2), cost=self.costs[interpreted])


SCENE: Any = None
EPSILON = 2.0**-52
CHANGES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "one bit": lambda x: np.where(x == 1.0, 1.0 + EPSILON, x),
    "a number for NaN": np.nan_to_num,
    "another shape": lambda x: x[:2],
}


@pytest.mark.parametrize("kind", CHANGES)
def test_any_difference_is_seen(kind: str) -> None:
    laboratory: Any = Modes(CHANGES[kind])
    judged = same_bits(laboratory, SCENE, "stepping", "scene")
    assert judged.outcome == "fail"
    assert "velocities" in judged.note


def test_equal_runs_pass() -> None:
    laboratory: Any = Modes(np.copy)
    judged = same_bits(laboratory, SCENE, "stepping", "scene")
    assert (judged.outcome, judged.measured, judged.note) == ("pass", 0.0, "")


def test_what_is_counted_must_be_the_same() -> None:
    laboratory: Any = Modes(np.copy)
    laboratory.costs[True].pair_tests = 6
    judged = same_bits(laboratory, SCENE, "stepping", "scene")
    assert (judged.outcome, judged.note) == ("fail", "they differ in 1 of cost.pair_tests")


@pytest.mark.parametrize(("roundings", "outcome"), [(3.0, "pass"), (40.0, "fail")])
def test_roundings_are_those_of_the_largest_number(roundings: float, outcome: str) -> None:
    laboratory: Any = Modes(lambda x: np.where(x == 1.0, 1.0 + 3.0 * roundings * EPSILON, x))
    laboratory.values = np.array([1.0, -3.0])
    assert same_to_rounding(laboratory, SCENE, "stepping", "scene", 10.0, "a reason").outcome == outcome
