"""Fluids of `refimpl` far from the origin, in short boxes, and in runs that truly diverge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crosscheck.engines.refimpl.engine import RefimplEngine
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import Unsupported
from crosscheck.scene import Box, Gravity, LennardJones, Method, Output, Scene, Spring, explicit

MINIMUM = 2 ** (1 / 6)


def fluid(positions: Any, velocities: Any, **changes: Any) -> Scene:
    entries: dict[str, Any] = {
        "name": "fluid",
        "dimension": 2,
        "duration": 1.0,
        "lennard_jones": LennardJones(cutoff=2.5),
        "box": Box(lengths=(4.0, 4.0)),
        "initial": explicit(np.array(positions), np.array(velocities)),
        "output": Output(interval=0.25, observables=("kinetic_energy", "potential_energy"), trajectory=True),
    }
    return Scene(**(entries | changes))


def test_a_bound_pair_streams_through_1e9_boxes(interpreted: Worker) -> None:
    """At 5e5 boxes a step: no divergence, the energy of the minimum, and the place to the rounding of the distance."""
    steps, dt = 2_000, 2.0**-8
    speed = 4.0 * 5e5 / dt
    scene = fluid([[1.0, 1.0], [1.0, 1.0 + MINIMUM]], [[speed, 0.0]] * 2, duration=steps * dt)
    scene = scene.changed(output=scene.output.model_copy(update={"interval": steps * dt / 4}))
    run = interpreted.run(scene, Method(scheme="velocity_verlet", dt=dt))
    assert not run.diverged
    np.testing.assert_allclose(run["positions"][:, :, 0], 1.0 + speed * run["time"][:, None] * [1, 1], rtol=1e-13)
    assert abs(run["positions"][-1] / 4).max() >= 1e9
    np.testing.assert_allclose(run["potential_energy"], run["potential_energy"][0], rtol=1e-12)
    np.testing.assert_allclose(run["positions"][:, 1, 1] - run["positions"][:, 0, 1], MINIMUM, rtol=1e-12)


@pytest.mark.parametrize("box", [None, Box(lengths=(4.0, 4.0))])
def test_an_overlap_at_the_start_explodes_and_is_named(interpreted: Worker, box: Box | None) -> None:
    scene = fluid([[1.0, 1.0], [1.001, 1.0], [2.5, 2.0]], np.zeros((3, 2)), box=box)
    run = interpreted.run(scene, Method(scheme="velocity_verlet", dt=2.0**-8))
    assert run.diverged
    assert np.isfinite(run["positions"][0]).all()
    assert np.isnan(run["positions"][-1]).all()


def test_a_box_too_short_for_its_images_is_refused(interpreted: Worker) -> None:
    short = fluid([[0.0, 0.0]] * 1, [[0.0, 0.0]], box=Box(lengths=(1e-6, 1e-6)))
    with pytest.raises(Unsupported, match="images of particles within cutoff"):
        interpreted.run(short, Method(scheme="velocity_verlet", dt=2.0**-8))


def test_what_is_not_computed_is_not_declared() -> None:
    line = explicit(np.array([[0.0], [1.0]]), np.zeros((2, 1)))
    of = {capability.interaction: capability.words for capability in RefimplEngine.capabilities}
    assert "dimension=1" not in of["gravity"]
    assert {"dimension=1", "masses[]"} <= of["spring"]
    Scene(name="line", dimension=1, duration=1.0, gravity=Gravity(), initial=line)
    Scene(name="line", dimension=1, duration=1.0, spring=Spring(k=1.0), masses=(1.0, 2.0), initial=line)
