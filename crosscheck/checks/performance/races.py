"""Races: one scene that several sides run in turns, for the benchmarks of `benchmarks/` and for checks of speed.

A side is a scheme of an engine, or a program that no registry offers. Sides of one race are named, the first one is the
one that the others are compared with. What all sides must do alike is asked of their runs before a time counts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.performance.speeds import TURNS, Turn, alternated
from crosscheck.engines.protocol import Run
from crosscheck.errors import EngineMissing, Unsupported
from crosscheck.scene import Method, Scene

#: The reference implementation: the first side of all races.
OURS = "refimpl"
#: Rounding of a number near 1.
EPSILON = float(np.finfo(float).eps)


class Start(NamedTuple):
    """What all sides of a race run; scene: the scene. work: of a run of it, in the unit of the race."""

    scene: Scene
    work: Callable[[Run], float]


class Ready(NamedTuple):
    """A side that is ready.

    run: runs the scene once. note: what was chosen for it, or "". held: bytes a particle that a run holds; 0: unknown.
    """

    run: Callable[[], Run]
    note: str = ""
    held: float = 0.0


@dataclass(frozen=True)
class Side:
    """One that takes part: `prepare(laboratory, scene)` says how it runs the scene.

    name: in tables. prepare: raises EngineMissing or Unsupported, with the reason, where this side cannot take part.
    elapsed: what counts is the elapsed time, not that of the processors.
    """

    name: str
    prepare: Callable[[Laboratory, Scene], Ready]
    elapsed: bool = False


@dataclass(frozen=True)
class Race:
    """One scene, and the sides that run it.

    name: of the group of benchmarks. unit: of the work, in the plural. start: makes the scene. sides: the first one is
    ours. alike: raises AssertionError where the sides did not do the same; of runs by the names of the sides. turns: of
    each side that count.
    """

    name: str
    unit: str
    start: Callable[[Laboratory], Start]
    sides: tuple[Side, ...]
    alike: Callable[[Scene, Mapping[str, Run]], None]
    turns: int = TURNS


class Outcome(NamedTuple):
    """What came of a race, by the names of the sides.

    turns: of each side. absent: the reasons of those that could not take part. notes: what was chosen for a side. held:
    bytes a particle that a run of it holds, where that is known.
    """

    turns: dict[str, list[Turn]]
    absent: dict[str, str]
    notes: dict[str, str]
    held: dict[str, float]


def run_race(laboratory: Laboratory, race: Race, turns: int | None = None) -> Outcome:
    """Runs a race.

    laboratory: runs the engines. turns: that count of each side; None: as the race says. AssertionError if the sides do
    not do the same.
    """
    scene, work = race.start(laboratory)
    runs: dict[str, Run] = {}
    runners: dict[str, Callable[[], Turn]] = {}
    absent: dict[str, str] = {}
    notes: dict[str, str] = {}
    held: dict[str, float] = {}
    for side in race.sides:
        try:
            ready = side.prepare(laboratory, scene)
            runs[side.name] = ready.run()  # compiles, warms, and is what is compared
        except (EngineMissing, Unsupported) as reason:
            absent[side.name] = str(reason)
            continue
        notes |= {side.name: ready.note} if ready.note else {}
        held |= {side.name: ready.held} if ready.held else {}
        runners[side.name] = _turn(ready.run, work, side.elapsed)
    race.alike(scene, runs)
    runs.clear()
    return Outcome(alternated(runners, race.turns if turns is None else turns, warm=0), absent, notes, held)


def _turn(run: Callable[[], Run], work: Callable[[Run], float], elapsed: bool) -> Callable[[], Turn]:
    def turn() -> Turn:
        done = run()
        return Turn(done.cost.wall if elapsed else done.cost.cpu, work(done), done.cost)

    return turn


# -- sides ------------------------------------------------------------------------------------------------------------


def engine_side(name: str, engine: str, method: Method, *, elapsed: bool = False) -> Side:
    """An engine as a side; name: in tables. engine: its name, or path.py:Class. method: how. elapsed: as of `Side`."""

    def prepare(laboratory: Laboratory, scene: Scene) -> Ready:
        return Ready(lambda: laboratory.run(scene, method, engine=engine))

    return Side(name, prepare, elapsed)


def best_of(name: str, sides: tuple[Side, ...]) -> Side:
    """The fastest of several sides, found by two runs of each, of which the first warms; name: in tables.

    sides: such as one program with several settings.
    """

    def prepare(laboratory: Laboratory, scene: Scene) -> Ready:
        def seconds(side: Side) -> float:
            run = side.prepare(laboratory, scene).run
            run()
            return run().cost.cpu

        best = min(sides, key=seconds)
        return Ready(best.prepare(laboratory, scene).run, best.name)

    return Side(name, prepare)


# -- what the sides must do alike --------------------------------------------------------------------------------------


def alone(scene: Scene, runs: Mapping[str, Run]) -> None:
    """Nothing to compare: sides that do different things on purpose, such as integration schemes.

    scene, runs: as of `Race.alike`.
    """


def same_state(scene: Scene, runs: Mapping[str, Run]) -> None:
    """All sides end in the same bits; AssertionError if not.

    scene, runs: as of `Race.alike`.
    """
    first, *others = runs.items()
    for name, run in others:
        for what in ("final_positions", "final_velocities"):
            if not np.array_equal(run[what], first[1][what]):
                raise AssertionError(f"{scene.name}: {what} of {name} are not those of {first[0]}, bit for bit")


def near(scene: Scene, runs: Mapping[str, Run], tolerance: float) -> None:
    """No coordinate at the end is further from that of the first side than `tolerance`, length; AssertionError if not.

    scene, runs: as of `Race.alike`.
    """
    first, *others = runs.items()
    for name, run in others:
        apart = float(np.abs(run["final_positions"] - first[1]["final_positions"]).max())
        if not apart <= tolerance:
            raise AssertionError(f"{scene.name}: {name} and {first[0]} end {apart:.3g} apart, beyond {tolerance:.3g}")
