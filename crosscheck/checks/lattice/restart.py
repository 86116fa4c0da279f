"""Lattice gases in two halves: the number of the step, and with it the random numbers, go on."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.halves import CRITERION, EQUATION, halves, restarting
from crosscheck.checks.lattice.gases import FHP, LATTICE, filled, gas_scene, methods_for
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Obstacle, Output
from crosscheck.verdict import Judged, Judgement, worst

STEPS, BETWEEN = 8, 2


def _judge(laboratory: Laboratory, _: str) -> Judged:
    """Two models, by every scheme that can move it, with a force and walls that draw random numbers."""
    walls = (Obstacle(rows=(0, 0), rule="diffusive_y"), Obstacle(columns=(20, 21), rows=(4, 6)))
    judged: list[Judgement] = []
    for model in ("hpp", "fhp1"):
        for observables in (("populations", "force_impulse"), ("populations", "h_function")):
            gas = {"force": 0.1, "obstacles": walls} if "force_impulse" in observables else {}
            output = Output(interval=BETWEEN, fields=(2, 2), observables=observables)
            scene = gas_scene("halves", model, 12, 70, STEPS, filled(0.35, laboratory.seed(model)), output, **gas)
            for method in methods_for(laboratory.engine, scene):
                judged += halves(laboratory, scene, method, f"{model}, {method.scheme}")
    return worst(judged)


CHECKS = (
    Check(
        name="lattice/restart",
        title="Lattice gases in two halves, and without a break",
        equation=EQUATION,
        criterion=CRITERION,
        citation=FHP,
        judge=_judge,
        variants=variants_of({"models": "all"}),
        faults=(
            (
                "models",
                Fault(
                    "steps-counted-anew",
                    "snapshot.py",
                    "        return type(old)(new[()])",
                    "        return old",
                    "the number of the step is not restored, and random numbers repeat",
                ),
            ),
        ),
        needs=restarting(Needs("lattice_gas", (LATTICE,))),
        interpreted=True,
    ),
)
