"""What a law is: for which runs it holds, and how it is judged."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged


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
