"""Frames that belong together, whatever clock a file has."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.compare.pairing import pair
from crosscheck.compare.units import factor
from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import Units
from crosscheck.trajectories.memory import InMemory, in_memory


def source(times: Any, steps: Any = None, name: str = "one", **units: str) -> InMemory:
    times = np.asarray(times, dtype=np.float64)
    known = None if steps is None else np.asarray(steps, dtype=np.int64)
    made = in_memory(name, times, np.zeros((len(times), 2, 3)), steps=known)
    return replace(made, units=Units(**units))


@given(st.integers(1, 400), st.sampled_from([0.001, 0.1, 1.6, 2.0]))
def test_times_of_32_bits_are_the_times(count: int, interval: float) -> None:
    times = np.arange(count) * interval
    rounded = times.astype(np.float32).astype(np.float64)
    summed = np.cumsum(np.full(count, interval, dtype=np.float32), dtype=np.float32) - np.float32(interval)
    for other in (rounded, summed[:8]):
        found = pair(source(times), source(other))
        assert found.clock == "time"
        assert list(found.first) == list(found.second) == list(range(len(other)))


@given(st.permutations(range(12)), st.lists(st.integers(0, 11), max_size=4))
def test_any_order_and_doubles_give_the_same_pairs(order: list[int], doubles: list[int]) -> None:
    times = np.array([*order, *doubles]) * 0.5
    found = pair(source(np.arange(12) * 0.5), source(times, name="two"))
    assert list(found.first) == list(range(12))
    assert list(times[found.second]) == list(np.arange(12) * 0.5)
    # of duplicates, the last one of the file
    assert all(k == np.flatnonzero(times == times[k])[-1] for k in found.second)
    told = " ".join(found.remarks)
    assert ("are of one time" in told) == bool(doubles)
    assert ("frames are sorted" in told) == bool((np.diff(times) < 0).any())


def test_steps_go_before_the_order_and_times_before_steps() -> None:
    timed, stepped = (
        source([0.0, 0.5, 1.0], [0, 100, 200], time="tau"),
        source([0, 100, 200], [0, 100, 200], time="step"),
    )
    assert pair(timed, stepped).clock == "step"
    assert pair(stepped, timed).clock == "step"
    assert pair(stepped, stepped).clock == "step"  # no time in which velocities could be compared with positions
    nothing = source([np.nan] * 3)
    found = pair(timed, nothing)
    assert found.clock == "order"
    assert "by their order" in found.remarks[0]
    for one, other in ((nothing, source([np.nan] * 5, name="two")), (source([np.nan] * 5, name="two"), nothing)):
        found = pair(one, other)
        assert list(found.first) == list(found.second) == [0, 1, 2]
        assert list(found.times) == [0, 1, 2]
        assert found.remarks[1:] == ("2 of 5 frames of two have no counterpart.",)


def test_units_are_converted_and_said() -> None:
    real = source([0.0, 1000.0], length="Angstrom", time="fs", velocity="Angstrom/fs")
    nano = source([0.0, 1.0], name="two", length="nm", time="ps", velocity="nm/ps")
    found = pair(real, nano)
    assert found.clock == "time"
    assert len(found.first) == 2
    assert found.length == pytest.approx(10.0)
    assert found.velocity == pytest.approx(0.01)
    assert "the length of two is converted from nm to Angstrom." in found.remarks
    assert found.spin == pytest.approx(0.001)
    stepped = source([0, 1000], name="steps", length="nm", time="step", velocity="nm/ps")
    assert pair(real, stepped).spin == pytest.approx(0.001)
    assert pair(real, source([0.0, 1000.0], name="no", length="nm")).spin == 1.0
    reduced = source([0.0, 1000.0], name="three", length="sigma", time="tau", velocity="sigma/tau")
    assert "reduced units" in pair(real, reduced).remarks[0]


def test_units_that_cannot_be_converted_are_refused() -> None:
    with pytest.raises(UsageError, match="its length is in furlong, that of one in nm"):
        pair(source([0.0], length="nm"), source([0.0], name="two", length="furlong"))


def test_times_that_never_agree_are_refused() -> None:
    with pytest.raises(UsageError, match=r"no frame of one has the time of a frame of the other \(0 to 1 and 5 to 6\)"):
        pair(source([0.0, 1.0]), source([5.0, 6.0], name="two"))


def test_factors_of_units() -> None:
    assert factor("nm", "Angstrom") == pytest.approx(10.0)
    assert factor("Angstrom/fs", "m/s") == pytest.approx(1e5)
    assert factor("Angstrom/ASE-time", "Angstrom/fs") == pytest.approx(0.09822694788, rel=1e-8)
    assert factor("LAMMPS-electron-time", "fs") == pytest.approx(1.03275, rel=1e-5)
    assert factor("Bohr/atu", "m/s") == pytest.approx(2187691.262, rel=1e-8)
    assert factor("", "nm") == factor("nm", "") == factor("nm", "nm") == 1.0
    assert factor("nm", "ells") is None
