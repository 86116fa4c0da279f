"""The counts of evaluations that are expected, against calls counted one by one; ladders, and how they are judged."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from crosscheck.checks.performance import (
    work_precision_kepler,
    work_precision_lennard_jones,
    work_precision_oscillator,
    work_precision_three_bodies,
)
from crosscheck.checks.performance.work_precision_judging import (
    Problem,
    Rung,
    as_figure,
    check,
    expected_evaluations,
    family,
    judged_order,
    methods_of,
)
from crosscheck.convergence import Observed, observed_order
from crosscheck.engines.protocol import Claims, Cost, Run
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.engines.scipy import ScipyEngine
from refimpl.compilation import implements
from refimpl.stepping.forces.generic import accelerate
from refimpl.stepping.schemes import SCHEMES

PROBLEMS = [
    problem
    for module in (
        work_precision_kepler,
        work_precision_lennard_jones,
        work_precision_oscillator,
        work_precision_three_bodies,
    )
    for problem in module.PROBLEMS
]
by_name = pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)


class Counting(NamedTuple):
    """a = -r; calls: shape (1,)."""

    calls: np.ndarray


@implements(accelerate, Counting)
def _accelerate(force: Counting, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    force.calls[0] += 1
    return -r


@pytest.mark.parametrize("scheme", SCHEMES)
def test_evaluations_of_every_scheme(scheme: str) -> None:
    force, record, dt = Counting(np.zeros(1, dtype=np.int64)), SCHEMES[scheme].record, 0.1
    r, v = np.array([1.0]), np.array([0.5])
    memory = record.start(force, r, v, dt)
    assert force.calls[0] == expected_evaluations("refimpl", scheme, 0)
    for _ in range(7):
        r, v, memory = record.step(force, r, v, memory, dt)
    assert force.calls[0] == expected_evaluations("refimpl", scheme, 7)


@by_name
@pytest.mark.parametrize("scheme", SCHEMES)
def test_ladders_divide_the_samples_and_grow_finer(problem: Problem, scheme: str) -> None:
    claims = RefimplEngine.schemes[scheme]
    if not problem.accept(scheme, claims):
        return
    methods = methods_of(problem, scheme, claims)
    assert len(methods) >= 5
    assert list(methods) == sorted(methods, reverse=True)
    for dt, method in methods.items():
        assert method.step == dt
        problem.scene.steps(dt)
        problem.scene.every(dt)


@by_name
def test_schemes_with_a_tolerance_climb_tolerances(problem: Problem) -> None:
    claims = ScipyEngine.schemes["RK45"]
    methods = methods_of(problem, "RK45", claims)
    assert [method.tolerance for method in methods.values()] == list(methods)
    assert all(method.dt is None for method in methods.values())


@by_name
def test_faults_are_planted_in_variants_that_there_are(problem: Problem) -> None:
    names = [variant.name for variant in check(problem).offered(RefimplEngine.schemes)]
    assert problem.faults
    assert {name for name, _ in problem.faults} <= set(names)


def test_families_follow_from_claims() -> None:
    assert family(Claims(kind="adaptive")) == family(Claims()) == "chooses its steps"
    assert family(Claims((2, 2), symplectic=True)) == "symplectic"
    assert family(Claims((1, 1))) == "first order"
    assert family(Claims((4, 4))) == "not symplectic, order 2 or more"
    assert family(Claims(kind="event_driven")) == "event-driven"


def seen(value: float, half: float) -> Observed:
    return Observed(value, half, (3, 2, 1, 0))


@pytest.mark.parametrize(
    ("found", "outcome"),
    [
        (seen(2.01, 0.1), "pass"),
        (seen(1.0, 0.1), "fail"),
        (seen(2.0, 3.0), "inconclusive"),  # four orders would do
        (seen(-100.0, 290.0), "inconclusive"),
        (seen(9.0, 3.0), "fail"),  # wide, but far away
        (Observed(np.nan, np.nan, (), "none"), "inconclusive"),
    ],
)
def test_an_order_is_green_only_if_it_is_known(found: Observed, outcome: str) -> None:
    assert judged_order("order", found, 2.0).outcome == outcome


def test_a_saturating_error_is_red() -> None:
    steps = 0.5 ** np.arange(12)
    assert judged_order("order", observed_order(steps, steps**2 + 1e-3, 1e-12), 2.0).outcome == "fail"


def test_failed_runs_stay_in_the_figure() -> None:
    good, bad = Run(cost=Cost(cpu=2.0, evaluations=7)), Run(diverged=True, cost=Cost(cpu=1.0, evaluations=3))
    rungs = [Rung(0.2, (bad, bad)), Rung(0.1, (good, good))]
    figure = as_figure("case", "error", "euler", Claims((1, 1)), "dt", rungs, [np.inf, 0.5], [0.0, 0.0])
    assert figure.ladder is not None
    assert figure.ladder.failures == ["diverged", ""]
    assert figure.ladder.count == [3.0, 7.0]
    assert figure.ladder.cpu == [1.0, 2.0]
