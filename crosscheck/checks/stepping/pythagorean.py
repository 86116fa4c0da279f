"""The Pythagorean problem of three bodies, against the state known to 20 digits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.faults import gravity_fault
from crosscheck.checks.stepping.three_bodies import (
    EQUATION,
    WHY_ROUNDING,
    best,
    best_schemes,
    furthest,
    three_body_scene,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims
from crosscheck.references.three_body import PYTHAGOREAN
from crosscheck.verdict import Judged, round_off

TRIANGLE = three_body_scene("pythagorean", PYTHAGOREAN)


def _variants(schemes: Mapping[str, Claims]) -> tuple[Variant, ...]:
    return tuple(replace(one, tier="full") for one in best_schemes(schemes))


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    found = best(laboratory, scheme, TRIANGLE, PYTHAGOREAN, 120_000)
    return round_off(
        "largest position error at t = 10",
        furthest(found.positions, PYTHAGOREAN.final_positions),
        found.uncertainty,
        WHY_ROUNDING + "; where steps are uneven, from where it matters most",
        note=found.note,
    )


CHECKS = (
    Check(
        name="stepping/pythagorean",
        title="Pythagorean problem of three bodies: positions at t = 10, after close encounters",
        equation=f"{EQUATION}; m = 3, 4, 5 at (1, 3), (-2, -1), (1, -1), at rest",
        criterion="distance from the state known to 20 digits within rounding, carried through the encounters",
        citation="Burrau, Astron. Nachr. 195, 113 (1913); Szebehely & Peters, Astron. J. 72, 876 (1967)",
        judge=_judge,
        variants=_variants,
        faults=(
            (
                "velocity_verlet",
                gravity_fault(
                    "gravity-mass-of-third",
                    "from_i = inverse_cube * mass[i]",
                    "from_i = inverse_cube * mass[i] * 1.00000001",
                    "later bodies attract earlier ones too strongly by 1e-8",
                ),
            ),
        ),
        needs=Needs("gravity", words=frozenset({"dimension=2", "masses[]"})),
    ),
)
