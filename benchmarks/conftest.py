"""What all benchmarks share: races that are run once, and the clock that pytest-benchmark reads their turns from.

A benchmark is one side of a race (`crosscheck.checks.performance.races`). pytest-benchmark times one function after the
other; here all sides of a race take turns, so that a load on the machine meets all of them, each in a worker process of
its own that says how many seconds its turn took, compilation and start apart. So a race is run before the first of its
benchmarks, and each benchmark then goes through the turns of its side, with those seconds as its clock.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import card
import numpy as np
import pytest

from crosscheck.checks.base import Laboratory
from crosscheck.checks.performance.races import OURS, Outcome, Race, run_race
from crosscheck.checks.performance.speeds import Turn, rates
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool

#: Entries of `Cost` that are times or sizes, not numbers of operations.
_NOT_COUNTED = {"wall", "cpu", "compile", "peak_bytes"}
_SHORT_TURNS = 1


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--short", action="store_true", help="tiny scenes and one turn of each: that the benchmarks work")


def pytest_benchmark_update_machine_info(config: pytest.Config, machine_info: dict[str, Any]) -> None:
    machine_info["card"] = card.of_machine()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """One benchmark for each side of the races of a module: its RACES, or SHORT in the short form."""
    if "side" in metafunc.fixturenames:
        races = metafunc.module.SHORT if metafunc.config.getoption("--short") else metafunc.module.RACES
        metafunc.parametrize(
            ("race", "side"),
            [pytest.param(race, side.name, id=f"{race.name}: {side.name}") for race in races for side in race.sides],
        )


class Clock:
    """Seconds that the turns took so far, for pytest-benchmark: `clock()`. turns: of one side, in their order."""

    __name__ = "seconds of the integration"

    def __init__(self, turns: list[Turn]) -> None:
        self._seconds = 0.0
        self._left = iter(turns)

    def __call__(self) -> float:
        return self._seconds

    def next_turn(self) -> None:
        self._seconds += next(self._left).seconds


@pytest.fixture(scope="session")
def _laboratory() -> Iterator[Laboratory]:
    pool = Pool()
    yield Laboratory(OURS, engine_class(OURS).schemes, pool, "benchmarks")
    pool.close()


@pytest.fixture(scope="session")
def _outcomes() -> dict[str, Outcome | Exception]:
    """What came of the races that were run, by their names: all sides of a race that failed fail."""
    return {}


@pytest.fixture
def read_out(
    request: pytest.FixtureRequest, _laboratory: Laboratory, _outcomes: dict[str, Outcome | Exception]
) -> Callable[[Race, str], None]:
    """Hands the turns of one side of a race to pytest-benchmark, with all that is known of them in `extra_info`."""

    def hand_over(race: Race, side: str) -> None:
        if race.name not in _outcomes:
            short = request.config.getoption("--short")
            try:
                _outcomes[race.name] = run_race(_laboratory, race, _SHORT_TURNS if short else None)
            except Exception as error:
                _outcomes[race.name] = error
        outcome = _outcomes[race.name]
        if isinstance(outcome, Exception):
            raise outcome
        if side in outcome.absent:
            pytest.skip(outcome.absent[side])
        turns = outcome.turns[side]
        clock = Clock(turns)
        request.node.add_marker(pytest.mark.benchmark(group=race.name, timer=clock))
        benchmark = request.getfixturevalue("benchmark")
        benchmark.extra_info.update(_known(race, side, outcome))
        benchmark.pedantic(clock.next_turn, rounds=len(turns), iterations=1)

    return hand_over


def _known(race: Race, side: str, outcome: Outcome) -> dict[str, Any]:
    """Rate, ratio to the other sides, operations a unit of work, and memory, of one side."""
    turns = outcome.turns[side]
    own = rates(turns)
    first = rates(outcome.turns[race.sides[0].name])
    over = first / own
    counted = turns[-1].cost.known()
    return {
        "side": side,
        "unit": race.unit,
        "elapsed": next(one.elapsed for one in race.sides if one.name == side),
        "work": turns[-1].work,
        "rate": float(np.median(own)),
        "ratio": {"of": race.sides[0].name, "median": float(np.median(over)), "turns": over.tolist()},
        "counters": {name: value for name, value in counted.items() if name not in _NOT_COUNTED},
        "note": outcome.notes.get(side, ""),
        **({"bytes": outcome.held[side]} if side in outcome.held else {}),
        "compile_seconds": outcome.turns[side][0].cost.compile,
        "peak_bytes": turns[-1].cost.peak_bytes,
    }
