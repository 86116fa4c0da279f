"""Forces, energy and virial of one configuration, engine against engine."""

from __future__ import annotations

from dataclasses import replace

from crosscheck.checks.base import Check, Laboratory, full, quick
from crosscheck.checks.stepping.faults import pair_fault
from crosscheck.checks.stepping.fluids import FORCE_TERM, LISTS, PERIODIC, POTENTIAL, STATICS, STEP, fluid, shaken
from crosscheck.checks.stepping.statics import Static, compare
from crosscheck.references import lennard_jones as reference
from crosscheck.verdict import Judged


def _judge(laboratory: Laboratory, other: str) -> Judged:
    """other: the engine that is compared with."""
    scene = shaken(fluid(4000, 0.8442, 0.0, 0), 0.05, laboratory.seed())
    ours = Static.of(laboratory.run(scene, STEP))
    theirs = Static.of(laboratory.run(scene, STEP, engine=other))
    return compare(ours, theirs, reference.pair_sum(scene), other)


CHECKS = (
    Check(
        name="stepping/lennard-jones-configuration",
        title="Forces, energy and virial of one configuration of 4000 particles, engine against engine",
        equation=POTENTIAL,
        criterion="largest difference, relative to the sum of the terms' sizes, <= 2 x 14 (L/r_min) eps",
        citation=LISTS,
        judge=_judge,
        # ASE takes seconds for 4000 particles
        variants=(*quick(**{"against-lammps": "lammps"}), *full(**{"against-ase": "ase"})),
        faults=(
            (
                "against-lammps",
                pair_fault(
                    "repulsion-1e-9",
                    FORCE_TERM,
                    "f = q2 * q2 * (q2 * q * repulsion * splat(1.000000001) - attraction)",
                    "the repulsion is off by 1e-9",
                ),
            ),
        ),
        needs=replace(STATICS, words=PERIODIC),
        reference=("lammps", "ase"),
    ),
)
