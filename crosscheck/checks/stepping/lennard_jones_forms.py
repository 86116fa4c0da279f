"""Forces, energy and virial in every form of the potential, against a direct pair sum."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.faults import pair_fault
from crosscheck.checks.stepping.fluids import LISTS, POTENTIAL, STATICS, STEP, fluid, shaken
from crosscheck.checks.stepping.statics import Static, compare
from crosscheck.references import lennard_jones as reference
from crosscheck.scene import Box, Lattice, LennardJones, Scene, Wall
from crosscheck.verdict import Judged


def _forms() -> dict[str, Scene]:
    base = fluid(500, 0.8, 0.0, 0)
    half = tuple(int(kind) for kind in np.arange(500) % 2)
    lattice2 = Lattice(kind="lattice", structure="triangular", number=400, temperature=0.0, seed=0)
    walls = Box(lengths=(9.0, 8.0, 11.0), boundaries=("periodic", "periodic", "wall"), wall=Wall(cutoff=2.5))
    return {
        "truncated": base,
        "shifted": fluid(500, 0.8, 0.0, 0, truncation="shifted"),
        "force-shifted": fluid(500, 0.8, 0.0, 0, truncation="force_shifted"),
        "r_m": base.changed(lennard_jones=LennardJones(cutoff=2.5, length=1.1, length_form="r_m")),
        "mixture": base.changed(
            species=half, lennard_jones=LennardJones(cutoff=2.5, epsilon=(1.0, 0.5), length=(1.0, 0.88))
        ),
        "2d": base.changed(dimension=2, box=Box(density=0.8), initial=lattice2),
        "walls": base.changed(box=walls),
    }


def _judge(laboratory: Laboratory, form: Scene) -> Judged:
    scene = shaken(form, 0.05, laboratory.seed())
    sums = reference.pair_sum(scene)
    return compare(Static.of(laboratory.run(scene, STEP)), Static.summed(sums), sums, "a direct pair sum")


CHECKS = (
    Check(
        name="stepping/lennard-jones-forms",
        title="Forces, energy and virial in every form of the potential, against a direct pair sum",
        equation=f"{POTENTIAL}; truncated, shifted, force-shifted; sigma and r_m = 2^(1/6) sigma; mixtures; walls; 2D",
        criterion="largest difference, relative to the sum of the terms' sizes, <= 2 x 14 (L/r_min) eps",
        citation=LISTS,
        judge=_judge,
        # a kernel of its own, which takes long to compile: the quick tier has disks in the audit of features
        variants=tuple(Variant(name, form, "full" if name == "2d" else "quick") for name, form in _forms().items()),
        faults=(
            (
                "mixture",
                pair_fault(
                    "mixing-rule",
                    "length = size + load_splat(sizes, j)",
                    "length = size + size",
                    "unlike pairs take the size of one partner",
                ),
            ),
            (
                "force-shifted",
                pair_fault(
                    "force-shift-sign",
                    "f = f + _slope_at_cutoff(",
                    "f = f - _slope_at_cutoff(",
                    "the force shift has the wrong sign",
                ),
            ),
        ),
        needs=STATICS,
    ),
)
