"""Bisection of the largest stable step, on limits that are known."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.granular.step_limit import bisect


@given(limit=st.floats(0.91, 1.09))
def test_bisect(limit: float) -> None:
    assert bisect(lambda x: x > limit, 0.9, 1.1, 1e-6) == pytest.approx(limit, abs=1e-6)


@pytest.mark.parametrize("always", [False, True])
def test_bisect_wants_the_limit_between(always: bool) -> None:
    with pytest.raises(ValueError, match="does not lie between"):
        bisect(lambda x: always, 0.9, 1.1, 1e-6)
