"""Every step of every scheme by its recurrence, and every sample by sums over all pairs: springs, gravity, fluids."""

from __future__ import annotations

from functools import partial

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.audit import (
    Expected,
    Ledger,
    asking,
    audit_samples,
    audit_steps,
    has_recurrence,
    run_or_refuse,
)
from crosscheck.checks.stepping.faults import gravity_fault, pair_fault, scheme_fault
from crosscheck.engines.capabilities import Needs
from crosscheck.scene import Box, Gravity, LennardJones, Method, Scene, Spring, Wall, explicit
from crosscheck.verdict import Judged

#: Steps of a run, each of which is recorded; and those between samples of another run, which ends after the last.
STEPS, EVERY = 6, 4
#: Scenes of each interaction, richest first, with a time step: an engine is judged by the first ones that it knows.
Scenes = tuple[tuple[Scene, float], ...]


def _springs() -> Scenes:
    rng = np.random.default_rng(11)
    base = Scene(
        name="springs",
        dimension=2,
        duration=0.0,
        masses=(1.0, 0.7, 9.0),
        spring=Spring(k=1.7, gamma=0.31),
        initial=explicit(*rng.uniform(0.5, 1.0, (2, 3, 2))),
    )
    plain = base.changed(dimension=1, masses=2.5, spring=Spring(k=1.7), initial=explicit(*rng.normal(size=(2, 2, 1))))
    return (base, 0.21), (plain, 0.21)


def _bodies() -> Scenes:
    rng = np.random.default_rng(12)
    r, v = 2 * rng.normal(size=(4, 3)) + (5.0, -3.0, 1.0), rng.normal(size=(4, 3))
    softened = Scene(
        name="softened-bodies",
        dimension=3,
        duration=0.0,
        masses=(3.0, 1.0, 0.2, 2.0),
        gravity=Gravity(G=1.7, softening=0.4),
        initial=explicit(r, v),
    )
    many = softened.changed(
        name="bodies",
        dimension=2,
        masses=tuple(rng.uniform(0.2, 2.0, 11).tolist()),
        gravity=Gravity(G=0.6),
        initial=explicit(4 * rng.normal(size=(11, 2)), rng.normal(size=(11, 2))),
    )
    plain = many.changed(masses=1.0, gravity=Gravity(), initial=explicit(3 * r[:, :2], v[:, :2]))
    return (softened, 0.09), (many, 0.01), (plain, 0.03)


def _fluids() -> Scenes:
    rng = np.random.default_rng(13)
    places = np.array([[0.9, 1.1], [2.1, 1.0], [3.4, 1.3], [1.4, 2.2], [2.7, 2.4]])
    start = explicit(places + rng.uniform(-0.06, 0.06, (5, 2)), rng.normal(size=(5, 2)))
    channel = Scene(
        name="channel",
        dimension=2,
        duration=0.0,
        masses=(1.0, 0.4, 3.0, 1.5, 0.8),
        species=(0, 1, 1, 0, 1),
        lennard_jones=LennardJones(
            epsilon=(1.2, 0.7), length=(1.05, 0.9), cutoff=2.3, truncation="force_shifted", length_form="r_m"
        ),
        box=Box(lengths=(4.1, 3.4), boundaries=("periodic", "wall"), wall=Wall(epsilon=0.6, sigma=0.8, cutoff=1.7)),
        initial=start,
    )
    plain = channel.changed(
        name="plane", species=None, lennard_jones=LennardJones(cutoff=1.9), box=Box(lengths=(4.3, 4.1)), masses=1.0
    )
    return (channel, 0.011), (plain, 0.011)


def _judge(laboratory: Laboratory, scheme: str, scenes: Scenes, judged: int) -> Judged:
    """judged: how many of the scenes are judged."""
    ledger = Ledger()
    for scene, dt in scenes:
        if ledger.scenes == judged:
            break
        scene, method = scene.changed(duration=STEPS * dt), Method(scheme=scheme, dt=dt)
        expected = Expected(scene, scheme, dt, STEPS)
        asked = asking(laboratory.engine, scene, dt)
        run = run_or_refuse(laboratory, ledger, asked, method)
        if run is not None:
            audit_samples(ledger, asked, run, scene.name)
            audit_steps(ledger, expected, run, STEPS, 1, scene.name)
            if ledger.scenes == 1:
                asked = asking(laboratory.engine, scene, EVERY * dt)
                run = laboratory.run(asked, method)
                audit_samples(ledger, asked, run, f"{scene.name}, every {EVERY} steps")
                audit_steps(ledger, expected, run, STEPS, EVERY, f"{scene.name}, every {EVERY} steps")
    return ledger.findings()


