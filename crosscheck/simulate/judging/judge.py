"""Judges the runs of a simulation by all laws, and says beforehand what that takes."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from crosscheck.engines.protocol import Cost
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EndedEarly, EngineError, EngineMissing, Unsupported, UsageError
from crosscheck.scene import Scene
from crosscheck.simulate.judging import agreement
from crosscheck.simulate.judging.ladder import Ladder
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.laws import all_laws
from crosscheck.simulate.judging.trial import Bench, Extra, Tell, Trial, key_of
from crosscheck.simulate.methods import Planned
from crosscheck.simulate.observables import Result
from crosscheck.verdict import Judged, Judgement, Outcome, Verdict, again, bounded, findings, suspicious, worst

#: Computing time, s, that the extra runs of one law may take: twice that of the run, from 5 to 30 s; of a long run, a
#: quarter of it.
LEAST_ALLOWANCE, MOST_ALLOWANCE, OF_THE_RUN, OF_A_LONG_RUN = 5.0, 30.0, 2.0, 0.25

#: Laws that say nothing of what was simulated.
JUDGE_NOTHING = ("end",)


def observables_needed() -> tuple[str, ...]:
    """Names of what the laws ask a run to record."""
    return tuple(dict.fromkeys(name for law in all_laws() for name in law.records))


def check_of(scene: Scene) -> str:
    """Name of the check in the record: "simulate/" and the scene's name, as far as it can be part of one."""
    return f"simulate/{re.sub(r'[^A-Za-z0-9_.-]+', '-', scene.name).strip('-') or 'scene'}"


def allowance(cpu: float) -> float:
    """Computing time, s, that the extra runs of one law may take. cpu: that of the run, s."""
    return max(LEAST_ALLOWANCE, min(OF_THE_RUN * cpu, MOST_ALLOWANCE), OF_A_LONG_RUN * cpu)


class Judge:
    """Judges runs of a scene, each by all laws, and each pair of them.

    results: the runs. pool: of their engines. tolerance: of the changes on halving dt, relative.
    """

    def __init__(self, results: Sequence[tuple[Planned, Result]], pool: Pool, tolerance: float) -> None:
        self._bench = Bench(pool)
        self._trials = [
            Trial(one, result, self._bench, allowance(result.run.cost.cpu), tolerance) for one, result in results
        ]

    def verdicts(self, tell: Tell) -> Iterator[Verdict]:
        """A verdict for each law and run, and for each pair, as they are found.

        tell: says, before they are made, how many extra runs there will be.
        """
        questions = [_of_run(law, trial) for trial in self._trials for law in all_laws()]
        questions += [_of_pair(one, other) for one, other in agreement.pairs(self._trials)]
        extras = {
            key_of(trial.planned, extra): extra
            for question in questions
            if question.excuse is None
            for trial, extra in question.extras()
        }
        self._bench.planned = len(extras)
        if extras:
            seconds = sum(extra.seconds for extra in extras.values())
            needed = f"about {seconds:.2g} s" if seconds >= 1 else "less than 1 s"
            tell(f"judging: {len(extras)} extra runs, or some more: {needed} of computing time beside compilation")
        for question in questions:
            yield _verdict(question)

    @property
    def ladders(self) -> dict[str, Ladder]:
        """The ladders of time steps that were climbed, by the label of the run."""
        found = {trial.result.engine: trial.shared.get("ladder") for trial in self._trials}
        return {label: ladder for label, ladder in found.items() if ladder is not None}


@dataclass(frozen=True)
class _Question:
    """What is judged: a law and its run, or a pair of runs.

    name: of the law. engine: of the run, or of both. trials: the runs. excuse: why it cannot be judged; None: it can.
    answer: judges. extras: the runs that this takes.
    """

    name: str
    engine: str
    trials: tuple[Trial, ...]
    excuse: str | None
    answer: Callable[[], Judged]
    extras: Callable[[], Iterable[tuple[Trial, Extra]]]


def _of_run(law: Law, trial: Trial) -> _Question:
    return _Question(
        law.name,
        trial.result.engine,
        (trial,),
        law.excuse(trial),
        lambda: law.judge(trial),
        lambda: [(trial, extra) for extra in law.extra(trial)],
    )


def _of_pair(one: Trial, other: Trial) -> _Question:
    return _Question(
        "agreement",
        agreement.name_of(one, other),
        (one, other),
        agreement.excuse(one, other),
        lambda: worst(agreement.agreement(one, other)),
        lambda: agreement.extras(one, other),
    )


def _undecided(reason: str) -> Judgement:
    """That nothing can be decided, since a run beside those that are judged did not go to its end."""
    why = "what is judged is compared with them"
    judged = bounded("extra runs that ended before their time", 1.0, 0.0, why, note=reason)
    return replace(judged, outcome="inconclusive")


def _verdict(question: _Question) -> Verdict:
    """The answer: "skip" with the reason where there is none, "error" where an engine failed."""
    started, found, message = time.perf_counter(), None, ""
    outcome: Outcome
    cost = Cost()
    for trial in question.trials:
        trial.cost, trial.attempt = cost, 0
    if question.excuse is not None:
        outcome, message = "skip", f"{question.name}: {question.excuse}"
    else:
        try:
            found = findings(question.answer())
            if suspicious(found):  # measured again, with other random numbers
                for trial in question.trials:
                    trial.attempt = 1
                found = again(found, findings(question.answer()))
            outcome = found.outcome
        except EndedEarly as reason:
            found = findings(_undecided(str(reason)))
            outcome = found.outcome
        except (EngineMissing, Unsupported) as refusal:
            outcome, message = "skip", f"{question.name}: {refusal}"
        except (EngineError, UsageError) as error:
            outcome, message = "error", str(error)
        except Exception as error:
            outcome, message = "error", f"the law {question.name} failed: {type(error).__name__}: {error}"
    spent = {"seconds": time.perf_counter() - started, **cost.known()}
    scene = question.trials[0].scene
    return Verdict(check_of(scene), question.name, question.engine, outcome, found, message, spent)
