"""Strouhal number and drag of plates cover the published ranges, and those of a row of plates."""

from __future__ import annotations

import pytest

from crosscheck.references.vortex_street import plate_drag, plate_strouhal


def test_a_single_plate_has_the_published_range() -> None:
    value, uncertainty, doubt = plate_strouhal(0.0)
    assert uncertainty == 0
    assert (value - doubt, value + doubt) == pytest.approx((0.14, 0.18))
    assert plate_drag(0.0) == (2.0, 3.4)


@pytest.mark.parametrize("blockage", [0.05, 0.15, 0.25])
def test_in_a_row_the_flow_is_faster_by_continuity(blockage: float) -> None:
    """Between the speed far ahead and that between the plates, U/(1 - blockage)."""
    value, _, doubt = plate_strouhal(blockage)
    assert 0.16 < value < 0.16 / (1 - blockage)
    assert value == pytest.approx((0.16 + 0.16 / (1 - blockage)) / 2, abs=0.16 * blockage**2 / 2)
    assert value - doubt < 0.14 < 0.18 < 0.16 / (1 - blockage) + 0.02 < value + doubt + 0.16 * blockage**2
    assert plate_drag(blockage)[1] * (1 - blockage) ** 2 == pytest.approx(3.4)
