"""What an engine refuses costs nothing: no other engine runs before it is asked."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest

from crosscheck.checks import all_checks
from crosscheck.checks.base import Check, Laboratory
from crosscheck.engines.registry import engine_class, shipped_engines
from crosscheck.errors import EngineMissing, Unsupported
from crosscheck.runner import judging


class _Judged(str):
    """The name of the engine under judgement, told from that of the same engine as a reference."""


class _Refusing:
    """Workers of an engine that refuses every scene, and of references that must not be asked for a run."""

    def __init__(self, engine: str) -> None:
        self.engine = engine

    def worker(self, engine: str, interpreted: bool = False) -> _Refusing:
        return _Refusing(engine)

    def supports(self, scene: Any, method: Any) -> str:
        return "no"

    def run(self, scene: Any, method: Any, **files: Any) -> None:
        assert isinstance(self.engine, _Judged), f"{self.engine} runs {scene.name} for an engine that refuses"
        raise Unsupported("no")


#: Variants of a check that are tried: no check has more ways to judge, and those that have dozens of them take seconds.
VARIANTS = 4


def _cases(check: Check) -> list[tuple[str, Any]]:
    """An engine and a value for some variants, the first engine that is judged by each."""
    found: dict[str, tuple[str, Any]] = {}
    for engine in shipped_engines():
        for variant in judging(check, engine, engine_class(engine)):
            found.setdefault(variant.name, (engine, variant.value))
    return list(found.values())[:VARIANTS]


@pytest.mark.parametrize("check", all_checks(), ids=lambda check: check.name)
def test_no_reference_runs_for_an_engine_that_refuses(check: Check) -> None:
    for engine, value in _cases(check):
        claims = engine_class(engine).schemes
        laboratory = Laboratory(_Judged(engine), claims, _Refusing(engine), f"{check.name}/x")  # type: ignore[arg-type]
        with suppress(Unsupported, EngineMissing):  # a check may ask for a refusal, or for a program that is not here
            check.judge(laboratory, value)