_TITLE = "Every step of every scheme against its recurrence, every sample against sums over all pairs"
_CITATION = (
    "Verlet, Phys. Rev. 159, 98 (1967); Swope et al., J. Chem. Phys. 76, 637 (1982); Beeman, J. Comput. Phys. 20, 130 "
    "(1976); Gear, Numerical Initial Value Problems in ODEs (1971); Higham, Accuracy and Stability (2002)"
)
_CRITERION = (
    "each within bounds of rounding: of coordinates, terms, sums, and 20 times that of the recurrence in doubles"
)

CHECKS = (
    Check(
        name="stepping/gravity-steps",
        title=f"{_TITLE}: bodies of unlike masses",
        equation="phi = -G m_i m_j/sqrt(r^2 + s^2), W = sum r_ij . F_ij; the recurrence of each scheme, start included",
        criterion=_CRITERION,
        citation=f"{_CITATION}; Aarseth, MNRAS 126, 223 (1963)",
        judge=partial(_judge, scenes=_bodies(), judged=2),
        variants=schemes_with(lambda name, claims: has_recurrence(name)),
        faults=(
            (
                "velocity_verlet",
                gravity_fault(
                    "gravity-lighter-body",
                    "from_i = inverse_cube * mass[i]",
                    "from_i = inverse_cube * mass[j]",
                    "the earlier of two bodies feels its own mass",
                ),
            ),
            (
                "beeman",
                scheme_fault(
                    "beeman-start-position",
                    "return a, accelerate(force, r - dt * v + 0.5 * dt**2 * a, v - dt * a)",
                    "return a, accelerate(force, r - dt * v, v - dt * a)",
                    "the step backwards leaves out the acceleration",
                ),
            ),
        ),
        needs=Needs("gravity"),
        interpreted=True,
    ),
    Check(
        name="stepping/lennard-jones-steps",
        title=f"{_TITLE}: a mixture between walls",
        equation="phi = 4 epsilon ((sigma/r)^12 - (sigma/r)^6), cut and shifted; the recurrence of each scheme",
        criterion=_CRITERION,
        citation=_CITATION,
        judge=partial(_judge, scenes=_fluids(), judged=1),
        variants=schemes_with(lambda name, claims: has_recurrence(name)),
        faults=(
            (
                "gear3",
                pair_fault(
                    "wall-of-the-other-side",
                    "return _one_wall(walls, x) - _one_wall(walls, lengths[k] - x)",
                    "return _one_wall(walls, x) - _one_wall(walls, x)",
                    "the upper wall pushes by the distance from the lower one",
                ),
            ),
        ),
        needs=Needs("lennard_jones"),
        interpreted=True,
    ),
    Check(
        name="stepping/spring-steps",
        title=f"{_TITLE}: damped springs of unlike masses",
        equation="m_i r_i'' = -k r_i - gamma r_i'; the recurrence of each scheme, start included",
        criterion=_CRITERION,
        citation=_CITATION,
        judge=partial(_judge, scenes=_springs(), judged=2),
        variants=schemes_with(lambda name, claims: has_recurrence(name)),
        faults=(
            (
                "gear4_velocity",
                scheme_fault(
                    "gear4-velocity-table",
                    "_GEAR4_VELOCITY = (19 / 120, 3 / 4, 1.0, 1 / 2, 1 / 12), (19 / 90,",
                    "_GEAR4_VELOCITY = (19 / 120, 3 / 4, 1.0, 1 / 2, 1 / 12), (19 / 120,",
                    "the corrector for f(r, v) takes its first coefficient from the table for f(r)",
                ),
            ),
        ),
        needs=Needs("spring"),
        interpreted=True,
    ),
)
