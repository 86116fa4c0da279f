"""Which cases are chosen, how they are run, and that whatever goes wrong costs one verdict."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from crosscheck.checks.base import Check, Laboratory, Variant, full, quick, schemes_with, small
from crosscheck.engines.capabilities import Needs, capability
from crosscheck.engines.protocol import Claims, Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import EndedEarly, EngineError, EngineMissing, Unsupported, UsageError
from crosscheck.runner import Case, _CasesOfThreads, close_pools, find, judge, run, select, unmatched
from crosscheck.scene import Explicit, Method, Scene, Spring
from crosscheck.verdict import LEFT_OUT, Judgement, Verdict, round_off, statistical

SCENE = Scene(name="spring", dimension=1, duration=0.1, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))

#: An engine that ends its own process on its second run.
MORTAL = """
import os, signal
import numpy as np
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run, sample_times

class Engine:
    name = "mortal"
    schemes = {"good": Claims((1, 1))}
    capabilities = (capability("spring", "stepping", words="dimension=1", observables=""),)
    runs = 0

    def version(self):
        return "1"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        Engine.runs += 1
        if Engine.runs == 2:
            os.kill(os.getpid(), signal.SIGKILL)
        state = scene.initial_state()
        return Run(time=sample_times(scene, method), final_positions=state.positions, final_velocities=state.velocities)
