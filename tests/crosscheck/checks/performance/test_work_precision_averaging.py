"""Standard errors of runs of growing length, from made-up averages."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.performance.work_precision_averaging import MEMBERS, averaged
from crosscheck.engines.protocol import Claims, Cost, Run


def made(power: float, seed: int = 0):  # type: ignore[no-untyped-def]
    """Averages about 2 whose scatter falls as this power of the amount; a second of CPU time for each unit."""
    rng = np.random.default_rng(seed)

    def run(amount: float, member: int) -> tuple[float, Run]:
        return 2 + 0.1 * amount**power * rng.normal(), Run(cost=Cost(cpu=amount, steps=int(amount)))

    return averaged([1, 4, 16, 64], run)


def test_averages_over_independent_parts_are_green() -> None:
    found = [made(-0.5, seed).exponent() for seed in range(40)]
    assert all(one.outcome == "pass" for one in found)
    sigmas = [(one.measured + 0.5) / one.uncertainty for one in found]  # type: ignore[operator]
    assert abs(np.mean(sigmas)) < 5 / 40**0.5
    assert 0.7 < np.std(sigmas) < 1.4


@pytest.mark.parametrize("power", [0.0, -0.2, -1.0])
def test_errors_that_fall_otherwise_are_red(power: float) -> None:
    assert made(power).exponent().outcome == "fail"


def test_the_ladder_has_the_relative_error_and_the_cpu_time_of_one_run() -> None:
    found = made(-0.5)
    ladder = found.figure("t", "m", Claims(kind="event_driven"), "steps", lambda run: run.cost.steps, "steps").ladder
    assert ladder is not None
    assert ladder.cpu == [1.0, 4.0, 16.0, 64.0]
    assert ladder.count == [1.0, 4.0, 16.0, 64.0]
    assert ladder.error[0] == pytest.approx(0.05, rel=0.6)
    assert ladder.uncertainty[0] == pytest.approx(ladder.error[0] / (2 * (MEMBERS - 1)) ** 0.5, rel=1e-4)
    assert found.merit().startswith("relative standard error 0.0")


def test_a_bias_is_part_of_the_error_where_it_may_be() -> None:
    """Values that are off by 10 % have that error, however little they scatter."""

    def run(amount: float, member: int) -> tuple[float, Run]:
        return 2.2 + 1e-3 * (-1) ** member, Run(cost=Cost(cpu=amount, steps=int(amount)))

    found = averaged([1, 4, 16, 64], run, expected=2.0)
    assert found.errors == pytest.approx(0.1, rel=1e-3)
    assert found.exponent().outcome == "fail"
    assert averaged([1, 4], run).errors == pytest.approx(1e-3 / 2.2, rel=0.1)
