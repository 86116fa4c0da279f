"""Whether a deviation of the stated sensitivity is seen in 90 % of all runs, where the data of an engine have it.

    python benchmarks/evidence/sensitivities.py [pattern of checks or cases ...] [--seeds K] [--tier T] [--engine NAME]

For each number that a case judges statistically with a standard error, one observable of the engine's runs is altered:
multiplied by 1 + epsilon, in all or in the first half of the particles, the first component or one of several runs
alone, shifted by epsilon of its root mean square, or raised to the power 1 + epsilon; last, times are. The first of
these that moves the number is taken, of the observable that moves it most; it is found by trying. epsilon is such that
the number lies off what is expected by the sensitivity, in the mean over all runs, to either side. Then the check
itself judges the altered data, of each seed in two runs with different random numbers, as `crosscheck run` does where
the first is red; counted are the seeds in which the number is red in both.

The deviation that is injected is that of the mean sensitivity of all runs (root mean square of what depends on the
standard error). Printed for either side: the share of seeds in which it is seen, and of all of them the interval that
holds the true share with the probability 0.95 (Clopper and Pearson); what else turns red, of numbers without a standard
error. Where the expected value has an error of its own, the same in all runs, more than 90 % are seen.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binomtest

from crosscheck import runner
from crosscheck.checks.base import Laboratory
from crosscheck.engines.protocol import Kind, Run
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import UsageError
from crosscheck.scene import Method, Scene
from crosscheck.statistics import seen_beyond, student_quantile
from crosscheck.verdict import SEEN, SUSPICIOUS, Findings, Judgement, findings

#: epsilon of the trial, and the largest one that is injected: a larger one would change the scatter like the mean.
TRIAL, LARGEST = 1e-3, 0.5
#: Of data that a check cannot read.
UNREADABLE = (ValueError, ArithmeticError, LookupError, UsageError)
#: How exactly the deviation is injected, as a share of it.
EXACT = 0.01
#: Observables (..., N, d) of N particles.
OF_PARTICLES = ("positions", "velocities", "angular_velocities", "final_positions", "final_velocities")


def _of_half(x: np.ndarray, epsilon: float) -> np.ndarray:
    factors = np.ones((x.shape[-2], 1))
    factors[: len(factors) // 2] += epsilon
    return x * factors


def _of_first(x: np.ndarray, epsilon: float) -> np.ndarray:
    changed = x.copy()
    changed[..., 0] *= 1 + epsilon
    return changed


#: Alterations: name, and what becomes of an array x.
ALTERATIONS: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "times 1 + e": lambda x, e: x * (1 + e),
    "of half of the particles times 1 + e": _of_half,
    "first component times 1 + e": _of_first,
    "plus e rms": lambda x, e: x + e * np.sqrt(np.mean(x**2)),
    "to the power 1 + e": lambda x, e: np.sign(x) * np.abs(x) ** (1 + e),
}


class Alteration(NamedTuple):
    """Of the observable `name` by `how`, in the run of this `number` alone (None: in all)."""

    name: str
    how: str
    number: int | None = None

    def apply(self, run: Run, number: int, epsilon: float) -> Run:
        """The run of this number as it is altered."""
        if self.name not in run or self.number not in (None, number):
            return run
        arrays = {**run, self.name: ALTERATIONS[self.how](np.asarray(run[self.name], dtype=float), epsilon)}
        return Run(arrays, diverged=run.diverged, stopped=run.stopped, cost=run.cost, remarks=run.remarks)

    def __str__(self) -> str:
        return f"{self.name} {self.how}" + ("" if self.number is None else f", run {self.number} alone")


@dataclass
class Replaying(Laboratory):
    """A laboratory that keeps the runs of a case, and gives them again, altered.

    kept: runs in the order in which the check asked for them, with the engine that was asked. change: the alteration;
    None: none. epsilon: see `Alteration`. asked: number of runs asked for since `again`.
    """

    kept: list[tuple[str, Run]] = field(default_factory=list)
    change: Alteration | None = None
    epsilon: float = 0.0
    asked: int = 0

    def run(
        self,
        scene: Scene,
        method: Method | Kind,
        engine: str | None = None,
        *,
        may_end_early: bool = False,
        interpreted: bool | None = None,
    ) -> Run:
        """As `Laboratory.run`, from what is kept if there is something; of the engine under judgement as altered."""
        number, self.asked = self.asked, self.asked + 1
        if number == len(self.kept):
            run = super().run(scene, method, engine, may_end_early=may_end_early, interpreted=interpreted)
            self.kept.append((engine or self.engine, run))
        name, run = self.kept[number]
        return run if self.change is None or name != self.engine else self.change.apply(run, number, self.epsilon)

    def judged(self, judge: Callable[[], Any], change: Alteration | None = None, epsilon: float = 0.0) -> Findings:
        """What the check finds in the runs with an alteration; judge: calls it with this laboratory."""
        self.change, self.epsilon, self.asked = change, epsilon, 0
        return findings(judge())


def statistical_ones(found: Findings) -> dict[int, Judgement]:
    """Judgements with a standard error, by their number."""
    return {i: one for i, one in enumerate(found.judgements) if one.freedom is not None}


def alterations(runs: Sequence[tuple[str, Run]], engine: str) -> Iterator[list[Alteration]]:
    """Those of all observables, by kind, the simplest kinds first."""
    names = sorted({name for other, run in runs if other == engine for name in run} - {"time"})
    scaled, halved, first, shifted, power = ALTERATIONS
    yield [Alteration(name, scaled) for name in names]
    yield [Alteration(name, halved) for name in names if name in OF_PARTICLES]
    yield [Alteration(name, first) for name in names]
    yield [Alteration(name, shifted) for name in names]
    yield [Alteration(name, scaled, number) for name in names for number in range(min(len(runs), 3))]
    yield [Alteration(name, power) for name in names]
    yield [Alteration("time", scaled)]


class Answer(NamedTuple):
    """To an alteration: slope, the change of the measured number, less what is expected, over epsilon."""

    alteration: Alteration
    slope: float


def moving(run: Judged, index: int, size: float) -> Iterator[Answer]:
    """The alterations that move the number of a judgement: the simplest kind first, of each the strongest first.

    index: of the judgement. size: of the deviation that is to be injected by an epsilon of at most `LARGEST`.
    """
    laboratory, judge, still = run
    for several in alterations(laboratory.kept, laboratory.engine):
        answers = []
        for one in several:
            try:
                moved = laboratory.judged(judge, one, TRIAL)
            except UNREADABLE:
                continue
            if len(moved.judgements) == len(still.judgements):
                change = (off(moved, index) - off(still, index)) / TRIAL
                answers.append(Answer(one, float(np.nan_to_num(change))))
        strong = [answer for answer in answers if abs(answer.slope) * LARGEST > size]
        yield from sorted(strong, key=lambda answer: -abs(answer.slope))


def off(found: Findings, index: int) -> float:
    """The measured number of a judgement less what is expected, which may depend on the data too; NaN: none."""
    one = found.judgements[index]
    return np.nan if one.measured is None or one.expected is None else one.measured - one.expected


def deviation(judged: Sequence[Judgement]) -> float:
    """The sensitivity of all runs, in the unit of the measured number."""
    parts = []
    for one in judged:
        assert one.freedom is not None
        error = np.hypot(one.uncertainty or 0.0, one.expected_uncertainty or 0.0)
        parts.append(seen_beyond(student_quantile(SUSPICIOUS, one.freedom), one.freedom, SEEN**0.5) * error)
    return float(np.mean(np.square(parts)) ** 0.5 + np.mean([one.doubt or 0.0 for one in judged]))


class Judged(NamedTuple):
    """A run of a case. laboratory: has its data. judge: judges them. still: what it found in them as they are."""

    laboratory: Replaying
    judge: Callable[[], Any]
    still: Findings


class Seen(NamedTuple):
    """Of a deviation to one side. twice: seeds in which both runs were red. others: what became red besides, of numbers
    without a standard error.
    """

    twice: int
    others: set[str]


def injected(runs: Sequence[Judged], index: int, answer: Answer, side: int) -> Seen | None:
    """Judges the altered runs: two of each seed, one after the other; index: of the judgement; side: 1 or -1.

    None where the check ends before it comes to that judgement, since what it looks at first is red or unreadable.
    """
    ones = [run.still.judgements[index] for run in runs]
    size = deviation(ones)
    wanted = side * size
    start = float(np.mean([off(run.still, index) for run in runs]))
    epsilon = (wanted - start) / answer.slope
    for _ in range(4):  # the answer is not quite linear, and not the same in all runs
        found = []
        for run in runs:
            try:
                found.append(run.laboratory.judged(run.judge, answer.alteration, epsilon))
            except UNREADABLE:
                return None
            if len(found[-1].judgements) < len(run.still.judgements):
                return None
        moved = float(np.mean([off(one, index) for one in found]))
        if abs(moved - wanted) < EXACT * size:
            break
        epsilon *= (wanted - start) / (moved - start)
    red = [one.judgements[index].outcome == "fail" for one in found]
    others = {j.quantity for one in found for j in one.judgements if j.outcome == "fail" and j.freedom is None}
    twice = sum(first and second for first, second in zip(red[::2], red[1::2], strict=True))
    return Seen(twice, others)


def rows(case: runner.Case, seeds: int, pool: Pool) -> Iterator[str]:
    """Rows of the table of one case."""
    check = runner.find(case.check)
    schemes = engine_class(case.engine).schemes
    variant = next(one for one in check.offered(schemes) if one.name == case.variant)

    def judged(name: str, seed: int) -> Judged:
        laboratory = Replaying(case.engine, schemes, pool, name, seed, interpreted=check.interpreted)

        def judge() -> Any:
            return check.judge(laboratory, variant.value)

        return Judged(laboratory, judge, laboratory.judged(judge))

    first = judged(case.name, 0)
    chosen = statistical_ones(first.still)
    if not chosen:
        return
    runs = [first, judged(again(case), 0)]
    runs += [judged(name, seed) for seed in range(1, seeds) for name in (case.name, again(case))]
    label = f"{case.name} [{case.engine}]"
    for index, one in chosen.items():
        for answer in moving(first, index, deviation([one])):
            up, down = (injected(runs, index, answer, side) for side in (1, -1))
            if up and down:
                break
        else:
            yield f"| {label} | {one.quantity} | {one.freedom:.3g} | none moves it | | | | |"
            continue
        interval = binomtest(up.twice + down.twice, 2 * seeds).proportion_ci()
        yield (
            f"| {label} | {one.quantity} | {one.freedom:.3g} | {answer.alteration} | {up.twice / seeds:.2f} | "
            f"{down.twice / seeds:.2f} | {interval.low:.2f} to {interval.high:.2f} | "
            f"{'; '.join(sorted(up.others | down.others))} |"
        )


def again(case: runner.Case) -> str:
    """The name that seeds the second run of a case, as in `runner.judge`."""
    return f"{case.name}/again"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("patterns", nargs="*")
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--tier", default="quick")
    parser.add_argument("--engine", default="refimpl")
    options = parser.parse_args()
    pool = Pool()
    print(
        "| case | quantity | freedom | altered | seen, + | seen, - | 95 % of both | also red, without standard error |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for case in runner.select(options.patterns, options.tier, [options.engine]):
        if not case.timing:
            for row in rows(case, options.seeds, pool):
                print(row, flush=True)
    pool.close()


if __name__ == "__main__":
    main()
