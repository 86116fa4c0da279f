"""Counts what the cases consist of, with the engines that come with the suite: see `loads`."""

from __future__ import annotations

import math
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import numpy as np

from crosscheck.budget.loads import CaseLoad, Load, as_case, as_line, rounded_size
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.engines.capabilities import measured_by, scheme_of
from crosscheck.engines.protocol import Kind, Run
from crosscheck.engines.registry import engine_class, shipped_engines
from crosscheck.engines.soft_spheres import resolved
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import EndedEarly, EngineMissing, Unsupported
from crosscheck.runner import judging
from crosscheck.scene import Method, Observable, Output, Scene

#: Changes of state of hard spheres, which event-driven runs are asked for beside what the check asks for.
_CHANGES: tuple[Observable, ...] = ("collisions", "wall_collisions")


@dataclass
class _Tally:
    """What the runs of one interaction, kind and size add up to."""

    schemes: set[str] = field(default_factory=set)
    runs: int = 0
    units: float = 0.0


class _UnderJudgement(str):
    """The name of the engine under judgement: told from that of the same engine where a check names it as another."""


@dataclass
class _CountingLaboratory(Laboratory):
    """A laboratory that notes what the engine under judgement is asked to do.

    own_seconds: that its runs have taken.
    """

    own_seconds: float = 0.0
    _tallies: defaultdict[tuple[str, str, int], _Tally] = field(default_factory=lambda: defaultdict(_Tally))

    def run(
        self,
        scene: Scene,
        method: Method | Kind,
        engine: str | None = None,
        *,
        may_end_early: bool = False,
        interpreted: bool | None = None,
    ) -> Run:
        """As `Laboratory.run`, whose arguments these are."""
        if engine is not None and not isinstance(engine, _UnderJudgement):
            return super().run(scene, method, engine, may_end_early=may_end_early, interpreted=interpreted)
        scheme, kind = self._scheme(scene, method)
        counted = self._counted(scene, scheme) if kind == "event_driven" else scene
        started = time.perf_counter()
        run = super().run(counted, method, engine, may_end_early=may_end_early, interpreted=interpreted)
        self.own_seconds += time.perf_counter() - started
        self._note(scene, method, scheme, kind, run)
        for name in counted.asked().keys() - scene.asked().keys():
            del run[name]
        return run

    def run_in_two(self, scene: Scene, method: Method | Kind) -> tuple[Run, Run]:
        """As `Laboratory.run_in_two`, whose arguments these are."""
        started = time.perf_counter()
        runs = super().run_in_two(scene, method)
        self.own_seconds += time.perf_counter() - started
        scheme, kind = self._scheme(scene, method)
        for run in runs:
            self._note(scene.changed(duration=scene.duration / 2), method, scheme, kind, run)
        return runs

    def loads(self) -> tuple[Load, ...]:
        """What was noted, the larger sizes last."""
        return tuple(
            Load(interaction, kind, size, len(tally.schemes), tally.runs, math.ceil(tally.units))
            for (interaction, kind, size), tally in sorted(self._tallies.items())
        )

    def _scheme(self, scene: Scene, method: Method | Kind) -> tuple[str, str]:
        """The scheme that will run, and its kind."""
        if isinstance(method, Method):
            return method.scheme, self.claims[method.scheme].kind
        return scheme_of(engine_class(self.engine), scene.interaction, method) or "", method

    def _counted(self, scene: Scene, scheme: str) -> Scene:
        """The scene, asking for the changes of state too, as far as the scheme measures them."""
        output, able = scene.output, measured_by(engine_class(self.engine), scene.interaction, scheme)
        more = [name for name in _CHANGES if name in able and name not in output.observables]
        if not more or output.trace or scene.duration == 0:
            return scene
        interval = output.interval
        if interval is None and output.collisions is None:
            interval = scene.duration
        changes = {"observables": (*output.observables, *more), "interval": interval}
        return scene.changed(output=Output(**(dict(output) | changes)))

    def _note(self, scene: Scene, method: Method | Kind, scheme: str, kind: str, run: Run) -> None:
        gas = scene.lattice_gas
        size = scene.number if gas is None else gas.rows * gas.columns
        tally = self._tallies[scene.interaction, kind, rounded_size(size)]
        tally.schemes.add(scheme)
        tally.runs += 1
        if kind == "event_driven":
            tally.units += _changes(run)
        elif gas is not None:
            tally.units += scene.duration * size
        else:
            assert isinstance(method, Method)
            dt = resolved(scene, method).dt
            tally.units += 1 + (run.cost.steps if dt is None else scene.steps(dt))  # the forces at the start


