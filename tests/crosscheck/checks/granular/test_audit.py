"""The audit of soft grains on foreign engines: a right one is green, and wrong ones are red, each by what is wrong."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from crosscheck.checks.granular.audit import FACTORS, common_rows, rows, simple_rows
from crosscheck.checks.granular.audited_scenes import audited_method, audited_scene, possible
from crosscheck.pairs import pairs_of
from crosscheck.references.soft_grains import audit
from crosscheck.runner import Case, close_pools, judge
from tests.support import grain_engines

SUPPORT = Path(__file__).parents[3] / "support"


@pytest.fixture(scope="module", autouse=True)
def _end_workers() -> Iterator[None]:
    yield
    close_pools()


def test_a_right_engine_is_green() -> None:
    verdict = judge(Case("granular/audit", "simple-rows", f"{SUPPORT / 'grain_engines.py'}:Right", False), seed=0)
    assert verdict.outcome == "pass", verdict.message


def test_a_drum_that_turns_backwards_is_red() -> None:
    verdict = judge(Case("granular/audit", "rows-0", f"{SUPPORT / 'backwards_drum.py'}:BackwardsDrum", False), seed=0)
    assert verdict.outcome == "fail", verdict.message
    assert verdict.findings is not None
    assert "turning" in verdict.findings.shown.note


@pytest.mark.parametrize(
    "engine",
    [
        grain_engines.FrictionOfOneSign,
        grain_engines.NoTorque,
        grain_engines.NoReaction,
        grain_engines.NeverForgets,
        grain_engines.NeverTurns,
        grain_engines.TwiceDamped,
        grain_engines.LargestReach,
    ],
)
def test_a_wrong_engine_has_errors_far_above_rounding(engine: type[grain_engines.Right]) -> None:
    shares = []
    for row in simple_rows()[0]:
        scene, method = audited_scene(row, 1, False), audited_method(row)
        assert method.contact is not None
        shares.append(audit(scene, method.contact, method.step, engine().run(scene, method)).worst[1].share)
        if shares[-1] > 1e3:
            break
    assert max(shares) > 1e3


def test_rows_have_every_pair_that_is_possible() -> None:
    table, never = rows()
    assert all(map(possible, table))
    found = set().union(*map(pairs_of, table))
    names = list(FACTORS)
    every = {
        ((one, a), (other, b))
        for k, one in enumerate(names)
        for other in names[k + 1 :]
        for a in FACTORS[one]
        for b in FACTORS[other]
    }
    assert found | never == every
    assert not found & never
    # what can never be: a factor that another one takes the meaning of
    assert {first[0] for first, _ in never} <= {"law", "friction", "x", "y", "z", "cylinder", "turning", "dimension"}


def test_all_rows_make_scenes() -> None:
    for table, potential in ((rows()[0], True), (simple_rows()[0], False), (common_rows()[0], False)):
        for row in table:
            scene, method = audited_scene(row, 1, potential), audited_method(row)
            scene.initial_state(method.contact)
