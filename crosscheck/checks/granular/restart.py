"""Soft grains in two halves: stretched springs of contacts and the pair list go on as if there had been no break."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.granular.audit import rows
from crosscheck.checks.granular.audited_scenes import audited_method, audited_scene
from crosscheck.checks.granular.soft_grains import soft_needs
from crosscheck.checks.halves import CRITERION, EQUATION, halves, restarting
from crosscheck.faults import Fault
from crosscheck.verdict import Judged, Judgement, worst

#: Every so many rows of `granular/audit`; steps of a run, and from one sample to the next.
EVERY, STEPS, BETWEEN = 12, 40, 10


def _judge(laboratory: Laboratory, _: str) -> Judged:
    judged: list[Judgement] = []
    for number, row in enumerate(rows()[0]):
        method = audited_method(row)
        scene = audited_scene(row, laboratory.seed(f"row {number}"), True)
        if number % EVERY or laboratory.refusal(scene, method) is not None:
            continue
        output = scene.output.model_copy(update={"interval": BETWEEN * method.step})
        scene = scene.changed(duration=STEPS * method.step, output=output)
        judged += halves(laboratory, scene, method, f"row {number}")
    return worst(judged)


CHECKS = (
    Check(
        name="granular/restart",
        title="Soft grains in two halves, and without a break",
        equation=EQUATION,
        criterion=CRITERION,
        citation="Cundall and Strack, Geotechnique 29, 47 (1979)",
        judge=_judge,
        variants=variants_of({"rows": "all"}),
        faults=(
            (
                "rows",
                Fault(
                    "springs-forgotten",
                    "snapshot.py",
                    "    old[...] = new\n",
                    "    old[...] = 0 if 'stretches' in name else new\n",
                    "grains in contact have lost their stretched springs after a break",
                ),
            ),
        ),
        needs=restarting(soft_needs("", "positions velocities potential_energy")),
        interpreted=True,
    ),
)
