"""The command `prove`: checks with their planted faults."""

from __future__ import annotations

import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fnmatch import fnmatchcase
from itertools import chain
from pathlib import Path

from crosscheck import runner
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check
from crosscheck.commands.console import that_pay
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.errors import UsageError
from crosscheck.faults import Fault
from crosscheck.status import Status, decisive
from crosscheck.verdict import Verdict


def prove(patterns: list[str], jobs: int | None, seed: int, time_limit: float = TIME_LIMIT) -> int:
    """Runs checks with their planted faults, and prints a line for each; returns the exit status.

    Checks that measure computing times come last, one after the other: what runs beside them would change their ratios.

    patterns: shell patterns of names of checks or of `check/variant`; none: all. jobs: faults at a time; None: one per
    core. seed: the suite's seed. time_limit: seconds that one call of an engine may take. The status is PASSED if
    every fault turns its check red, which is green without it; UNJUDGED if cases could not run, with the fault or
    without it; FAILED if another fault is not seen. UsageError if a pattern matches no check with a fault, or the text
    that a fault replaces is not there.
    """

    def matches(pattern: str, check: Check, variant: str) -> bool:
        return fnmatchcase(check.name, pattern) or fnmatchcase(f"{check.name}/{variant}", pattern)

    planted = [
        (check, variant, fault)
        for check in all_checks()
        for variant, fault in check.faults
        if not patterns or any(matches(pattern, check, variant) for pattern in patterns)
    ]
    for pattern in patterns:
        if not any(matches(pattern, check, variant) for check, variant, _ in planted):
            raise UsageError(f"no check matches {pattern}; see `crosscheck list`")
    planted.sort(key=lambda item: item[0].timing)
    together = sum(not check.timing for check, _, _ in planted)
    seen, held = 0, [Status.PASSED]

    def proved(item: tuple[Check, str, Fault]) -> tuple[Verdict, str]:
        return _prove_one(*item, seed=seed, time_limit=time_limit)

    with ThreadPoolExecutor(that_pay(jobs, len(planted))) as pool:
        results = chain(pool.map(proved, planted[:together]), map(proved, planted[together:]))
        for (check, variant, fault), (verdict, without) in zip(planted, results, strict=True):
            red = verdict.outcome == "fail" and without == "pass"
            seen += red
            if not red:
                held.append(Status.UNJUDGED if "error" in (verdict.outcome, without) else Status.FAILED)
            state = "red" if red else f"NOT RED ({verdict.outcome})"
            if verdict.outcome == "fail" and not red:
                state = f"NOT GREEN WITHOUT ({without})"
            print(f"{state:<16} {check.name}/{variant}  {fault.name}: {fault.breaks}", flush=True)
            if verdict.message:
                print(f"    {verdict.message}")
    runner.close_pools()
    print(f"{seen} of {len(planted)} planted faults turned their check red")
    return int(decisive(*held))


def _prove_one(check: Check, variant: str, fault: Fault, *, seed: int, time_limit: float) -> tuple[Verdict, str]:
    """The verdict with the fault, and the outcome without it if that verdict is red."""
    case = runner.Case(check.name, variant, "refimpl", check.timing)
    with tempfile.TemporaryDirectory(prefix="crosscheck-fault-") as directory:
        overlay = Path(directory)
        fault.apply(overlay)
        verdict = runner.judge(case, seed, overlay, time_limit)
    without = runner.judge(case, seed, None, time_limit).outcome if verdict.outcome == "fail" else ""
    return replace(verdict, cost={}), without
