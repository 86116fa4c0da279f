"""Forces, energy and virial in boxes shorter than two cutoffs, where a particle meets several images of another."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.stepping.fluids import LISTS, POTENTIAL, STATICS, STEP, fluid, shaken
from crosscheck.checks.stepping.statics import Static, compare
from crosscheck.faults import Fault
from crosscheck.references import lennard_jones as reference
from crosscheck.scene import Box, Lattice, LennardJones, Scene, Wall
from crosscheck.verdict import Judged

_LISTS_FILE = "stepping/kernels/neighbours.py"


def _boxes() -> dict[str, Scene]:
    cube = fluid(32, 32 / 3.36**3, 0.0, 0)
    half = tuple(int(kind) for kind in np.arange(32) % 2)
    plane = Lattice(kind="lattice", structure="triangular", number=20, temperature=0.0, seed=0)
    channel = Box(lengths=(2.0, 3.0, 9.0), boundaries=("periodic", "periodic", "wall"), wall=Wall(cutoff=2.5))
    mixture = LennardJones(cutoff=2.5, epsilon=(1.0, 0.5), length=(1.0, 0.88))
    return {
        "cube": cube,
        "force-shifted": fluid(32, 32 / 3.36**3, 0.0, 0, truncation="force_shifted"),
        "mixture": cube.changed(species=half, lennard_jones=mixture),
        "own-images": fluid(4, 0.8, 0.0, 0, cutoff=4.0),
        "one-particle": fluid(1, 0.9, 0.0, 0, cutoff=3.5),
        "slab": fluid(200, 0.8, 0.0, 0).changed(box=Box(lengths=(10.0, 12.5, 2.0))),
        "channel": fluid(36, 0.8, 0.0, 0).changed(box=channel),
        "2d": cube.changed(dimension=2, box=Box(lengths=(2.1, 11.0)), initial=plane),
    }


def _judge(laboratory: Laboratory, box: Scene) -> Judged:
    scene = shaken(box, 0.05, laboratory.seed())
    sums = reference.pair_sum(scene)
    return compare(Static.of(laboratory.run(scene, STEP)), Static.summed(sums), sums, "a direct sum over images")


CHECKS = (
    Check(
        name="stepping/small-box",
        title="Forces, energy and virial in boxes shorter than two cutoffs or one, against a direct sum over images",
        equation=f"{POTENTIAL}; over all images within the cutoff, and U, W over a particle's own images by half",
        criterion="largest difference, relative to the sum of the terms' sizes, <= 2 x 14 (L/r_min) eps",
        citation=f"{LISTS}; sections 1.5.2-1.5.3, periodic images and the minimum image",
        judge=_judge,
        variants=variants_of(_boxes()),
        faults=(
            (
                "own-images",
                Fault(
                    "one-shell-of-images",
                    _LISTS_FILE,
                    "around = np.ceil((reach + 2 * rounding) * inverse) if side > 0 else 0.0",
                    "around = min(cells, np.ceil((reach + 2 * rounding) * inverse)) if side > 0 else 0.0",
                    "no images beyond the boxes next to that of the particles",
                ),
            ),
            (
                "slab",
                Fault(
                    "images-above-once",
                    _LISTS_FILE,
                    "high = min(grid.c.cells - 1, grid.c.around - 1 - (shift_c - 1) * grid.c.cells)",
                    "high = min(grid.c.cells - 1, grid.c.around - 1) if shift_c < 2 else -1",
                    "along the last axis, images above the particles in one box only",
                ),
            ),
        ),
        needs=STATICS,
    ),
)
