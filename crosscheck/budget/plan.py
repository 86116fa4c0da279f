"""Which cases a run has time for, and in which order.

Each check is judged by its cheapest case before any of them is judged by a second one, and cheap checks come before
expensive ones: so most phenomena are judged. A case of the small tier is not run where there is time for the larger one
that it stands for.
"""

from __future__ import annotations

import math
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from crosscheck.budget.loads import classes, load_of, share
from crosscheck.budget.speeds import Speed, measured
from crosscheck.engines.registry import engine_class
from crosscheck.runner import Case, find
from crosscheck.verdict import LEFT_OUT, Verdict

#: A case may take so many times what is predicted for it, and such a share of the whole time at least, before it ends.
_MOST_TIMES, _LEAST_SHARE = 20.0, 0.25
#: Share of the time that one run of the measurement of speeds may take.
_SHARE_OF_A_TRIAL = 0.25
#: Seconds of finished cases that count as much as what was measured beforehand; and by how much they may correct it.
_SECONDS_OF_TRUST, _MOST_CORRECTION = 1.0, 8.0


class Predicted(NamedTuple):
    """A case, and the seconds that it will take; None: nobody knows."""

    case: Case
    seconds: float | None


#: Speeds by engine, interaction and kind of scheme; None where it could not be measured.
Speeds = Mapping[tuple[str, str, str], Speed | None]


def measure(cases: Iterable[Case], seconds: float, tell: Callable[[str], None] = lambda text: None) -> Speeds:
    """The speeds that the prediction of `cases` needs, measured one after the other.

    seconds: of the whole run, of which one trial may take a share. tell: is told each speed, in words.
    """
    wanted: dict[tuple[str, str, str], None] = {}
    for case in cases:
        load = load_of(case.check, case.variant)
        for interaction, kind in sorted(classes(load.loads)) if load is not None else ():
            wanted[case.engine, interaction, kind] = None
    found: dict[tuple[str, str, str], Speed | None] = {}
    for key in wanted:
        found[key] = measured(*key, time_limit=_SHARE_OF_A_TRIAL * seconds)
        tell(_in_words(*key, found[key]))
    return found


_UNITS = {"event_driven": "an event", "lattice": "a site"}


def _in_words(engine: str, interaction: str, kind: str, speed: Speed | None) -> str:
    if speed is None:
        return f"{engine}, [{interaction}], {kind}: speed unknown; it runs none of the trial scenes, or fails"
    things = "sites" if kind == "lattice" else "particles"
    unit = _UNITS.get(kind, "a step")
    values = ", ".join(f"{1e6 * s:.3g} us ({n})" for n, s in zip(speed.sizes, speed.units, strict=True))
    return f"{engine}, [{interaction}], {kind}: {unit} takes {values} {things}"


def predicted(case: Case, speeds: Speeds) -> float | None:
    """Seconds that a case will take; None if it was not counted, or a speed is not known. speeds: measured ones."""
    load = load_of(case.check, case.variant)
    if load is None:
        return None
    engine, total = engine_class(case.engine), load.elsewhere
    for one in load.loads:
        speed = speeds.get((case.engine, one.interaction, one.kind))
        if speed is None:
            return None
        total += share(one, engine) * speed.of(one)
    return total


def ordered(predictions: Sequence[Predicted]) -> list[Predicted]:
    """In the order in which cases are chosen: the cheapest of each check and engine, then the second ones, and so on.

    What nobody can predict comes last. predictions: of all cases.
    """
    groups: defaultdict[tuple[str, str], list[Predicted]] = defaultdict(list)
    for one in predictions:
        groups[one.case.check, one.case.engine].append(one)
    ranked = [
        (rank, one)
        for group in groups.values()
        for rank, one in enumerate(sorted(group, key=lambda one: (_seconds(one), one.case.name)))
    ]
    ranked.sort(key=lambda item: (item[1].seconds is None, item[0], _seconds(item[1]), item[1].case.name))
    return [one for _, one in ranked]


def _seconds(one: Predicted) -> float:
    return math.inf if one.seconds is None else one.seconds


def chosen(order: Sequence[Predicted], seconds: float, jobs: int) -> list[Predicted]:
    """Those that end in time if all take what is predicted: `jobs` at a time, those that measure times afterwards.

    order: in which they are started. seconds: that there are. A small case goes where there is time for its larger one,
    and for all others that were chosen.
    """
    needless: set[Case] = set()
    fits = _that_fit(order, seconds, jobs)
    for small in [one.case for one in fits if one.case.instead]:
        without = _that_fit([one for one in order if one.case not in needless | {small}], seconds, jobs)
        cases = {one.case for one in without}
        larger = any((case.check, case.engine, case.variant) == _larger(small) for case in cases)
        if larger and {one.case for one in fits} - {small} <= cases:
            needless.add(small)
            fits = without
    return fits


def _larger(case: Case) -> tuple[str, str, str]:
    """Check, engine and variant that a case of the small tier stands for."""
    return case.check, case.engine, case.instead


