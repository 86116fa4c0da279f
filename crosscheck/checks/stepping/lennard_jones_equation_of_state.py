"""Energy and pressure of the fluid, against two equations of state."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, Variant, small
from crosscheck.checks.stepping.faults import LOSS, STALE_LISTS, pair_fault
from crosscheck.checks.stepping.fluids import (
    AVERAGE,
    AVERAGES,
    CUTOFF,
    FEW_PARTICLES,
    STATE_POINTS,
    StatePoint,
    energy_kept,
    equilibrated,
    series,
)
from crosscheck.references import lennard_jones as reference
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, statistical, worst


def _judge(laboratory: Laboratory, point: StatePoint) -> Judged:
    """u and p at the temperature that the run has, against the equations of state."""
    scene = equilibrated(laboratory, point)
    run = laboratory.run(scene, AVERAGE)
    kept = energy_kept(scene, run, laboratory.engine)
    if kept.outcome == "fail":  # what is left may be as hot as no equation of state knows
        return kept
    measured = series(scene, run)
    t = correlated_mean(measured["T"])
    tail = reference.tail(point.density, CUTOFF)
    known = reference.equation_of_state(t.value, point.density)
    warmer = reference.equation_of_state(1.01 * t.value, point.density)
    judgements = [kept]
    for name, correction, field, size in (
        ("u", tail.energy, "energy", abs(known.energy)),
        ("p", tail.pressure, "pressure", point.density * t.value),
    ):
        expected, gap = getattr(known, field), getattr(known, f"{field}_uncertainty")
        # u, p and T fluctuate together: the error is that of the series with the temperature's share taken out
        slope = (getattr(warmer, field) - expected) / (0.01 * t.value)
        mean = correlated_mean(measured[name] - slope * (measured["T"] - t.value))
        judgements.append(
            statistical(
                f"{name} at the temperature of the run",
                mean.value + correction,
                mean.error,
                expected,
                0.0,
                "error of correlated data; off by half the gap between two equations of state, 1/N of it and of T",
                samples=(mean, t),
                # a finite system at constant energy differs by 1/N in the quantity, and in what its temperature is
                doubt=gap + (size + abs(slope) * t.value) / point.number,
                needed=point.needed if name == "u" else None,
            )
        )
    return worst(judgements, f"T = {t.value:.4f} +- {t.error:.4f}")


CHECKS = (
    Check(
        name="stepping/lennard-jones-equation-of-state",
        title="Energy and pressure of the fluid at constant energy, against two equations of state",
        equation="u = <U>/N + u_tail, p = (2 <K> + <W>)/3V + p_tail, at T = 2 <K>/(3 (N - 1))",
        criterion="within the standard errors of correlated data, the gap between the equations, and 1/N; "
        "a drift, of the energy too, is red",
        citation="Kolafa & Nezbeda, Fluid Phase Equilib. 100, 1 (1994); Thol et al., JPCRD 45, 023101 (2016)",
        judge=_judge,
        variants=(
            *(
                Variant(name, point, "quick" if name == "rho0.5-T2.0" else "full")
                for name, point in STATE_POINTS.items()
            ),
            small("rho0.3-T2.5-N108", FEW_PARTICLES, "rho0.5-T2.0"),
        ),
        faults=(
            (
                "rho0.8-T1.0",
                pair_fault(
                    "virial-factor",
                    "return 0.5 * all_energy, 0.5 * all_work",
                    "return 0.5 * all_energy, 0.6 * all_work",
                    "the virial is 20 % too large",
                ),
            ),
            ("rho0.5-T2.0", LOSS),
            ("rho0.3-T2.5-N108", LOSS),
            ("rho0.3-T2.5", STALE_LISTS),
        ),
        needs=AVERAGES,
    ),
)
