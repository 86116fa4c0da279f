"""What a run records so that it can be judged: what the user asks for, and what the laws need beside it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from crosscheck.engines.capabilities import refusal
from crosscheck.engines.registry import engine_class
from crosscheck.engines.soft_spheres import resolved
from crosscheck.scene import Method, Output, Scene
from crosscheck.scene.observables import TABLE
from crosscheck.simulate.methods import Planned

#: Samples of a run whose scene does not say when to take them.
SAMPLES = 200
#: Bytes of positions and velocities that may be recorded although the user has not asked for them.
MOST_BYTES = 1 << 27


def recording(plan: Sequence[Planned], names: Iterable[str]) -> list[Planned]:
    """The same runs, which also record what is needed to judge them; each method with the dt that it will have.

    plan: the runs. names: of the observables that the laws need; "trajectory" for positions and velocities. What an
    engine does not measure, or the scene cannot have, is left out, and a trajectory that is too large.
    """
    wanted = tuple(names)
    steps = {method.dt for one in plan if (method := resolved(one.scene, one.method)).dt is not None}
    found = []
    for one in plan:
        method = resolved(one.scene, one.method)
        scene = one.scene.model_copy(update={"method": method})
        output = scene.output
        if output.interval is None and output.collisions is None and scene.duration > 0:
            interval = scene.duration / _samples(scene.duration, [dt for dt in steps if dt is not None])
            output = output.model_copy(update={"interval": interval})
        output = with_observables(one.engine, scene, method, output, wanted)
        found.append(replace(one, scene=scene.model_copy(update={"output": output}), method=method))
    return found


def _samples(duration: float, steps: Sequence[float]) -> int:
    """How many times to record: about `SAMPLES`, at whole numbers of all time steps."""
    for number in range(SAMPLES, 0, -1):
        if all(is_whole(duration / number / dt) for dt in steps):
            return number
    return 1


def is_whole(ratio: float) -> bool:
    """Whether the ratio of two times is a whole number of at least 1, as `whole_steps` understands it."""
    return round(ratio) >= 1 and abs(ratio - round(ratio)) <= 1e-10 * max(1.0, ratio)


def with_observables(engine: str, scene: Scene, method: Method, output: Output, names: Iterable[str]) -> Output:
    """The output with those of the observables that the scene can have and the engine measures.

    engine: its name. scene, method: what is run. output: to which they are added. names: of observables; "trajectory".
    """
    declared = engine_class(engine)

    def possible(changed: Output) -> bool:
        return refusal(declared, scene.model_copy(update={"output": changed}), method) is None

    for name in names:
        if name == "trajectory":
            more: dict[str, Any] = {"trajectory": True}
            if scene.lattice_gas is not None:
                continue
            if not output.trajectory and _bytes_of_trajectory(scene, output) > MOST_BYTES:
                continue
        elif name in output.observables or TABLE[name].matter not in scene.matters or not _has(scene, name):
            continue
        else:
            more = {"observables": (*output.observables, name)}
        changed = output.model_copy(update=more)
        if possible(changed):
            output = changed
    return output


def _has(scene: Scene, name: str) -> bool:
    """Whether the scene has the table without which an observable has no meaning."""
    requires = TABLE[name].requires
    found: Any = scene
    if requires is None:
        return True
    for part in requires[0].split("."):
        found = getattr(found, part, None)
        if found is None:
            return False
    return True


def _bytes_of_trajectory(scene: Scene, output: Output) -> float:
    samples = 2.0 if output.interval is None else scene.duration / output.interval + 1
    if output.collisions is not None:
        samples = len(output.collisions) + 1
    return 2 * 8 * samples * scene.number * scene.dimension


def in_steps(duration: float, steps: Sequence[float], most: int = SAMPLES) -> tuple[float, float] | None:
    """A duration up to this one and an interval that divides it into `most` samples at most, both whole numbers of all
    steps; None if there is none.

    duration: time. steps: time steps; none: of an event-driven run.
    """
    if not steps:
        return duration, duration / most
    unit = common_multiple(steps)
    if unit is None or duration < unit * (1 - 1e-9):
        return None
    units = int(np.floor(duration / unit * (1 + 1e-9)))
    every = max(1, -(-units // most))
    return (units // every) * every * unit, every * unit


def common_multiple(steps: Sequence[float], most: int = 4096) -> float | None:
    """The least time that is a whole number of each of the steps, up to `most` times the largest; None: there is none.

    steps: time steps.
    """
    largest = max(steps)
    for number in range(1, most + 1):
        if all(is_whole(number * largest / dt) for dt in steps):
            return number * largest
    return None
