"""What the suite catches: the last scores of random mutations, and which features are judged together.

A score is the file that `crosscheck prove --mutate` writes, kept in `crosscheck/mutation/scores/`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from crosscheck import mutation
from crosscheck.checks.base import Check

_SCORES = Path(mutation.__path__[0]) / "scores"


def scores(directory: Path = _SCORES) -> list[dict[str, Any]]:
    """The scores that come with the suite, see `mutation.score.as_record`; directory: of the files."""
    return [json.loads(path.read_text(encoding="utf-8")) for path in sorted(directory.glob("*.json"))]


@dataclass(frozen=True)
class Together:
    """Which pairs of features one check judges.

    check: its name. features: their names. levels: of each feature, those that are not its absence. cells: for each
    feature, for each feature: how many pairs of their levels occur in a row that is judged, how many could; a feature
    with itself: its levels. rows: number of rows. never: of pairs that no scene has.
    """

    check: str
    features: tuple[str, ...]
    levels: tuple[tuple[str, ...], ...]
    cells: tuple[tuple[tuple[int, int], ...], ...]
    rows: int
    never: int


def together(checks: Iterable[Check]) -> list[Together]:
    """The table of each check that combines features; checks: those of the suite."""
    return [_table(check) for check in checks if check.features is not None]


def _table(check: Check) -> Together:
    assert check.features is not None
    factors = {name: tuple(levels) for name, levels in check.features.factors.items()}
    rows, never = check.features.rows()
    impossible = {frozenset(pair) for pair in never}

    def cell(one: str, other: str) -> tuple[int, int]:
        judged = {(row[one], row[other]) for row in rows}
        if one == other:
            return len(judged), len(factors[one])
        could = [
            pair for pair in product(factors[one], factors[other])
            if frozenset([(one, pair[0]), (other, pair[1])]) not in impossible
        ]  # fmt: skip
        return len(judged & set(could)), len(could)

    return Together(
        check.name,
        tuple(factors),
        tuple(levels[1:] for levels in factors.values()),
        tuple(tuple(cell(one, other) for other in factors) for one in factors),
        len(rows),
        len(never),
    )
