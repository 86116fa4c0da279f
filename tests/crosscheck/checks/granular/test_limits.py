"""The logic that the checks of soft contacts at their limits bring with them, by independent routes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks.granular.limits import EXPLODED, STABLE_STEPS, bisect, growth_delay, sticking_bound
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import HookeImpact, SoftContact, damping, stability_limit


def _stick(contact: SoftContact, resolution: float, phase: float) -> float:
    """u'/u of a contact that sticks, step by step."""
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    c, h = damping(contact.alpha), resolution * exact.contact_time
    x, v, u, stretch = phase * h, 1.0, 1.0, 0.0
    while x > 0:
        v -= h * (x + c * v)
        x += h * v
        if contact.friction == "history":
            stretch += resolution * u
            u -= resolution * math.acos(contact.alpha_t) ** 2 * stretch
        else:
            u += resolution * math.log(contact.alpha_t) * u
    return u


@given(
    alpha=st.floats(0.1, 1.0),
    alpha_t=st.floats(-1.0, 1.0),
    history=st.booleans(),
    steps=st.floats(20, 300),
    phase=st.floats(0.001, 1.0),
)
@settings(deadline=None, max_examples=60)
def test_sticking_bound_holds_at_every_phase(
    alpha: float, alpha_t: float, history: bool, steps: float, phase: float
) -> None:
    law = "history" if history else "dashpot"
    contact = SoftContact(alpha, alpha_t if history else max(abs(alpha_t), 0.05), math.inf, 0.4, law)  # type: ignore[arg-type]
    found = _stick(contact, 1 / steps, phase)
    assert abs(found - contact.alpha_t) <= sticking_bound(contact, 1 / steps) + 10 * EPSILON


# -- stability ---------------------------------------------------------------------------------------------------------


@given(limit=st.floats(0.91, 1.09))
def test_bisect(limit: float) -> None:
    assert bisect(lambda x: x > limit, 0.9, 1.1, 1e-6) == pytest.approx(limit, abs=1e-6)


@pytest.mark.parametrize("always", [False, True])
def test_bisect_wants_the_limit_between(always: bool) -> None:
    with pytest.raises(ValueError, match="does not lie between"):
        bisect(lambda x: always, 0.9, 1.1, 1e-6)


@pytest.mark.parametrize("c", [0.0, 1e-3, 0.2, 1.4])
def test_growth_delay_is_where_the_map_explodes(c: float) -> None:
    def explodes(share: float) -> bool:
        h = share * stability_limit(c)
        powers = np.linalg.matrix_power(np.array([[1 - h * h, h * (1 - c * h)], [-h, 1 - c * h]]), STABLE_STEPS)
        return bool(abs(powers @ [0.0, 1.0]).max() > EXPLODED)

    delay = bisect(explodes, 1 - 1e-9, 1.002, 1e-10) - 1
    assert 0 < delay <= growth_delay(c) < 1e-3
    # near a double eigenvalue, at c = 0, the amplitude grows with the number of steps by itself, and needs less
    assert delay > growth_delay(c) / 20
