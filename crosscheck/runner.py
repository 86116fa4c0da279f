"""Runs checks on any `concurrent.futures` executor; checks of computing times run alone, after the others."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Set
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from itertools import pairwise
from pathlib import Path
from typing import Protocol

from crosscheck.checks import all_checks
from crosscheck.checks.base import Check, Laboratory, Tier, Variant
from crosscheck.engines.capabilities import lacks
from crosscheck.engines.protocol import Engine
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.engines.workers.pool import Pool
from crosscheck.engines.workers.recording import Executed
from crosscheck.errors import EndedEarly, EngineError, EngineMissing, Unsupported, UsageError
from crosscheck.verdict import LEFT_OUT, Verdict, again, bounded, findings, suspicious, unrepeated


@dataclass(frozen=True)
class Case:
    """One variant of one check on one engine: the unit of work and of the record; a crash costs one case.

    check, variant, engine: their names. timing: it measures computing times, and runs alone. instead: of the small
    tier, the name of the larger variant that it stands for.
    """

    check: str
    variant: str
    engine: str
    timing: bool
    instead: str = ""

    @property
    def name(self) -> str:
        """`group/phenomenon/variant`."""
        return f"{self.check}/{self.variant}"


#: Promises that say how fast an engine is: of no use where its speed is measured.
OF_SPEED = frozenset({"long_runs"})
#: The tiers of the variants that a run of a tier takes.
_CONTAINED: dict[str, tuple[Tier, ...]] = {"small": ("small",), "quick": ("quick",), "full": ("quick", "full")}


def select(patterns: list[str], tier: str, engines: list[str], *, budget: bool = False) -> list[Case]:
    """The cases whose name, or whose check's name, matches, on those of the engines that declare what the check needs.

    patterns: shell patterns; none: all cases. tier: "quick", or "full", which contains it; or "small". engines: names,
    or path.py:Class. budget: measured speeds will choose among the cases: those of the small tier are there too, and
    no promise of speed is asked for. None may be left: the engines may declare too little. UsageError if a pattern
    matches no case of this tier on any installed engine either, or if there is no such engine.
    """
    tiers = {*_CONTAINED[tier], *(("small",) if budget else ())}
    waived = OF_SPEED if budget or tier == "small" else frozenset()
    cases: list[Case] = []
    for check in all_checks():
        for name in dict.fromkeys(engines):
            engine = engine_class(name)
            for variant in judging(check, name, engine, waived):
                case = Case(check.name, variant.name, name, check.timing, variant.instead)
                matches = any(_matches(pattern, check.name, case.name) for pattern in patterns)
                if (not patterns or matches) and variant.tier in tiers:
                    cases.append(case)
    for pattern in patterns:
        if not any(_matches(pattern, case.check, case.name) for case in cases):
            _must_be_known(pattern, tier, tiers, engines)
    return cases


def _matches(pattern: str, check: str, case: str) -> bool:
    return fnmatchcase(case, pattern) or fnmatchcase(check, pattern)


def _must_be_known(pattern: str, tier: str, taken: Set[str], engines: list[str]) -> None:
    """UsageError if the pattern matches no case of the tier on any engine; taken: the tiers of variants in it."""
    tiers = {
        variant.tier
        for check in all_checks()
        for name in dict.fromkeys([*engines, *engine_names()])
        for variant in judging(check, name, engine_class(name))
        if _matches(pattern, check.name, f"{check.name}/{variant.name}")
    }
    if not tiers:
        raise UsageError(f"no check matches {pattern}; see `crosscheck list`")
    if not tiers & taken:
        other = "full" if tiers - {"small"} else "small"
        raise UsageError(f"no case of tier '{tier}' matches {pattern}: add --tier {other}")


def unmatched(check: Check, name: str, engine: type[Engine], waived: Set[str] = frozenset()) -> str | None:
    """None if `check` judges this engine; else what the engine lacks, or that the check compares others with it.

    name: of the engine. engine: its class. waived: promises that are not asked for.
    """
    if name in (check.reference if isinstance(check.reference, tuple) else (check.reference,)):
        return "it is the engine that the check compares others with"
    for needs in check.all_needs:
        reason = lacks(engine, needs, waived)
        if reason is not None:
            return reason
    return None


def judging(check: Check, name: str, engine: type[Engine], waived: Set[str] = frozenset()) -> tuple[Variant, ...]:
    """The variants of a check that judge an engine: those whose needs, and the check's own, it declares.

    name: of the engine. engine: its class. waived: promises that are not asked for.
    """
    if unmatched(check, name, engine, waived) is not None:
        return ()
    return tuple(
        variant
        for variant in check.offered(engine.schemes)
        if variant.needs is None or lacks(engine, variant.needs, waived) is None
    )


def find(name: str) -> Check:
    """The check of this name. name: of a check, or of a case. UsageError, with similar names, if there is none."""
    import difflib

    checks = {check.name: check for check in all_checks()}
    parts = name.split("/")
    for length in range(len(parts), 0, -1):  # the name of a variant, which follows that of the check, may have slashes
        candidate = "/".join(parts[:length])
        if candidate in checks:
            return checks[candidate]
    near = difflib.get_close_matches(name, checks, 3, 0.3)
    raise UsageError(f"unknown check '{name}'; near: {', '.join(near) or 'none'}; see `crosscheck list`")


_local = threading.local()
_pools: list[Pool] = []


def _pool(overlay: Path | None, time_limit: float, deadline: float) -> Pool:
    """This thread's (or process's) pool of workers."""
    if not hasattr(_local, "pool") or _local.overlay != overlay:
        if hasattr(_local, "pool"):
            _local.pool.close()
        _local.pool, _local.overlay = Pool(overlay, time_limit), overlay
        _pools.append(_local.pool)
    pool: Pool = _local.pool
    pool.time_limit, pool.deadline = time_limit, deadline
    return pool


def lines_of_workers() -> Executed:
    """The lines that this thread's workers executed since the last call, see `workers.recording`."""
    return _local.pool.lines() if hasattr(_local, "pool") else {}


