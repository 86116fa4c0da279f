"""Times of a run that goes on."""

from __future__ import annotations

import numpy as np
import pytest
from hard_disks import disks
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.engines.refimpl.continuation import Continuation, absolute_times
from crosscheck.errors import UsageError
from crosscheck.scene import Output


@given(st.sampled_from([0.1, 0.3, 0.7, 1e-13, 2.0]), st.integers(1, 40), st.integers(1, 40))
def test_samples_are_those_of_a_run_without_a_break(interval: float, before: int, more: int) -> None:
    scene = disks(output=Output(interval=interval))
    start = before * interval
    whole = scene.changed(duration=start + more * interval).samples()
    found = absolute_times(scene.changed(duration=more * interval), start)
    np.testing.assert_array_equal(found, whole[before : before + len(found)])


def test_samples_off_the_grid_and_without_an_interval() -> None:
    scene = disks(output=Output(interval=0.5))
    np.testing.assert_array_equal(absolute_times(scene, 0.0), scene.samples())
    np.testing.assert_array_equal(absolute_times(scene, 0.25), 0.25 + scene.samples())
    np.testing.assert_array_equal(absolute_times(disks(output=Output()), 3.0), [3.0, 5.0])


def test_arrays_that_do_not_fit_are_an_error_of_the_user() -> None:
    ends = Continuation({"r": np.zeros(3)})
    with pytest.raises(UsageError, match=r"the restart file does not fit: array r has the shape \(3,\), not \(2,\)"):
        ends.restored({"r": np.zeros(2)})
    assert Continuation().restored({"r": 1}) == {"r": 1}