"""


def passed(laboratory: Laboratory, variant: str) -> Judgement:
    return round_off("nothing", 0.0, 1.0, "because")


def check(name: str, judge: Any = passed, **changes: Any) -> Check:
    options = {"variants": quick("one"), "faults": (), "needs": Needs("spring")} | changes
    return Check(name, "title", "equation", "criterion", "citation", judge, **options)


@pytest.fixture(autouse=True)
def no_workers_left() -> Iterator[None]:
    yield
    close_pools()


def offer(monkeypatch: pytest.MonkeyPatch, *checks: Check) -> None:
    monkeypatch.setattr("crosscheck.runner.all_checks", lambda: checks)


def names(cases: list[Case]) -> list[str]:
    return [case.name for case in cases]


# -- which cases -------------------------------------------------------------------------------------


@pytest.fixture
def three(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(
        monkeypatch,
        check("a/quick", variants=quick("one", "two")),
        check("a/slow", variants=full("one")),
        check(
            "b/schemes",
            variants=schemes_with(lambda name, claims: claims.symplectic is True),
            needs=Needs("hard_spheres", ("collision_search",)),
        ),
    )


@pytest.mark.usefixtures("three")
@pytest.mark.parametrize(
    ("patterns", "tier", "found"),
    [
        ([], "quick", ["a/quick/one", "a/quick/two"]),
        ([], "full", ["a/quick/one", "a/quick/two", "a/slow/one"]),
        (["a/quick"], "quick", ["a/quick/one", "a/quick/two"]),
        (["a/quick/two"], "quick", ["a/quick/two"]),
        (["*/one"], "full", ["a/quick/one", "a/slow/one"]),
        (["a/s*", "*two"], "full", ["a/quick/two", "a/slow/one"]),
    ],
)
def test_patterns_and_tiers(patterns: list[str], tier: str, found: list[str]) -> None:
    assert names(select(patterns, tier, ["refimpl"])) == found


@pytest.mark.usefixtures("three")
def test_engines_get_the_checks_whose_needs_they_declare(tmp_path: Path) -> None:
    """Own and foreign ones alike: by what they declare, not by their names."""
    cases = select([], "quick", ["refimpl", "rebound"])
    assert {(case.check, case.engine) for case in cases} == {("a/quick", "refimpl"), ("b/schemes", "rebound")}
    file = tmp_path / "engine.py"
    file.write_text(MORTAL)
    assert names(select([], "full", [f"{file}:Engine"])) == ["a/quick/one", "a/quick/two", "a/slow/one"]


@pytest.mark.parametrize(
    ("needs", "reason"),
    [
        (Needs("spring"), None),
        (Needs("spring", observables=frozenset({"virial"})), None),
        (Needs("spring", words=frozenset({"spring.gamma", "box"})), "no box"),
        (Needs("spring", schemes=("velocity_verlet", "magic")), "no scheme magic"),
        (Needs("spring", ("lattice",)), "no lattice scheme for [spring]"),
        (Needs("spring", promises=("speed", "beauty")), "does not promise beauty"),
        ((Needs("spring"), Needs("lattice_gas", ("lattice",))), None),
        ((Needs("spring"), Needs("lattice_gas")), "no stepping scheme for [lattice_gas]"),
    ],
)
def test_what_an_engine_lacks_is_said(needs: Any, reason: str | None) -> None:
    assert unmatched(check("a/b", needs=needs), "refimpl", engine_class("refimpl")) == reason


def test_a_check_does_not_judge_what_it_compares_with() -> None:
    assert unmatched(check("a/b", reference="lammps"), "lammps", engine_class("lammps")) is not None
    assert unmatched(check("a/b", reference="lammps"), "refimpl", engine_class("refimpl")) is None


@pytest.mark.usefixtures("three")
def test_an_engine_that_is_named_twice_is_judged_once() -> None:
    assert len(select(["a/quick/one"], "quick", ["refimpl", "refimpl"])) == 1


@pytest.mark.usefixtures("three")
def test_no_match_says_what_was_looked_for() -> None:
    with pytest.raises(UsageError, match=r"no case of tier 'quick' matches a/slow: add --tier full"):
        select(["a/quick*", "a/slow"], "quick", ["refimpl"])
    with pytest.raises(UsageError, match=r"no check matches c\*; see `crosscheck list`"):
        select(["a/quick*", "c*"], "full", ["refimpl"])


@pytest.mark.usefixtures("three")
def test_an_engine_that_declares_too_little_has_no_cases() -> None:
    """The pattern is no mistake: refimpl has such cases."""
    assert select(["a/quick*"], "quick", ["rebound"]) == []


@pytest.mark.usefixtures("three")
def test_an_unknown_engine_is_named_with_those_there_are() -> None:
    with pytest.raises(UsageError, match=r"unknown engine 'refimp'; known: refimpl"):
        select([], "quick", ["refimp"])


@pytest.mark.usefixtures("three")
@pytest.mark.parametrize("name", ["a/quick", "a/quick/two", "a/quick/two/e0.5"])
def test_find(name: str) -> None:
    assert find(name).name == "a/quick"


@pytest.mark.usefixtures("three")
def test_an_unknown_check_is_named_with_the_near_ones() -> None:
    with pytest.raises(UsageError, match=r"unknown check 'a/quikc'; near: a/quick"):
        find("a/quikc")


def test_small_variants_are_for_slow_codes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measured speeds take the place of the promise of speed, and the small tier joins the others."""
    promising = Needs("gravity", promises=("long_runs",))
    variants = (*quick("one"), *full("two"), small("few", "few", "one"))
    offer(monkeypatch, check("a/b", variants=variants, needs=promising), check("a/c", needs=Needs("gravity")))
    assert names(select([], "quick", ["refimpl"])) == ["a/b/one", "a/c/one"]
    assert names(select([], "quick", ["refimpl"], budget=True)) == ["a/b/one", "a/b/few", "a/c/one"]
    assert names(select([], "full", ["refimpl"], budget=True)) == ["a/b/one", "a/b/two", "a/b/few", "a/c/one"]
    assert names(select([], "full", ["refimpl"])) == ["a/b/one", "a/b/two", "a/c/one"]
    (few,) = select([], "small", ["refimpl"])
    assert (few.name, few.instead) == ("a/b/few", "one")
    with pytest.raises(UsageError, match="no case of tier 'quick' matches a/b/few: add --tier small"):
        select(["a/b/few"], "quick", ["refimpl"])
    monkeypatch.setattr("crosscheck.runner.engine_class", lambda name: Slow)
    assert names(select([], "quick", ["slow"])) == ["a/c/one"]
    assert names(select([], "quick", ["slow"], budget=True)) == ["a/b/one", "a/b/few", "a/c/one"]


class Slow:
    """It has no promises."""

    schemes = {"leapfrog": Claims((2, 2))}
    capabilities = (capability("gravity", "stepping", words="", observables=""),)


# -- one case ---------------------------------------------------------------------------------------


def raises(error: Exception) -> Any:
    def judge(laboratory: Laboratory, variant: str) -> Judgement:
        raise error

    return judge