def _that_fit(order: Sequence[Predicted], seconds: float, jobs: int) -> list[Predicted]:
    threads, alone, fits = [0.0] * jobs, 0.0, []
    for one in order:
        took = _seconds(one)
        if one.case.timing:
            if max(threads) + alone + took > seconds:
                continue
            alone += took
        else:
            first = threads.index(min(threads))
            if max(max(threads), threads[first] + took) + alone > seconds:
                continue
            threads[first] += took
        fits.append(one)
    return fits


class Budget:
    """What there is time for, as a run goes on: `crosscheck.runner.Budget`.

    cases: to choose from. speeds: of their engines. seconds: of the run. jobs: cases at a time. began: when the run
    did, on the clock `time.monotonic`; None: now.
    """

    def __init__(
        self, cases: Sequence[Case], speeds: Speeds, seconds: float, jobs: int, began: float | None = None
    ) -> None:
        now = time.monotonic()
        self._seconds, self._deadline = seconds, (now if began is None else began) + seconds
        order = ordered([Predicted(case, predicted(case, speeds)) for case in cases])
        taken = chosen(order, self._deadline - now, jobs)
        self._predicted = {one.case: one.seconds for one in order}
        self._reserved = {one.case: _seconds(one) for one in taken if one.case.timing}
        self._took: defaultdict[tuple[str, str], list[float]] = defaultdict(lambda: [0.0, 0.0])
        self._lock = threading.Lock()
        names = {(one.case.check, one.case.engine, one.case.variant) for one in taken}
        rest = [one for one in order if one not in taken and _larger(one.case) not in names]
        #: In the order in which they are to be run; those that there seems to be no time for come last.
        self.cases = [one.case for one in (*taken, *rest)]
        #: Those that were chosen beforehand.
        self.chosen = [one.case for one in taken]
        #: What was chosen, in words.
        self.said = _choice(taken, order, self._deadline - now)

    def left_out(self, case: Case) -> Verdict | None:
        """As in `crosscheck.runner.Budget`. case: whose turn has come."""
        with self._lock:
            self._reserved.pop(case, None)
            left = self._deadline - time.monotonic() - sum(self._reserved.values())
            expected = self._corrected(case)
        if left > 0 and (expected is None or expected <= left):
            return None
        return left_out(case, expected)

    def limit(self, case: Case) -> float:
        """As in `crosscheck.runner.Budget`. case: that starts."""
        return min(self._deadline, time.monotonic() + self.allowed(case))

    def allowed(self, case: Case) -> float:
        """Seconds that a case may take, whatever else there is to do: many times what is predicted. case: that one."""
        return max(_MOST_TIMES * (self._predicted[case] or 0.0), _LEAST_SHARE * self._seconds)

    def expected(self, case: Case) -> float | None:
        """Seconds that were predicted beforehand; None: nobody could. case: that one."""
        return self._predicted[case]

    def finished(self, case: Case, verdict: Verdict) -> Verdict:
        """As in `crosscheck.runner.Budget`. case, verdict: that one, and its."""
        expected = self._predicted[case]
        if expected is None:
            return verdict
        if verdict.outcome != "skip":
            with self._lock:
                sums = self._took[_group(case)]
                sums[0] += verdict.cost["seconds"]
                sums[1] += expected
        message = verdict.message
        if message.startswith(LEFT_OUT):
            message += f", {expected:.2g} s were predicted"
        return replace(verdict, message=message, cost={**verdict.cost, "predicted": expected})

    def _corrected(self, case: Case) -> float | None:
        """What is predicted, times what the finished cases of its group took over what was predicted for them."""
        seconds = self._predicted[case]
        if seconds is None:
            return None
        took, expected = self._took[_group(case)]
        factor = (took + _SECONDS_OF_TRUST) / (expected + _SECONDS_OF_TRUST)
        return seconds * min(max(factor, 1 / _MOST_CORRECTION), _MOST_CORRECTION)


def _choice(taken: Sequence[Predicted], order: Sequence[Predicted], left: float) -> str:
    cases = f"{len(taken)} of {len(order)} cases" if len(taken) < len(order) else f"all {len(order)} cases"
    return f"budget: {cases} fit, predicted {sum(_seconds(one) for one in taken):.3g} s; {left:.3g} s are left"


def _group(case: Case) -> tuple[str, str]:
    """Cases whose predictions are wrong by a similar factor: of one engine, and one group of checks."""
    return case.engine, case.check.partition("/")[0]


def left_out(case: Case, seconds: float | None) -> Verdict:
    """The verdict of a case that there is no time for. seconds: that it was predicted to take; None: not predicted."""
    found = find(case.check).offered(engine_class(case.engine).schemes)
    tier = next(variant.tier for variant in found if variant.name == case.variant)
    reason = "no speed is known" if seconds is None else f"predicted {seconds:.2g} s"
    cost = {"seconds": 0.0} if seconds is None else {"seconds": 0.0, "predicted": seconds}
    return Verdict(case.check, case.variant, case.engine, "skip", None, f"{LEFT_OUT}: {reason}", cost, tier)
