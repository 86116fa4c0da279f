"""The judge of orders on Kepler orbits, on a made-up engine: what it accepts, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.stepping import kepler_order
from crosscheck.checks.stepping.orbits import ECCENTRICITIES, Orbit
from crosscheck.engines.protocol import Claims
from crosscheck.references import kepler
from crosscheck.verdict import findings


@pytest.mark.parametrize("e", ECCENTRICITIES)
@pytest.mark.parametrize(("claimed", "outcome"), [(2, "pass"), (1, "fail"), (3, "fail")])
def test_order(imagined, e: float, claimed: int, outcome: str) -> None:  # type: ignore[no-untyped-def]
    fast = kepler.fastest(e)
    laboratory = imagined(Claims((claimed, claimed)), lambda dt, t: (fast * dt) ** 2 * np.sin(t))
    assert kepler_order._judge(laboratory, Orbit(e, "scheme")).outcome == outcome


def test_a_scheme_that_is_exact_is_judged_by_rounding(imagined) -> None:  # type: ignore[no-untyped-def]
    orbit = Orbit(0.5, "scheme")
    exact = findings(kepler_order._judge(imagined(Claims((2, 2)), lambda dt, t: 0 * t), orbit)).shown
    assert (exact.outcome, exact.criterion.kind) == ("pass", "round_off")
    # an error far above rounding, but the same at all steps, is no convergence
    stuck = kepler_order._judge(imagined(Claims((2, 2)), lambda dt, t: 1e-6 * np.sin(t)), orbit)
    assert stuck.outcome == "fail"
