"""Runs checks on any `concurrent.futures` executor; those that time something run alone, after the others."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from itertools import pairwise
from pathlib import Path

from crosscheck.checks import all_checks
from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.engines.capabilities import lacks
from crosscheck.engines.protocol import Engine
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import TIME_LIMIT, Pool
from crosscheck.errors import EngineError, EngineMissing, Unsupported, UsageError
from crosscheck.verdict import Verdict, findings


@dataclass(frozen=True)
class Case:
    """One variant of one check on one engine: the unit of work, of the record and of what a crash costs."""

    check: str
    variant: str
    engine: str
    timing: bool

    @property
    def name(self) -> str:
        return f"{self.check}/{self.variant}"


def select(patterns: list[str], tier: str, engines: list[str]) -> list[Case]:
    """The cases whose name, or whose check's name, matches a shell pattern, on the engines given.

    An engine gets the checks whose needs it declares. The full tier contains the quick one. UsageError if nothing
    matches.
    """
    cases: list[Case] = []
    for check in all_checks():
        for name in dict.fromkeys(engines):
            engine = engine_class(name)
            for variant in judging(check, name, engine):
                case = Case(check.name, variant.name, name, check.timing)
                named = any(fnmatchcase(case.name, p) or fnmatchcase(check.name, p) for p in patterns)
                if (not patterns or named) and (tier == "full" or variant.tier == "quick"):
                    cases.append(case)
    if not cases:
        raise UsageError(
            f"no check of tier '{tier}' on {', '.join(engines)} matches {' '.join(patterns) or '*'}; "
            "see `crosscheck list`"
        )
    return cases


def unmatched(check: Check, name: str, engine: type[Engine]) -> str | None:
    """None if the check judges this engine; else what the engine lacks, or that the check compares with it."""
    if name in (check.reference if isinstance(check.reference, tuple) else (check.reference,)):
        return "it is what the check compares with"
    for needs in check.needs if isinstance(check.needs, tuple) else (check.needs,):
        reason = lacks(engine, needs)
        if reason is not None:
            return reason
    return None


def judging(check: Check, name: str, engine: type[Engine]) -> tuple[Variant, ...]:
    """The variants of a check that judge this engine: those whose needs, and the check's own, it declares."""
    if unmatched(check, name, engine) is not None:
        return ()
    return tuple(
        variant
        for variant in check.offered(engine.schemes)
        if variant.needs is None or lacks(engine, variant.needs) is None
    )


def find(name: str) -> Check:
    """The check of this name; UsageError with the near ones otherwise."""
    import difflib

    checks = {check.name: check for check in all_checks()}
    parts = name.split("/")
    for length in range(len(parts), 0, -1):  # the name of a case will do: a variant may have slashes too
        candidate = "/".join(parts[:length])
        if candidate in checks:
            return checks[candidate]
    near = difflib.get_close_matches(name, checks, 3, 0.3)
    raise UsageError(f"unknown check '{name}'; near: {', '.join(near) or 'none'}; see `crosscheck list`")


_local = threading.local()
_pools: list[Pool] = []


def _pool(overlay: Path | None, time_limit: float) -> Pool:
    """This thread's (or process's) pool of workers."""
    key = (overlay, time_limit)
    if getattr(_local, "key", None) != key:
        if hasattr(_local, "pool"):
            _local.pool.close()
        _local.pool, _local.key = Pool(overlay, time_limit), key
        _pools.append(_local.pool)
    pool: Pool = _local.pool
    return pool


def close_pools() -> None:
    """Ends the workers of all threads of this process."""
    while _pools:
        _pools.pop().close()
    _local.__dict__.clear()


def judge(case: Case, seed: int, overlay: Path | None = None, time_limit: float = TIME_LIMIT) -> Verdict:
    """The verdict of one case; whatever goes wrong becomes a verdict too."""
    check = find(case.check)
    pool = _pool(overlay, time_limit)
    schemes = engine_class(case.engine).schemes
    laboratory = Laboratory(case.engine, schemes, pool, case.name, seed)
    started = time.perf_counter()
    found, message, tier = None, "", "quick"
    try:
        variant = next((one for one in check.offered(schemes) if one.name == case.variant), None)
        if variant is None:
            raise UsageError(f"check {check.name} has no variant '{case.variant}' for {case.engine}")
        tier = variant.tier
        found = findings(check.judge(laboratory, variant.value))
        outcome = found.outcome
    except (EngineMissing, Unsupported) as reason:
        outcome, message = "skip", str(reason)
    except EngineError as error:
        outcome, message = "error", str(error)
    except Exception as error:
        outcome, message = "error", f"the check failed: {type(error).__name__}: {error}"
    cost = {"seconds": time.perf_counter() - started, **asdict(laboratory.cost)}
    return Verdict(check.name, case.variant, case.engine, outcome, found, message, cost, tier)


class _Shares:
    """Cases for several threads: each has a stretch of its own, and then takes from the end of the longest.

    Neighbours want the same kernels: one thread after another's heels would wait for what that one compiles.
    """

    def __init__(self, cases: list[Case], threads: int) -> None:
        edges = [len(cases) * k // threads for k in range(threads + 1)]
        self._shares = [deque(cases[start:end]) for start, end in pairwise(edges)]
        self._of: dict[int, deque[Case]] = {}
        self._lock = threading.Lock()

    def take(self) -> Case:
        with self._lock:
            mine = self._of.setdefault(threading.get_ident(), self._shares[len(self._of) % len(self._shares)])
            return mine.popleft() if mine else max(self._shares, key=len).pop()


def run(
    cases: list[Case],
    seed: int,
    jobs: int,
    on_start: Callable[[Case], None] = lambda case: None,
    executor: Executor | None = None,
) -> Iterator[Verdict]:
    """Yields verdicts as they come: parallel cases first, then those that time something, one after the other.

    executor: any `concurrent.futures.Executor`; by default `jobs` threads, whose work is done in worker processes.
    """

    def work(case: Case) -> Verdict:
        on_start(case)
        return judge(case, seed)

    own = executor is None
    pool = executor or ThreadPoolExecutor(jobs)
    futures: list[Future[Verdict]] = []
    try:
        parallel = [case for case in cases if not case.timing]
        shares = _Shares(parallel, jobs)
        futures = [pool.submit(lambda: work(shares.take())) if own else pool.submit(judge, c, seed) for c in parallel]
        for future in as_completed(futures):
            yield future.result()
        for case in cases:
            if case.timing:
                yield pool.submit(work, case).result() if own else pool.submit(judge, case, seed).result()
    finally:
        for future in futures:
            future.cancel()
        if own:
            pool.shutdown(wait=True, cancel_futures=True)
            close_pools()
