"""Smooth forces: every sample against sums over all pairs, every step against the recurrence of the scheme."""

from __future__ import annotations

from crosscheck.checks.stepping.audit import ENERGIES, Expected, Ledger, audit_samples, audit_steps, has_recurrence
from crosscheck.engines.protocol import Run
from crosscheck.simulate.judging.audits.pieces import step_by_step
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
    return step_by_step(trial, _steps(trial), ("trajectory", *ENERGIES), forces=True)


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
