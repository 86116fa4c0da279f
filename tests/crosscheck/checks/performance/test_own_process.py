"""A module that runs in a process of its own: what it prints, and what is said if it fails."""

from pathlib import Path

import pytest

from crosscheck.checks.performance.own_process import answer_of
from crosscheck.errors import EngineError


def test_the_last_line_is_the_answer(tmp_path: Path) -> None:
    assert answer_of("json.tool", 3, tmp_path, 60.0, "answer") == 3


def test_a_failure_is_said_with_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(EngineError, match=r"refimpl: no counts of a scene: .*No module named crosscheck\.nothing"):
        answer_of("crosscheck.nothing", [], tmp_path, 60.0, "counts of a scene")
