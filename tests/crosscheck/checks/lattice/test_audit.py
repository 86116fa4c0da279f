"""What the audits of lattice gases say of an engine of another hand, right and wrong, and which features they join."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import cast

import pytest

from crosscheck import runner
from crosscheck.checks import base
from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice import audit, recording
from crosscheck.checks.lattice.audit import CHUNKS, FACTORS, rows
from crosscheck.engines.protocol import Run
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool
from crosscheck.errors import Unsupported
from crosscheck.pairs import pairs_of
from crosscheck.scene import Method, Scene
from crosscheck.verdict import Findings, findings
from tests.support import lattice_engines
from tests.support.lattice_engines import WRONG, GoodEngine, OneWay


class Here:
    """A pool whose one worker is this process: it starts none."""

    def __init__(self, engine: type[GoodEngine]) -> None:
        self.engine = engine()

    def worker(self, name: str, interpreted: bool) -> Here:
        return self

    def run(self, scene: Scene, method: Method) -> Run:
        refused = self.engine.supports(scene, method)
        if refused is not None:
            raise Unsupported(refused)
        return self.engine.run(scene, method)


def judged(patch: pytest.MonkeyPatch, engine: type[GoodEngine], name: str, variant: str) -> Findings:
    for module in (base, recording, audit):
        patch.setattr(module, "engine_class", lambda name: engine)
    check = runner.find(name)
    (value,) = (one.value for one in check.offered(engine.schemes) if one.name == variant)
    pool = cast(Pool, Here(engine))
    return findings(check.judge(Laboratory(engine.name, engine.schemes, pool, f"{name}/{variant}"), value))


GOOD = [*(("lattice/audit", f"rows-{chunk}") for chunk in range(CHUNKS)), ("lattice/starts", "hpp")]


@pytest.mark.parametrize(("check", "variant"), sorted({*GOOD, *WRONG.values()}))
def test_an_engine_of_another_hand_is_green(monkeypatch: pytest.MonkeyPatch, check: str, variant: str) -> None:
    found = judged(monkeypatch, GoodEngine, check, variant)
    assert found.outcome == "pass", found.shown


@pytest.mark.parametrize("engine", WRONG, ids=lambda engine: engine.name)
def test_a_wrong_engine_is_red(monkeypatch: pytest.MonkeyPatch, engine: type[GoodEngine]) -> None:
    found = judged(monkeypatch, engine, *WRONG[engine])
    assert found.outcome == "fail", found.shown


@pytest.fixture
def pools() -> Iterator[None]:
    yield
    runner.close_pools()


@pytest.mark.usefixtures("pools")
def test_a_wrong_engine_named_by_its_file_is_red() -> None:
    name = f"{lattice_engines.__file__}:{OneWay.__name__}"
    case = runner.Case(*WRONG[OneWay], name, False)
    assert case in runner.select(["lattice/*"], "quick", [name])
    assert runner.judge(case, 0, None).outcome == "fail"


def test_an_engine_with_one_scheme_is_not_compared_with_itself() -> None:
    name = f"{lattice_engines.__file__}:GoodEngine"
    assert not runner.judging(runner.find("lattice/evolvers"), name, engine_class(name))


def test_features_occur_in_pairs() -> None:
    """What a gas with random numbers, or mean occupations, cannot do is left out; and nothing else."""
    found, never = rows()
    assert all(list(row) == list(FACTORS) for row in found)
    every = {((p, a), (q, b)) for p, q in combinations(FACTORS, 2) for a in FACTORS[p] for b in FACTORS[q]}
    assert set().union(*map(pairs_of, found)) | never == every
    for one, other in never:
        features = {one[0], other[0]}
        assert "reversals" in features or features == {"start", "scheme"}, (one, other)
