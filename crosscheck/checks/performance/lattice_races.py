"""Races of lattice gases: bit planes beside bytes and beside a copy of memory; two threads beside one."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice.gases import filled, gas_scene
from crosscheck.checks.performance.races import (
    OURS,
    Race,
    Ready,
    Side,
    Start,
    alone,
    engine_side,
)
from crosscheck.engines.protocol import Run, timed
from crosscheck.references.lattice_models import VELOCITIES
from crosscheck.scene import (
    Method,
    Output,
    Scene,
)

_PLANES = Method(scheme="lattice_planes")


def lattice_race(model: str, size: int, steps: int) -> Race:
    """Bit planes on size x size sites beside the evolver that moves bytes, and a copy of memory.

    The unit is a site update. model: name of the gas. steps: of a turn; bytes take a 32nd of them.
    """

    def fewer(laboratory: Laboratory, scene: Scene) -> Ready:
        shorter = scene.changed(duration=max(1, steps // 32))
        return Ready(lambda: laboratory.run(shorter, Method(scheme="lattice_lookup"), engine=OURS))

    sides = (engine_side(OURS, OURS, _PLANES), Side("table look-up", fewer), _copy_side(model))
    return Race(f"{model}, {size} x {size}", "site updates", _lattice_start(model, size, steps), sides, alone, 5)


def threads_race(model: str, size: int, steps: int) -> Race:
    """Bit planes on size x size sites, and the same with two threads: elapsed time, and the same bits.

    The unit is a site update. model: name of the gas. steps: of a turn.
    """
    sides = (
        engine_side("one thread", OURS, _PLANES, elapsed=True),
        engine_side("two threads", OURS, Method(scheme="lattice_planes", threads=2), elapsed=True),
    )
    start = _lattice_start(model, size, steps, Output(observables=("sites",)))

    def alike(scene: Scene, runs: Mapping[str, Run]) -> None:
        one, two = (run["sites"] for run in runs.values())
        if not np.array_equal(one, two):
            raise AssertionError(f"{scene.name}: two threads do not end in the bits of one")

    return Race(f"{model}, {size} x {size}, elapsed time", "site updates", start, sides, alike, 5)


def _lattice_start(model: str, size: int, steps: int, output: Output | None = None) -> Callable[[Laboratory], Start]:
    def start(laboratory: Laboratory) -> Start:
        initial = filled(0.3, laboratory.seed())
        scene = gas_scene(f"{model}-{size}", model, size, size, steps, initial, output or Output())
        return Start(scene, lambda run: float(size * size * run.cost.steps))

    return start


def _copy_side(model: str) -> Side:
    """A copy of memory as a side of a lattice gas: for each step, all channels of all sites, a bit each, are copied.

    model: name of the gas.
    """

    def prepare(laboratory: Laboratory, scene: Scene) -> Ready:
        source = np.ones(25_000_000)
        target = np.empty_like(source)

        def run() -> Run:
            assert scene.lattice_gas is not None
            sites = scene.lattice_gas.rows * scene.lattice_gas.columns
            run = Run()
            steps = max(1, round(8 * source.nbytes / (VELOCITIES[model].channels * sites)))
            part = min(source.size, VELOCITIES[model].channels * sites // 64)
            with timed(run.cost):
                for _ in range(steps):
                    np.copyto(target[:part], source[:part])
            run.cost.steps = steps
            return run

        return Ready(run)

    return Side("copy of memory", prepare)
