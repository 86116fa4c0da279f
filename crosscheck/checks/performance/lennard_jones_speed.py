"""Speed of a Lennard-Jones liquid beside LAMMPS."""

from __future__ import annotations

from pathlib import Path

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.performance.speeds import CITATION, EQUATION, beside, by_two_threads, criterion
from crosscheck.checks.performance.stepping_races import melt
from crosscheck.checks.stepping.fluids import PERIODIC, STEP
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.verdict import Judged

PEER = "lammps"
#: Times as fast as the peer with vectors of eight doubles, and with shorter ones; and what is asked for of it.
GOAL_WIDE, GOAL, ASKED = 5.0, 3.0, 0.9
#: Speed of two threads over that of one.
TWO_THREADS = 1.8


def _has_eight_lanes() -> bool:
    """Whether the processor has AVX-512; False where the system does not say."""
    flags = Path("/proc/cpuinfo")
    return flags.exists() and "avx512f" in flags.read_text(encoding="utf-8")


def _judge(laboratory: Laboratory, number: int) -> Judged:
    """The melt of LAMMPS' own benchmark, lists rebuilt by displacement on both sides; number: of particles."""
    scene = melt(laboratory, number).changed(duration=800_000 // number * STEP.step)
    return beside(laboratory, scene, STEP, PEER, ASKED * (GOAL_WIDE if _has_eight_lanes() else GOAL))


def _judge_threads(laboratory: Laboratory, number: int) -> Judged:
    """One thread beside two; number: of particles."""
    scene = melt(laboratory, number).changed(duration=3_200_000 // number * STEP.step)
    return by_two_threads(laboratory, scene, STEP, ASKED * TWO_THREADS, f"{number} particles, velocity Verlet")


CHECKS = (
    Check(
        name="performance/lennard-jones-speed",
        title="Lennard-Jones at rho = 0.8442, cutoff 2.5: speed beside LAMMPS lj/cut/opt",
        equation=EQUATION,
        criterion=criterion("at least 0.9 of the goal: 5 times LAMMPS with AVX-512, 3 times without"),
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
    Check(
        name="performance/lennard-jones-threads",
        title="Lennard-Jones at rho = 0.8442, cutoff 2.5: two threads beside one",
        equation="elapsed seconds of one thread/elapsed seconds of two",
        criterion="at least 0.9 of the goal, 1.8; inconclusive where two cores are not free",
        citation="Amdahl, AFIPS Conf. Proc. 30, 483 (1967)",
        judge=_judge_threads,
        variants=full(N4000=4000, N32000=32000),
        faults=(
            (
                "N4000",
                Fault(
                    "one-piece-of-tiles",
                    "stepping/kernels/neighbours.py",
                    "PART, LEAST_TILES = 16, 4",
                    "PART, LEAST_TILES = 16, 1_000_000",
                    "the tiles are one piece of work, which nobody can share",
                ),
            ),
        ),
        needs=Needs(
            "lennard_jones",
            words=PERIODIC | {"method.threads"},
            schemes=(STEP.scheme,),
            promises=("speed",),
        ),
        timing=True,
    ),
)
