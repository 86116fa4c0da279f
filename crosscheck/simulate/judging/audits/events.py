"""Event-driven runs: every event against the rules, every flight between events, and no event missed.

Collisions that follow each other soon, for which `hard_spheres.contact_duration` has a rule, may happen nowhere near
the start or the end of a run: a trace of it says where.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from crosscheck.checks.events.rows import reported_time
from crosscheck.engines.protocol import Run
from crosscheck.errors import EngineError
from crosscheck.references.event_audit import KINDS, Audit, audit
from crosscheck.scene import Scene
from crosscheck.scene.observables import named
from crosscheck.simulate.judging.audits.pieces import from_end_of, from_start_and_end, with_output
from crosscheck.simulate.judging.law import none_there
from crosscheck.simulate.judging.recording import with_observables
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, round_off, worst

#: Events of a piece at most; particles times events; and samples.
MOST_EVENTS, MOST_STATES, SAMPLES = 1500, 1_000_000, 8
#: By how much a piece is made longer at a time, and how often.
_FACTOR, _TRIES = 30.0, 5
#: Events that are searched for collisions that follow each other within the contact duration; events audited there, and
#: how many of them come before the first such one.
_SEARCHED, _AUDITED, _BEFORE = 200_000, 300, 20
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
    total, parts, soon = Audit(), [], 0
    for where, extra, run in _pieces(trial):
        collapsed = math.isfinite(reported_time(run))
        if run.diverged or (run.stopped and not collapsed):
            raise EngineError(f"{trial.planned.label}: the run {where} {run.stopped or 'diverged'}")
        found = audit(extra.scene, run, collapsed=collapsed)
        total.events += found.events
        soon += int(_soon(extra.scene, run).sum())
        for kind, share in found.shares.items():
            total.note(kind, share, 1.0, f"{where}: {found.where.get(kind, '')}")
        parts.append(f"{found.events} events {where}, for a time of {extra.scene.duration:g}")
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
        judged.append(none_there("events that were audited", "what has no events judges nothing"))
    if _contact_duration(trial.scene) is not None:
        parts.append(f"{soon or 'none'} of them within contact_duration of the one before")
    return worst(judged, "; ".join(parts))


def _pieces(trial: Trial) -> Iterator[tuple[str, Extra, Run]]:
    """Where each piece begins, in words, and its run."""
    soon = 0
    for where, scene in from_start_and_end(trial)[: _number(trial)]:
        extra, run = _with_many(trial, where, scene)
        soon += int(_soon(extra.scene, run).sum())
        yield where, extra, run
    if not soon and _contact_duration(trial.scene) is not None and _number(trial) > 1:
        yield from _of_contacts(trial)


def _contact_duration(scene: Scene) -> float | None:
    assert scene.hard_spheres is not None
    return scene.hard_spheres.contact_duration


def _soon(scene: Scene, run: Run) -> NDArray[np.bool_]:
    """Of each event, whether a partner had one less than the contact duration before, (events,)."""
    duration, times = _contact_duration(scene), run["event_times"]
    found = np.zeros(len(times), dtype=bool)
    last = np.full(scene.number, -np.inf)
    for k, (time, pair) in enumerate(zip(times, run["event_partners"].astype(int), strict=True)):
        partners = pair[pair >= 0]
        found[k] = duration is not None and (time - last[partners] < duration).any()
        last[partners] = time
    return found


def _of_contacts(trial: Trial) -> Iterator[tuple[str, Extra, Run]]:
    """A piece where most events follow another one within the contact duration, if there are any in a trace."""
    duration = trial.end * min(1.0, _SEARCHED / max(trial.run.cost.events, 1))
    output = trial.scene.output.model_validate({"interval": duration, "trace": True})
    whole = trial.scene.model_copy(update={"duration": duration, "output": output})
    traced = trial.make_any(Extra("contacts that follow each other", whole, trial.method, trial.seconds(duration)))
    soon, times = _soon(whole, traced), traced["event_times"]
    if not soon.any():
        return
    number = int(min(_AUDITED, _wanted(trial)))
    seen = np.convolve(soon, np.ones(number))[number - 1 :][: len(soon)]  # among this event and those after it
    window = int(np.argmax(seen))
    first = max(0, window + int(np.argmax(soon[window:])) - min(_BEFORE, number // 2))
    begin = float(times[first] + (times[first - 1] if first else 0.0)) / 2
    before = trial.scene.model_copy(
        update={"duration": begin, "output": output.model_copy(update={"interval": begin or 1.0, "trace": False})}
    )
    run = trial.make_any(Extra("contacts that follow each other", before, trial.method, trial.seconds(begin)))
    scene = from_end_of(trial, run, begin)
    if scene is not None:
        span = float(times[min(first + number, len(times) - 1)]) - begin
        where = f"from t = {begin:g}"
        extra = _extra(trial, where, scene, span)
        yield where, extra, trial.make_any(extra)


def _with_many(trial: Trial, where: str, scene: Scene) -> tuple[Extra, Run]:
    """A piece with about as many events as are wanted, no more than twice as many, and its run."""
    duration = _first_duration(trial)
    best = _extra(trial, where, scene, duration)
    run, most = trial.make_any(best), _FACTOR
    if len(run["event_times"]) > 2 * _wanted(trial):  # as before an inelastic collapse, far more than on average
        last = int(_wanted(trial))
        best = _extra(trial, where, scene, float(run["event_times"][last - 1 : last + 1].mean()))
        return best, trial.make_any(best)
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
