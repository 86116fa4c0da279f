"""A made-up engine that knows Kepler's orbit, for the judges to accept or refuse."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
import pytest

from crosscheck.checks.base import Laboratory
from crosscheck.checks.stepping import orbits
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times
from crosscheck.references import kepler
from crosscheck.scene import Method, Scene

Error = Callable[[float, np.ndarray], np.ndarray]


class Imagined:
    """A laboratory whose engine knows the orbit, and adds `error(dt, t)` to the first coordinate of the second body."""

    engine = "imagined"

    def __init__(self, claims: Claims, error: Error) -> None:
        self.claims = {"scheme": claims}
        self._error = error

    def run(self, scene: Scene, method: Method, engine: str | None = None, *, may_end_early: bool = False) -> Run:
        eccentricity = float(scene.name.removeprefix("kepler-e"))
        t = sample_times(scene, method)
        r, v = kepler.two_bodies(t, orbits.MASSES, eccentricity, orbits.AXIS, orbits.G)
        r[:, 1, 0] += self._error(method.step, t)
        final = {"final_positions": r[-1], "final_velocities": v[-1]}
        return Run({"time": t, **final, "positions": r, "velocities": v}, cost=Cost(steps=scene.steps(method.step)))


@pytest.fixture
def imagined() -> Callable[[Claims, Error], Laboratory]:
    """The laboratory, from the claims of its scheme and its error."""
    return lambda claims, error: cast(Laboratory, Imagined(claims, error))
