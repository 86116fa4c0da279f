"""The score: how many mutants were caught, with its interval, in all and by file and operator."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from crosscheck.mutation.draw import Mutant
from crosscheck.mutation.equivalents import Equivalent
from crosscheck.mutation.trial import Outcome

#: Of the interval of a score.
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Count:
    """How many mutants were caught, survived, and survived since they are equivalent to the original."""

    caught: int
    survived: int
    equivalent: int = 0

    @property
    def share(self) -> float:
        """The share of the caught among those that are not equivalent; NaN of none."""
        number = self.caught + self.survived
        return self.caught / number if number else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Of the share, by Clopper and Pearson, Biometrika 26, 404 (1934), at the level `CONFIDENCE`."""
        from scipy.stats import binomtest

        number = self.caught + self.survived
        if not number:
            return 0.0, 1.0
        found = binomtest(self.caught, number).proportion_ci(CONFIDENCE, method="exact")
        return float(found.low), float(found.high)


@dataclass(frozen=True)
class Judged:
    """A mutant and what became of it.

    mutant: which. outcome: of its trial. reason: why it is equivalent to the original, "" if it is not known to be.
    """

    mutant: Mutant
    outcome: Outcome
    reason: str = ""

    @property
    def state(self) -> str:
        """ "caught", "survived" or "equivalent"."""
        return "caught" if self.outcome.caught else "equivalent" if self.reason else "survived"


def judged(mutant: Mutant, outcome: Outcome, entries: Sequence[Equivalent]) -> Judged:
    """The mutant with its outcome, and the reason of the first of the entries that matches it.

    mutant, outcome: see `Judged`. entries: of the list of equivalent mutations.
    """
    return Judged(mutant, outcome, next((one.reason for one in entries if one.matches(mutant)), ""))


def counted(found: Iterable[Judged]) -> Count:
    """How many of each state. found: the mutants."""
    states = [one.state for one in found]
    return Count(*(states.count(state) for state in ("caught", "survived", "equivalent")))


def counted_by(found: Sequence[Judged], key: Callable[[Mutant], str]) -> dict[str, Count]:
    """How many of each state, for each value of a key. found: the mutants. key: of a mutant."""
    keys = sorted({key(one.mutant) for one in found})
    return {name: counted(one for one in found if key(one.mutant) == name) for name in keys}


def by_file(mutant: Mutant) -> str:
    """The key for a table by file: that of the mutant."""
    return f"{mutant.package}/{mutant.file}"


def by_operator(mutant: Mutant) -> str:
    """The key for a table by operator: that of the mutant."""
    return mutant.mutation.operator


def as_record(found: Sequence[Judged], about: dict[str, Any]) -> dict[str, Any]:
    """The score as JSON. found: the mutants. about: date, command and the like, which comes first."""
    total = counted(found)
    return {
        **about,
        "confidence": CONFIDENCE,
        **_as_entry(total),
        "by_file": {name: _as_entry(count) for name, count in counted_by(found, by_file).items()},
        "by_operator": {name: _as_entry(count) for name, count in counted_by(found, by_operator).items()},
        "not_caught": [
            {
                "name": one.mutant.name,
                "function": one.mutant.mutation.function,
                "state": one.state,
                "reason": one.reason,
                "judged": one.outcome.judged,
                "left": one.outcome.left,
                "diff": one.mutant.diff(0),
            }
            for one in found
            if one.state != "caught"
        ],
    }


def _as_entry(count: Count) -> dict[str, Any]:
    return {**asdict(count), "interval": [round(edge, 4) for edge in count.interval]}


def write(path: Path, record: dict[str, Any]) -> None:
    """Writes the score; path: of the file. record: of `as_record`."""
    path.write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", encoding="utf-8")
