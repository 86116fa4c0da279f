"""Event-driven runs in two halves: the queue, clocks, counters and wells go on as if there had been no break."""

from __future__ import annotations

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.audit_rows import row_scene, rows
from crosscheck.checks.events.gases import event_driven
from crosscheck.checks.halves import CRITERION, EQUATION, halves, restarting
from crosscheck.engines.capabilities import refusal
from crosscheck.engines.registry import engine_class
from crosscheck.faults import Fault
from crosscheck.scene import Method, Observable, Output
from crosscheck.verdict import Judged, Judgement, worst

#: Every so many rows of `events/audit`, the first of which is this one, and the share of their duration.
EVERY, FIRST, SHARE = 9, 2, 0.5
_SUMS: tuple[Observable, ...] = ("kinetic_energy", "kinetic_energy_integral", "collisions", "wall_impulse")


def _judge(laboratory: Laboratory, _: str) -> Judged:
    schemes = [name for name, claims in laboratory.claims.items() if claims.kind == EVENT_DRIVEN]
    judged: list[Judgement] = []
    table, _never = rows()
    for number in range(FIRST, len(table), EVERY):
        scene = row_scene(table[number], number)
        duration = SHARE * scene.duration
        method = Method(scheme=schemes[number % len(schemes)])
        for observables in (_SUMS, ()):
            output = Output(interval=duration / 4, trajectory=True, observables=observables)
            scene = scene.changed(duration=duration, output=output)
            if refusal(engine_class(laboratory.engine), scene, method) is None:
                judged += halves(laboratory, scene, method, f"row {number}")
                break
    return worst(judged, f"{len(range(FIRST, len(table), EVERY))} scenes")


CHECKS = (
    Check(
        name="events/restart",
        title="Event-driven runs in two halves, and without a break",
        equation=EQUATION,
        criterion=CRITERION,
        citation="Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993)",
        judge=_judge,
        variants=variants_of({"rows": "all"}),
        faults=(
            (
                "rows",
                Fault(
                    "integrals-since-the-first-start",
                    "events/simulation.py",
                    "            self._tallies.sums[measure.SINCE] = self._now\n            self._tallies.walls",
                    "            self._tallies.walls",
                    "after a restart, integrals over time begin at the very first start",
                ),
            ),
        ),
        needs=restarting(event_driven(observables="positions velocities")),
        interpreted=True,
    ),
)
