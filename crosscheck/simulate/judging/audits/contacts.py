"""Soft grains: every step of velocity Verlet from the one before, and every sum over the run."""

from __future__ import annotations

from crosscheck.engines.registry import engine_class
from crosscheck.references.soft_grains import audit
from crosscheck.scene.observables import named
from crosscheck.simulate.judging.audits.pieces import step_by_step
from crosscheck.simulate.judging.law import none_there
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, round_off, worst

#: The scheme whose steps are known, particles at most, pairs in all steps, and steps at most.
_SCHEME, MOST, _PAIRS, _MOST_STEPS = "velocity_verlet", 500, 4_000_000, 400
_WHY = "rounding of coordinates, of the forces that they give, and of the sums over the run"


def excuse(trial: Trial) -> str | None:
    """None, or why no step can be audited; trial: a run of soft grains."""
    if trial.method.scheme != _SCHEME:
        return f"soft grains are audited step by step with {_SCHEME}, not with {trial.method.scheme}"
    if trial.scene.number > MOST:
        return f"{trial.scene.number} grains: the auditor looks at all pairs of up to {MOST}"
    return None


def _steps(trial: Trial) -> int:
    most = min(_MOST_STEPS, max(8, _PAIRS // max(trial.scene.number, 1) ** 2))
    return min(most, max(1, trial.scene.steps(trial.method.step)))


def _pieces(trial: Trial) -> list[tuple[str, Extra]]:
    names = ("trajectory", *named("hard_spheres"), "kinetic_energy", "potential_energy")
    return step_by_step(trial, _steps(trial), names)


def extras(trial: Trial) -> list[Extra]:
    """The runs that the audit asks for; trial: the run."""
    return [extra for _, extra in _pieces(trial)]


def judge(trial: Trial) -> Judged:
    """The largest error of all quantities over its rounding, of each piece. trial: the run."""
    contact = trial.method.contact
    assert contact is not None
    turned = "springs_turned_at_walls" in getattr(engine_class(trial.planned.engine), "promises", ())
    judged, touched = [], 0
    for where, extra in _pieces(trial):
        found = audit(extra.scene, contact, trial.method.step, trial.make(extra), turned)
        quantity, largest = found.worst
        touched += max(found.contacts + found.walls, found.at_once)
        note = f"{quantity} of sample {largest.sample} off by {largest.error:.3g}, rounding {largest.rounding:.3g}"
        judged.append(round_off(f"{where}: largest error over its rounding", largest.share, 1.0, _WHY, note=note))
    note = f"{_steps(trial)} steps from each, {touched} contacts or more"
    if not touched:
        judged.append(none_there("contacts", "what does not happen is not judged"))
    return worst(judged, note)
