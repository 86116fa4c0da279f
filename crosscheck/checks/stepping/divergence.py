"""How far two runs from one start are apart: what the checks of trajectories share."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.stepping.fluids import STEP, fluid
from crosscheck.engines.protocol import Run
from crosscheck.scene import Floats, Lattice, Output, Scene

#: Small enough for many starts; the box is just twice the cutoff.
_TRAJECTORY = fluid(108, 0.8442, 1.44, 0)
_STEPS, _EVERY = 2400, 20


def separation(one: Run, two: Run) -> Floats:
    """Root of the mean squared difference of a coordinate between two runs, (samples,); one, two: of one scene."""
    return np.sqrt(((one["positions"] - two["positions"]) ** 2).mean(axis=(1, 2)))


def melting(seed: int) -> Scene:
    """A lattice with random velocities, which melts; seed: of the velocities."""
    initial = _TRAJECTORY.initial
    assert isinstance(initial, Lattice)
    return _TRAJECTORY.changed(
        initial=initial.model_copy(update={"seed": seed}),
        duration=_STEPS * STEP.step,
        output=Output(interval=_EVERY * STEP.step, trajectory=True),
    )
