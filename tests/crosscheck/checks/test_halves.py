"""What the checks of restarts say of engines that forget."""

from __future__ import annotations

from pathlib import Path

import pytest

from crosscheck import runner

FORGETFUL = Path(__file__).parents[2] / "support" / "forgetful.py"


@pytest.mark.parametrize(("engine", "outcome"), [("FromTheStart", "fail"), ("LeavesNothing", "error")])
def test_an_engine_that_forgets_is_red(engine: str, outcome: str) -> None:
    case = runner.Case("stepping/restart-gravity", "schemes", f"{FORGETFUL}:{engine}", False)
    try:
        verdict = runner.judge(case, 0)
    finally:
        runner.close_pools()
    assert verdict.outcome == outcome, verdict.message
    if outcome == "error":
        assert "leaves no state" in verdict.message
