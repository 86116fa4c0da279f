"""Scenes judged by all laws, by workers that run plain Python: few particles, and extra runs of less than a second."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from crosscheck.engines.workers.pool import Pool
from crosscheck.faults import Fault
from crosscheck.scene import Scene
from crosscheck.simulate.judging import judge as judging
from crosscheck.simulate.judging.judge import Judge, observables_needed
from crosscheck.simulate.judging.recording import recording
from crosscheck.simulate.methods import planned
from crosscheck.simulate.observables import Result, observables
from crosscheck.verdict import Verdict

#: Computing time, s, that the extra runs of one law may take.
ALLOWANCE = 0.3


def verdicts(
    pool: Pool,
    scene: Scene,
    engines: Sequence[str] = ("refimpl",),
    methods: Sequence[str] = (),
    tolerance: float = 1e-2,
) -> dict[str, Verdict]:
    """The verdict of each law by its name; "name engine" where there are several engines."""
    before, judging.allowance = judging.allowance, lambda cpu: ALLOWANCE
    try:
        results = []
        for one in recording(planned(scene, engines, methods), observables_needed()):
            run = pool.worker(one.engine).run(one.scene, one.method)
            results.append((one, Result(one.label, "1", run, observables(one.scene, run))))
        found = list(Judge(results, pool, tolerance).verdicts(lambda text: None))
    finally:
        judging.allowance = before
    return {one.variant if len(results) == 1 else f"{one.variant} {one.engine}": one for one in found}


def with_fault(directory: Path, file: str, old: str, new: str) -> Pool:
    """Workers of a copy of `refimpl` in which a text is replaced."""
    Fault("planted", file, old, new, "a test").apply(directory)
    return Pool(directory)


def outcomes(found: dict[str, Verdict], *wanted: str) -> dict[str, str]:
    """Names of the laws with these outcomes, and what they are about."""
    return {
        name: one.message
        or "; ".join(judged.quantity for judged in one.findings.judgements if judged.outcome in wanted)
        for name, one in found.items()
        if one.outcome in wanted
        for _ in [assert_told(one)]
    }


def assert_told(one: Verdict) -> None:
    """A verdict has judgements, or says why not."""
    assert one.findings is not None or one.message
