"""Error against run time of Kepler orbits of four eccentricities.

Literature: J. M. A. Danby, Fundamentals of Celestial Mechanics (1988), chapter 6; H. Rein and D. S. Spiegel, Mon. Not.
R. Astron. Soc. 446, 1424 (2015).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from crosscheck.checks.performance.work_precision_judging import Problem, check
from crosscheck.checks.performance.work_precision_oscillator import EVALUATIONS
from crosscheck.checks.stepping import orbits
from crosscheck.checks.stepping.faults import gravity_fault
from crosscheck.checks.stepping.orbits import SAMPLED_ORBIT
from crosscheck.engines.protocol import Claims, Run
from crosscheck.references import kepler
from crosscheck.scene import Floats

#: Samples a period: at whole and half periods, the errors of some schemes vanish.
SAMPLES = 5
#: Periods of a run, by eccentricity.
PERIODS = {0.0: 10, 0.5: 10, 0.9: 4, 0.99: 2}
#: Of the orbits that start far from where their errors arise.
_WHY_AT_LEAST = (
    "at apocentre, where the run starts, the terms of lowest order (of Gear's zero start, of symplectic Euler's shift "
    "of the phase) are so small that those of higher order outweigh them at all steps above rounding"
)


def _numbers(claims: Claims, eccentricity: float) -> Floats:
    """Steps of a whole run, doubled each time, from steps of about a radian at pericentre."""
    nominal = claims.order[0] if claims.order else 2
    explicit = nominal == 1 and not claims.symplectic
    # the error of explicit Euler grows exponentially, unless steps are far smaller
    finer, runs = (1024, 6) if explicit else (8, 8) if nominal == 1 else (1, 9)
    coarsest = int(np.ceil(2 * np.pi * kepler.fastest(eccentricity) / SAMPLES))
    return np.asarray(finer * coarsest * SAMPLES * PERIODS[eccentricity] * 2.0 ** np.arange(runs))


def _accept(scheme: str, claims: Claims, eccentricity: float) -> bool:
    """Explicit schemes of first order lose an orbit of high eccentricity at any step that can be paid for."""
    return eccentricity < 0.9 or claims.order is None or claims.order[0] > 1 or bool(claims.symplectic)


def _error(run: Run, eccentricity: float) -> float:
    return np.inf if run.stopped else orbits.position_error(run, eccentricity)


def _problem(eccentricity: float) -> Problem:
    e, periods = eccentricity, PERIODS[eccentricity]
    measured = gravity_fault(
        "gravity-off-at-pericentre",
        "inverse_cube = G / (square * sqrt(square))",
        "inverse_cube = G / (square * sqrt(square) + 1e-3)",
        "a softening of 1e-3 in the cube of the distance: the orbit precesses",
    )
    return Problem(
        name="kepler" if e == 0.5 else f"kepler-e{e:g}",
        title=f"a Kepler orbit, e = {e:g}, {periods} periods",
        equation="r'' = -mu r/|r|^3",
        citation="Danby, Fundamentals of Celestial Mechanics (1988), chapter 6; Rein & Spiegel, MNRAS 446, 1424 (2015)",
        unit="a",
        scene=orbits.kepler_scene(e, periods, SAMPLES),
        error=partial(_error, eccentricity=e),
        order=orbits.nominal_order,
        numbers=partial(_numbers, eccentricity=e),
        floor=lambda scheme, steps: orbits.rounding_floor(scheme, e, periods, max(steps, 1)),
        needs=SAMPLED_ORBIT,
        faults=(("leapfrog", EVALUATIONS),) if e == 0.5 else (("velocity_verlet", measured),),
        accept=partial(_accept, eccentricity=e),
        at_least=_WHY_AT_LEAST if e >= 0.9 else "",
        quick=("leapfrog", "velocity_verlet", "gear5", "whfast", "ias15", "DOP853") if e == 0.5 else (),
    )


PROBLEMS = tuple(map(_problem, PERIODS))
CHECKS = tuple(map(check, PROBLEMS))
