"""Turns that alternate, and races of sides that are made up: who takes part, and what must be alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from crosscheck.checks.base import Laboratory
from crosscheck.checks.performance.event_races import GASES, event_driven_sides, gas_of
from crosscheck.checks.performance.races import OURS, Race, Ready, Side, Start, best_of, run_race, same_state
from crosscheck.checks.performance.speeds import Turn, alternated, rates
from crosscheck.checks.performance.stepping_races import gravity_race
from crosscheck.engines.protocol import Cost, Run
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EngineMissing
from crosscheck.scene import Scene, Spring, explicit

SCENE = Scene(
    name="one", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=explicit(np.zeros((1, 1)), np.ones((1, 1)))
)


@pytest.fixture
def laboratory() -> Laboratory:
    return Laboratory(OURS, {}, Pool(), "performance/race")


def side(name: str, cpu: float, place: float = 0.0, missing: str = "") -> Side:
    def prepare(laboratory: Laboratory, scene: Scene) -> Ready:
        if missing:
            raise EngineMissing(missing)
        end = np.full((1, 1), place)
        return Ready(lambda: Run(final_positions=end, final_velocities=end, cost=Cost(cpu=cpu, wall=9.0, steps=10)))

    return Side(name, prepare)


def race(*sides: Side, alike: Callable[[Scene, Mapping[str, Run]], None] = same_state) -> Race:
    return Race("race", "steps", lambda laboratory: Start(SCENE, lambda run: run.cost.steps), sides, alike, turns=3)


def test_sides_take_turns_and_the_first_does_not_count() -> None:
    called: list[str] = []

    def runner(name: str) -> Callable[[], Turn]:
        def run() -> Turn:
            called.append(name)
            return Turn(float(len(called)), 1.0, Cost())

        return run

    taken = alternated({"a": runner("a"), "b": runner("b")}, turns=2)
    assert called == ["a", "b"] * 3
    assert [turn.seconds for turn in taken["a"]] == [3.0, 5.0]
    assert rates(taken["b"]).tolist() == [1 / 4, 1 / 6]


def test_a_race_measures_work_per_second_of_the_processor(laboratory: Laboratory) -> None:
    turns = run_race(laboratory, race(side("ours", 0.5), side("other", 2.0))).turns
    assert [len(found) for found in turns.values()] == [3, 3]
    assert rates(turns["ours"])[0] / rates(turns["other"])[0] == 4.0


def test_who_is_missing_is_said(laboratory: Laboratory) -> None:
    outcome = run_race(laboratory, race(side("ours", 0.5), side("other", 2.0, missing="OTHER is not set")), turns=1)
    assert outcome.absent == {"other": "OTHER is not set"}
    assert list(outcome.turns) == ["ours"]


def test_sides_that_do_not_do_the_same_are_not_compared(laboratory: Laboratory) -> None:
    with pytest.raises(AssertionError, match="final_positions of other are not those of ours"):
        run_race(laboratory, race(side("ours", 0.5), side("other", 2.0, place=1e-15)))


def test_the_best_of_several_settings_takes_part(laboratory: Laboratory) -> None:
    several = best_of("other", (side("slow", 3.0), side("fast", 1.0), side("middle", 2.0)))
    outcome = run_race(laboratory, race(side("ours", 0.5), several))
    assert outcome.notes == {"other": "fast"}
    assert outcome.turns["other"][0].seconds == 1.0


@pytest.mark.parametrize("apart", [1e-7, float("nan")])
def test_gravity_of_two_codes_must_agree(apart: float) -> None:
    scene = gravity_race(3).start(None).scene  # type: ignore[arg-type]
    start = scene.initial_state().positions
    runs = {"ours": Run(final_positions=start), "other": Run(final_positions=start + apart)}
    with pytest.raises(AssertionError, match="apart"):
        gravity_race(3, pairs=100).alike(scene.changed(duration=1e-3), runs)


def test_every_gas_is_a_scene() -> None:
    for gas in GASES:
        assert gas_of(gas, 108, seed=1).number == 108


def test_schedulers_without_the_naive_algorithm() -> None:
    names = [side.name for side in event_driven_sides(1.0)]
    assert names[0] == OURS
    assert not [name for name in names if "naive" in name]
