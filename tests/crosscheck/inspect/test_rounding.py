"""What rounding makes of sums, against numbers that are rounded."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.inspect.rounding import bound_of_sum


@pytest.mark.parametrize("number", [1, 5, 1000])
def test_rounding_to_decimals_stays_within_the_bound(number: int) -> None:
    rng = np.random.default_rng(number)
    values = rng.normal(size=(number, 2000))
    off = np.abs((np.round(values, 3) - values).sum(axis=0))
    bound = bound_of_sum(np.full((number, 1), 0.5e-3))
    assert off.max() <= bound
    # the bound is no more than what Hoeffding's inequality costs: 6.5 against 1/3^(1/2) of one standard deviation
    assert bound == pytest.approx(0.5e-3 * 6.5446 * number**0.5, rel=1e-3)


def test_errors_of_several_kinds_add_up_in_squares() -> None:
    one, other = np.full((4, 3), 3.0), np.full((4, 3), 4.0)
    np.testing.assert_allclose(bound_of_sum(one, other), bound_of_sum(np.full((4, 3), 5.0)))
