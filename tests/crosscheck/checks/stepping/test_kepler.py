"""The judges of Kepler orbits on made-up engines: what they accept, and what they refuse."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
import pytest

from crosscheck.checks.base import Laboratory
from crosscheck.checks.stepping import kepler as checks
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times
from crosscheck.references import kepler
from crosscheck.scene import Method, Scene

Error = Callable[[float, np.ndarray], np.ndarray]


class Imagined:
    """A laboratory whose engine knows the orbit, and adds `error(dt, t)` to the first coordinate of the second body."""

    engine = "imagined"

    def __init__(self, claims: Claims, error: Error) -> None:
        self.claims = {"scheme": claims}
        self._error = error

    def run(self, scene: Scene, method: Method, engine: str | None = None) -> Run:
        eccentricity = float(scene.name.removeprefix("kepler-e"))
        t = sample_times(scene, method)
        r, v = kepler.two_bodies(t, checks.MASSES, eccentricity, checks.AXIS, checks.G)
        r[:, 1, 0] += self._error(method.dt, t)
        return Run(t, r[-1], v[-1], r, v, cost=Cost(steps=scene.steps(method.dt)))


def _laboratory(claims: Claims, error: Error) -> Laboratory:
    return cast(Laboratory, Imagined(claims, error))


@pytest.mark.parametrize("e", checks.ECCENTRICITIES)
@pytest.mark.parametrize(("claimed", "outcome"), [(2, "pass"), (1, "fail"), (3, "fail")])
def test_order(e: float, claimed: int, outcome: str) -> None:
    fast = kepler.fastest(e)
    laboratory = _laboratory(Claims((claimed, claimed)), lambda dt, t: (fast * dt) ** 2 * np.sin(t))
    assert checks._judge_order(laboratory, f"e{e:g}/scheme").outcome == outcome


def test_a_scheme_that_is_exact_is_judged_by_rounding() -> None:
    exact = checks._judge_order(_laboratory(Claims((2, 2)), lambda dt, t: 0 * t), "e0.5/scheme")
    assert (exact.outcome, exact.criterion.kind) == ("pass", "round_off")
    # an error far above rounding, but the same at all steps, is no convergence
    stuck = checks._judge_order(_laboratory(Claims((2, 2)), lambda dt, t: 1e-6 * np.sin(t)), "e0.5/scheme")
    assert stuck.outcome == "fail"


def test_invariants_of_an_engine_that_is_exact() -> None:
    judgement = checks._judge_invariants(_laboratory(Claims((2, 2), symplectic=True), lambda dt, t: 0 * t), "scheme")
    assert judgement.outcome == "pass"


def test_invariants_see_a_drift() -> None:
    laboratory = _laboratory(Claims((2, 2), symplectic=True), lambda dt, t: dt**2 * t)
    judgement = checks._judge_invariants(laboratory, "scheme")
    assert judgement.outcome == "fail"


def test_adaptive_scheme_at_the_limit_of_rounding() -> None:
    claims = Claims(None)
    assert checks._judge_rounding(_laboratory(claims, lambda dt, t: 0 * t), "e0.9/scheme").outcome == "pass"
    assert checks._judge_rounding(_laboratory(claims, lambda dt, t: 1e-10 + 0 * t), "e0.9/scheme").outcome == "fail"


def test_gear_loses_its_order_to_the_start() -> None:
    assert checks.nominal_order("gear5", Claims((6, 5))) == 2
    assert checks.nominal_order("runge_kutta", Claims((4, 4))) == 4


def test_steps_divide_the_samples_and_resolve_the_pericentre() -> None:
    for e in checks.ECCENTRICITIES:
        numbers = checks.step_numbers(e, 0.1, 4)
        assert (numbers % checks.SAMPLES == 0).all()
        assert checks.PERIOD / numbers[0] * kepler.fastest(e) <= 0.1
