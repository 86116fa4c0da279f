"""Trajectories that are known in all their statistics, as sources in memory; and what an inspection says of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from benchmark_modules import benchmark_named

from crosscheck.inspect.inspection import Inspection
from crosscheck.inspect.properties import properties
from crosscheck.inspect.property import Told
from crosscheck.inspect.setting import Options, setting_of
from crosscheck.inspect.view import View
from crosscheck.scene import Scene
from crosscheck.trajectories.frames import Box, Source
from crosscheck.trajectories.memory import in_memory
from crosscheck.verdict import FALSE_ALARM_OF_A_RUN, Judgement

#: benchmarks/evidence/inspections.py, whose trajectories and planted faults the tests share.
PLANTED = benchmark_named("evidence/inspections")


def cube(side: float = 5.0) -> Box:
    """A periodic cube at the origin."""
    return Box(np.diag([side] * 3), np.zeros(3), np.ones(3, dtype=bool))


def flying(seed: int = 1, frames: int = 60, number: int = 20, **more: Any) -> Source:
    """Free flight of particles with normal velocities, and total momentum 0, in a periodic cube of side 5.

    more: other arguments of `in_memory`, such as `positions`, in place of those that are drawn.
    """
    rng = np.random.default_rng(seed)
    v = rng.normal(size=(number, 3))
    v -= v.mean(axis=0)
    times = 0.01 * np.arange(frames)
    x = rng.uniform(0, 5, (number, 3)) + v * times[:, None, None]
    entries = {
        "times": times,
        "positions": x,
        "velocities": np.broadcast_to(v, x.shape),
        "box": cube(),
        "masses": np.ones(number),
    }
    return in_memory("flying", **(entries | more))


#: The level of a statistical judgement of one property alone: that of one of 20.
ONCE = FALSE_ALARM_OF_A_RUN / 20


def of_property(source: Source, name: str, scene: Scene | None = None, **options: Any) -> Told | str:
    """What is told of one property alone, or why nothing is. options: of `Options`."""
    setting = setting_of(source, scene, Options(**options))
    (one,) = [one for one in properties() if one.name == name]
    collector = one.begin(setting)
    if isinstance(collector, str):
        return collector
    before = None
    for index in range(len(source)):
        view = View(setting, index, setting.boxed(source.read(index)), before)
        collector.add(view)
        view.before, before = None, view
    return collector.judge(ONCE)


def judged(source: Source, name: str, scene: Scene | None = None, **options: Any) -> tuple[Judgement, ...]:
    """The judgements of the property of this name."""
    found = of_property(source, name, scene, **options)
    return () if isinstance(found, str) else found.judgements


def said(source: Source, name: str, scene: Scene | None = None, **options: Any) -> str:
    """What is said of the property of this name, and not judged."""
    found = of_property(source, name, scene, **options)
    return found if isinstance(found, str) else " ".join(found.said)


def told(inspection: Inspection, name: str) -> tuple[Judgement, ...]:
    """The judgements of the property of this name in an inspection."""
    (one,) = [found for found in inspection.found if found.property.name == name]
    return one.told.judgements


def red(inspection: Inspection) -> set[str]:
    """Names of the properties with a red judgement."""
    return {
        found.property.name
        for found in inspection.found
        if any(judgement.outcome == "fail" for judgement in found.told.judgements)
    }
