"""Runs by time steps in two halves: derivatives, lists and clocks go on as if there had been no break."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.halves import CRITERION, EQUATION, halves, restarting
from crosscheck.checks.stepping import gravity_features, lennard_jones_features
from crosscheck.checks.stepping.audit import Features
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.registry import engine_class
from crosscheck.faults import Fault
from crosscheck.scene import Method, Output, Scene
from crosscheck.verdict import Judged, Judgement, worst

#: Steps of a run, and from one sample to the next.
STEPS, BETWEEN = 24, 6
#: Every so many rows of Lennard-Jones scenes.
EVERY = 7
_WRITTEN = "Allen & Tildesley, Computer Simulation of Liquids (1987), section 5.7"


def _sampled(scene: Scene, dt: float) -> Scene:
    output = Output(interval=BETWEEN * dt, trajectory=True, observables=("kinetic_energy", "potential_energy"))
    return scene.changed(duration=STEPS * dt, output=output)


def _of_schemes(laboratory: Laboratory, _: str) -> Judged:
    """Few bodies, by every scheme of the engine that takes steps."""
    features = gravity_features.FEATURES
    row = features.known(laboratory.engine)[-1]
    scene = _sampled(features.scene_of(row, laboratory.seed()), features.dt)
    judged: list[Judgement] = []
    for name, claims in laboratory.claims.items():
        method = Method(scheme=name, dt=features.dt)
        if claims.kind == "stepping" and laboratory.refusal(scene, method) is None:
            judged += halves(laboratory, scene, method, name)
    return worst(judged)


def _of_rows(laboratory: Laboratory, _: str) -> Judged:
    """Lennard-Jones scenes with many features."""
    features: Features = lennard_jones_features.FEATURES
    judged: list[Judgement] = []
    engine = engine_class(laboratory.engine)
    for number, row in enumerate(features.known(laboratory.engine)[::EVERY]):
        scene = _sampled(features.scene_of(row, laboratory.seed(str(number))), features.dt)
        judged += halves(laboratory, scene, features.method(engine, scene), f"scene {number}")
    return worst(judged)


CHECKS = (
    Check(
        name="stepping/restart-gravity",
        title="Few bodies in two halves, and without a break, by every scheme",
        equation=EQUATION,
        criterion=CRITERION,
        citation=_WRITTEN,
        judge=_of_schemes,
        variants=variants_of({"schemes": "all"}),
        faults=(
            (
                "schemes",
                Fault(
                    "derivatives-start-anew",
                    "stepping/integrate.py",
                    "outcome, starts = GOOD, state is None",
                    "outcome, starts = GOOD, True",
                    "a run that goes on makes its derivatives anew",
                ),
            ),
        ),
        needs=restarting(Needs("gravity")),
        interpreted=True,
    ),
    Check(
        name="stepping/restart-lennard-jones",
        title="Lennard-Jones particles in two halves, and without a break",
        equation=EQUATION,
        criterion=CRITERION,
        citation=_WRITTEN,
        judge=_of_rows,
        variants=variants_of({"rows": "all"}),
        faults=(
            (
                "rows",
                Fault(
                    "rounded-snapshot",
                    "snapshot.py",
                    "found[name] = np.array(value)",
                    "found[name] = np.around(value, 12) if name == 'v' else np.array(value)",
                    "velocities are handed on with twelve decimals",
                ),
            ),
        ),
        needs=restarting(Needs("lennard_jones")),
        interpreted=True,
    ),
)
