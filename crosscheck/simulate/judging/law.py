"""What a law is: for which runs it holds, and how it is judged; and what is said where there is nothing to judge."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, Judgement, bounded


def none_there(quantity: str, why: str, *, number: float = 0.0, note: str = "") -> Judgement:
    """The judgement that nothing is decided, for there is nothing of what would have to be looked at.

    quantity: what there should be one of, at least. why: the reason why it takes one. number: of them. note: what
    kept them away.
    """
    return replace(bounded(quantity, number, 1.0, why, at_least=True, note=note), outcome="inconclusive")


@dataclass(frozen=True)
class Law:
    """Something that holds for any scene with certain parts.

    name: of the law, the variant of its verdicts. equation: in plain text. excuse: of a run, None if the law holds for
    it, else why it does not apply, or cannot be judged, in words. judge: its judgements of a run; Unsupported, with the
    reason, if the engine cannot make an extra run that it needs. records: observables that it needs of the run itself,
    as far as the scene can have and the engine can measure them. extra: of a trial, the runs that it will ask for, as
    far as that is known beforehand.
    """

    name: str
    equation: str
    excuse: Callable[[Trial], str | None]
    judge: Callable[[Trial], Judged]
    records: tuple[str, ...] = ()
    extra: Callable[[Trial], Iterable[Extra]] = lambda trial: ()
