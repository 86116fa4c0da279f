"""The difference of two results: every judgement and case in one category, and the exit status that follows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from crosscheck.regression.baseline import same_text
from crosscheck.regression.change import FALSE_ALARM, MOVED, change, statistical
from crosscheck.regression.results import Case, Key, Number, Results
from crosscheck.regression.work import Pace, growth, incomparable, paces
from crosscheck.status import Status, decisive

Category = Literal[
    "new_failure",
    "changed",
    "more_operations",
    "could_not_run",
    "no_longer_tested",
    "inconclusive",
    "known",
    "nearer",
    "slower",
    "fewer_operations",
    "faster",
    "fixed",
    "newly_tested",
]


class Kind(NamedTuple):
    """A category. title: as it is shown. status: the exit status that follows if there is anything in it."""

    title: str
    status: Status


#: In the order in which they are shown: what is worse first, then what a user should know, then what is better.
CATEGORIES: dict[Category, Kind] = {
    "new_failure": Kind("new failures", Status.FAILED),
    "changed": Kind("changed beyond uncertainty", Status.FAILED),
    "more_operations": Kind("slower: more operations", Status.FAILED),
    "could_not_run": Kind("could not run", Status.UNJUDGED),
    "no_longer_tested": Kind("no longer tested", Status.UNJUDGED),
    "inconclusive": Kind("became inconclusive", Status.INCONCLUSIVE),
    "known": Kind("not green, as before", Status.PASSED),
    "nearer": Kind("nearer to a limit", Status.PASSED),
    "slower": Kind("slower beside another engine", Status.PASSED),
    "fewer_operations": Kind("faster: fewer operations", Status.PASSED),
    "faster": Kind("faster beside another engine", Status.PASSED),
    "fixed": Kind("fixed", Status.PASSED),
    "newly_tested": Kind("newly tested", Status.PASSED),
}


class Entry(NamedTuple):
    """One thing that differs.

    category: see `CATEGORIES`. case, engine: of what; case "" of all cases of the engine. quantity: of a judgement; "":
    of the whole case. old, new: its numbers in the two results; None: there are none. share: how far the number has
    moved, as a share of what two right runs may differ by; None: it cannot be told. message: the rest, in words.
    """

    category: Category
    case: str
    engine: str
    quantity: str = ""
    old: Number | None = None
    new: Number | None = None
    share: float | None = None
    message: str = ""


@dataclass(frozen=True)
class Difference:
    """The difference of two results.

    old, new: their names. entries: in the order of the categories, of cases and engines. cases: how many there are in
    both, judged. judgements: how many judgements were compared. same: of these, how many numbers are equal. rounded: to
    the digits of a baseline, else to the last bit. errors: how many of them were compared by standard errors. remarks:
    sentences on what was not compared, and what to expect.
    """

    old: str
    new: str
    entries: tuple[Entry, ...]
    cases: int
    judgements: int
    same: int
    rounded: bool
    errors: int
    remarks: tuple[str, ...]

    def of(self, category: Category) -> list[Entry]:
        """The entries of a category."""
        return [one for one in self.entries if one.category == category]

    def status(self, allow_inconclusive: bool = False) -> Status:
        """The exit status: that of the category that counts first; UNJUDGED too if no case is judged in both.

        allow_inconclusive: what became inconclusive does not count.
        """
        held = {CATEGORIES[one.category].status for one in self.entries}
        if allow_inconclusive:
            held.discard(Status.INCONCLUSIVE)
        return decisive(*held, *([] if self.cases else [Status.UNJUDGED]))

    @property
    def false_alarms(self) -> str:
        """A sentence on how often two right runs seem to differ; "": nothing was compared by standard errors."""
        if not self.errors:
            return ""
        return (
            f"false alarms: {self.errors} numbers are compared by standard errors: of two right runs with other random "
            f"numbers, any of them changes beyond uncertainty with the probability {FALSE_ALARM:g}"
        )


def compare(old: Results, new: Results, beside: str = "refimpl") -> Difference:
    """The difference between two results of the same cases.

    old, new: of the first run, or of a baseline, and of the second. beside: the engine that the computing times of
    others are compared with, within each run.
    """
    same_seed = old.seed is not None and old.seed == new.seed
    rounded = old.rounded or new.rounded
    pairs = [(old.cases[key], case) for key, case in new.cases.items() if key in old.cases]
    pairs = [(before, after) for before, after in pairs if before.judged and after.judged]
    errors = sum(statistical(one, other) for one, other in _numbers(pairs))
    level = FALSE_ALARM / max(errors, 1)
    judge = _Judge(lambda one, other: change(one, other, level, same_seed), same_seed)
    found = [
        one for key in {**old.cases, **new.cases} for one in judge.case(key, old.cases.get(key), new.cases.get(key))
    ]
    times, untimed = _times(old, new, beside)
    found += _paces(times, beside)
    order = {category: rank for rank, category in enumerate(CATEGORIES)}
    found.sort(key=lambda one: (order[one.category], one.case, one.engine))
    return Difference(
        old.name,
        new.name,
        tuple(found),
        len(pairs),
        sum(1 for _ in _numbers(pairs)),
        sum(same_text(*both) if rounded else both[0].off == both[1].off for both in _numbers(pairs)),
        rounded,
        errors,
        tuple(_remarks(old, new, same_seed, untimed)),
    )


def within(results: Results, covers: Callable[[Key, Case], bool]) -> Results:
    """The results of those cases that `covers` accepts, by name, engine and what came of them."""
    return replace(results, cases={key: case for key, case in results.cases.items() if covers(key, case)})


def _numbers(pairs: Sequence[tuple[Case, Case]]) -> Iterator[tuple[Number, Number]]:
    """The numbers that both cases of a pair have."""
    for before, after in pairs:
        for name, number in after.numbers.items():
            if name in before.numbers:
                yield before.numbers[name], number


class _Judge:
    """Puts what differs between two results of a case in its category.

    change: of a number, see `change`. same_seed: numbers of operations can be compared.
    """

    def __init__(self, change: Callable[[Number, Number], float | None], same_seed: bool) -> None:
        self._change, self._same_seed = change, same_seed

    def case(self, key: Key, old: Case | None, new: Case | None) -> Iterator[Entry]:
        """What differs in one case; None: a result does not have it."""
        before = "not there" if old is None else old.outcome
        if new is None:
            if before != "skip":
                yield Entry("no_longer_tested", *key, message=f"{before} before; the case is not there")
        elif new.outcome == "error":
            category: Category = "known" if before == "error" else "could_not_run"
            yield Entry(category, *key, message=f"{before} before; {_error(new)}")
        elif new.outcome == "skip":
            if old is not None and old.judged:
                yield Entry("no_longer_tested", *key, message=f"{before} before; skipped: {new.message}")
            elif before == "error":
                yield Entry("known", *key, message=f"error before; skipped: {new.message}")
        elif old is None or not old.judged:
            yield from self._begun(key, before, new)
        else:
            yield from self._judgements(key, old.numbers, new.numbers)
            if old.refused is not None and (new.refused or 0) > old.refused:
                message = f"scenes that the engine refuses: {old.refused} before, {new.refused} now"
                yield Entry("no_longer_tested", *key, message=message)
            same_scenes = None in (old.refused, new.refused) or old.refused == new.refused
            if self._same_seed and same_scenes:
                yield from _operations(key, old, new)

    def _begun(self, key: Key, before: str, new: Case) -> Iterator[Entry]:
        """A case that was not judged before."""
        bad = [one for name, number in new.numbers.items() for one in self._alone(key, name, number)]
        yield from bad
        if not bad:
            category: Category = "fixed" if before == "error" else "newly_tested"
            number = f"{len(new.numbers)} judgement{'s' if len(new.numbers) > 1 else ''}, all green"
            yield Entry(category, *key, message=f"{before} before; {number}")

    @staticmethod
    def _alone(key: Key, name: str, number: Number) -> Iterator[Entry]:
        """A number that has none to be compared with."""
        if number.outcome == "fail":
            yield Entry("new_failure", *key, name, None, number)
        elif number.outcome == "inconclusive":
            yield Entry("inconclusive", *key, name, None, number)

    def _judgements(self, key: Key, old: Mapping[str, Number], new: Mapping[str, Number]) -> Iterator[Entry]:
        """The judgements of a case that was judged in both."""
        begun = 0
        for name, number in new.items():
            if name in old:
                yield from self._both(key, name, old[name], number)
            else:
                alone = list(self._alone(key, name, number))
                yield from alone
                begun += not alone
        if begun:
            yield Entry("newly_tested", *key, message=f"{begun} of {len(new)} judgements")
        gone = [name for name in old if name not in new]
        if gone:
            listed = "; ".join(gone[:3]) + (f"; and {len(gone) - 3} more" if len(gone) > 3 else "")
            message = f"{len(gone)} of {len(old)} judgements are not there: {listed}"
            yield Entry("no_longer_tested", *key, message=message)

    def _both(self, key: Key, name: str, old: Number, new: Number) -> Iterator[Entry]:
        """A number that both results have."""
        share = self._change(old, new)
        changed = share is not None and share > 1
        outcomes = old.outcome, new.outcome
        found: Category | None = None
        message = ""
        if new.outcome == "fail" and (old.outcome != "fail" or changed):
            found, message = "new_failure", "it failed otherwise before" if old.outcome == "fail" else ""
        elif new.outcome == "pass" and old.outcome != "pass":
            found = "fixed"
        elif changed:
            found = "changed"
        elif outcomes == ("pass", "inconclusive"):
            found = "inconclusive"
        elif new.outcome != "pass":
            found = "known"
        elif _nearer(old, new):
            found = "nearer"
        if found is not None:
            yield Entry(found, *key, name, old, new, share, message)


def _nearer(old: Number, new: Number) -> bool:
    """Whether a green bound has come nearer to its limit by more than the share `MOVED` of that; not of random ones."""
    known = new.kind in ("bound", "expected_failure") and (old.kind, old.sense) == (new.kind, new.sense)
    return known and new.share - old.share > MOVED


def _error(case: Case) -> str:
    """The first line of the message of an error."""
    return case.message.partition("\n")[0] or "it ended in an error"


def _operations(key: Key, old: Case, new: Case) -> Iterator[Entry]:
    more, fewer = growth(old.counters, new.counters)
    for category, found in (("more_operations", more), ("fewer_operations", fewer)):
        if found:
            # mypy does not see that these are names of categories
            yield Entry(category, *key, message="; ".join(map(str, found)))  # type: ignore[arg-type]


def _times(old: Results, new: Results, beside: str) -> tuple[list[Pace], str]:
    """How computing times have changed, and why they were not compared; "": they were, or a baseline has none."""
    if old.rounded or new.rounded:
        return [], ""
    if reason := incomparable(old, new, beside):
        return [], reason
    times = paces(old, new, beside)
    return times, "" if times else f"there are too few cases of other engines beside {beside}"


def _paces(times: Sequence[Pace], beside: str) -> Iterator[Entry]:
    for one in times:
        if one.slower or one.faster:
            scope = "" if one.case else f", the median of {one.cases} cases; 99.9 %: {one.low:.3g} to {one.high:.3g}"
            message = f"CPU time beside {beside}: times {one.factor:.3g}{scope}"
            yield Entry("slower" if one.slower else "faster", one.case, one.engine, message=message)


def _remarks(old: Results, new: Results, same_seed: bool, untimed: str) -> Iterator[str]:
    """Sentences on what was not compared, and on what may be expected. untimed: why times were not compared, or ""."""
    if not same_seed:
        seeds = " and ".join("several" if one.seed is None else str(one.seed) for one in (old, new))
        yield f"numbers of operations are not compared: the seeds are {seeds}"
    elif old.provenance and all(old.provenance.get(name) == new.provenance.get(name) for name in _SAME_BITS):
        yield "same seed, versions and processor: an engine that has not changed gives the same numbers to the last bit"
    if untimed:
        yield f"computing times are not compared: {untimed}"


#: Entries of a provenance that decide about the last bits.
_SAME_BITS = ("versions", "cpu")
