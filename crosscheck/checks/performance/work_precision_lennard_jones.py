"""Error against run time of Lennard-Jones particles: of trajectories up to an early time, and of the energy.

Literature: M. P. Allen and D. J. Tildesley, Computer Simulation of Liquids (1987), chapter 3; E. Hairer, S. P. Norsett
and G. Wanner, Solving Ordinary Differential Equations I (1993).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.performance.work_precision_averaging import CRITERION, FACTOR, MEMBERS, averaged
from crosscheck.checks.performance.work_precision_judging import Problem, check
from crosscheck.checks.stepping.fluids import AVERAGE, AVERAGES, FEW_PARTICLES, OPEN, equilibrated
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.references import EPSILON, lennard_jones
from crosscheck.scene import Box, Floats, Lattice, LennardJones, Output, Scene, explicit
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, statistical, worst

_CITATION = "Allen & Tildesley, Computer Simulation of Liquids (1987), chapter 3; Hairer, Norsett & Wanner (1993)"
_NEEDS = Needs("lennard_jones", words=OPEN, observables=frozenset({"positions", "velocities", "potential_energy"}))
_ENERGY = Needs("lennard_jones", words=OPEN, observables=frozenset({"kinetic_energy", "potential_energy"}))


def _cluster() -> Scene:
    """32 particles in open space, T = 0.3; the cutoff lies beyond them all, so that the forces are smooth."""
    lattice = Scene(
        name="fcc",
        dimension=3,
        duration=0.0,
        lennard_jones=LennardJones(cutoff=1.0),
        box=Box(lengths=(3.1, 3.1, 3.1)),
        initial=Lattice(kind="lattice", structure="fcc", number=32, temperature=0.3, seed=7),
    ).initial_state()
    return Scene(
        name="work-precision-lennard-jones",
        dimension=3,
        duration=1.0,
        lennard_jones=LennardJones(cutoff=12.0),
        box=Box(lengths=(20.0, 20.0, 20.0), boundaries=("open", "open", "open")),
        initial=explicit(lattice.positions + 8.0, lattice.velocities),
        # with an energy, the compiled loop is that of stepping/lennard-jones-energy
        output=Output(interval=0.25, trajectory=True, observables=("potential_energy",)),
    )


def _hot() -> Scene:
    """The same cluster, at T = 1.5 and off its lattice, where forces do not cancel; its energy is recorded."""
    cluster = _cluster()
    state = cluster.initial_state()
    off = np.random.default_rng(11).uniform(-0.05, 0.05, state.positions.shape)
    return cluster.changed(
        name="work-precision-lennard-jones-energy",
        initial=explicit(state.positions + off, state.velocities * 5**0.5),
        output=Output(interval=0.02, observables=("kinetic_energy", "potential_energy")),
    )


@cache
def _cluster_solution() -> Floats:
    state = _cluster().initial_state()
    return lennard_jones.open_cluster(state.positions, state.velocities, np.array([0.25, 0.5, 0.75, 1.0]))


def _cluster_error(run: Run) -> float:
    return np.inf if run.diverged else float(abs(run["positions"][1:] - _cluster_solution()).max())


def _energy_error(run: Run) -> float:
    """Root mean square of E(t) - E(0), in units of epsilon a particle."""
    if run.diverged:
        return np.inf
    energy = (run["kinetic_energy"] + run["potential_energy"]) / 32
    return float(np.sqrt(((energy - energy[0]) ** 2).mean()))


def _second(scheme: str, claims: Claims) -> int:
    """2 at most: the higher derivatives that Gear's schemes start from are zero here."""
    return min(claims.order[0], 2) if claims.order else 0


def _cluster_steps(claims: Claims) -> Floats:
    nominal = claims.order[0] if claims.order else 2
    # few: ASE takes milliseconds a step
    return np.asarray((256.0 if nominal == 1 and not claims.symplectic else 32.0) * 2.0 ** np.arange(5))


def _energy_steps(claims: Claims) -> Floats:
    nominal = claims.order[0] if claims.order else 2
    return np.asarray((400.0 if nominal == 1 else 100.0) * 2.0 ** np.arange(6))


