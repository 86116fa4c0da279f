"""Which cases are chosen: most checks first, within the time, the smaller form only where the larger does not fit."""

from __future__ import annotations

import math
import time
from collections import defaultdict

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.budget import plan
from crosscheck.budget.loads import CaseLoad, Load
from crosscheck.budget.plan import Budget, Predicted, chosen, ordered
from crosscheck.budget.speeds import Speed
from crosscheck.record import is_left_out
from crosscheck.runner import Case
from crosscheck.verdict import LEFT_OUT, Verdict


def one(check: str, variant: str, seconds: float | None, *, timing: bool = False, instead: str = "") -> Predicted:
    return Predicted(Case(check, variant, "refimpl", timing, instead), seconds)


def names(predictions: list[Predicted]) -> list[str]:
    return [item.case.name for item in predictions]


CASES = st.lists(
    st.tuples(
        st.sampled_from(["a/x", "a/y", "b/z"]),
        st.integers(0, 9),
        st.one_of(st.none(), st.floats(0.01, 100)),
        st.booleans(),
    ),
    unique_by=lambda item: item[:2],
    max_size=20,
).map(lambda rows: [one(check, str(number), seconds, timing=timing) for check, number, seconds, timing in rows])


@given(CASES)
def test_each_check_comes_once_before_any_comes_twice(predictions: list[Predicted]) -> None:
    order = ordered(predictions)
    assert sorted(order, key=repr) == sorted(predictions, key=repr)
    known = [item for item in order if item.seconds is not None]
    assert order[: len(known)] == known, "what nobody can predict comes last"
    seen: defaultdict[str, list[float]] = defaultdict(list)
    ranks = []
    for item in known:
        assert item.seconds is not None
        ranks.append((len(seen[item.case.check]), item.seconds))
        assert seen[item.case.check] == sorted(seen[item.case.check])
        seen[item.case.check].append(item.seconds)
    assert ranks == sorted(ranks), "within a round, the cheapest first"


@given(CASES, st.floats(0, 200), st.integers(1, 4))
def test_what_is_chosen_ends_in_time(predictions: list[Predicted], seconds: float, jobs: int) -> None:
    fits = chosen(ordered(predictions), seconds, jobs)
    total = sum(item.seconds or 0.0 for item in fits)
    alone = sum(item.seconds or 0.0 for item in fits if item.case.timing)
    assert all(item.seconds is not None for item in fits)
    assert (total - alone) / jobs + alone <= seconds * (1 + 1e-12)
    # and nothing is left that would fit after all the others
    longest = seconds - (total - alone) - alone
    left = [item for item in predictions if item not in fits and item.seconds is not None]
    assert not any(item.seconds is not None and item.seconds <= longest for item in left)


def test_the_small_form_is_for_those_that_have_no_time_for_the_large_one() -> None:
    small, large = one("a/x", "large-N64", 2.0, instead="large"), one("a/x", "large", 50.0)
    other = one("b/z", "other", 49.0)
    order = ordered([large, small, other])
    assert names(chosen(order, 51.0, 1)) == ["a/x/large-N64", "b/z/other"]
    assert names(chosen(order, 100.0, 1)) == ["b/z/other", "a/x/large"], "and the time of the small one is used"
    assert names(chosen(order, 1.0, 1)) == []


def verdict(case: Case, seconds: float, outcome: str = "pass", message: str = "") -> Verdict:
    return Verdict(case.check, case.variant, case.engine, outcome, None, message, {"seconds": seconds})  # type: ignore[arg-type]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return now


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> dict[Case, float | None]:
    """What is predicted for a case."""
    seconds: dict[Case, float | None] = {}
    monkeypatch.setattr(plan, "predicted", lambda case, speeds: seconds[case])
    return seconds


REAL = Case("stepping/lennard-jones-chaos", "against-lammps", "refimpl", False)
OTHER = Case("stepping/lennard-jones-energy", "velocity_verlet", "refimpl", False)
LAST = Case("performance/gravity-speed", "leapfrog", "refimpl", True)


def test_time_that_passes_leaves_cases_out(clock: list[float], known: dict[Case, float | None]) -> None:
    known |= {OTHER: 8.0}
    budget = Budget([OTHER], {}, 10.0, 1)
    assert budget.left_out(OTHER) is None
    clock[0] += 3.0
    left = budget.left_out(OTHER)
    assert left is not None
    assert (left.outcome, left.message, left.tier) == ("skip", f"{LEFT_OUT}: predicted 8 s", "quick")
    assert left.cost == {"seconds": 0.0, "predicted": 8.0}
    assert is_left_out(left.as_record())


def test_cases_that_measure_times_keep_theirs(clock: list[float], known: dict[Case, float | None]) -> None:
    known |= {OTHER: 4.0, LAST: 5.0}
    budget = Budget([LAST, OTHER], {}, 10.0, 2)
    assert budget.left_out(OTHER) is None
    clock[0] += 2.0
    assert budget.left_out(OTHER) is not None, "5 s are for those that run alone"
    clock[0] += 2.0
    assert budget.left_out(LAST) is None


