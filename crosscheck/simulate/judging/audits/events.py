"""Event-driven runs: every event against the rules, every flight between events, and no event missed."""

from __future__ import annotations

import math
from dataclasses import replace

from crosscheck.checks.events.rows import reported_time
from crosscheck.engines.protocol import Run
from crosscheck.errors import EngineError
from crosscheck.references.event_audit import KINDS, Audit, audit
from crosscheck.scene import Scene
from crosscheck.scene.observables import named
from crosscheck.simulate.judging.audits.pieces import from_start_and_end, with_output
from crosscheck.simulate.judging.recording import with_observables
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, bounded, round_off, worst

#: Events of a piece at most; particles times events; and samples.
MOST_EVENTS, MOST_STATES, SAMPLES = 1500, 1_000_000, 8
#: By how much a piece is made longer at a time, and how often.
_FACTOR, _TRIES = 30.0, 5
_OF_SUMS = "rounding of terms times their number: 1e-12 of the sum of their sizes"


def excuse(trial: Trial) -> str | None:
    """None, or why no event can be audited; trial: an event-driven run."""
    if MOST_STATES // max(trial.scene.number, 1) < 10:
        return f"{trial.scene.number} particles are more than the auditor can follow"
    scene = _piece(trial, trial.scene, 1.0)
    return None if scene.output.trace else "the engine keeps no trace of its events"


def extras(trial: Trial) -> list[Extra]:
    """The runs that the audit will ask for, as far as is known; trial: the run."""
    return [
        _extra(trial, where, scene, _first_duration(trial))
        for where, scene in from_start_and_end(trial)[: _number(trial)]
    ]


def _wanted(trial: Trial) -> float:
    return float(min(MOST_EVENTS, MOST_STATES // max(trial.scene.number, 1)))


def _number(trial: Trial) -> int:
    """How many pieces: one, if it is the whole run."""
    return 1 if _first_duration(trial) >= trial.end else 2


def _first_duration(trial: Trial) -> float:
    """A duration with no more events than wanted: passages of cells are counted too, so that there may be fewer."""
    events = max(float(trial.run.cost.events), 1.0)
    return trial.end * min(1.0, _wanted(trial) / events)


def _piece(trial: Trial, scene: Scene, duration: float) -> Scene:
    asked = with_output(scene, trial.method, duration, interval=(duration or 1.0) / SAMPLES)
    for more in ({"trace": True}, {"fields": trial.scene.output.fields}):
        changed = asked.output.model_copy(update=more)
        if trial.able(asked.model_copy(update={"output": changed})):
            asked = asked.model_copy(update={"output": changed})
    names = ("trajectory", *named("hard_spheres"), "kinetic_energy", "potential_energy")
    output = with_observables(trial.planned.engine, asked, trial.method, asked.output, names)
    return asked.model_copy(update={"output": output})


def _extra(trial: Trial, where: str, scene: Scene, duration: float) -> Extra:
    return Extra(f"the audit of events {where}", _piece(trial, scene, duration), trial.method, trial.seconds(duration))


def judge(trial: Trial) -> Judged:
    """The largest deviation of each kind. trial: the run."""
    total, parts = Audit(), []
    for where, scene in from_start_and_end(trial)[: _number(trial)]:
        extra, run = _with_many(trial, where, scene)
        collapsed = math.isfinite(reported_time(run))
        if run.diverged or (run.stopped and not collapsed):
            raise EngineError(f"{trial.planned.label}: the run {where} {run.stopped or 'diverged'}")
        found = audit(extra.scene, run, collapsed=collapsed)
        total.events += found.events
        for kind, share in found.shares.items():
            total.note(kind, share, 1.0, f"{where}: {found.where.get(kind, '')}")
        parts.append(f"{found.events} events {where} to t = {extra.scene.duration:g}")
    judged = [
        round_off(
            f"{kind}: largest error, in its rounding", total.shares[kind], 1.0, why, note=total.where.get(kind, "")
        )
        for kind, why in KINDS.items()
    ]
    sums = {kind: share for kind, share in total.shares.items() if kind not in KINDS}
    if sums:
        kind = max(sums, key=lambda one: sums[one])
        note = f"{kind}: {total.where.get(kind, '')}"
        judged.append(
            round_off("samples and sums: largest error, in its rounding", sums[kind], 1.0, _OF_SUMS, note=note)
        )
    if not total.events and _number(trial) > 1:  # of a whole run it is known that there is none
        none = bounded("events that were audited", 0.0, 1.0, "what has no events judges nothing", at_least=True)
        judged.append(replace(none, outcome="inconclusive"))
    return worst(judged, "; ".join(parts))


def _with_many(trial: Trial, where: str, scene: Scene) -> tuple[Extra, Run]:
    """A piece with about as many events as are wanted, no more than twice as many, and its run."""
    duration = _first_duration(trial)
    best = _extra(trial, where, scene, duration)
    run, most = trial.make_any(best), _FACTOR
    for _ in range(_TRIES):
        seen = len(run["event_times"])
        factor = min(most, 0.8 * _wanted(trial) / max(seen, 1), trial.end / duration)
        if run.stopped or seen >= _wanted(trial) / 3 or factor <= 1.1:
            break
        longer = _extra(trial, where, scene, duration * factor)
        another = trial.make_any(longer)
        if len(another["event_times"]) <= 2 * _wanted(trial):
            best, run, duration = longer, another, duration * factor
        else:
            most = factor**0.5  # their rate grows
    return best, run
