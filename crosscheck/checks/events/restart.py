"""Event-driven runs in two halves: the queue, clocks, counters and wells go on as if there had been no break."""

from __future__ import annotations

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, quick, variants_of
from crosscheck.checks.events.audit_crowd import CROWDED, crowd
from crosscheck.checks.events.audit_rows import row_scene, rows
from crosscheck.checks.events.gases import event_driven
from crosscheck.checks.halves import CRITERION, EQUATION, halves, restarting
from crosscheck.faults import Fault
from crosscheck.scene import Method, Observable, Output
from crosscheck.verdict import Judged, Judgement, worst

#: Every so many rows of `events/audit`, the first of which is this one; so many of the first ones that measure fields;
#: and the share of their duration.
EVERY, FIRST, WITH_FIELDS, SHARE = 9, 2, 2, 0.5
_SUMS: tuple[Observable, ...] = ("kinetic_energy", "kinetic_energy_integral", "collisions", "wall_impulse")
#: Duration of the crowd, in whose first half the small disks gather.
GATHERING = 11.0


def _judge(laboratory: Laboratory, _: str) -> Judged:
    schemes = [name for name, claims in laboratory.claims.items() if claims.kind == EVENT_DRIVEN]
    judged: list[Judgement] = []
    table, _never = rows()
    fields = [number for number, row in enumerate(table) if row["measured"] == "fields"]
    numbers = sorted({*range(FIRST, len(table), EVERY), *fields[:WITH_FIELDS]})
    for number in numbers:
        scene = row_scene(table[number], number)
        duration = SHARE * scene.duration
        method = Method(scheme=schemes[number % len(schemes)])
        cells = scene.output.fields
        for observables, shape in (((*_SUMS, "operation_counts"), cells), (_SUMS, cells), (_SUMS, None), ((), None)):
            output = Output(interval=duration / 4, trajectory=True, observables=observables, fields=shape)
            scene = scene.changed(duration=duration, output=output)
            if laboratory.refusal(scene, method) is None:
                judged += halves(laboratory, scene, method, f"row {number}")
                break
    return worst(judged, f"{len(numbers)} scenes")


def _judge_crowd(laboratory: Laboratory, seed: int) -> Judged:
    """In the first half, tables of partners and cells get more room: the second one must find them as large."""
    scene = crowd(seed)
    output = Output(interval=GATHERING / 4, trajectory=True, observables=("kinetic_energy", "potential_energy"))
    return worst(halves(laboratory, scene.changed(duration=GATHERING, output=output), EVENT_DRIVEN, "crowd"))


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
                    "            self._tallies.sums[measure.SINCE] = self._now\n        if",
                    "        if",
                    "after a restart, integrals over time begin at the very first start",
                ),
            ),
        ),
        needs=restarting(event_driven(observables="positions velocities")),
        interpreted=True,
    ),
    Check(
        name="events/restart-crowd",
        title="Small disks that gather around a large one, in two halves, and without a break",
        equation=EQUATION,
        criterion=CRITERION,
        citation="Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993)",
        judge=_judge_crowd,
        variants=quick(first=3),
        faults=(
            (
                "first",
                Fault(
                    "larger-tables-are-lost",
                    "snapshot.py",
                    "    old[...] = new\n",
                    "    old[...] = new\n    if 'bonds' in name and new.shape != wanted.shape:\n        old[...] = 0\n",
                    "tables of partners that have grown are empty after a break",
                ),
            ),
        ),
        needs=restarting(event_driven(CROWDED, "positions velocities kinetic_energy potential_energy")),
        interpreted=True,
    ),
)
