"""Runs of one Lennard-Jones liquid that differ in one thing, as trajectories in memory."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from crosscheck.compare.differences import Gap
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.scene import Scene
from crosscheck.scene.parts import Method
from crosscheck.scene.starts import explicit
from crosscheck.trajectories.frames import SINGLE, Box, Floats, Rounding
from crosscheck.trajectories.memory import InMemory, in_memory

DT = 0.005
NUMBER = 32
#: Ways to print numbers: the function that rounds them, and what is known of it.
ROUNDINGS: dict[str, tuple[Callable[[Floats], Floats], Rounding]] = {
    "float32": (lambda x: x.astype(np.float32).astype(np.float64), SINGLE),
    "%g": (lambda x: np.vectorize(lambda one: float(f"{one:g}"))(x), Rounding(0.0, 5e-6, "6 significant digits")),
}


def liquid(seed: int = 1, **changes: Any) -> Scene:
    """A liquid of 32 particles that records every 0.1 for 12 units of time."""
    entries = {
        "name": "liquid",
        "dimension": 3,
        "duration": 12.0,
        "lennard_jones": {"cutoff": 1.6, "truncation": "shifted"},
        "box": {"density": 0.7},
        "initial": {
            "kind": "lattice", "structure": "fcc", "number": NUMBER, "temperature": 2.4, "seed": seed
        },
        "method": {"scheme": "velocity_verlet", "dt": DT},
        "output": {"interval": 0.1, "trajectory": True},
    }  # fmt: skip
    return Scene.model_validate(entries | changes)


def run(scene: Scene, dt: float = DT) -> dict[str, Floats]:
    """What a run of the scene recorded."""
    return dict(RefimplEngine().run(scene, Method(scheme="velocity_verlet", dt=dt)))


def from_state(scene: Scene, positions: Floats, velocities: Floats, **changes: Any) -> Scene:
    """The scene from another start."""
    return scene.changed(initial=explicit(positions, velocities), **changes)


def trajectory(
    scene: Scene,
    arrays: dict[str, Floats],
    name: str = "run",
    rounding: str = "",
    *,
    wrapped: bool = False,
    dt: float = DT,
) -> InMemory:
    """A run as a trajectory, rounded as a file would, and wrapped into the box if asked."""
    lengths = scene.own_start().lengths
    assert lengths is not None
    positions, velocities = arrays["positions"], arrays["velocities"]
    if wrapped:
        positions = positions - np.floor(positions / lengths) * lengths
    known: dict[str, Any] = {}
    if rounding:
        rounded, known["rounding"] = ROUNDINGS[rounding]
        positions, velocities = rounded(positions), rounded(velocities)
    return in_memory(
        name,
        arrays["time"],
        positions,
        velocities,
        steps=np.rint(arrays["time"] / dt).astype(np.int64),
        box=Box(np.diag(lengths), np.zeros(3), np.ones(3, dtype=bool)),
        wrapping="wrapped" if wrapped else "unwrapped",
        **known,
    )


def kicked(scene: Scene, at: float, particle: int, axis: int, kick: float) -> dict[str, Floats]:
    """The run of the scene, in which one velocity changes by `kick` right after the sample at the time `at`."""
    first = run(scene.changed(duration=at))
    velocities = first["velocities"][-1].copy()
    velocities[particle, axis] += kick
    rest = run(from_state(scene, first["positions"][-1], velocities, duration=scene.duration - at))
    joined = {name: np.concatenate([first[name], rest[name][1:]]) for name in ("positions", "velocities")}
    return joined | {"time": np.concatenate([first["time"], at + rest["time"][1:]])}


def gap(time: float, **known: Any) -> Gap:
    """Two frames of five particles that are the same."""
    same = Gap(
        time=time, same=True, beyond=None, differing=None, rms={"positions": 0.0}, largest={"positions": 0.0},
        farthest={"positions": 7}, floor={"positions": 1e-16}, most={"positions": 1e-16}, extent=3.0, number=5,
        missing=(0, 0), kinetic=(1.5, 1.5), finite=True, momentum=((0.0,) * 3, (3.0, 4.0, 0.0)),
        momentum_rounding=1e-9, momentum_scale=5.0,
    )  # fmt: skip
    return same._replace(**known)