@pytest.mark.parametrize(
    ("how", "outcome", "message"),
    [
        (passed, "pass", ""),
        (raises(EngineMissing("lammps: not here")), "skip", "lammps: not here"),
        (raises(Unsupported("refimpl: too hard")), "skip", "refimpl: too hard"),
        (raises(EngineError("refimpl was killed\nlast lines")), "error", "refimpl was killed\nlast lines"),
        (raises(ValueError("two and two")), "error", "the check failed: ValueError: two and two"),
        (raises(UsageError("a bad step")), "error", "the check failed: UsageError: a bad step"),
        (raises(KeyError("x")), "error", "the check failed: KeyError: 'x'"),
    ],
)
def test_whatever_goes_wrong_is_a_verdict(
    monkeypatch: pytest.MonkeyPatch, how: Any, outcome: str, message: str
) -> None:
    offer(monkeypatch, check("a/b", how))
    verdict = judge(Case("a/b", "one", "refimpl", False), seed=0)
    assert (verdict.name, verdict.check, verdict.variant, verdict.engine) == ("a/b/one", "a/b", "one", "refimpl")
    assert (verdict.outcome, verdict.message) == (outcome, message)
    assert (verdict.findings is None) == (outcome != "pass")
    assert verdict.cost["seconds"] >= 0


@pytest.mark.parametrize("by_variant", [False, True])
def test_what_is_promised_and_refused_is_red(monkeypatch: pytest.MonkeyPatch, by_variant: bool) -> None:
    promised, plain = Needs("spring", promises=("restarts",)), Needs("spring")
    variants = (Variant("one", None, needs=promised if by_variant else None),)
    how = raises(Unsupported("refimpl: too hard"))
    offer(monkeypatch, check("a/b", how, variants=variants, needs=plain if by_variant else promised))
    verdict = judge(Case("a/b", "one", "refimpl", False), 0)
    assert verdict.outcome == "fail"
    assert verdict.findings is not None
    assert verdict.findings.note == "refimpl: too hard"
    assert "promises restarts" in verdict.findings.shown.criterion.why


def test_a_waived_promise_is_no_promise(monkeypatch: pytest.MonkeyPatch) -> None:
    """An engine that is judged within a budget has not promised to be fast, and may refuse."""
    offer(monkeypatch, check("a/b", raises(Unsupported("slow: no")), needs=Needs("gravity", promises=("long_runs",))))
    monkeypatch.setattr("crosscheck.runner.engine_class", lambda name: Slow)
    assert judge(Case("a/b", "one", "slow", False), 0).outcome == "skip"


HANGING = """
import signal
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims

class Engine:
    name = "hanging"
    schemes = {"good": Claims((1, 1))}
    capabilities = (capability("spring", "stepping", words="dimension=1", observables=""),)

    def version(self):
        return "1"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        signal.pause()
"""


