"""The judge of invariants on Kepler orbits, on a made-up engine: what it accepts, and what it refuses."""

from __future__ import annotations

from crosscheck.checks.stepping import kepler_invariants
from crosscheck.engines.protocol import Claims


def test_invariants_of_an_engine_that_is_exact(imagined) -> None:  # type: ignore[no-untyped-def]
    laboratory = imagined(Claims((2, 2), symplectic=True), lambda dt, t: 0 * t)
    assert kepler_invariants._judge(laboratory, "scheme").outcome == "pass"


def test_invariants_see_a_drift(imagined) -> None:  # type: ignore[no-untyped-def]
    laboratory = imagined(Claims((2, 2), symplectic=True), lambda dt, t: dt**2 * t)
    assert kepler_invariants._judge(laboratory, "scheme").outcome == "fail"


def test_invariants_see_a_start_that_is_not_that_of_the_orbit(imagined) -> None:  # type: ignore[no-untyped-def]
    """Constants of the motion, but wrong ones: over those of the start, they would not show."""
    laboratory = imagined(Claims((2, 2), symplectic=True), lambda dt, t: 1e-9 + 0 * t)
    assert kepler_invariants._judge(laboratory, "scheme").outcome == "fail"
