"""Kepler orbits that the checks of this group share: scene, errors, numbers of steps, and what rounding may do."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.convergence import Limit, extrapolate
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.references import kepler
from crosscheck.references.oscillator import rounding_lever
from crosscheck.scene import Floats, Gravity, Kepler, Method, Output, Scene

# No constant is 1, so that a missing factor shows, but mu = G (m_0 + m_1) = a^3, so that n = 1 and the period is 2 pi.
MASSES, G, AXIS = (3.0, 1.0), 2.0, 2.0
MU = G * sum(MASSES)
PERIOD = 2 * np.pi
ECCENTRICITIES = (0.0, 0.5, 0.9, 0.99)
#: Samples a period.
SAMPLES = 16
#: Ratios of the step numbers of an extrapolation: errors in dt^2 up to dt^14 are removed.
SEQUENCE = np.array([1, 2, 3, 4, 6, 8, 12, 16])
#: Largest energy error of a run, to that of its first period: the secular part is as large as the oscillation.
DRIFT = 2.0
WHY_DRIFT = "twice that of the first period: a secular part as large as the oscillation"
#: Standard deviations of rounding: random ones stay within 5, and a bias of the same size within twice that.
SIGMAS = 10.0
WHY_ROUNDING = "10 standard deviations of independent roundings of r and v in every step, carried along the orbit"
#: For schemes that solve the problem exactly: sqrt(steps) times as much, since their roundings may all be alike.
WHY_BIASED = "10 standard deviations of the rounding of r and v, alike in every step, carried along the orbit"

#: Needs of checks that use final states; of those that use samples too.
ORBIT = Needs("gravity", words=frozenset({"dimension=2", "masses[]", "gravity.G"}))
#: Hundreds of thousands of steps: asked of engines that promise to take them in seconds.
LONG_ORBIT = replace(ORBIT, promises=("long_runs",))
SAMPLED_ORBIT = replace(ORBIT, observables=frozenset({"positions", "velocities"}))

ORBITS = "Danby, Fundamentals of Celestial Mechanics (1988), chapter 6; Murray & Dermott, Solar System Dynamics (1999)"
MODIFIED = "Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), chapter IX"
EQUATION = "r'' = -mu r/|r|^3;  E - e sin E = n t + pi,  r = a (e - cos E, -sqrt(1 - e^2) sin E)"


class Orbit(NamedTuple):
    """The value of a variant: the orbit's `eccentricity`, and the `scheme` that follows it."""

    eccentricity: float
    scheme: str

    @property
    def name(self) -> str:
        """Name of the variant."""
        return f"e{self.eccentricity:g}/{self.scheme}"


#: The tier of a scheme: one of each family shows in the quick one what the audits judge step by step for all.
tier_of = tier_beside_audits("velocity_verlet", "symplectic_euler", "gear5")


def kepler_scene(eccentricity: float, periods: float, samples: int | None = None) -> Scene:
    """The orbit from apocentre, for so many periods, with `samples` samples a period or none; eccentricity: 0 to 1."""
    return Scene(
        name=f"kepler-e{eccentricity:g}",
        dimension=2,
        duration=periods * PERIOD,
        masses=MASSES,
        gravity=Gravity(G=G),
        initial=Kepler(kind="kepler", semi_major_axis=AXIS, eccentricity=eccentricity),
        output=Output() if samples is None else Output(interval=PERIOD / samples, trajectory=True),
    )


def position_error(run: Run, eccentricity: float) -> float:
    """Largest distance of a body from its place on the orbit, over all samples, in units of a; infinite if diverged.

    run: with positions. eccentricity: of the orbit.
    """
    if run.diverged:
        return np.inf
    exact, _ = kepler.two_bodies(run["time"], MASSES, eccentricity, AXIS, G)
    return float(np.linalg.norm(run["positions"] - exact, axis=-1).max() / AXIS)


def energies(run: Run) -> Floats:
    """E/|E_0| of every sample of `run`, (samples,); E_0 = -mu/2a, the energy of the orbit."""
    r, v = kepler.relative(run["positions"]), kepler.relative(run["velocities"])
    return np.asarray(kepler.energy(r, v, MU) * (2 * AXIS / MU))


def departure(series: Floats) -> float:
    """Largest difference of a value of `series`, (samples,), from the first one."""
    return float(abs(series - series[0]).max())


def rounding_floor(scheme: str, eccentricity: float, periods: float, steps: float) -> float:
    """Error of the position by rounding, at most, in units of a.

    scheme: name. eccentricity, periods: of the run. steps: of the whole run.
    """
    lever = rounding_lever(scheme, steps / (PERIOD * periods))
    return SIGMAS * lever * kepler.rounding_error(eccentricity, periods, steps)


def step_numbers(eccentricity: float, largest: float, runs: int, multiple: int = SAMPLES) -> Floats:
    """Steps a period of several runs, (runs,), doubled each time.

    eccentricity: of the orbit. largest: step of the first run, times the angular speed at pericentre. runs: how many.
    multiple: all are multiples of it, by default of the samples a period.
    """
    coarsest = np.ceil(PERIOD * kepler.fastest(eccentricity) / largest / multiple)
    return np.asarray(multiple * coarsest * 2.0 ** np.arange(runs))


def nominal_order(scheme: str, claims: Claims) -> int:
    """Order of the position's error, from the scheme's name and claims.

    2 at most for Gear's schemes: they start without the higher derivatives, which gravity does not give.
    """
    assert claims.order is not None
    return min(claims.order[0], 2) if scheme.startswith("gear") else claims.order[0]


def extrapolated(laboratory: Laboratory, eccentricity: float, periods: int) -> tuple[Limit, float, Floats]:
    """Final relative position/a of velocity Verlet, extrapolated to dt = 0; its rounding error; the steps a period.

    laboratory: runs it. eccentricity, periods: of the run.
    """
    numbers = step_numbers(eccentricity, 0.4, 1, 1)[0] * SEQUENCE
    scene = kepler_scene(eccentricity, periods)
    runs = [laboratory.run(scene, Method(scheme="velocity_verlet", dt=PERIOD / n)) for n in numbers]
    limit = extrapolate(1 / numbers, [kepler.relative(run["final_positions"]) / AXIS for run in runs])
    each = np.array([rounding_floor("velocity_verlet", eccentricity, periods, n * periods) for n in numbers])
    return limit, float(np.sqrt(((limit.weights * each) ** 2).sum())), numbers
