"""An engine of one's own in one's own tests: `pytest test_my_engine.py`, with particle-crosscheck installed.

Each case of these checks is a test. `docs/pytest.md` has the arguments of the marker.
"""

import pytest

from crosscheck.verdict import Verdict


@pytest.mark.crosscheck(engine="my_engine.py:MyEngine", checks=["stepping/gravity-*", "stepping/kepler-precession"])
def test_gravity() -> None:
    """Red, or inconclusive, fails the test: nothing is to be done here."""


@pytest.mark.crosscheck(
    engine="my_engine.py:MyEngine",
    checks="stepping/kepler-order",
    # an order that is off by 15 % must be seen; the check alone asks for nothing
    needed={"order of the position error": 0.15},
)
def test_order(crosscheck_verdict: Verdict) -> None:
    """A green verdict is looked at further: velocity Verlet evaluates the forces once a step."""
    cost = crosscheck_verdict.cost
    assert cost["steps"] < cost["evaluations"] < 1.05 * cost["steps"]
