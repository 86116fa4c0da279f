"""A run goes to its end."""

from __future__ import annotations

from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, bounded


def _judge(trial: Trial) -> Judged:
    run = trial.run
    note = "it diverged" if run.diverged else f"it stopped: {run.stopped}" if run.stopped else trial.broken
    why = "what a part of a run shows says nothing of the whole"
    return bounded("runs that ended before their time, or fell apart", float(bool(trial.broken)), 0.0, why, note=note)


LAWS = (Law("end", "the last time is that of the scene", lambda trial: None, _judge),)
