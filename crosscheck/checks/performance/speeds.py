"""Speed of an engine beside its peer: the same scene, alternated, CPU seconds of the integration alone."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.scene import Method, Scene
from crosscheck.verdict import Judgement, bounded

#: Turns of each engine; the median ratio counts, so that a disturbed turn does not.
TURNS = 7
EQUATION = "particles x steps / CPU seconds"
CITATION = "Thompson et al., Comput. Phys. Commun. 271, 108171 (2022); Rein & Liu, A&A 537, A128 (2012)"


def criterion(goal: str) -> str:
    """The criterion of a check of speed: `goal`, in words, and how it is measured."""
    return f"{goal}, median of {TURNS} alternated turns, one thread, compilation apart"


def beside(laboratory: Laboratory, scene: Scene, method: Method, peer: str, goal: float) -> Judgement:
    """Particle steps per CPU second of the engine under judgement, at least `goal` times those of `peer`.

    laboratory: of the engine under judgement. scene, method: what both engines run. peer: name of the other engine.
    """
    rates: dict[str, list[float]] = {laboratory.engine: [], peer: []}
    for turn in range(TURNS + 1):
        for engine, found in rates.items():
            cost = laboratory.run(scene, method, engine=engine).cost
            if turn:  # the first turn warms caches
                found.append(scene.number * cost.steps / cost.cpu)
    ratios = np.array(rates[laboratory.engine]) / np.array(rates[peer])
    ours, theirs = (float(np.median(found)) for found in rates.values())
    return bounded(
        f"particle steps per CPU second, ratio to {peer}",
        float(np.median(ratios)),
        goal,
        f"the goal; median of {TURNS} alternated turns, of {ratios.min():.2f} ... {ratios.max():.2f}",
        at_least=True,
        note=f"{laboratory.engine} {ours:.3g}, {peer} {theirs:.3g} particle steps per CPU second",
    )
