"""Runs of gases in equilibrium as an engine might have returned them: velocities that are drawn, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.engines.workers.pool import Pool
from crosscheck.scene import Box, HardSpheres, Lattice, Method, Output, Scene
from crosscheck.simulate.judging.equilibrium import Equilibrium
from crosscheck.simulate.judging.trial import Bench, Trial
from crosscheck.simulate.methods import Planned
from crosscheck.simulate.observables import Result

EVENTS = Method(scheme="event_driven")


def gas(number: int = 64, dimension: int = 2, **entries: Any) -> Scene:
    """Hard disks or spheres in a periodic box, T = 1."""
    structure: Any = "square" if dimension == 2 else "sc"
    return Scene(
        **(
            {
                "name": "gas",
                "dimension": dimension,
                "duration": 100.0,
                "hard_spheres": HardSpheres(),
                "box": Box(lengths=(12.0,) * dimension),
                "initial": Lattice(kind="lattice", structure=structure, number=number, temperature=1.0, seed=1),
                "output": Output(interval=0.25, trajectory=True),
                "method": EVENTS,
            }
            | entries
        )
    )


def drawn(scene: Scene, seed: int, samples: int = 400) -> np.ndarray:
    """Velocities (samples, N, d) at constant energy and with no total momentum, independent of each other."""
    state, rng = scene.initial_state(), np.random.default_rng(seed)
    v = rng.standard_normal((samples, *state.velocities.shape)) / np.sqrt(state.masses)[:, None]
    v -= np.einsum("i,sij->sj", state.masses, v)[:, None] / state.masses.sum()
    energy = np.einsum("i,sij->s", state.masses, v**2)
    return v * np.sqrt(np.einsum("i,ij->", state.masses, state.velocities**2) / energy)[:, None, None]


def trial(scene: Scene, velocities: Callable[[int], np.ndarray]) -> Trial:
    """A trial whose runs for means are made of `velocities` of a seed, (samples, N, d): another one at each attempt."""
    state = scene.initial_state()
    run = Run(final_positions=state.positions, final_velocities=state.velocities, time=np.array([0.0]))
    planned = Planned("refimpl", "refimpl", scene, EVENTS)
    found = Trial(planned, Result("refimpl", "1", run, {}), Bench(Pool()), 1.0, 1e-3)
    for attempt in range(2):
        v = velocities(attempt)
        times = np.arange(len(v)) * 0.25
        mean = Run(velocities=v, time=times, final_velocities=v[-1], final_positions=state.positions)
        found.shared[f"equilibrium {attempt}"] = Equilibrium(found, scene, mean, 0)
    return found
