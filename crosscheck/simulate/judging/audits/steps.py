"""Smooth forces: every sample against sums over all pairs, every step against the recurrence of the scheme."""

from __future__ import annotations

from crosscheck.checks.stepping.audit import ENERGIES, Expected, Ledger, audit_samples, audit_steps, has_recurrence
from crosscheck.engines.protocol import Run
from crosscheck.simulate.judging.audits.pieces import from_start_and_end, with_output
from crosscheck.simulate.judging.recording import with_observables
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, worst

#: Particles of which all pairs, with their images, can be summed in long double.
MOST = 1000
#: Pairs in all steps of a piece; steps at most, and at least.
_PAIRS, _MOST_STEPS, _LEAST_STEPS = 1_000_000, 64, 3


def excuse(trial: Trial) -> str | None:
    """None, or why no step can be audited; trial: a run by time steps under smooth forces."""
    if trial.scene.number > MOST:
        return f"{trial.scene.number} particles: the auditor sums over all pairs of up to {MOST}"
    return None


def _steps(trial: Trial) -> int:
    most = min(_MOST_STEPS, max(_LEAST_STEPS, _PAIRS // trial.scene.number**2))
    return min(most, max(1, trial.scene.steps(trial.method.step)))


def _pieces(trial: Trial) -> list[tuple[str, Extra]]:
    dt, steps = trial.method.step, _steps(trial)
    found = []
    for where, scene in from_start_and_end(trial):
        piece = with_output(scene, trial.method, steps * dt, interval=dt)
        forces = piece.model_copy(update={"output": piece.output.model_copy(update={"forces": True})})
        piece = forces if trial.able(forces) else piece
        output = with_observables(trial.planned.engine, piece, trial.method, piece.output, ("trajectory", *ENERGIES))
        piece = piece.model_copy(update={"output": output})
        found.append((where, Extra(f"the audit of steps {where}", piece, trial.method, trial.seconds(steps * dt))))
    return found


def extras(trial: Trial) -> list[Extra]:
    """The runs that the audit asks for; trial: the run."""
    return [extra for _, extra in _pieces(trial)]


def judge(trial: Trial) -> Judged:
    """The largest error of each quantity, in bounds of rounding. trial: the run."""
    ledger, steps, dt = Ledger(), _steps(trial), trial.method.step
    for where, extra in _pieces(trial):
        run = trial.make(extra)
        ledger.scenes += 1
        audit_samples(ledger, extra.scene, run, where)
        if has_recurrence(trial.method.scheme):
            counted = Run(run)  # how often an engine evaluates its forces is its own affair
            audit_steps(ledger, Expected(extra.scene, trial.method.scheme, dt, steps), counted, steps, 1, where)
    known = "" if has_recurrence(trial.method.scheme) else "; of this scheme, energies and forces alone"
    return worst([ledger.findings()], f"{steps} steps from the start, and as many from the end{known}")