def close_pools() -> None:
    """Ends the workers of all threads of this process."""
    while _pools:
        _pools.pop().close()
    _local.__dict__.clear()


def judge(
    case: Case,
    seed: int,
    overlay: Path | None = None,
    time_limit: float = TIME_LIMIT,
    repeat: bool = True,
    deadline: float = math.inf,
) -> Verdict:
    """The verdict of one case.

    A case in which statistical judgements alone are red runs again with other random numbers: see `verdict.again`.
    Exceptions become verdicts: "skip" if the engine is missing or cannot run a scene, "fail" if it promised what the
    check asks for and refuses its scene, or ended a run early that the check needs whole, else "error".

    case: what to run. seed: the suite's seed. overlay: a directory with a copy of `refimpl` with a planted fault; None:
    the installed one. time_limit: seconds that one run of an engine may take. repeat: what is suspicious runs again;
    else it is red. deadline: on the clock `time.monotonic`, when no engine may run any more: what is not judged by then
    is left out, a "skip", and what is suspicious and not repeated by then is "inconclusive".
    """
    check = find(case.check)
    pool = _pool(overlay, time_limit, deadline)
    schemes = engine_class(case.engine).schemes
    laboratory = Laboratory(case.engine, schemes, pool, case.name, seed, interpreted=check.interpreted)
    repeated = replace(laboratory, case=f"{case.name}/again", refused=[])  # the same sum of costs
    started = time.perf_counter()
    found, message, tier = None, "", "quick"
    variant: Variant | None = None
    try:
        variant = next((one for one in check.offered(schemes) if one.name == case.variant), None)
        if variant is None:
            raise UsageError(f"check {check.name} has no variant '{case.variant}' for {case.engine}")
        tier = variant.tier
        found = findings(check.judge(laboratory, variant.value))
        if repeat and suspicious(found):
            first, found = found, unrepeated(found)  # which stays, if there is no time for the second run
            found = again(first, findings(check.judge(repeated, variant.value)))
        outcome = found.outcome
    except EngineMissing as reason:
        outcome, message = "skip", str(reason)
    except Unsupported as refusal:
        outcome, message = "skip", str(refusal)
        promises = _promises(check, variant, engine_class(case.engine))
        if promises:
            why = f"it promises {promises}, in all scenes of the words that it declares"
            found = findings(bounded("scenes that it refuses", 1.0, 0.0, why, note=message))
            outcome, message = found.outcome, ""
    except EndedEarly as reason:
        why = "what a part of a run shows says nothing of the whole"
        found = findings(bounded("runs that ended before their time", 1.0, 0.0, why, note=str(reason)))
        outcome = found.outcome
    except EngineError as error:
        outcome, message = "error", str(error)
        if time.monotonic() >= deadline:
            outcome, message = "skip", f"{LEFT_OUT}: not finished after {time.perf_counter() - started:.2g} s"
            if found is not None:
                outcome, message = found.outcome, ""
    except Exception as error:
        outcome, message = "error", f"the check failed: {type(error).__name__}: {error}"
    if outcome in ("skip", "error"):
        found = None  # of a second run; what the first one found is not a verdict
    cost = {"seconds": time.perf_counter() - started, **laboratory.cost.known()}
    refused = len(laboratory.refused)
    return Verdict(check.name, case.variant, case.engine, outcome, found, message, cost, tier, refused)


