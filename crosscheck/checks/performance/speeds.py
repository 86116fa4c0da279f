"""Speed of an engine beside its peer: the same scene, alternated, CPU seconds of the integration alone.

A machine that others use is slower in one second than in the next. So the sides of a comparison take turns, and what
counts is the median over the turns of the ratio within each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.engines.protocol import Cost
from crosscheck.scene import Floats, Method, Scene
from crosscheck.verdict import Judgement, bounded

#: Turns of each engine; the median ratio counts, so that a disturbed turn does not.
TURNS = 7
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
