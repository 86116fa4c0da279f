"""Speed of a Lennard-Jones liquid beside LAMMPS."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.performance.speeds import CITATION, EQUATION, beside, criterion
from crosscheck.checks.stepping.fluids import PERIODIC, STEP, fluid
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import explicit
from crosscheck.verdict import Judged

PEER, GOAL = "lammps", 1.5


def _judge(laboratory: Laboratory, number: int) -> Judged:
    """The melt of LAMMPS' own benchmark, lists rebuilt by displacement on both sides; number: of particles."""
    melt = fluid(number, 0.8442, 1.44, laboratory.seed(), duration=1.0)
    start = laboratory.run(melt, STEP)
    steps = 800_000 // number
    scene = melt.changed(
        initial=explicit(start["final_positions"], start["final_velocities"]), duration=steps * STEP.step
    )
    return beside(laboratory, scene, STEP, PEER, GOAL)


CHECKS = (
    Check(
        name="performance/lennard-jones-speed",
        title="Lennard-Jones at rho = 0.8442, cutoff 2.5: speed beside LAMMPS lj/cut/opt",
        equation=EQUATION,
        criterion=criterion("at least 1.5 times LAMMPS"),
        citation=CITATION,
        judge=_judge,
        variants=full(N4000=4000, N32000=32000),
        faults=(
            (
                "N4000",
                Fault(
                    "no-skin",
                    "stepping/forces/lennard_jones.py",
                    "SKIN = 0.8",
                    "SKIN = 0.0001",
                    "the lists have no skin to speak of: they are built at every step",
                ),
            ),
        ),
        needs=Needs("lennard_jones", words=PERIODIC, schemes=(STEP.scheme,), promises=("speed",)),
        reference=PEER,
        timing=True,
    ),
)
