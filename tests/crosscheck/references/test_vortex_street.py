"""The Strouhal number of plates covers the published range, and that of a row of plates."""

from __future__ import annotations

import pytest

from crosscheck.references.vortex_street import plate_strouhal


def test_a_single_plate_has_the_published_range() -> None:
    value, uncertainty = plate_strouhal(0.0)
    assert (value - uncertainty, value + uncertainty) == pytest.approx((0.14, 0.18))


@pytest.mark.parametrize("blockage", [0.05, 0.15, 0.25])
def test_in_a_row_the_flow_is_faster_by_continuity(blockage: float) -> None:
    """Between the speed far ahead and that between the plates, U/(1 - blockage)."""
    value, _ = plate_strouhal(blockage)
    assert 0.16 < value < 0.16 / (1 - blockage)
    assert value == pytest.approx((0.16 + 0.16 / (1 - blockage)) / 2, abs=0.16 * blockage**2 / 2)