def _changes(run: Run) -> float:
    """Collisions of pairs and with walls; all events, where the run did not tell them apart."""
    if "event_times" in run:
        return float(len(run["event_times"]))
    if not all(name in run for name in _CHANGES):
        return float(run.cost.events)
    return float(sum(np.nansum(np.atleast_1d(_last(run[name]))) for name in _CHANGES))


def _last(series: np.ndarray) -> np.ndarray:
    """The last sample that there is, of a run that may have ended early."""
    there = ~np.isnan(series.reshape(len(series), -1)).any(axis=1)
    return np.asarray(series[np.flatnonzero(there)[-1]] if there.any() else 0.0)


class _Counted(NamedTuple):
    """A case, and the engine that it is counted with."""

    check: Check
    variant: Variant
    engine: str

    @property
    def name(self) -> str:
        return f"{self.check.name}/{self.variant.name}"


def cases(patterns: Sequence[str] = ()) -> list[_Counted]:
    """Each case that a shipped engine is judged by, with the first of these engines; patterns: of names; none: all."""
    found: dict[str, _Counted] = {}
    for check in all_checks():
        for engine in shipped_engines():
            for variant in judging(check, engine, engine_class(engine)):
                one = _Counted(check, variant, engine)
                if not patterns or any(fnmatchcase(one.name, p) or fnmatchcase(check.name, p) for p in patterns):
                    found.setdefault(one.name, one)
    return list(found.values())


def counted(case: _Counted, pool: Pool, seed: int = 0) -> CaseLoad | None:
    """What a case consists of, by running it; None if its engine is not on this machine.

    pool: of the workers. seed: of the suite.
    """
    claims = engine_class(case.engine).schemes
    name = _UnderJudgement(case.engine)
    laboratory = _CountingLaboratory(name, claims, pool, case.name, seed, interpreted=case.check.interpreted)
    started = time.perf_counter()
    try:
        case.check.judge(laboratory, case.variant.value)
    except EngineMissing:
        return None
    except (EndedEarly, Unsupported):
        pass
    elsewhere = max(time.perf_counter() - started - laboratory.own_seconds, 1e-3)
    return CaseLoad(case.engine, laboratory.loads(), float(f"{elsewhere:.1g}"))


def count(path: Path, patterns: Sequence[str]) -> Iterator[str]:
    """Counts cases, and writes them into the file; yields a line for each as it is done.

    path: of the file; cases that are not counted now stay as they are, those that do not exist any more go. patterns:
    of names of cases or checks; none: all.
    """
    known = dict(as_case(line) for line in path.read_text(encoding="utf-8").splitlines()) if path.exists() else {}
    names = {case.name for case in cases()}
    known = {name: load for name, load in known.items() if name in names}
    pool = Pool()
    try:
        for case in cases(patterns):
            load = counted(case, pool)
            if load is None:
                yield f"{case.name}: {case.engine} is missing"
                continue
            before = known.get(case.name)
            if before is not None and before.loads == load.loads:  # what depends on the machine stays
                load = load._replace(elsewhere=before.elsewhere)
            known[case.name] = load
            lines = [as_line(name, load) for name, load in sorted(known.items())]
            path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8", newline="\n")
            yield lines[sorted(known).index(case.name)]
    finally:
        pool.close()
