"""Speed of an engine beside its peer: the same scene, alternated, CPU seconds of the integration alone.

A machine that others use is slower in one second than in the next. So the sides of a comparison take turns, and what
counts is the median over the turns of the ratio within each.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from hashlib import sha256
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.engines.protocol import Cost
from crosscheck.scene import Floats, Method, Scene
from crosscheck.verdict import Judgement, bounded

#: Turns of each engine; the median ratio counts, so that a disturbed turn does not.
TURNS = 7
#: Turns of one thread and two at most, until so many found two free cores; cores that two threads find there that share
#: nothing.
_ATTEMPTS, _COUNTED, _FREE = 12, 5, 1.9
EQUATION = "particles x steps / CPU seconds"
CITATION = "Thompson et al., Comput. Phys. Commun. 271, 108171 (2022); Rein & Liu, A&A 537, A128 (2012)"


class Turn(NamedTuple):
    """One run of one side: seconds that it took, compilation and start apart; work: done in them; cost: of the run.

    The work is in a unit of the comparison, such as particle steps. The seconds are those of the processor, or elapsed
    ones where several threads are compared.
    """

    seconds: float
    work: float
    cost: Cost


def alternated(sides: Mapping[str, Callable[[], Turn]], turns: int = TURNS, warm: int = 1) -> dict[str, list[Turn]]:
    """The turns of each side, by its name: all sides in each, one after the other.

    sides: functions that run one turn, by names. turns: of each side. warm: turns before them, which do not count: they
    warm caches.
    """
    taken: dict[str, list[Turn]] = {name: [] for name in sides}
    for turn in range(-warm, turns):
        for name, run in sides.items():
            done = run()
            if turn >= 0:
                taken[name].append(done)
    return taken


def rates(turns: list[Turn]) -> Floats:
    """Work per second of each turn, (turns,)."""
    return np.array([turn.work / turn.seconds for turn in turns])


def criterion(goal: str) -> str:
    """The criterion of a check of speed: `goal`, in words, and how it is measured."""
    return f"{goal}, median of {TURNS} alternated turns, one thread, compilation apart"


def beside(laboratory: Laboratory, scene: Scene, method: Method, peer: str, goal: float) -> Judgement:
    """Particle steps per CPU second of the engine under judgement, at least `goal` times those of `peer`.

    laboratory: of the engine under judgement. scene, method: what both engines run. peer: name of the other engine.
    """

    def side(engine: str) -> Callable[[], Turn]:
        def run() -> Turn:
            cost = laboratory.run(scene, method, engine=engine).cost
            return Turn(cost.cpu, scene.number * cost.steps, cost)

        return run

    taken = alternated({engine: side(engine) for engine in (laboratory.engine, peer)})
    found = {engine: rates(turns) for engine, turns in taken.items()}
    ratios = found[laboratory.engine] / found[peer]
    ours, theirs = (float(np.median(rate)) for rate in found.values())
    return bounded(
        f"particle steps per CPU second, ratio to {peer}",
        float(np.median(ratios)),
        goal,
        f"the goal; median of {TURNS} alternated turns, of {ratios.min():.2f} ... {ratios.max():.2f}",
        at_least=True,
        note=f"{laboratory.engine} {ours:.3g}, {peer} {theirs:.3g} particle steps per CPU second",
    )


def _free_cores() -> float:
    """How many cores two threads find that share nothing: by the longest that they take, and the shortest of one."""
    text = bytes(1 << 25)

    def seconds(threads: int) -> float:
        with ThreadPoolExecutor(threads) as pool:
            started = time.perf_counter()
            for done in [pool.submit(sha256, text) for _ in range(threads)]:
                done.result()
            return time.perf_counter() - started

    return 2 * min(seconds(1) for _ in range(3)) / max(seconds(2) for _ in range(3))


def _without_cores(turns: int, found: float) -> Judgement:
    """Nothing is decided where other programs run. turns: that found two free cores; found: cores, in the median."""
    needed = bounded(
        "turns with two free cores",
        turns,
        _COUNTED,
        "fewer say nothing of a median",
        at_least=True,
        note=f"two threads that share nothing had {found:.2f} cores: run it where nothing else runs",
    )
    return replace(needed, outcome="inconclusive")


def by_two_threads(laboratory: Laboratory, scene: Scene, method: Method, asked: float, note: str) -> Judgement:
    """Elapsed time of one thread over that of two, at least `asked`; inconclusive where two cores are not free.

    laboratory: of the engine under judgement. scene, method: what it runs. note: what that is, in words.
    """
    ratios: list[float] = []
    free = [_free_cores()]
    for turn in range(_ATTEMPTS + 1):
        one, two = (
            laboratory.run(scene, method.model_copy(update={"threads": threads})).cost.wall for threads in (1, 2)
        )
        free.append(_free_cores())
        if turn and min(free[-2:]) >= _FREE:  # the first turn warms
            ratios.append(one / two)
        if len(ratios) == _COUNTED:
            break
    if len(ratios) < _COUNTED:
        return _without_cores(len(ratios), float(np.median(free)))
    return bounded(
        "time of one thread over that of two",
        float(np.median(ratios)),
        asked,
        f"0.9 of the goal; median of {_COUNTED} turns with two free cores, of {min(ratios):.2f} ... {max(ratios):.2f}",
        at_least=True,
        note=note,
    )
