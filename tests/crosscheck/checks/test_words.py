"""Every word of the scene language that `refimpl` understands is used by a scene of the quick tier.

A feature that no check judges is an error of the suite. The scenes are collected without running them: a worker stands
in that returns random numbers of the right shapes, so that most checks go on to their last scene. The checks that join
all features come first, and the rest is left out once nothing is missing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np

from crosscheck import runner
from crosscheck.checks.base import Laboratory
from crosscheck.engines.capabilities import words
from crosscheck.engines.protocol import Cost, Run, sample_times, shapes
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.engines.soft_spheres import resolved
from crosscheck.engines.workers.pool import Pool
from crosscheck.scene import Method, Scene


class _Collector:
    """Stands in for a pool of workers, and for each worker: notes the words of the scenes."""

    def __init__(self) -> None:
        self.words: set[str] = set()

    def worker(self, *which: Any) -> _Collector:
        return self

    def supports(self, scene: Scene, method: Method) -> str | None:
        return None

    def version(self) -> str:
        return "none"

    def run(self, scene: Scene, method: Method, *files: Path) -> Run:
        method = resolved(scene, method)
        self.words |= words(scene, method)
        times, chance = sample_times(scene, method), np.random.default_rng(0)
        arrays = {name: chance.normal(size=shape) for name, shape in shapes(scene, times.size).items()}
        return Run(arrays | {"time": times}, cost=Cost())


def test_no_word_of_the_scene_language_is_left_to_nobody() -> None:
    schemes, collector = RefimplEngine.schemes, _Collector()
    declared = {word for one in RefimplEngine.capabilities for word in one.words}
    cases = runner.select([], "quick", ["refimpl"])
    first = {case.check: case for case in reversed(cases)}
    for case in sorted(cases, key=lambda case: (runner.find(case.check).features is None, case != first[case.check])):
        if declared <= collector.words:
            break
        check = runner.find(case.check)
        variant = next(one for one in check.offered(schemes) if one.name == case.variant)
        laboratory = Laboratory("refimpl", schemes, cast(Pool, collector), case.name, interpreted=check.interpreted)
        with np.errstate(all="ignore"):
            try:
                check.judge(laboratory, variant.value)
            except Exception:  # whatever a check makes of random numbers
                continue
    assert sorted(declared - collector.words) == []
