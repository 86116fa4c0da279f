"""Short runs in which everything that happens is looked at, by auditors that share no code with any engine."""

from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType

from crosscheck.simulate.judging.audits import contacts, events, searches, sites, steps
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged


def _auditor(trial: Trial) -> ModuleType:
    """The auditor of the way in which the scene is moved."""
    if trial.kind == "stepping":
        return contacts if trial.scene.hard_spheres is not None else steps
    return {"event_driven": events, "lattice": sites, "collision_search": searches}[trial.kind]


def _excuse(trial: Trial) -> str | None:
    if trial.kind == "adaptive":
        return f"scheme {trial.method.scheme} chooses its own steps, which no run shows"
    if trial.run.diverged:
        return trial.broken
    if trial.end <= 0:
        return "nothing happens in a run of no duration"
    found: str | None = _auditor(trial).excuse(trial)
    return found


def _judge(trial: Trial) -> Judged:
    judged: Judged = _auditor(trial).judge(trial)
    return judged


def _extra(trial: Trial) -> Iterable[Extra]:
    if trial.kind == "adaptive":
        return []
    extras: Iterable[Extra] = _auditor(trial).extras(trial)
    return extras


LAWS = (
    Law(
        "audit",
        "each event, step or site follows from the one before it, by the definitions of the scene language",
        _excuse,
        _judge,
        extra=_extra,
    ),
)