def test_a_case_that_is_not_finished_in_time_is_left_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The limit of the budget is no fault of the engine; that of a call is."""
    file = tmp_path / "engine.py"
    file.write_text(HANGING)
    offer(monkeypatch, check("a/b", lambda laboratory, variant: laboratory.run(SCENE, Method(scheme="good", dt=0.1))))
    case = Case("a/b", "one", f"{file}:Engine", False)
    late = judge(case, 0, deadline=time.monotonic() + 1.0)
    assert late.outcome == "skip"
    assert late.message.startswith(f"{LEFT_OUT}: not finished after ")
    hung = judge(case, 0, time_limit=0.5, deadline=time.monotonic() + 1000)
    assert hung.outcome == "error"
    assert "gave no answer within 0.5 s" in hung.message
    over = judge(case, 0, deadline=time.monotonic() - 1)
    assert over.outcome == "skip"


def test_a_suspicion_without_time_for_a_second_run_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("crosscheck.runner.time.monotonic", lambda: now[0])

    def once(laboratory: Laboratory, variant: str) -> Judgement:
        if laboratory.case.endswith("again"):
            now[0] = 10.0
            raise EngineError("the time is over")
        return statistical("x", 5.0, 1.0, 0.0, 0.0, "why", samples=1e6)

    offer(monkeypatch, check("a/b", once))
    verdict = judge(Case("a/b", "one", "refimpl", False), 0, deadline=9.0)
    assert (verdict.outcome, verdict.message) == ("inconclusive", "")
    now[0] = 0.0
    broken = judge(Case("a/b", "one", "refimpl", False), 0, deadline=11.0)
    assert (broken.outcome, broken.findings) == ("error", None), "an error of the second run is one of the case"


def test_a_case_knows_its_variant_its_claims_and_its_seeds(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []

    def look(laboratory: Laboratory, variant: str) -> Judgement:
        seen.append((variant, laboratory.seed(), laboratory.seed("other"), sorted(laboratory.claims)[0]))
        return passed(laboratory, variant)

    offer(monkeypatch, check("a/b", look, variants=quick("one", two=2)))
    for seed, variant in ((0, "one"), (0, "one"), (1, "one"), (0, "two")):
        judge(Case("a/b", variant, "refimpl", False), seed)
    assert seen[0] == seen[1]
    assert [entry[0] for entry in seen] == ["one", "one", "one", 2]
    assert len({number for entry in seen for number in entry[1:3]}) == 6
    assert seen[0][3] == "beeman"


def test_a_variant_that_an_engine_has_not_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(monkeypatch, check("a/b"))
    verdict = judge(Case("a/b", "two", "refimpl", False), 0)
    assert verdict.outcome == "error"
    assert "check a/b has no variant 'two' for refimpl" in verdict.message


def test_costs_of_all_runs_add_up(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "engine.py"
    text = MORTAL.replace("Engine.runs == 2", "False").replace("import Claims, Run", "import Claims, Cost, Run")
    file.write_text(
        text.replace(
            "final_velocities=state.velocities)",
            "final_velocities=state.velocities, cost=Cost(1, 1, 1, 3, 4, 5 * Engine.runs))",
        )
    )

    def twice(laboratory: Laboratory, variant: str) -> Judgement:
        laboratory.run(SCENE, Method(scheme="good", dt=0.1))
        laboratory.run(SCENE, Method(scheme="good", dt=0.1))
        return passed(laboratory, variant)

    offer(monkeypatch, check("a/b", twice))
    cost = judge(Case("a/b", "one", f"{file}:Engine", False), seed=0).cost
    assert (cost["wall"], cost["steps"], cost["evaluations"]) == (2, 6, 8)
    assert cost["peak_bytes"] == 10  # the largest, not the sum


# -- many cases --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sigmas", "outcome", "runs"), [((1.0,), "pass", 1), ((5.0, 1.0), "pass", 2), ((5.0, -4.0), "fail", 2)]
)
def test_what_is_suspicious_runs_again_with_other_seeds(
    monkeypatch: pytest.MonkeyPatch, sigmas: tuple[float, ...], outcome: str, runs: int
) -> None:
    """Its costs add up."""
    seeds = []

    def judge_one(laboratory: Laboratory, variant: str) -> Judgement:
        laboratory.cost.steps += 7
        seeds.append(laboratory.seed())
        return statistical("x", sigmas[len(seeds) - 1], 1.0, 0.0, 0.0, "why", samples=1e6)

    offer(monkeypatch, check("a/b", judge_one))
    verdict = judge(Case("a/b", "one", "refimpl", False), 0)
    assert verdict.outcome == outcome
    assert len(set(seeds)) == len(seeds) == runs
    assert verdict.cost["steps"] == 7 * runs


def test_every_case_gets_one_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(monkeypatch, check("a/b", variants=quick(*"abcdef")), check("a/c", raises(EngineError("broken"))))
    cases, started = select([], "quick", ["refimpl"]), []
    verdicts = list(run(cases, seed=0, jobs=3, on_start=started.append))
    assert sorted(verdict.name for verdict in verdicts) == names(cases)
    assert sorted(started, key=lambda case: case.name) == cases
    assert [verdict.outcome for verdict in verdicts].count("error") == 1


@pytest.mark.parametrize("own", [True, False])
def test_timing_runs_after_the_others_and_alone(monkeypatch: pytest.MonkeyPatch, own: bool) -> None:
    log: list[tuple[str, str]] = []

    def busy(laboratory: Laboratory, variant: str) -> Judgement:
        log.append(("start", laboratory.case))
        total = sum(range(20_000))
        log.append(("end", laboratory.case))
        assert total
        return passed(laboratory, variant)

    offer(
        monkeypatch,
        check("a/timing", busy, timing=True, variants=quick(*"xyz")),
        check("b/other", busy, variants=quick(*"abcdef")),
    )
    cases = select([], "quick", ["refimpl"])
    with ThreadPoolExecutor(4) as executor:
        verdicts = list(run(cases, 0, 4, executor=None if own else executor))
    assert {verdict.outcome for verdict in verdicts} == {"pass"}
    assert [verdict.name for verdict in verdicts][6:] == [f"a/timing/{name}" for name in "xyz"]
    assert log[12:] == [(what, f"a/timing/{name}") for name in "xyz" for what in ("start", "end")]


def test_threads_start_far_apart_and_share_what_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two that work on one stretch would wait for each other's kernels; one that has done its own helps."""
    begun, others = threading.Barrier(2), threading.Event()
    done: dict[str, list[str]] = {}

    def busy(laboratory: Laboratory, variant: str) -> Judgement:
        mine = done.setdefault(threading.current_thread().name, [])
        mine.append(variant)
        if len(mine) == 1:  # after both first cases are in `done`, whose total says when all have started
            begun.wait(20)
        if variant == "a":  # holds its thread until the other one has done all the rest
            assert others.wait(20)
        elif sum(map(len, done.values())) == 8:
            others.set()
        return passed(laboratory, variant)

    offer(monkeypatch, check("a/b", busy, variants=quick(*"abcdefgh")))
    assert {verdict.outcome for verdict in run(select([], "quick", ["refimpl"]), 0, 2)} == {"pass"}
    assert sorted(done.values()) == [["a"], ["e", "f", "g", "h", "d", "c", "b"]]


