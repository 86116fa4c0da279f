"""Arrays in memory as a trajectory."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from crosscheck.trajectories.frames import SINGLE, Box
from crosscheck.trajectories.memory import in_memory


def test_arrays_come_back_frame_by_frame() -> None:
    positions, velocities = np.random.default_rng(1).normal(size=(2, 3, 4, 3))
    box = Box(np.eye(3), np.zeros(3), np.ones(3, dtype=bool))
    source = in_memory(
        "a",
        np.arange(3.0),
        positions,
        velocities,
        steps=np.array([0, 5, 10]),
        box=box,
        rounding=SINGLE,
        wrapping="wrapped",
    )
    assert len(source) == 3
    assert source.path == Path("a")
    assert source.rounding["positions"] == SINGLE
    for k, frame in enumerate(source.frames()):
        assert np.array_equal(frame.positions, positions[k])
        assert np.array_equal(frame.velocities, velocities[k])
        assert (frame.time, frame.step) == (k, 5 * k)
        assert frame.ids.tolist() == [1, 2, 3, 4]
        assert frame.box is box
    assert in_memory("b", np.arange(3.0), positions).read(0).velocities is None
