"""Trajectories of two engines from one start: the first steps, to rounding."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, quick
from crosscheck.checks.stepping.divergence import melting, separation
from crosscheck.checks.stepping.faults import pair_fault
from crosscheck.checks.stepping.fluids import FORCE_TERM, STEP, TRAJECTORIES
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.scene import Output
from crosscheck.verdict import Judged, round_off

STEPS = 20


def _judge(laboratory: Laboratory, other: str) -> Judged:
    """The first 20 steps, one by one: only rounding may separate the two."""
    scene = melting(laboratory.seed()).changed(
        duration=STEPS * STEP.step, output=Output(interval=STEP.step, trajectory=True)
    )
    run = laboratory.run(scene, STEP)
    apart = separation(run, laboratory.run(scene, STEP, engine=other))
    lengths = scene.lengths()
    assert lengths is not None
    return round_off(
        f"rms separation from {other} after {STEPS} steps",
        float(apart[-1]),
        4 * EPSILON * float(lengths.max()) * STEPS,
        "four roundings of a coordinate a step, and no time for chaos",
        figures=(
            Figure(
                "separation, step by step", "step", "rms separation", "linear", "log",
                (Series("two engines", list(range(1, STEPS + 1)), apart[1:].tolist()),),
            ),
        ),
    )  # fmt: skip


CHECKS = (
    Check(
        name="stepping/lennard-jones-trajectory",
        title="The first 20 steps at constant energy, engine against engine",
        equation="m a = F, velocity Verlet, rho = 0.8442, dt = 0.005",
        criterion="rms separation <= four roundings of a coordinate a step",
        citation="Swope, Andersen, Berens & Wilson, J. Chem. Phys. 76, 637 (1982)",
        judge=_judge,
        variants=quick(**{"against-lammps": "lammps", "against-ase": "ase"}),
        faults=(
            (
                "against-lammps",
                pair_fault(
                    "attraction-1e-9",
                    FORCE_TERM,
                    "f = q2 * q2 * (q2 * q * repulsion - attraction * splat(1.000000001))",
                    "the attraction is off by 1e-9",
                ),
            ),
        ),
        needs=TRAJECTORIES,
        reference=("lammps", "ase"),
    ),
)
