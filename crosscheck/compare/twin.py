"""The rate at which separations grow in a scene: measured by a run of it and one whose start is disturbed."""

from __future__ import annotations

import numpy as np

from crosscheck.compare.differences import spacing
from crosscheck.compare.growth import Rate, measured_rate
from crosscheck.engines.protocol import Run
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import UsageError
from crosscheck.scene import Explicit, Scene
from crosscheck.scene.starts import explicit
from crosscheck.trajectories.frames import Frame

#: Size of the disturbance: of velocities, relative to their root mean square (of a start at rest, of positions,
#: relative to the distance of neighbours).
DISTURBANCE = 1e-9
#: Growth, from the disturbance, before the rate is measured: by then the fastest direction has taken over.
_SETTLED = 100.0
#: Samples of a twin run, at most; and numbers that they may have.
_SAMPLES, _NUMBERS = 400, 3e7


def twin_rate(scene: Scene, engine: str, time_limit: float) -> Rate:
    """Growth rate of separations of a scene.

    scene: with its method. engine: its name. time_limit: seconds that each of the two runs may take. The twin: see
    `disturbed`.

    UsageError if the scene has no method or no particles that are told apart, or if separations do not grow in it.
    """
    if scene.method is None or scene.lattice_gas is not None:
        raise UsageError(f"--scene: scene {scene.name} needs a [method], and particles that are told apart")
    state = scene.own_start()
    samples = max(8, min(_SAMPLES, int(_NUMBERS / max(state.positions.size, 1))))
    dt = scene.method.dt
    every = scene.duration / samples if dt is None else max(1, round(scene.duration / samples / dt)) * dt
    duration = scene.duration if dt is None else int(scene.duration / every) * every
    changes = {
        "duration": duration,
        "output": type(scene.output)(interval=every, observables=(), trajectory=True),
    }
    starts = explicit(state.positions, state.velocities, state.angular_velocities), disturbed(scene)
    worker = Worker(engine, time_limit=time_limit)
    try:
        runs = [worker.run(scene.changed(initial=start, **changes), scene.method) for start in starts]
    finally:
        worker.close()
    found = rate_of(*runs, near=neighbours_of(scene))
    if found is None:
        raise UsageError(
            f"--scene: two runs of scene {scene.name} with {engine}, one disturbed, do not part as chaos does: its "
            "separations give no rate"
        )
    return found


def disturbed(scene: Scene) -> Explicit:
    """The start of a scene of particles, disturbed a little, the same in every call.

    scene: whose start it is. The velocity of every particle that moves is off by normal noise of `DISTURBANCE` of
    their root mean square; of a start at rest, every position.
    """
    state = scene.own_start()
    noise = np.random.default_rng(0).standard_normal(state.positions.shape)
    noise[scene.fixed()] = 0.0
    speed = float(np.sqrt(np.mean(np.sum(state.velocities**2, axis=1))))
    positions, velocities = state.positions, state.velocities
    if speed > 0:
        velocities = velocities + DISTURBANCE * speed * noise
    else:
        positions = positions + DISTURBANCE * neighbours_of(scene) * noise
    return explicit(positions, velocities, state.angular_velocities)


def neighbours_of(scene: Scene) -> float:
    """Distance of neighbours at the start of a scene in open space, length; scene: of particles."""
    positions = scene.own_start().positions
    return spacing(Frame(0.0, None, np.arange(len(positions)), positions))


def rate_of(one: Run, twin: Run, *, near: float) -> Rate | None:
    """Growth rate of separations, from a run and one from a disturbed start; None if they do not part as chaos does.

    one, twin: with positions at the same times. near: distance of neighbours, length.
    """
    number = min(len(run["positions"]) for run in (one, twin))
    apart = twin["positions"][:number] - one["positions"][:number]
    values = np.sqrt(np.mean(np.sum(apart**2, axis=2), axis=1))
    first = values[np.flatnonzero(values)[0]] if values.any() else 0.0
    return measured_rate(one["time"][:number], values, _SETTLED * first, near)
