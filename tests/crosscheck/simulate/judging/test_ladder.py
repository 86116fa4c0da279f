"""Orders that a ladder of time steps tells, and where it tells none."""

from __future__ import annotations

from crosscheck.simulate.judging.ladder import _with_order


def test_the_order_is_that_by_which_a_change_falls() -> None:
    assert _with_order([4e-3, 1e-3], 1e-9) == (4e-3, 2.0)
    assert _with_order([2e-3, 1e-3], 0.0) == (2e-3, 1.0)


def test_differences_of_rounding_and_a_last_change_have_no_order() -> None:
    assert _with_order([4e-3, 1e-3], 1e-3) == (4e-3, None)
    assert _with_order([1e-3], 0.0) == (1e-3, None)
    assert _with_order([], 0.0) == (None, None)
