"""Small runs with all pairs of features, every event against the definitions (`crosscheck.references.event_audit`)."""

from __future__ import annotations

import math
from typing import NamedTuple

from crosscheck.checks.base import Check, FeatureRows, Laboratory, full, quick
from crosscheck.checks.events.audit_rows import EVENTS, FACTORS, row_scene, rows, valid
from crosscheck.checks.events.gases import event_driven
from crosscheck.checks.events.rows import reported_time
from crosscheck.engines.capabilities import measured
from crosscheck.engines.protocol import Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import EndedEarly, Unsupported
from crosscheck.faults import Fault
from crosscheck.pairs import Row
from crosscheck.references.event_audit import KINDS, Audit, audit
from crosscheck.scene import Method, Output, Scene
from crosscheck.verdict import Judged, bounded, round_off, worst

#: A run begins with one shorter by this factor, whose number of events says how long it should be: so many events, or
#: so many times as many passages of cells.
PILOT, CROSSINGS = 12, 5
#: Events of a row of the full tier, at most.
MANY_EVENTS = 1500.0
#: Cases that the rows of the quick tier are divided into; tables of other rows, whole, of the full tier.
CHUNKS, TABLES = 6, range(2, 10)
#: Numbers of scenes, of which each table has its own.
_STARTS = 1001
_OF_SUMS = "rounding of terms times their number: 1e-12 of the sum of their sizes"


class _Chunk(NamedTuple):
    """Every so many rows of a table (`step`), from `first` on, each with about so many `events`."""

    first: int
    step: int = CHUNKS
    events: float = EVENTS
    table: int = 1


def _judge(laboratory: Laboratory, chunk: _Chunk) -> Judged:
    """The largest deviation of each kind in all rows of a chunk."""
    table, _ = rows(chunk.table)
    total, judged = Audit(), 0
    seen: list[Row] = []
    for place in range(chunk.first, len(table), chunk.step):
        number = _STARTS * (chunk.table - 1) + place
        row = _able(laboratory, table[place], number)
        if row in seen or (chunk.events > EVENTS and not _keeps_moving(row)):
            continue
        seen.append(row)
        scene, method = _measured(laboratory, row, row_scene(row, number))
        scene = _of_good_length(laboratory, scene, method, chunk.events)
        run = laboratory.run(scene, method, may_end_early=True)
        found = audit(scene, run, collapsed=_collapsed(scene, run))
        judged += 1
        total.events += found.events
        for kind, share in found.shares.items():
            total.note(kind, share, 1.0, f"row {number}: {found.where.get(kind, '')} ({features(row)})")
    known = {kind: total.shares[kind] for kind in KINDS}
    judgements = [
        round_off(f"{kind}: largest error, in its rounding", share, 1.0, KINDS[kind], note=total.where.get(kind, ""))
        for kind, share in known.items()
    ]
    sums = {kind: share for kind, share in total.shares.items() if kind not in KINDS}
    if sums:
        kind = max(sums, key=lambda kind: sums[kind])
        note = f"{kind}: {total.where.get(kind, '')}"
        judgements.append(round_off("samples, sums and fields: largest error", sums[kind], 1.0, _OF_SUMS, note=note))
    few = float(total.events < judged)
    judgements.append(bounded("runs without events", few, 0.0, "what has no events judges nothing", control=True))
    return worst(judgements, f"{judged} rows, {total.events} events")


def _able(laboratory: Laboratory, row: Row, number: int) -> Row:
    """The row without those features that the engine does not declare; Unsupported if it can run no such scene."""
    reason = _refused(laboratory, row, number)
    if reason is None:
        return row
    plain = {name: levels[0] for name, levels in FACTORS.items()} | {"scheme": row["scheme"]}
    starts = [plain | {"dimension": one} for one in (row["dimension"], *FACTORS["dimension"])]
    able = next((one for one in starts if _refused(laboratory, one, number) is None), None)
    if able is None:
        raise Unsupported(f"{laboratory.engine}: {reason}")
    for name, level in row.items():
        more = able | {name: level}
        if valid(more) and _refused(laboratory, more, number) is None:
            able = more
    return able


def _keeps_moving(row: Row) -> bool:
    """Whether particles lose little and do not settle, so that a long run has many events."""
    return row["restitution"] == "1" and row["field"] == "none" and row["walls"] != "open"


def _collapsed(scene: Scene, run: Run) -> bool:
    """Whether the run ended in an inelastic collapse, which the audit then looks for; EndedEarly for another end.

    A run that counts collisions may also end with its duration, before the last of them: what it says then names no
    particles, and it is audited to its duration.
    """
    collapsed = math.isfinite(reported_time(run))
    counts = scene.output.collisions is not None
    if run.diverged or (run.stopped and not (collapsed or counts)):
        raise EndedEarly(f"scene {scene.name}: the run {'diverged' if run.diverged else f'stopped: {run.stopped}'}")
    return collapsed


