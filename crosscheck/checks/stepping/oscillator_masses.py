"""Oscillators of unlike masses in one scene: each against the exact numerical solution for its own mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.springs import DAMPED
from crosscheck.faults import Fault
from crosscheck.references import EPSILON, oscillator
from crosscheck.scene import Method, Output, Scene, Spring, explicit
from crosscheck.verdict import Judged, round_off, worst

#: Masses in units of m, for which omega0 = 1.
MASSES = (1.0, 0.7, 9.0)
STEPS, STEP, DAMPING = 200, 0.1, 0.2
#: Schemes of different kinds of memory; the others take as long to compile and are judged by the full tier.
_QUICK = ("velocity_verlet", "gear5_velocity")


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    rng = np.random.default_rng(laboratory.seed())
    r0, v0 = rng.uniform(0.5, 1.0, (2, len(MASSES), 2))
    scene = Scene(
        name="oscillator-masses",
        dimension=2,
        duration=STEPS * STEP,
        masses=MASSES,
        spring=Spring(k=1.0, gamma=DAMPING),
        initial=explicit(r0, v0),
        output=Output(interval=STEP, trajectory=True, observables=("kinetic_energy",)),
    )
    run = laboratory.run(scene, Method(scheme=scheme, dt=STEP))
    kinetic = np.zeros(STEPS + 1)
    judgements = []
    why = f"four roundings a step, added up over {STEPS} steps"
    for particle, mass in enumerate(MASSES):
        error = 0.0
        for axis in range(2):
            start = float(r0[particle, axis]), float(v0[particle, axis])
            r, v = oscillator.numerical_solution(scheme, STEPS, STEP, *start, mass**-0.5, DAMPING / (2 * mass))
            error = max(error, abs(run["positions"][:, particle, axis] - r).max())
            # r and v/omega0 have the size of the amplitude
            error = max(error, abs(run["velocities"][:, particle, axis] - v).max() * mass**0.5)
            kinetic += 0.5 * mass * v**2
        quantity = f"largest difference from the exact numerical solution, mass {mass:g}"
        # r0 and v0/omega0 are at most 1 and mass^(1/2)
        judgements.append(round_off(quantity, float(error), 4 * EPSILON * STEPS * (1 + mass**0.5), why))
    energy = float(abs(run["kinetic_energy"] - kinetic).max() / kinetic[0])
    judgements.append(round_off("kinetic energy, over that at the start", energy, 16 * EPSILON * STEPS, f"twice {why}"))
    return worst(judgements)


CHECKS = (
    Check(
        name="stepping/oscillator-masses",
        title="Damped oscillators of three masses in one scene, each against the exact numerical solution for its mass",
        equation="m_i r_i'' = -k r_i - gamma r_i';  K = sum_i m_i v_i^2/2",
        criterion=f"largest difference <= {4 * STEPS} eps of the amplitude: four roundings a step",
        citation="Gear, Numerical Initial Value Problems in ODEs (1971); Nordsieck, Math. Comp. 16, 22 (1962)",
        judge=_judge,
        variants=schemes_with(
            lambda name, claims: oscillator.has_matrix(name), lambda name: "quick" if name in _QUICK else "full"
        ),
        faults=(
            (
                "velocity_verlet",
                Fault(
                    "masses-of-the-first",
                    "stepping/forces/spring.py",
                    "float(masses.flat[0]) if one else masses",
                    "float(masses.flat[0])",
                    "every particle has the mass of the first",
                ),
            ),
        ),
        needs=replace(DAMPED, words=frozenset({"dimension=2", "masses[]", "spring.gamma"})),
        interpreted=True,
    ),
)
