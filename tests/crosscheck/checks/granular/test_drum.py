"""Means of two laws between which a third one lies."""

from __future__ import annotations

from crosscheck.checks.granular.drum import between
from crosscheck.statistics import Mean

_LOW, _HIGH = Mean(1.0, 0.3, 10.0, 2.0), Mean(2.0, 0.4, 20.0, 4.0)


def test_middle_of_two_means_with_the_larger_error_and_half_their_difference() -> None:
    expected = (Mean(1.5, 0.4, 20.0, 4.0), 0.5)
    assert between(_LOW, _HIGH) == between(_HIGH, _LOW) == expected
