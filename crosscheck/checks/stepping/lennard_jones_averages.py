"""Averages of the fluid from one start, engine against engine."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.stepping.faults import LOSS, STALE_LISTS
from crosscheck.checks.stepping.fluids import (
    AVERAGE,
    AVERAGES,
    PARTICLES,
    STATE_POINTS,
    StatePoint,
    energy_kept,
    equilibrated,
    finite_energy,
    series,
)
from crosscheck.faults import Fault
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, statistical, worst

OTHER = "lammps"


def _judge(laboratory: Laboratory, point: StatePoint) -> Judged:
    """T, u and p of two engines that start from one state: the same energy, hence the same averages."""
    scene = equilibrated(laboratory, point)
    runs = {engine: laboratory.run(scene, AVERAGE, engine=engine) for engine in (laboratory.engine, OTHER)}
    judgements = [energy_kept(scene, run, engine) for engine, run in runs.items()]
    if not all(map(finite_energy, runs.values())):
        return worst(judgements)
    ours, theirs = (
        {name: correlated_mean(values) for name, values in series(scene, run).items()} for run in runs.values()
    )
    judgements += [
        statistical(
            f"{name} ({laboratory.engine} against {OTHER})",
            ours[name].value,
            ours[name].error,
            theirs[name].value,
            theirs[name].error,
            "standard errors of two correlated series",
            samples=(ours[name], theirs[name]),
            needed=0.05 if name != "p" else None,
        )
        for name in ("T", "u", "p")
    ]
    return worst(judgements, f"{point.steps} steps of {PARTICLES} particles")


CHECKS = (
    Check(
        name="stepping/lennard-jones-averages",
        title="Temperature, energy and pressure from one start, engine against engine",
        equation="T = 2 <K>/(3 (N - 1)), u = <U>/N, p = (2 <K> + <W>)/3V",
        criterion="within the standard errors of two correlated series; a drift, of the energy too, is red",
        citation="Flyvbjerg & Petersen, J. Chem. Phys. 91, 461 (1989); Wolff, Comput. Phys. Commun. 156, 143 (2004)",
        judge=_judge,
        variants=variants_of({f"{name}-against-{OTHER}": point for name, point in STATE_POINTS.items()}),
        faults=(
            (
                "rho0.8-T1.0-against-lammps",
                Fault(
                    "kinetic-energy-1-percent",
                    "stepping/forces/lennard_jones.py",
                    "    return 0.5 * sum_of_squares(v)",
                    "    return 0.505 * sum_of_squares(v)",
                    "the kinetic energy is 1 % too large",
                ),
            ),
            ("rho0.5-T2.0-against-lammps", LOSS),
            ("rho0.3-T2.5-against-lammps", STALE_LISTS),
        ),
        needs=AVERAGES,
        reference=OTHER,
    ),
)
