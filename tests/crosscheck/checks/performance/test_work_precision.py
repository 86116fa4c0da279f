"""The counts of evaluations that the check expects, against calls counted one by one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from crosscheck.checks.performance.work_precision import PROBLEMS, expected_evaluations
from crosscheck.engines.protocol import Claims
from refimpl.compilation import implements
from refimpl.stepping.forces.generic import accelerate
from refimpl.stepping.schemes import SCHEMES


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


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
@pytest.mark.parametrize("claims", [Claims((1, 1)), Claims((1, 1), symplectic=True), Claims((2, 2)), Claims((6, 5))])
def test_ladders_divide_the_samples(problem, claims) -> None:  # type: ignore[no-untyped-def]
    for n in problem.numbers(claims):
        assert problem.scene.every(problem.scene.duration / n) is not None
