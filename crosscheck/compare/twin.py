"""The rate at which separations grow in a scene: measured by a run of it and one whose start is disturbed."""

from __future__ import annotations

import numpy as np

from crosscheck.compare.differences import spacing
from crosscheck.compare.growth import Rate, measured_rate
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import UsageError
from crosscheck.scene import Scene
from crosscheck.scene.starts import explicit
from crosscheck.trajectories.frames import Frame

#: Size of the disturbance: of velocities, relative to their root mean square (of a start at rest, of positions,
#: relative to the distance of neighbours).
_DISTURBANCE = 1e-9
#: Growth, from the disturbance, before the rate is measured: by then the fastest direction has taken over.
_SETTLED = 100.0
#: Samples of a twin run, at most; and numbers that they may have.
_SAMPLES, _NUMBERS = 400, 3e7


def twin_rate(scene: Scene, engine: str, time_limit: float) -> Rate:
    """Growth rate of separations of a scene.

    Every velocity of the twin is disturbed by normal noise of 1e-9 of their root mean square, the same in every call;
    of a start at rest every position. scene: with its method. engine: its name. time_limit: seconds that each of the
    two runs may take.

    UsageError if the scene has no method or no particles that are told apart, or if separations do not grow in it.
    """
    if scene.method is None or scene.lattice_gas is not None:
        raise UsageError(f"--scene: scene {scene.name} needs a [method], and particles that are told apart")
    state = scene.own_start()
    noise = np.random.default_rng(0).standard_normal(state.positions.shape)
    speed = float(np.sqrt(np.mean(np.sum(state.velocities**2, axis=1))))
    near = spacing(Frame(0.0, None, np.arange(len(state.positions)), state.positions))
    positions, velocities = state.positions, state.velocities
    if speed > 0:
        velocities = velocities + _DISTURBANCE * speed * noise
    else:
        positions = positions + _DISTURBANCE * near * noise
    samples = max(8, min(_SAMPLES, int(_NUMBERS / max(state.positions.size, 1))))
    dt = scene.method.dt
    every = scene.duration / samples if dt is None else max(1, round(scene.duration / samples / dt)) * dt
    duration = scene.duration if dt is None else int(scene.duration / every) * every
    changes = {
        "duration": duration,
        "output": type(scene.output)(interval=every, observables=(), trajectory=True),
    }
    worker = Worker(engine, time_limit=time_limit)
    try:
        runs = [
            worker.run(scene.changed(initial=explicit(x, v, state.angular_velocities), **changes), scene.method)
            for x, v in ((state.positions, state.velocities), (positions, velocities))
        ]
    finally:
        worker.close()
    number = min(len(run["positions"]) for run in runs)
    apart = runs[1]["positions"][:number] - runs[0]["positions"][:number]
    values = np.sqrt(np.mean(np.sum(apart**2, axis=2), axis=1))
    first = values[np.flatnonzero(values)[0]] if values.any() else 0.0
    found = measured_rate(runs[0]["time"][:number], values, _SETTLED * first, near)
    if found is None:
        raise UsageError(
            f"--scene: two runs of scene {scene.name} with {engine}, one disturbed, do not part as chaos does: its "
            "separations give no rate"
        )
    return found
