"""Rows of a table of factors in which every pair of compatible levels occurs: a covering array of strength two.

    rows, never = covering({"walls": ("none", "hard"), "friction": ("no", "yes"), "gravity": ("no", "yes")})

Literature: D. M. Cohen, S. R. Dalal, M. L. Fredman and G. C. Patton, IEEE Trans. Softw. Eng. 23, 437 (1997).
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from typing import TypeAlias

#: A level of each factor, by the factor's name.
Row: TypeAlias = dict[str, str]
#: Two factors and a level of each, the factors in the order of the table.
Pair: TypeAlias = tuple[tuple[str, str], tuple[str, str]]

#: Whether a row makes sense, as far as this rule goes.
Rule: TypeAlias = Callable[[Row], bool]

#: A level of a factor.
_Feature: TypeAlias = tuple[str, str]

#: Rows that are tried for one pair, beside the one with all other factors at their first level.
_TRIED = 5


def pairs_of(row: Row) -> set[Pair]:
    """All pairs of levels in a row; row: its factors in the order of the table."""
    return set(combinations(row.items(), 2))


def covering(
    factors: Mapping[str, Sequence[str]], rules: Sequence[Rule] = (), seed: int = 0
) -> tuple[list[Row], set[Pair]]:
    """Few rows in which each pair of levels of two factors occurs, and the pairs that no valid row has.

    factors: the levels of each factor; the first one is the absence of the feature, which goes with most others.
    rules: a row makes sense if all say yes. Each takes what it needs of a row by `row[factor]`: rules are tried on rows
    that have a part of the factors, and one that a rule asks for in vain is chosen next. seed: of the choice among
    rows, greedy otherwise. The same arguments give the same rows.
    """
    chance = random.Random(seed)
    features = [(name, level) for name, levels in factors.items() for level in levels]
    missing = {one: {other for other in features if other[0] != one[0]} for one in features}
    rows: list[Row] = []
    never: set[Pair] = set()
    for one, other in sorted((a, b) for (i, a), (j, b) in combinations(enumerate(features), 2) if a[0] != b[0]):
        if other not in missing[one]:
            continue
        found = _with_pair(factors, rules, {one, other}, missing, chance)
        if not found:
            never.add((one, other))
            missing[one].discard(other)
            missing[other].discard(one)
            continue
        best = max(found, key=lambda row: sum(len(missing[feature] & row.items()) for feature in row.items()))
        rows.append(best)
        for feature in best.items():
            missing[feature] -= best.items()
    return rows, never


def _with_pair(
    factors: Mapping[str, Sequence[str]],
    rules: Sequence[Rule],
    pair: set[_Feature],
    missing: Mapping[_Feature, set[_Feature]],
    chance: random.Random,
) -> list[Row]:
    """Valid rows that hold the pair: one as plain as may be, others with levels whose pairs are still missing."""

    def plain(name: str, row: Row) -> Sequence[str]:
        return factors[name]

    def greedy(name: str, row: Row) -> Sequence[str]:
        levels = list(factors[name])
        chance.shuffle(levels)
        return sorted(levels, key=lambda level: -len(missing[name, level] & row.items()))

    rows: list[Row] = []
    for levels in (plain, *[greedy] * _TRIED):
        row = _completed(dict(pair), rules, factors, levels)
        if row is None:
            return rows  # there is none, however it is looked for
        free = [name for name in factors if name not in row]
        if levels is greedy:
            chance.shuffle(free)
        for name in free:
            row[name] = levels(name, row)[0]
        rows.append({name: row[name] for name in factors})
    return rows


def _completed(
    row: Row,
    rules: Sequence[Rule],
    factors: Mapping[str, Sequence[str]],
    levels: Callable[[str, Row], Sequence[str]],
) -> Row | None:
    """The row with levels of the factors that the rules ask for, so that all say yes; None if there are none.

    levels: of a factor, in the order in which they are tried.
    """
    wanted: list[str] = []
    open_rules = []
    for rule in rules:
        try:
            if not rule(row):
                return None
        except KeyError as asked:
            wanted.append(asked.args[0])
            if wanted[-1] not in factors or wanted[-1] in row:
                raise
            open_rules.append(rule)
    if not open_rules:
        return row
    name = wanted[0]
    for level in levels(name, row):
        found = _completed(row | {name: level}, open_rules, factors, levels)
        if found is not None:
            return found
    return None
