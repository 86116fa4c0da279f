"""Work-precision diagrams: the error of every scheme against CPU time and against evaluations of the force.

To add a problem: one `Problem` in `PROBLEMS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Tier, schemes_with
from crosscheck.checks.operations import evaluations_of
from crosscheck.checks.stepping import orbits
from crosscheck.checks.stepping.fluids import OPEN
from crosscheck.checks.stepping.orbits import SAMPLED_ORBIT, SIGMAS, WHY_BIASED
from crosscheck.checks.stepping.springs import MASS, OMEGA0, SPRING, STIFFNESS
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lennard_jones, oscillator
from crosscheck.scene import Box, Explicit, Floats, Lattice, LennardJones, Method, Output, Scene, Spring, explicit
from crosscheck.statistics import fitted_order
from crosscheck.verdict import Judged, order, round_off, worst

#: Times that every run is repeated, unless it takes longer than `LONG` CPU seconds; the median counts.
REPEATS, LONG = 3, 0.05

#: Left to the full tier: two schemes show the families, and the audits of `stepping` judge the steps of all.
FULL = (
    *("euler", "modified_euler", "euler_pc", "beeman", "beeman_pc", "symplectic_euler", "verlet"),
    *("gear2", "gear3", "gear4", "gear4_velocity", "gear5_velocity", "gear4_zero_start", "gear5_zero_start"),
)
#: These too, of the problem whose force takes longest to compile.
FULL_OF = {"lennard-jones": ("leapfrog", "gear5")}


@dataclass(frozen=True)
class Problem:
    """A case with a known solution.

    name: of the problem; its check is called work-precision-`name`. title: what the scene is, in words. equation,
    citation, needs, faults: as of a `Check`. scene: without its time step. error: of a run, in `unit`. unit: of the
    error. order: that a scheme shows here, from its name and claims. numbers: of steps of a run, from the claims,
    coarsest first. floor: what rounding makes of the error, from the scheme and the number of steps.
    """

    name: str
    title: str
    equation: str
    citation: str
    unit: str
    scene: Scene
    error: Callable[[Run], float]
    order: Callable[[str, Claims], int]
    numbers: Callable[[Claims], Floats]
    floor: Callable[[str, float], float]
    needs: Needs
    faults: tuple[tuple[str, Fault], ...]


# -- the problems ------------------------------------------------------------------------------------------------------

PERIODS = 10
#: Samples a period: at whole and half periods, the errors of some schemes vanish.
SAMPLES = 5
_R0, _V0 = 1.0, 0.7 * OMEGA0
_AMPLITUDE = float(np.hypot(_R0, _V0 / OMEGA0))
_PERIOD = 2 * np.pi / OMEGA0


def _ladder(claims: Claims, first: int, second: int, higher: int, explicit: int, runs: int) -> Floats:
    """Steps of a whole run, doubled each time; the coarsest, per sample, is small enough for the order to show.

    first, second, higher: by the order. explicit: of first order and not symplectic, whose error grows exponentially.
    """
    nominal = claims.order[0] if claims.order else 2
    coarsest = {1: first if claims.symplectic else explicit, 2: second}.get(nominal, higher)
    return np.asarray(coarsest * SAMPLES * PERIODS * 2.0 ** np.arange(runs))


def _oscillator_error(run: Run) -> float:
    exact, _ = oscillator.solution(run["time"], _R0, _V0, OMEGA0, 0.0)
    return np.inf if run.diverged else float(abs(run["positions"][:, 0, 0] - exact).max() / _AMPLITUDE)


def _oscillator_floor(scheme: str, steps: float) -> float:
    lever = oscillator.rounding_lever(scheme, steps / (2 * np.pi * PERIODS))
    return SIGMAS * lever * oscillator.rounding_error(steps)


_EVALUATIONS = Fault(
    "evaluations-of-the-start",
    "stepping/integrate.py",
    "starts * table.start_evaluations + done * table.evaluations",
    "done * table.evaluations",
    "the evaluations of the start are not counted",
)
_ECCENTRICITY = 0.5


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


@cache
def _cluster_solution() -> Floats:
    state = _cluster().initial_state()
    return lennard_jones.open_cluster(state.positions, state.velocities, np.array([0.25, 0.5, 0.75, 1.0]))


def _cluster_error(run: Run) -> float:
    return np.inf if run.diverged else float(abs(run["positions"][1:] - _cluster_solution()).max())


def _cluster_steps(claims: Claims) -> Floats:
    nominal = claims.order[0] if claims.order else 2
    # few and coarse: ASE takes milliseconds a step
    return np.asarray((256.0 if nominal == 1 and not claims.symplectic else 32.0) * 2.0 ** np.arange(4))


PROBLEMS = (
    Problem(
        name="oscillator",
        title=f"the undamped oscillator, {PERIODS} periods",
        equation="m r'' = -k r",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), chapter 3; Hairer, Norsett & Wanner (1993)",
        unit="amplitude",
        scene=Scene(
            name="work-precision-oscillator",
            dimension=1,
            duration=PERIODS * _PERIOD,
            masses=MASS,
            spring=Spring(k=STIFFNESS),
            initial=Explicit(positions=((_R0,),), velocities=((_V0,),)),
            output=Output(interval=_PERIOD / SAMPLES, trajectory=True),
        ),
        error=_oscillator_error,
        order=lambda scheme, claims: claims.order[0] if claims.order else 0,
        numbers=partial(_ladder, first=64, second=8, higher=4, explicit=128, runs=7),
        floor=_oscillator_floor,
        needs=SPRING,
        faults=(
            ("velocity_verlet", _EVALUATIONS),
            (
                "gear5",
                Fault(
                    "gear5-second",
                    "stepping/schemes.py",
                    "_GEAR5 = (3 / 20, 251 / 360, 1.0",
                    "_GEAR5 = (3 / 20, 251.251 / 360, 1.0",
                    "one coefficient is off by 1e-3: the error falls too slowly",
                ),
            ),
        ),
    ),
    Problem(
        name="kepler",
        title=f"a Kepler orbit, e = {_ECCENTRICITY:g}, {PERIODS} periods",
        equation="r'' = -mu r/|r|^3",
        citation="Danby, Fundamentals of Celestial Mechanics (1988), chapter 6; Rein & Spiegel, MNRAS 446, 1424 (2015)",
        unit="a",
        scene=orbits.kepler_scene(_ECCENTRICITY, PERIODS, SAMPLES),
        error=partial(orbits.position_error, eccentricity=_ECCENTRICITY),
        order=orbits.nominal_order,
        numbers=partial(_ladder, first=50, second=25, higher=25, explicit=2500, runs=6),
        floor=lambda scheme, steps: orbits.rounding_floor(scheme, _ECCENTRICITY, PERIODS, steps),
        needs=SAMPLED_ORBIT,
        faults=(("leapfrog", _EVALUATIONS),),
    ),
    Problem(
        name="lennard-jones",
        title="a free cluster of 32 Lennard-Jones particles",
        equation="r_i'' = sum_j -phi'(r_ij) r_ij/|r_ij|, phi = 4 (r^-12 - r^-6), for one time unit",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), chapter 3; Hairer, Norsett & Wanner (1993)",
        unit="sigma",
        scene=_cluster(),
        error=_cluster_error,
        # the higher derivatives that Gear's schemes start from are zero here, which leaves order 2
        order=lambda scheme, claims: min(claims.order[0], 2) if claims.order else 0,
        numbers=_cluster_steps,
        # the reference's own error, and rounding far below the errors shown
        floor=lambda scheme, steps: 1e-10,
        needs=Needs(
            "lennard_jones", words=OPEN, observables=frozenset({"positions", "velocities", "potential_energy"})
        ),
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
    ),
)


# -- the judge ---------------------------------------------------------------------------------------------------------


def expected_evaluations(engine: str, scheme: str, steps: int) -> int | None:
    """Evaluations of the force by this scheme of this engine, in `steps` steps and at the start; None if not known.

    engine, scheme: names.
    """
    if engine != "refimpl" and (engine, scheme) != ("lammps", "velocity_verlet"):
        return None
    start, each = evaluations_of(scheme)
    return start + steps * each


def _judge(laboratory: Laboratory, scheme: str, problem: Problem) -> Judged:
    claims = laboratory.claims[scheme]
    numbers = problem.numbers(claims)
    if claims.order is None:  # adaptive: the step is its own
        numbers = numbers[:1]
    errors, cpu, evaluations, miscounted = [], [], [], 0
    for n in numbers.astype(int).tolist():
        runs = _repeated(laboratory, problem.scene, Method(scheme=scheme, dt=problem.scene.duration / n))
        errors.append(problem.error(runs[0]))
        cpu.append(float(np.median([run.cost.cpu for run in runs])))
        evaluations.append(runs[0].cost.evaluations)
        expected = expected_evaluations(laboratory.engine, scheme, n)
        if expected is not None:
            miscounted = max(miscounted, *(abs(run.cost.evaluations - expected) for run in runs))
    figures = _figures(problem, scheme, errors, cpu, evaluations)
    steps = runs[0].cost.steps
    floor = problem.floor(scheme, steps)
    biased = floor * steps**0.5
    if max(errors) <= biased:
        note = f"to rounding at every step; {cpu[0]:.2g} s at the largest"
        return round_off(f"largest error/{problem.unit}", max(errors), biased, WHY_BIASED, note=note, figures=figures)
    slope = fitted_order(1 / np.array(evaluations if all(evaluations) else numbers), errors, floor)
    judgements = [
        order(
            "order of the error in the number of evaluations",
            slope.value,
            problem.order(scheme, claims),
            ORDER_TOLERANCE,
            WHY_ORDER,
            uncertainty=slope.error,
        )
    ]
    if expected is not None:
        why = "a count: steps times those of a step, and the start's"
        judgements.append(round_off("evaluations miscounted", miscounted, 0.5, why))
    each = cpu[-1] / evaluations[-1] * 1e9 if evaluations[-1] else np.nan
    return worst(judgements, f"{each:.0f} ns an evaluation", figures)


def _repeated(laboratory: Laboratory, scene: Scene, method: Method) -> list[Run]:
    runs = [laboratory.run(scene, method, may_end_early=True)]
    while len(runs) < REPEATS and runs[0].cost.cpu < LONG:
        runs.append(laboratory.run(scene, method, may_end_early=True))
    return runs


def _figures(
    problem: Problem, scheme: str, errors: list[float], cpu: list[float], evaluations: list[int]
) -> tuple[Figure, ...]:
    y = f"largest position error/{problem.unit}"
    time = Series(scheme, cpu, errors)
    figures = [Figure(f"error against CPU time, {problem.name}", "CPU time/s", y, "log", "log", (time,))]
    if all(evaluations):
        count = Series(scheme, [float(number) for number in evaluations], errors)
        title = f"error against force evaluations, {problem.name}"
        figures.append(Figure(title, "evaluations of the force", y, "log", "log", (count,)))
    return tuple(figures)


def _tier(scheme: str, problem: str) -> Tier:
    return "full" if scheme in (*FULL, *FULL_OF.get(problem, ())) else "quick"


def _check(problem: Problem) -> Check:
    return Check(
        name=f"performance/work-precision-{problem.name}",
        title=f"Work and precision on {problem.title}",
        equation=problem.equation,
        criterion="error = C evaluations^-order, order as claimed +- "
        f"{ORDER_TOLERANCE}: {WHY_ORDER}; evaluations counted exactly; CPU time is shown, not judged",
        citation=problem.citation,
        judge=partial(_judge, problem=problem),
        variants=schemes_with(tier=partial(_tier, problem=problem.name)),
        faults=problem.faults,
        needs=problem.needs,
        timing=True,
    )


CHECKS = tuple(map(_check, PROBLEMS))