def test_a_thread_begins_with_a_check_where_one_begins_nearby() -> None:
    """Two threads in one check would compile the same kernels at the same time, and one of them wait."""
    cases = [
        Case(name, variant, "refimpl", False)
        for name, variants in (("a/b", "abcde"), ("a/c", "xyz"))
        for variant in variants
    ]
    assert [len(part) for part in _CasesOfThreads(cases, 2)._parts] == [5, 3]
    # none begins near the middle
    assert [len(part) for part in _CasesOfThreads(cases[:5], 2)._parts] == [2, 3]


def test_a_thread_begins_with_a_group_where_one_begins_nearby() -> None:
    """Groups differ in engines, and each thread starts its own workers."""

    def begins(**sizes: int) -> list[str]:
        names = [name.replace("_", "/") for name, size in sizes.items() for _ in range(size)]
        parts = _CasesOfThreads([Case(name, "one", "refimpl", False) for name in names], 2)._parts
        return [part[0].check for part in parts]

    assert begins(a_b=4, a_c=2, d_e=6, d_f=4) == ["a/b", "d/e"]
    # too far from the middle: with a check
    assert begins(a_b=1, d_e=8, d_f=7) == ["a/b", "d/f"]


class _Times:
    """A budget with time for what it is told."""

    def __init__(self, *fits: str) -> None:
        self.fits, self.asked, self.done = fits, [], []  # type: ignore[var-annotated]

    def left_out(self, case: Case) -> Verdict | None:
        self.asked.append(case.variant)
        if case.variant in self.fits:
            return None
        return Verdict(case.check, case.variant, case.engine, "skip", None, LEFT_OUT)

    def limit(self, case: Case) -> float:
        return 1e9

    def finished(self, case: Case, verdict: Verdict) -> Verdict:
        self.done.append(case.variant)
        return replace(verdict, cost={"predicted": 7.0})


def test_a_budget_is_asked_in_the_order_of_the_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[str] = []
    offer(monkeypatch, check("a/b", variants=quick(*"abcd")), check("a/t", timing=True, variants=quick(*"xy")))
    cases = [*select([], "quick", ["refimpl"])][::-1]
    budget = _Times("d", "b", "y")
    verdicts = list(run(cases, 0, 1, lambda case: started.append(case.variant), budget=budget))
    assert budget.asked == ["d", "c", "b", "a", "y", "x"]
    assert started == budget.done == ["d", "b", "y"]
    assert {v.variant: v.outcome for v in verdicts} == dict(zip("dcbayx", ["pass", "skip"] * 3, strict=True))
    assert [v.cost for v in verdicts if v.outcome == "pass"] == [{"predicted": 7.0}] * 3


