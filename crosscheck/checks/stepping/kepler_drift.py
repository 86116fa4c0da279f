"""The energy of schemes that are not symplectic drifts on a Kepler orbit: an expected failure."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.orbits import (
    DRIFT,
    MODIFIED,
    PERIOD,
    SAMPLED_ORBIT,
    SAMPLES,
    WHY_DRIFT,
    departure,
    energies,
    kepler_scene,
    tier_of,
)
from crosscheck.engines.protocol import Claims
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.scene import Method
from crosscheck.verdict import Judged, bounded, round_off, worst


def _drifts(name: str, claims: Claims) -> bool:
    """Beeman's positions are Verlet's; the schemes with a zero start are the others here."""
    others = claims.order is not None and claims.symplectic is False and not name.endswith("zero_start")
    return others and not name.startswith("beeman")


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    claimed = laboratory.claims[scheme].order
    assert claimed is not None
    e = 0.5
    number, periods = (2048, 20) if claimed[0] == 1 else (64, 100)
    run = laboratory.run(kepler_scene(e, periods, SAMPLES), Method(scheme=scheme, dt=PERIOD / number))
    energy = energies(run)
    first = departure(energy[: SAMPLES + 1])
    curve = Series(scheme, (run["time"] / PERIOD).tolist(), (energy + 1).tolist())
    drifts = bounded(
        f"largest energy error, {periods} periods to the first",
        departure(energy) / first,
        DRIFT,
        WHY_DRIFT,
        expected_failure=True,
        note=f"{number} steps a period; energy error in the first {first:.2g} |E0|",
        figures=(Figure(f"energy, e = 0.5, {number} steps a period", "periods", "(E - E0)/|E0|", series=(curve,)),),
    )
    start = round_off("energy of the start + |E0|, over |E0|", energy[0] + 1, 16 * EPSILON, "roundings of the state")
    return worst([start, drifts])


CHECKS = (
    Check(
        name="stepping/kepler-drift",
        title="The energy of schemes that are not symplectic drifts on a Kepler orbit",
        equation="E = v^2/2 - mu/r",
        criterion=f"expected failure: energy error of the whole run >= {DRIFT:g} times that of the first period",
        citation=MODIFIED,
        judge=_judge,
        variants=schemes_with(_drifts, tier_of),
        faults=(
            (
                "gear5",
                scheme_fault(
                    "gear-two-derivatives",
                    "            scaled[q] += self.corrector[q] * change\n",
                    "            if q == 1 or q == 2:\n                scaled[q] += change\n",
                    "r_1 and r_2 alone are corrected: velocity Verlet, whose energy does not drift",
                ),
            ),
            (
                "euler_pc",
                scheme_fault(
                    "euler-pc-not-predicted",
                    "v_new = v + dt * accelerate(force, r + dt * v, v + dt * a)",
                    "v_new = v + dt * a",
                    "the prediction is not used: symplectic Euler, whose energy does not drift",
                ),
            ),
        ),
        needs=SAMPLED_ORBIT,
    ),
)
