"""The pressure on walls from a run that is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.events import ideal_gas
from crosscheck.engines.protocol import Run
from crosscheck.references import hard_walls
from crosscheck.scene import Box, HardSpheres, Scene, explicit


def test_pressure_of_one_disk_that_bounces_to_and_fro() -> None:
    """v = 3/7 along x in a box of 10: a hit of 2 v every (L - sigma)/v; the virial theorem holds at any time."""
    length, v = 10.0, 3 / 7
    time = np.linspace(0.0, 10000.0, 61)
    way = (5.0 - 0.5 + v * time) / (length - 1)  # in crossings
    hits, phase = np.floor(way), way % 2
    x = 0.5 + (length - 1) * np.where(phase < 1, phase, 2 - phase)
    impulse = np.zeros((61, 4, 2))
    impulse[:, 1, 0], impulse[:, 0, 0] = 2 * v * np.ceil(hits / 2), -2 * v * np.floor(hits / 2)
    counts = np.zeros((61, 4))
    counts[:, 0] = hits
    scene = Scene(
        name="one",
        dimension=2,
        duration=10000.0,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(length, length), boundaries=("hard", "hard")),
        initial=explicit(np.array([[5.0, 5.0]]), np.array([[v, 0.0]])),
    )
    positions = np.stack([x, np.full(61, 5.0)], axis=1)[:, None, :]
    velocities = np.stack([np.where(phase < 1, v, -v), np.zeros(61)], axis=1)[:, None, :]
    run = Run(
        time=time,
        positions=positions,
        velocities=velocities,
        wall_impulse=impulse,
        wall_collisions=counts,
        collisional_virial=np.zeros(61),
        collisions=np.zeros(61),
    )
    found = ideal_gas._wall_pressure(scene, run)
    assert found.residual < 1e-12
    # the ideal gas in (L - sigma)^2, here with v^2/2 in the place of T; without noise
    ideal = hard_walls.ideal_wall_pressure(1, length, 2, 0.5 * v * v, 1.0)
    assert found.mean.value == pytest.approx(ideal, rel=1e-12)
    assert found.mean.error < 1e-12
    assert found.impulse.value == pytest.approx(2 * v)