def test_an_executor_that_is_given_stays_open(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(monkeypatch, check("a/b"))
    with ThreadPoolExecutor(1) as executor:
        assert len(list(run(select([], "quick", ["refimpl"]), 0, 1, executor=executor))) == 1
        assert executor.submit(lambda: 7).result() == 7


def test_a_run_that_is_left_cancels_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    done = []
    offer(
        monkeypatch,
        check("a/b", lambda laboratory, variant: done.append(variant), variants=quick(*map(str, range(500)))),
    )
    verdicts = run(select([], "quick", ["refimpl"]), 0, 1)
    next(verdicts)
    verdicts.close()
    assert len(done) < 500


def test_a_worker_that_dies_costs_one_verdict(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "engine.py"
    file.write_text(MORTAL)

    def runs(laboratory: Laboratory, variant: str) -> Judgement:
        found = laboratory.run(SCENE, Method(scheme="good", dt=0.1))
        return round_off("position", float(found["final_positions"][0, 0]) - 1, 1.0, "because")

    offer(monkeypatch, check("a/b", runs, variants=quick("1", "2", "3")))
    # one job: the new process would die on its second run too
    verdicts: list[Verdict] = list(run(select([], "quick", [f"{file}:Engine"]), 0, 1))
    assert sorted(verdict.outcome for verdict in verdicts) == ["error", "pass", "pass"]
    (error,) = (verdict for verdict in verdicts if verdict.outcome == "error")
    assert "was killed by signal 9" in error.message


def test_workers_are_ended_with_the_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "engine.py"
    file.write_text(MORTAL.replace('return "1"', "return str(os.getpid())"))
    processes = []

    def ask(laboratory: Laboratory, variant: str) -> Judgement:
        processes.append(int(laboratory.pool.worker(laboratory.engine).version()))
        return passed(laboratory, variant)

    offer(monkeypatch, check("a/b", ask, variants=quick("1", "2", "3")))
    list(run(select([], "quick", [f"{file}:Engine"]), 0, 1))
    assert len(set(processes)) == 1  # one worker a thread, kept from case to case
    assert not Path(f"/proc/{processes[0]}").exists()


# -- runs that end early -----------------------------------------------------------------------------------


class OneRun:
    """A pool whose engines all return the same run."""

    def __init__(self, result: Run) -> None:
        self.result = result

    def worker(self, name: str, interpreted: bool = False) -> Any:
        return SimpleNamespace(run=lambda scene, method: self.result)


@pytest.mark.parametrize("how", [{"diverged": True}, {"stopped": "inelastic collapse"}])
def test_a_run_that_ended_early_reaches_only_checks_that_expect_it(how: dict[str, Any]) -> None:
    pool: Any = OneRun(Run(time=np.zeros(1), **how))
    laboratory = Laboratory("refimpl", {}, pool, "a/b/c")
    method = Method(scheme="good", dt=0.1)
    reason = "scene spring: the run " + ("diverged" if "diverged" in how else "stopped: inelastic collapse")
    with pytest.raises(EndedEarly, match=f"refimpl, {reason}"):
        laboratory.run(SCENE, method)
    with pytest.raises(EngineError, match=f"lammps, {reason}"):  # a reference: nothing against refimpl
        laboratory.run(SCENE, method, "lammps")
    assert laboratory.run(SCENE, method, may_end_early=True) is pool.result


# -- scenes that are refused ---------------------------------------------------------------------------------


REFUSING = MORTAL.replace("return None", "return 'too long' if scene.duration > 1 else None")


def test_scenes_that_a_check_goes_on_without_are_counted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Those of the engine under judgement alone, whether its declaration or itself refuses them."""
    (tmp_path / "engine.py").write_text(REFUSING)
    method, long = Method(scheme="good", dt=0.1), SCENE.changed(duration=2.0)
    flat = SCENE.changed(dimension=2, initial=Explicit(positions=((1.0, 0.0),)))
    counts = []

    def audit(laboratory: Laboratory, variant: str) -> Judgement:
        for scene in (SCENE, long, flat):
            try:
                laboratory.run(scene, method)
            except Unsupported:
                counts.append(len(laboratory.refused))
        assert laboratory.refusal(flat, method) is not None
        assert laboratory.refusal(SCENE, method) is None
        with pytest.raises(Unsupported):
            laboratory.run(SCENE, "lattice", "refimpl")
        return passed(laboratory, variant)

    offer(monkeypatch, check("a/b", audit))
    verdict = judge(Case("a/b", "one", f"{tmp_path}/engine.py:Engine", False), 0)
    assert (verdict.outcome, verdict.message) == ("pass", "")
    assert counts == [1, 2]
    assert verdict.refused == 3
    assert verdict.as_record()["refused"] == 3


def test_a_run_that_is_repeated_counts_its_refusals_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def far(laboratory: Laboratory, variant: str) -> Judgement:
        with pytest.raises(Unsupported):
            laboratory.run(SCENE, "lattice")
        return statistical("x", 99.0, 1.0, 0.0, 0.0, "why", samples=100)

    offer(monkeypatch, check("a/b", far))
    assert judge(Case("a/b", "one", "refimpl", False), 0).refused == 1