def _refused(laboratory: Laboratory, row: Row, number: int) -> str | None:
    """None, or why the suite does not give the scene of a row to the engine."""
    scene, method = _measured(laboratory, row, row_scene(row, number))
    return laboratory.refusal(scene, method)


def _of_good_length(laboratory: Laboratory, scene: Scene, method: Method, wanted: float = EVENTS) -> Scene:
    """The scene, planned for `EVENTS`, with about as many as are `wanted`: its beginning shows how many it has."""
    pilot = scene.duration / PILOT
    output = Output(trace=True)
    run = laboratory.run(scene.changed(duration=pilot, output=output), method)
    # passages of cells cost time too
    events = max(len(run["event_times"]), run.cost.events / CROSSINGS)
    share = min(wanted / EVENTS, wanted / max(1.0, events * PILOT))
    sampled = {} if scene.output.interval is None else {"interval": scene.output.interval * share}
    return scene.changed(duration=scene.duration * share, output=scene.output.model_copy(update=sampled))


def features(row: Row) -> str:
    """The features of a row that are not absent, in words."""
    return ", ".join(f"{name} {level}" for name, level in row.items() if level != FACTORS[name][0])


def _measured(laboratory: Laboratory, row: Row, scene: Scene) -> tuple[Scene, Method]:
    """The scene, with those observables that the row's scheme of the engine measures, and the scheme."""
    schemes = [name for name, claims in laboratory.claims.items() if claims.kind == "event_driven"]
    scheme = schemes[FACTORS["scheme"].index(row["scheme"]) % len(schemes)]
    able: frozenset[str] = frozenset()
    cells = False
    for one in engine_class(laboratory.engine).capabilities:
        if one.interaction == "hard_spheres" and one.kind == "event_driven" and scheme in (one.schemes or (scheme,)):
            able, cells = able | one.observables, cells or "output.fields" in one.words
    output = scene.output.model_copy(
        update={
            "observables": tuple(name for name in scene.output.observables if name in able),
            "fields": scene.output.fields if cells else None,
        }
    )
    scene = scene.changed(output=output)
    assert {"event_times", "event_partners"} <= measured(scene)
    return scene, Method(scheme=scheme)


#: Bugs that many rows see, in the chunk that is run to show it.
FAULTS = (
    (
        "rows-0",
        Fault(
            "half-well",
            "events/rules.py",
            "new, held = well_velocity(gn, inside, 2.0 * well.depth / mass)",
            "new, held = well_velocity(gn, inside, 1.0 * well.depth / mass)",
            "a well gives half its energy",
        ),
    ),
    (
        "rows-1",
        Fault(
            "drum-backwards",
            "events/rules.py",
            "turning = cylinder.angular_velocity * cylinder.radius",
            "turning = -0.5 * cylinder.angular_velocity * cylinder.radius",
            "a drum turns backwards at half its speed",
        ),
    ),
    (
        "rows-2",
        Fault(
            "rough-for-smooth",
            "events/rules.py",
            "stick = (1.0 - alpha_t) * inertia",
            "stick = (1.0 + alpha_t) * inertia",
            "the tangential restitution has the wrong sign",
        ),
    ),
    (
        "rows-3",
        Fault(
            "one-sided-flux",
            "events/kernels/measure.py",
            "            sign = 1.0 if up else -1.0\n            mass =",
            "            sign = 1.0\n            mass =",
            "mass and energy through a cell's face count as upwards whatever their direction",
        ),
    ),
    (
        "rows-4",
        Fault(
            "small-pairs",
            "events/prediction.py",
            "return radii[i] + radii[j]",
            "return radii[i] + radii[j] if radii[i] == radii[j] else 0.9 * (radii[i] + radii[j])",
            "particles of unlike diameters collide at 90 % of their contact distance",
        ),
    ),
)

CHECKS = (
    Check(
        name="events/audit",
        title="Every event of small runs, with all pairs of features, against the definitions",
        equation="free flights, contacts, rules, no event missed; all sums and fields again from the trace",
        criterion="each number to its rounding",
        citation="Alder & Wainwright, J. Chem. Phys. 31, 459 (1959); Walton, in: Particulate Two-Phase Flow (1993)",
        judge=_judge,
        variants=(
            *quick(**{f"rows-{first}": _Chunk(first) for first in range(CHUNKS)}),
            *full(**{"long-rows": _Chunk(0, 1, MANY_EVENTS)}),
            *full(**{f"other-rows-{table}": _Chunk(0, 1, table=table) for table in TABLES}),
        ),
        needs=event_driven(
            observables="positions velocities event_times event_partners event_positions event_velocities"
        ),
        interpreted=True,
        features=FeatureRows(FACTORS, rows),
        faults=FAULTS,
    ),
)
