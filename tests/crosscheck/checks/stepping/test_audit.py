"""The audits of runs under smooth forces: a right engine passes, published bugs do not, and messages name the scene."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from crosscheck.checks import all_checks
from crosscheck.checks.base import Laboratory
from crosscheck.checks.stepping import audit, gravity_features, lennard_jones_features, spring_features
from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import Run
from crosscheck.errors import Unsupported
from crosscheck.pairs import pairs_of
from crosscheck.runner import Case, close_pools, judge
from crosscheck.scene import Gravity, Method, Scene, explicit
from crosscheck.verdict import Findings, findings
from tests.support import wrong_engines
from tests.support.wrong_engines import Right

CHECKS = {check.name: check for check in all_checks()}
GRAVITY = ("stepping/gravity-steps", "stepping/gravity-features")
FLUIDS = ("stepping/lennard-jones-steps", "stepping/lennard-jones-features", "stepping/lennard-jones-lists")
#: A bug, a check that must see it, and the quantity that is wrong.
BUGS = [
    ("SoftenedPower", "stepping/gravity-steps", "forces"),
    ("MassOfAnother", "stepping/gravity-steps", "positions, step by step"),
    ("OneSided", "stepping/gravity-features", "forces"),
    ("EnergyTwice", "stepping/gravity-features", "potential_energy"),
    ("HalfStepVelocities", "stepping/gravity-steps", "velocities, step by step"),
    ("NearestImage", "stepping/lennard-jones-features", "potential_energy"),
    ("ListOnce", "stepping/lennard-jones-lists", "positions, step by step"),
    ("CutWithoutShift", "stepping/lennard-jones-features", "potential_energy"),
    ("VirialOfSpace", "stepping/lennard-jones-steps", "virial"),
    ("VirialSign", "stepping/lennard-jones-features", "virial"),
    ("OneSided", "stepping/lennard-jones-steps", "forces"),
    ("EnergyTwice", "stepping/lennard-jones-features", "potential_energy"),
    ("HalfStepVelocities", "stepping/lennard-jones-features", "velocities, step by step"),
    ("MassOfAnother", "stepping/lennard-jones-features", "positions, step by step"),
]


class Direct:
    """A laboratory that runs an engine's class in this process."""

    def __init__(self, engine: type[Any]) -> None:
        self.engine, self.claims, self._class = engine.name, engine.schemes, engine

    def run(self, scene: Scene, method: Method) -> Run:
        return cast(Run, self._class().run(scene, method))

    def refusal(self, scene: Scene, method: Method) -> str | None:
        return refusal(self._class, scene, method)


def judged(engine: type[Any], name: str, monkeypatch: pytest.MonkeyPatch) -> list[Findings]:
    """Findings of all variants of a check on an engine's class, but for those whose scenes it does not know."""
    monkeypatch.setattr(audit, "engine_class", lambda _: engine)
    found = []
    for variant in CHECKS[name].offered(engine.schemes):
        try:
            found.append(findings(CHECKS[name].judge(cast(Laboratory, Direct(engine)), variant.value)))
        except Unsupported:
            continue
    return found


@pytest.mark.parametrize("name", [*GRAVITY, *FLUIDS])
def test_a_right_engine_passes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = judged(Right, name, monkeypatch)
    assert found
    assert {one.outcome for one in found} == {"pass"}


def test_judgements_have_the_same_order_in_every_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """That of sets of names depends on how Python hashes texts, which differs from process to process."""
    for name in ("stepping/gravity-features", "stepping/lennard-jones-steps"):
        for one in judged(Right, name, monkeypatch):
            energies = [
                j.quantity.partition(":")[0] for j in one.judgements if "energy" in j.quantity or "vir" in j.quantity
            ]
            assert energies == ["kinetic_energy", "potential_energy", "virial"]


@pytest.mark.parametrize(("bug", "name", "quantity"), BUGS, ids=[f"{bug}-{name[9:]}" for bug, name, _ in BUGS])
def test_a_published_bug_is_red(bug: str, name: str, quantity: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = judged(getattr(wrong_engines, bug), name, monkeypatch)
    red = {j.quantity.partition(":")[0] for one in found for j in one.judgements if j.outcome == "fail"}
    assert quantity in red


@pytest.mark.parametrize(
    ("engine", "name", "outcome"),
    [
        ("Right", "stepping/few-bodies", "pass"),
        ("Right", "stepping/few-particles", "pass"),
        ("SoftenedPower", "stepping/few-bodies", "fail"),
        ("MassOfAnother", "stepping/few-bodies", "fail"),
        ("HalfStepVelocities", "stepping/few-bodies", "fail"),
        ("OneSided", "stepping/few-particles", "fail"),
        ("HalfStepVelocities", "stepping/few-particles", "fail"),
    ],
)
def test_final_states_of_few_bodies_show_most(
    engine: str, name: str, outcome: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert [one.outcome for one in judged(getattr(wrong_engines, engine), name, monkeypatch)] == [outcome]


def test_an_engine_in_a_file_is_red_by_its_name() -> None:
    engine = f"{wrong_engines.__file__}:SoftenedPower"
    verdict = judge(Case("stepping/gravity-features", "rows-1", engine, False), 0)
    close_pools()
    assert verdict.outcome == "fail"
    assert verdict.findings is not None
    assert "softening" in verdict.findings.shown.note


@pytest.mark.parametrize("module", [gravity_features, lennard_jones_features, spring_features])
def test_every_pair_of_features_has_a_row_or_a_reason(module: Any) -> None:
    rows, never = module.rows()
    seen = set().union(*map(pairs_of, rows))
    names = list(module.FACTORS)
    every = {
        ((one, a), (other, b))
        for k, one in enumerate(names)
        for other in names[k + 1 :]
        for a in module.FACTORS[one]
        for b in module.FACTORS[other]
    }
    assert seen | never == every
    assert not seen & never
    for number, row in enumerate(rows):
        module.scene_of(row, number).check_start()


def test_nan_is_an_infinite_error() -> None:
    ledger = audit.Ledger()
    ledger.scenes = 1
    ledger.note("forces", np.array([1e-20, np.nan]), 1.0, "here")
    assert ledger.findings().outcome == "fail"


def test_an_exact_value_needs_no_bound() -> None:
    ledger = audit.Ledger()
    ledger.note("virial", 0.0, 0.0, "one particle")
    assert ledger.shares["virial"][0] == 0.0


def test_scenes_that_no_engine_knows_are_no_success() -> None:
    ledger = audit.Ledger()
    ledger.refused.append("no softening")
    with pytest.raises(Unsupported, match="no softening"):
        ledger.findings()


@pytest.mark.parametrize("scheme", ["leapfrog"])
def test_either_leapfrog_is_accepted(scheme: str) -> None:
    r, v = np.array([[1.0, 0.0], [-1.0, 0.2]]), np.array([[0.0, 0.6], [0.1, -0.6]])
    scene = Scene(name="two", dimension=2, duration=0.5, gravity=Gravity(), initial=explicit(r, v))
    problem = audit.problem_of(scene)
    expected = audit.Expected(scene, scheme, 0.1, 5)
    for path in audit.solutions(scheme, problem, r, v, 0.1, 5):
        errors, bounds = expected.compared(np.arange(6), *(part.astype(float) for part in path[:2]))
        assert all((abs(e) <= b).all() for e, b in zip(errors, bounds, strict=True))