def test_what_cases_took_corrects_the_predictions(clock: list[float], known: dict[Case, float | None]) -> None:
    known |= {REAL: 3.0, OTHER: 4.0}
    budget = Budget([REAL, OTHER], {}, 11.5, 1)
    assert budget.left_out(OTHER) is None
    done = budget.finished(REAL, verdict(REAL, 11.0))
    assert done.cost == {"seconds": 11.0, "predicted": 3.0}
    left = budget.left_out(OTHER)
    assert left is not None
    assert left.cost["predicted"] == pytest.approx(4.0 * (11 + 1) / (3 + 1))


def test_a_skip_says_nothing_of_the_speed(clock: list[float], known: dict[Case, float | None]) -> None:
    known |= {REAL: 3.0, OTHER: 4.0}
    budget = Budget([REAL, OTHER], {}, 8.0, 1)
    budget.finished(REAL, verdict(REAL, 0.0, "skip", "no"))
    clock[0] += 4.5
    assert budget.left_out(OTHER) is not None


def test_a_case_ends_at_many_times_what_was_predicted(clock: list[float], known: dict[Case, float | None]) -> None:
    known |= {REAL: 0.01, OTHER: 4.0, LAST: None}
    budget = Budget([REAL, OTHER, LAST], {}, 200.0, 1)
    assert budget.limit(REAL) == clock[0] + 0.25 * 200.0
    assert budget.limit(OTHER) == clock[0] + 20 * 4.0
    assert budget.limit(LAST) == clock[0] + 0.25 * 200.0
    clock[0] += 170.0
    assert budget.limit(OTHER) == clock[0] + 30.0, "and with the budget"
    ended = budget.finished(REAL, verdict(REAL, 50.0, "skip", f"{LEFT_OUT}: not finished after 50 s"))
    assert ended.message == f"{LEFT_OUT}: not finished after 50 s, 0.01 s were predicted"


def test_what_nobody_can_predict_is_tried_while_there_is_time(
    clock: list[float], known: dict[Case, float | None]
) -> None:
    known |= {REAL: None, OTHER: 4.0}
    budget = Budget([REAL, OTHER], {}, 10.0, 1)
    assert budget.cases == [OTHER, REAL]
    assert budget.chosen == [OTHER]
    assert budget.said == "budget: 1 of 2 cases fit, predicted 4 s; 10 s are left"
    assert budget.left_out(REAL) is None
    clock[0] += 10.0
    left = budget.left_out(REAL)
    assert left is not None
    assert left.message == f"{LEFT_OUT}: no speed is known"


def test_small_cases_go_where_the_larger_one_is_chosen(clock: list[float], known: dict[Case, float | None]) -> None:
    small = Case(REAL.check, "few", "refimpl", False, REAL.variant)
    known |= {small: 1.0, REAL: 5.0}
    assert Budget([small, REAL], {}, 10.0, 1).cases == [REAL]
    assert Budget([small, REAL], {}, 4.0, 1).cases == [small, REAL]


def test_a_prediction_adds_up_the_loads(monkeypatch: pytest.MonkeyPatch) -> None:
    speed = Speed((1, 100), (0.5, 0.5), (1e-3, 1e-1))
    loads = (Load("spring", "stepping", 1, 1, 2, 1000), Load("hard_spheres", "event_driven", 100, 10, 0, 10))
    monkeypatch.setattr(plan, "load_of", lambda check, variant: CaseLoad("refimpl", loads, 0.25))
    speeds = {("refimpl", "spring", "stepping"): speed, ("refimpl", "hard_spheres", "event_driven"): speed}
    # refimpl has half of ten event-driven schemes
    assert plan.predicted(REAL, speeds) == pytest.approx(0.25 + 2 * 0.5 + 1.0 + 0.5 * 1.0)
    assert plan.predicted(REAL, {**speeds, ("refimpl", "spring", "stepping"): None}) is None
    monkeypatch.setattr(plan, "load_of", lambda check, variant: None)
    assert plan.predicted(REAL, speeds) is None


def test_speeds_are_measured_once_for_each_kind_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, str, str, float]] = []

    def measured(engine: str, interaction: str, kind: str, time_limit: float) -> Speed | None:
        asked.append((engine, interaction, kind, time_limit))
        return Speed((32,), (0.0,), (2e-4,)) if interaction == "lennard_jones" else None

    monkeypatch.setattr(plan, "measured", measured)
    told: list[str] = []
    gravity = Case("stepping/gravity-steps", "velocity_verlet", "refimpl", False)
    speeds = plan.measure([OTHER, OTHER, gravity], 60.0, told.append)
    assert asked == [("refimpl", "lennard_jones", "stepping", 15.0), ("refimpl", "gravity", "stepping", 15.0)]
    assert list(speeds) == [key[:3] for key in asked]
    assert told[0] == "refimpl, [lennard_jones], stepping: a step takes 200 us (32) particles"
    assert told[1].startswith("refimpl, [gravity], stepping: speed unknown")


def test_no_end_is_no_error() -> None:
    assert names(chosen([one("a/x", "1", 1e9)], math.inf, 1)) == ["a/x/1"]
