"""Arrays that a worker hands to the suite as plain numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crosscheck.engines.workers.states import hand_over, taken_over

ARRAYS = {
    "time": np.array([0.0, -0.0, np.nan, np.inf, 5e-324]),
    "positions": np.arange(24.0).reshape(2, 3, 4).transpose(2, 0, 1),  # not contiguous
    "event_times": np.zeros(0),
    "event_velocities": np.zeros((0, 2, 3)),
}


def test_arrays_come_back_bit_by_bit(tmp_path: Path) -> None:
    shapes = hand_over(tmp_path / "run", ARRAYS)
    found = taken_over(tmp_path / "run", shapes)
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert found[name].shape == array.shape
        assert found[name].tobytes() == array.tobytes()
    found["positions"][0, 0, 0] = 7.0  # a check may write to what it was given


@pytest.mark.parametrize("name", ["time", "positions"])
@pytest.mark.parametrize("change", [-1, 1])
def test_shapes_that_are_not_those_of_the_file_are_refused(tmp_path: Path, name: str, change: int) -> None:
    shapes = hand_over(tmp_path / "run", ARRAYS)
    shapes[name][0] += change
    with pytest.raises(ValueError, match="does not hold the"):
        taken_over(tmp_path / "run", shapes)
