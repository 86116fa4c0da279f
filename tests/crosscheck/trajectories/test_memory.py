"""Arrays in memory as a trajectory."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pytest

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import SINGLE, Box, Frame
from crosscheck.trajectories.memory import InMemory, in_memory


@dataclass(frozen=True)
class Noisy(InMemory):
    """A source whose library warns, and fails for the second frame."""

    def _frame(self, index: int) -> Frame:
        warnings.warn("of what nobody asked for", UserWarning, stacklevel=1)
        if index:
            raise KeyError("no such\nchunk")
        return super()._frame(index)


def test_libraries_neither_warn_nor_raise_what_they_like() -> None:
    quiet = in_memory("a.gsd", np.arange(2.0), np.zeros((2, 4, 3)))
    source = Noisy(**{one.name: getattr(quiet, one.name) for one in fields(quiet)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(source.read(0).ids) == 4
        with pytest.raises(UsageError, match=r"a.gsd: frame 1 \(counted from 0\) cannot be read \('no such"):
            source.read(1)


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
