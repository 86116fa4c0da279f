"""Frames in the order of their ids."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.trajectories.frames import DOUBLE, Frame, Rounding, chosen, first_line, ordered

FRAME = Frame(
    0.5,
    3,
    np.array([7, 2, 5]),
    np.arange(9.0).reshape(3, 3),
    velocities=np.arange(9.0, 18).reshape(3, 3),
    types=np.array(["a", "b", "c"]),
    masses=np.array([1.0, 2, 3]),
)


def test_all_columns_follow_the_ids() -> None:
    frame = ordered(FRAME)
    assert frame.ids.tolist() == [2, 5, 7]
    assert frame.positions[:, 0].tolist() == [3, 6, 0]
    assert frame.velocities is not None
    assert frame.velocities[:, 0].tolist() == [12, 15, 9]
    assert frame.types is not None
    assert frame.types.tolist() == ["b", "c", "a"]
    assert frame.masses is not None
    assert frame.masses.tolist() == [2, 3, 1]
    assert frame.spins is frame.diameters is None
    assert (frame.time, frame.step) == (0.5, 3)
    assert ordered(frame) is frame


def test_some_of_the_particles() -> None:
    assert chosen(FRAME, FRAME.ids > 2).ids.tolist() == [7, 5]


def test_no_id_is_there_twice() -> None:
    with pytest.raises(ValueError, match="two particles have the id 7"):
        ordered(FRAME._replace(ids=np.array([7, 2, 7])))
    with pytest.raises(ValueError, match="two particles have the id 2"):
        ordered(FRAME._replace(ids=np.array([2, 7, 2])))


def test_a_rounding_is_absolute_and_relative() -> None:
    assert Rounding(0.5, 0.25, "x").of(np.array([0.0, -2, 4])).tolist() == [0.5, 1, 1.5]
    assert DOUBLE.of(np.array([1.0]))[0] == 2.0**-53


def test_the_first_line_of_an_error_is_shown() -> None:
    assert first_line(ValueError("one\ntwo")) == "one"
    assert first_line(ValueError()) == "ValueError"