PROBLEMS = (
    Problem(
        name="lennard-jones",
        title="a free cluster of 32 Lennard-Jones particles",
        equation="r_i'' = sum_j -phi'(r_ij) r_ij/|r_ij|, phi = 4 (r^-12 - r^-6), for one time unit",
        citation=_CITATION,
        unit="sigma",
        scene=_cluster(),
        error=_cluster_error,
        order=_second,
        numbers=_cluster_steps,
        # the reference's own error, and rounding far below the errors shown
        floor=lambda scheme, steps: 1e-10,
        needs=_NEEDS,
        faults=(
            (
                "velocity_verlet",
                Fault(
                    "attraction-1e-4",
                    "stepping/kernels/lennard_jones.py",
                    "f = q2 * q2 * (q2 * q * repulsion - attraction)",
                    "f = q2 * q2 * (q2 * q * repulsion - attraction * splat(1.0001))",
                    "the attraction is off by 1e-4: the error does not fall below that",
                ),
            ),
        ),
        quick=("velocity_verlet",),
    ),
    Problem(
        name="lennard-jones-energy",
        title="the energy of a hot cluster of 32 Lennard-Jones particles",
        equation="E = K + U, phi = 4 (r^-12 - r^-6): root mean square of E(t) - E(0) a particle, over one time unit",
        citation=_CITATION,
        unit="epsilon",
        scene=_hot(),
        error=_energy_error,
        order=_second,
        numbers=_energy_steps,
        # sums of 496 pairs of some epsilon, in every sample
        floor=lambda scheme, steps: 1e3 * EPSILON,
        needs=_ENERGY,
        faults=(
            (
                "velocity_verlet",
                Fault(
                    "attraction-1e-2",
                    "stepping/kernels/lennard_jones.py",
                    "f = q2 * q2 * (q2 * q * repulsion - attraction)",
                    "f = q2 * q2 * (q2 * q * repulsion - attraction * splat(1.01))",
                    "the attraction is off by 1e-2, the energy is not: it is not conserved",
                ),
            ),
        ),
    ),
)

# -- averages ----------------------------------------------------------------------------------------------------------

_POINT = FEW_PARTICLES
#: Steps of the shortest run, rungs of the ladder, and steps between the starts of independent runs.
_SHORTEST, _RUNGS, _APART = 100, 4, 500


def _judge_average(laboratory: Laboratory, scheme: str) -> Judged:
    """<U>/N of 108 particles from runs of growing length, beside that of another engine from the same starts."""
    method = AVERAGE.model_copy(update={"scheme": scheme})
    other = "lammps" if laboratory.engine == "refimpl" else "refimpl"
    melted = equilibrated(laboratory, _POINT)
    starts = [melted]
    for _ in range(MEMBERS - 1):
        silent = starts[-1].changed(duration=_APART * AVERAGE.step, output=Output())
        run = laboratory.run(silent, AVERAGE, engine="refimpl")
        starts.append(melted.changed(initial=explicit(run["final_positions"], run["final_velocities"])))

    def average(scene: Scene, steps: float, engine: str | None = None) -> tuple[float, Run]:
        duration = int(steps) * AVERAGE.step
        run = laboratory.run(scene.changed(duration=duration), AVERAGE if engine else method, engine=engine)
        return float(run["potential_energy"][1:].mean()) / _POINT.number, run

    amounts = [_SHORTEST * FACTOR**k for k in range(_RUNGS)]
    found = averaged(amounts, lambda steps, member: average(starts[member], steps))
    theirs = [average(start, amounts[-1], other)[0] for start in starts]
    mean = statistical(
        f"u = <U>/N of the longest runs ({laboratory.engine} against {other})",
        *independent_mean(found.values[-1]),
        *independent_mean(theirs),
        "standard errors of independent runs, of both",
        samples=MEMBERS,
    )
    figure = found.figure(
        f"the mean energy of {_POINT.number} Lennard-Jones particles, density {_POINT.density:g}",
        scheme, laboratory.claims[scheme], "steps", lambda run: float(run.cost.steps), "steps",
    )  # fmt: skip
    return worst([found.exponent(), mean], found.merit(), (figure,))


_AVERAGE = Check(
    name="performance/work-precision-lennard-jones-average",
    title="Work and precision on the mean energy of a Lennard-Jones fluid",
    equation="u = <U>/N, density 0.3, T = 2.5, cutoff 3",
    criterion=CRITERION,
    citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 6.4; Wolff, Comput. Phys. Commun. 156, "
    "143 (2004)",
    judge=_judge_average,
    variants=lambda schemes: (Variant(name, name, "full") for name in schemes if name == AVERAGE.scheme),
    faults=(
        (
            "velocity_verlet",
            Fault(
                "energy-1-percent",
                "stepping/kernels/lennard_jones.py",
                "return 0.5 * all_energy, 0.5 * all_work",
                "return 0.505 * all_energy, 0.5 * all_work",
                "the potential energy is 1 % too large",
            ),
        ),
    ),
    needs=AVERAGES,
    timing=True,
)
CHECKS = (*map(check, PROBLEMS), _AVERAGE)
