"""Peaks and projections of the thesis's experiments, on signals whose answer is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.lattice.thesis import CELL, SAMPLES, Box, _cosine, _peak


@given(
    peak=st.integers(1, SAMPLES // 2),
    away=st.floats(-0.4, 0.4),
    mean=st.floats(-10, 10),
    more=st.integers(0, 100),
)
def test_peaks_are_those_of_the_nearest_bin(peak: int, away: float, mean: float, more: int) -> None:
    """Bin n is that of n periods in the samples, counted from 0; further samples and the mean are left out."""
    bins = peak if peak in (1, SAMPLES // 2) else peak + away
    times = np.arange(SAMPLES + more)
    signal = mean + np.cos(2 * np.pi * bins * times / SAMPLES)
    signal[SAMPLES:] = 1e3
    assert _peak(signal) == peak


def test_the_largest_of_two_lines_and_other_lengths() -> None:
    times = np.arange(SAMPLES) / SAMPLES
    signal = np.cos(2 * np.pi * 36 * times) + 1.5 * np.sin(2 * np.pi * 12 * times)
    assert _peak(signal) == 12
    assert _peak(signal, SAMPLES // 4) == 3


@pytest.mark.parametrize("number", [1, 2, 3])
def test_projections_on_cosines_between_the_walls(number: int) -> None:
    columns = 305
    x = (np.arange(columns // CELL) + 0.5) * CELL - 0.5
    amplitudes = np.array([[0.1, 0.05], [-0.2, 0.0]])
    strips = amplitudes[..., None] * np.cos(number * math.pi * x / (columns - 1))
    box = Box(np.arange(2.0), strips, columns)
    # cells reach half a site beyond the wall sites
    np.testing.assert_allclose(_cosine(box, number), amplitudes, rtol=0.01, atol=1e-15)
    assert np.abs(_cosine(box, number + 1)).max() < 0.01 * np.abs(amplitudes).max()
