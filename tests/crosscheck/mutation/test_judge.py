"""A judge is a process of its own, with the mutated package first on its path."""

from __future__ import annotations

from pathlib import Path

from crosscheck.mutation.judge import Judge
from crosscheck.runner import Case


def test_a_package_that_cannot_be_imported_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "refimpl").mkdir()
    (tmp_path / "refimpl" / "__init__.py").write_text("raise ImportError('a mutation of the module')\n")
    with Judge(tmp_path, tmp_path) as judge:
        answer = judge.judge(Case("events/haff", "2d-0.9", "refimpl", False), 0, 60.0)
    assert answer.red
    assert answer.message == "the suite's own process ended"


def test_a_case_that_the_sources_do_not_offer_catches_nothing() -> None:
    with Judge() as judge:
        answer = judge.judge(Case("events/haff", "no such variant", "refimpl", False), 0, 60.0)
    assert answer.outcome == "skip"
    assert not answer.red
