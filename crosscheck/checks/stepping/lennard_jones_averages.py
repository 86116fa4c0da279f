"""Averages of the fluid from one start, engine against engine."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, Variant, small
from crosscheck.checks.stepping.faults import LOSS, STALE_LISTS
from crosscheck.checks.stepping.fluids import (
    AVERAGE,
    AVERAGES,
    FEW_PARTICLES,
    STATE_POINTS,
    StatePoint,
    energy_kept,
    equilibrated,
    series,
)
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, round_off, statistical, worst

OTHER = "lammps"


def _judge(laboratory: Laboratory, point: StatePoint) -> Judged:
    """T, u and p of two engines that start from one state: the same energy, hence the same averages."""
    scene = equilibrated(laboratory, point)
    judgements, means, starts = [], [], []
    for engine in (laboratory.engine, OTHER):
        run = laboratory.run(scene, AVERAGE, engine=engine)
        starts.append((run["kinetic_energy"][0], run["potential_energy"][0]))
        judgements.append(energy_kept(scene, run, engine))
        if judgements[-1].outcome == "fail":  # the fluid is another one than at the start, and has no averages
            return worst(judgements)
        means.append({name: correlated_mean(values) for name, values in series(scene, run).items()})
    ours, theirs = means
    for name, here, there, terms in zip("KU", *starts, (point.number, point.number**2 / 2), strict=True):
        judgements.append(
            round_off(
                f"relative difference of {name} at the start ({laboratory.engine} against {OTHER})",
                (here - there) / abs(there),
                terms * EPSILON,
                "one state, one energy: the sum loses at most a rounding a term, of particles or pairs",
            )
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
            needed=point.needed if name != "p" else None,
        )
        for name in ("T", "u", "p")
    ]
    return worst(judgements, f"{point.steps} steps of {point.number} particles")


_KINETIC_ENERGY = Fault(
    "kinetic-energy-1-percent",
    "stepping/forces/lennard_jones.py",
    "    return 0.5 * sum_of_squares(v)",
    "    return 0.505 * sum_of_squares(v)",
    "the kinetic energy is 1 % too large",
)

CHECKS = (
    Check(
        name="stepping/lennard-jones-averages",
        title="Temperature, energy and pressure from one start, engine against engine",
        equation="T = 2 <K>/(3 (N - 1)), u = <U>/N, p = (2 <K> + <W>)/3V",
        criterion=(
            "energies of the start equal but for rounding; averages within the standard errors of two correlated "
            "series; a drift, of the energy too, is red"
        ),
        citation="Flyvbjerg & Petersen, J. Chem. Phys. 91, 461 (1989); Wolff, Comput. Phys. Commun. 156, 143 (2004)",
        judge=_judge,
        variants=(
            *(Variant(f"{name}-against-{OTHER}", point, "full") for name, point in STATE_POINTS.items()),
            small(f"rho0.3-T2.5-N108-against-{OTHER}", FEW_PARTICLES, f"rho0.3-T2.5-against-{OTHER}"),
        ),
        faults=(
            ("rho0.8-T1.0-against-lammps", _KINETIC_ENERGY),
            ("rho0.3-T2.5-N108-against-lammps", _KINETIC_ENERGY),
            ("rho0.5-T2.0-against-lammps", LOSS),
            ("rho0.3-T2.5-against-lammps", STALE_LISTS),
        ),
        needs=AVERAGES,
        reference=OTHER,
    ),
)
