"""What a property is: what is collected of each frame, and what is judged of all of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

from crosscheck.figure import Figure
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.verdict import Judgement, within

#: Chapters of what is told, in their order.
CHAPTERS = ("file", "motion", "conservation", "velocities", "structure")


class Told(NamedTuple):
    """What is told of a property. judgements: verdicts. said: whole sentences: what was measured and is not judged, and
    why something cannot be said. figures: see `crosscheck.figure`."""

    judgements: tuple[Judgement, ...] = ()
    said: tuple[str, ...] = ()
    figures: tuple[Figure, ...] = ()


class Collector(ABC):
    """Takes what it needs of each frame, in the order of the file, and judges it when all are seen."""

    @abstractmethod
    def add(self, view: View) -> None:
        """Takes what it needs of a frame, of which nothing else is kept. view: of the frame."""

    @abstractmethod
    def judge(self, once: float) -> Told:
        """What is told of all frames. once: probability that a statistical judgement is red although all is right.

        It is asked twice: the first time to count the judgements, among which a probability is shared.
        """

    def stopped(self, reason: str) -> None:
        """Is told that no further frames are looked at. reason: a sentence."""
        return


class Property(NamedTuple):
    """A property of a trajectory.

    name: as users see it. chapter: one of `CHAPTERS`. begin: returns the collector for a trajectory, or a sentence that
    says why nothing can be said of it.
    """

    name: str
    chapter: str
    begin: Callable[[Setting], Collector | str]


def none_of(quantity: str, count: int, why: str, note: str = "") -> Judgement:
    """The judgement that something does not occur: one is too many.

    quantity: what is counted. count: how often it occurs. why: the reason why it must not. note: where it does.
    """
    return within("round_off", quantity, float(count), 0.0, 0.5, f"{why}; a count, of which one is too many", note=note)
