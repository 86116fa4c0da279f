"""The judge of rounding on Kepler orbits, on a made-up engine: what it accepts, and what it refuses."""

from __future__ import annotations

from crosscheck.checks.stepping import kepler_round_off
from crosscheck.checks.stepping.orbits import Orbit
from crosscheck.engines.protocol import Claims


def test_adaptive_scheme_at_the_limit_of_rounding(imagined) -> None:  # type: ignore[no-untyped-def]
    claims, orbit = Claims(None), Orbit(0.9, "scheme")
    assert kepler_round_off._judge(imagined(claims, lambda dt, t: 0 * t), orbit).outcome == "pass"
    assert kepler_round_off._judge(imagined(claims, lambda dt, t: 1e-10 + 0 * t), orbit).outcome == "fail"


def test_variants_are_those_of_schemes_that_can_reach_the_limit() -> None:
    schemes = {"velocity_verlet": Claims((2, 2)), "euler": Claims((1, 1)), "own_steps": Claims(None)}
    names = [variant.name for variant in kepler_round_off._variants(schemes)]
    assert names == [
        *("e0/velocity_verlet", "e0/own_steps", "e0.5/velocity_verlet", "e0.5/own_steps"),
        *("e0.9/velocity_verlet", "e0.9/own_steps", "e0.99/own_steps"),
    ]
