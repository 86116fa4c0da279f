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

#: Rows that are tried for one pair, beside the one with all other factors at their first level.
_TRIED = 30
#: Bases that are tried for one pair.
_BASES_TRIED = 8


def pairs_of(row: Row) -> set[Pair]:
    """All pairs of levels in a row; row: its factors in the order of the table."""
    return set(combinations(row.items(), 2))


def covering(
    factors: Mapping[str, Sequence[str]],
    valid: Callable[[Row], bool] = lambda row: True,
    seed: int = 0,
    bases: Sequence[Row] = (),
) -> tuple[list[Row], set[Pair]]:
    """Few rows in which each pair of levels of two factors occurs, and the pairs for which no valid row was found.

    factors: the levels of each factor; the first one is the absence of the feature, which goes with most others.
    valid: whether a whole row makes sense. seed: of the choice among rows, greedy otherwise. bases: of factors that
    need each other: valid levels of some factors, of which a row with any pair may start, the others absent; then a row
    is valid at each step of its making. The same arguments give the same rows.
    """
    chance = random.Random(seed)
    names = list(factors)
    missing = {
        ((one, a), (other, b)) for one, other in combinations(names, 2) for a in factors[one] for b in factors[other]
    }
    rows: list[Row] = []
    never: set[Pair] = set()
    for pair in sorted(missing):
        if pair not in missing:
            continue
        if bases:
            found = _from_bases(factors, pair, missing, chance, valid, bases)
        else:
            found = [row for row in _with_pair(factors, pair, missing, chance) if valid(row)]
        if not found:
            never.add(pair)
            missing.discard(pair)
            continue
        best = max(found, key=lambda row: len(pairs_of(row) & missing))
        rows.append(best)
        missing -= pairs_of(best)
    return rows, never


def _with_pair(
    factors: Mapping[str, Sequence[str]], pair: Pair, missing: set[Pair], chance: random.Random
) -> list[Row]:
    """Rows that hold the pair: one plain, and others filled with levels whose pairs are still missing."""
    given = dict(pair)
    plain = {name: given.get(name, levels[0]) for name, levels in factors.items()}
    rows = [plain]
    for _ in range(_TRIED):
        row = dict(given)
        free = [name for name in factors if name not in given]
        chance.shuffle(free)
        for name in free:
            levels = list(factors[name])
            chance.shuffle(levels)
            row[name] = max(levels, key=lambda level: _gain(row, name, level, missing))
        rows.append({name: row[name] for name in factors})
    return rows


def _from_bases(
    factors: Mapping[str, Sequence[str]],
    pair: Pair,
    missing: set[Pair],
    chance: random.Random,
    valid: Callable[[Row], bool],
    bases: Sequence[Row],
) -> list[Row]:
    """Rows that hold the pair, each from a base that goes with it; one factor after the other, valid at each step."""
    plain = {name: levels[0] for name, levels in factors.items()}
    starts = [plain | dict(base) | dict(pair) for base in bases]
    found = []
    able = list(filter(valid, starts))
    for start in chance.sample(able, min(len(able), _BASES_TRIED)):
        row, given = dict(start), {name for name, _ in pair}
        free = [name for name in factors if name not in given]
        chance.shuffle(free)
        for name in free:
            levels = [level for level in factors[name] if level == row[name] or valid(row | {name: level})]
            chance.shuffle(levels)
            row[name] = max(levels, key=lambda level: _gain(row | {name: ""}, name, level, missing))
        found.append(row)
    return found


def _gain(row: Row, name: str, level: str, missing: set[Pair]) -> int:
    """Number of missing pairs of this level with those that the row has so far."""
    return sum(((one, a), (name, level)) in missing or ((name, level), (one, a)) in missing for one, a in row.items())
