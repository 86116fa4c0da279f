"""What two runs cost: numbers of operations, which are exact, and computing times beside another engine of the run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from crosscheck.regression.results import Key, Results

#: The share by which a number of operations may grow: that of the checks `*/operations`.
GROWN = 0.05
#: Numbers that follow from the length of the run. The others depend on what happened in it: another rounding of a
#: chaotic run changes them, as other random numbers would.
_GIVEN = ("steps", "evaluations", "site_updates", "row_fetches")
#: So many standard errors of Poisson's distribution may the latter differ by: 6e-7, one of a thousand numbers rarely.
_POISSON = 5.0

#: Factors of the time beside another engine, in the median over cases, and of a single case, that are more than noise;
#: a single case counts from so many seconds of CPU time on. Found: up to 1.06, and 1.33 (docs/regression.md).
PACE, PACE_OF_A_CASE, LEAST_SECONDS = 1.1, 2.0, 0.02
#: Probability that the interval of a median does not hold it.
_LEVEL = 1e-3


class Growth(NamedTuple):
    """A number of operations that is another one. name: see `Cost`. old, new: the numbers."""

    name: str
    old: int
    new: int

    def __str__(self) -> str:
        times = f", times {self.new / self.old:.3g}" if self.old else ""
        return f"{self.name} {self.old} -> {self.new}{times}"


def growth(old: Mapping[str, int], new: Mapping[str, int]) -> tuple[list[Growth], list[Growth]]:
    """The numbers of operations that have grown, and those that have fallen, by more than `GROWN`.

    old, new: of a case in two runs with the same seed, by name; what one of them has not counted is left out.
    """
    both = [Growth(name, old[name], new[name]) for name in old if name in new]
    grown = [one for one in both if _more(one.name, one.old, one.new)]
    return grown, [one for one in both if _more(one.name, one.new, one.old)]


def _more(name: str, least: int, most: int) -> bool:
    chance = 0.0 if name in _GIVEN else _POISSON * math.sqrt(least + most)
    return most > (1 + GROWN) * least and most - least > chance


class Pace(NamedTuple):
    """How the CPU time of an engine, beside that of another one in the same run, has changed.

    engine: its name. case: the case; "": the median of all cases. factor: by which the ratio has grown. low, high: its
    interval of 99.9 %; of one case the factor itself. cases: how many.
    """

    engine: str
    case: str
    factor: float
    low: float
    high: float
    cases: int

    @property
    def slower(self) -> bool:
        """Whether it is slower beyond the noise."""
        return self.low > (PACE_OF_A_CASE if self.case else PACE)

    @property
    def faster(self) -> bool:
        """Whether it is faster beyond the noise."""
        return self.high < 1 / (PACE_OF_A_CASE if self.case else PACE)


def incomparable(old: Results, new: Results, beside: str) -> str:
    """Why the computing times of an old and a new run say nothing; "": they do.

    beside: the engine that others are compared with.
    """
    before, after = old.provenance, new.provenance
    for name, text in (("cpu", "processors"), ("cores", "numbers of cores")):
        if before.get(name) != after.get(name):
            return f"the runs had other {text}"
    versions = [
        {name: source.get("versions", {}).get(name) for name in _VERSIONS.get(beside, (beside,))}
        for source in (before, after)
    ]
    if versions[0] != versions[1]:
        return f"the runs had other versions of {beside}"
    return ""


#: Packages whose versions decide how fast an engine is, where they are not called as it is.
_VERSIONS = {"refimpl": ("particle-crosscheck", "numba", "numpy")}


def paces(old: Results, new: Results, beside: str) -> list[Pace]:
    """How the CPU times of engines have changed from an old to a new run, beside those of another engine in each.

    Of each case that both engines have in both runs: r = (t/t')_new/(t/t')_old, t and t' the CPU seconds of the engine
    and of `beside`. For an engine the median of r, with its interval by the sign test, from 11 cases on, with which an
    interval of 99.9 % exists; and each case of `LEAST_SECONDS` or more in all four.
    """
    ratios: dict[str, list[tuple[str, float, float]]] = {}
    for case, engine in old.cases:
        times = [_cpu(source, key) for source in (new, old) for key in ((case, engine), (case, beside))]
        if engine != beside and min(times) > 0:
            factor = times[0] / times[1] / (times[2] / times[3])
            ratios.setdefault(engine, []).append((case, factor, min(times)))
    found = []
    for engine, cases in ratios.items():
        found += _median(engine, sorted(factor for _, factor, _ in cases))
        found += [Pace(engine, case, f, f, f, 1) for case, f, least in cases if least >= LEAST_SECONDS]
    return found


def _cpu(source: Results, key: Key) -> float:
    """CPU seconds of a case; 0 where it was not judged."""
    case = source.cases.get(key)
    return 0.0 if case is None or not case.judged else case.cpu or 0.0


def _median(engine: str, factors: list[float]) -> list[Pace]:
    """The median of sorted factors with its interval; none where they are too few for one."""
    from scipy.stats import binom

    number = len(factors)
    rank = int(binom.ppf(_LEVEL / 2, number, 0.5))  # P(fewer than `rank` of the factors are below the median) < level/2
    if rank < 1:
        return []
    middle = (factors[(number - 1) // 2] * factors[number // 2]) ** 0.5
    return [Pace(engine, "", middle, factors[rank - 1], factors[number - rank], number)]