def _promises(check: Check, variant: Variant | None, engine: type[Engine]) -> str:
    """What the check and the variant ask the engine to promise, and it does, in one text."""
    asked = [*check.all_needs, *([variant.needs] if variant is not None and variant.needs is not None else [])]
    given = getattr(engine, "promises", ())
    return ", ".join(dict.fromkeys(promise for needs in asked for promise in needs.promises if promise in given))


def _group(case: Case) -> str:
    return case.check.partition("/")[0]


class _CasesOfThreads:
    """Cases divided among threads: each has a contiguous part, and afterwards takes from the end of the longest part.

    Neighbouring cases need the same compiled kernels. Threads that took them in turn would wait for each other's
    compilations; so a part begins with a group of checks, or else with a check, where one begins nearby. Groups differ
    in the engines and kernels that they need, of which each thread starts and loads its own.
    """

    def __init__(self, cases: list[Case], threads: int) -> None:
        starts = [i for i in range(1, len(cases)) if cases[i].check != cases[i - 1].check]
        groups = [i for i in starts if _group(cases[i]) != _group(cases[i - 1])]
        edges = [len(cases) * k // threads for k in range(threads + 1)]
        reach = len(cases) // (4 * threads)
        for k in range(1, threads):
            near = [start for start in groups if abs(start - edges[k]) <= 2 * reach]
            near = near or [start for start in starts if abs(start - edges[k]) <= reach]
            edges[k] = min(near, key=lambda start: abs(start - edges[k]), default=edges[k])
        self._parts = [deque(cases[start:end]) for start, end in pairwise(edges)]
        self._part_of_thread: dict[int, deque[Case]] = {}
        self._lock = threading.Lock()

    def take(self) -> Case:
        """The next case of the calling thread."""
        with self._lock:
            next_part = self._parts[len(self._part_of_thread) % len(self._parts)]
            mine = self._part_of_thread.setdefault(threading.get_ident(), next_part)
            return mine.popleft() if mine else max(self._parts, key=len).pop()


class Budget(Protocol):
    """What says which cases of a run there is time for: see `crosscheck.budget.plan.Budget`. Threads share it."""

    def left_out(self, case: Case) -> Verdict | None:
        """None, or the verdict of a case whose turn has come, and which there is no time for. case: that one."""

    def limit(self, case: Case) -> float:
        """On the clock `time.monotonic`, when a case has to end that starts now; case: that one."""

    def finished(self, case: Case, verdict: Verdict) -> Verdict:
        """Takes note of what a case took; its verdict, with what was predicted. case, verdict: that one, and its."""


def run(
    cases: list[Case],
    seed: int,
    jobs: int,
    on_start: Callable[[Case], None] = lambda case: None,
    executor: Executor | None = None,
    time_limit: float = TIME_LIMIT,
    budget: Budget | None = None,
) -> Iterator[Verdict]:
    """Yields verdicts as they are finished: parallel cases first, then those with `timing`, one after the other.

    cases: what to run. seed: the suite's seed. jobs: number of threads, each with its own worker processes. on_start:
    called on the thread of a case when it starts. executor: any `concurrent.futures.Executor`, used in place of the
    threads; on_start is then not called. time_limit: seconds that one run of an engine may take. budget: the cases are
    taken in their order, as long as there is time, by threads of this process; None: all are.
    """

    def work(case: Case) -> Verdict:
        if budget is None:
            on_start(case)
            return judge(case, seed, time_limit=time_limit)
        left_out = budget.left_out(case)
        if left_out is not None:
            return left_out
        on_start(case)
        return budget.finished(case, judge(case, seed, time_limit=time_limit, deadline=budget.limit(case)))

    own = executor is None
    pool = executor or ThreadPoolExecutor(jobs)
    futures: list[Future[Verdict]] = []
    try:
        parallel = [case for case in cases if not case.timing]
        shares = _CasesOfThreads(parallel, jobs if budget is None else 1)
        futures = [
            pool.submit(lambda: work(shares.take())) if own else pool.submit(judge, c, seed, None, time_limit)
            for c in parallel
        ]
        for future in as_completed(futures):
            yield future.result()
        for case in cases:
            if case.timing:
                alone = pool.submit(work, case) if own else pool.submit(judge, case, seed, None, time_limit)
                yield alone.result()
    finally:
        for future in futures:
            future.cancel()
        if own:
            pool.shutdown(wait=True, cancel_futures=True)
            close_pools()
