"""Exact numbers of operations: what is done too often costs time, and no clock is needed to see it.

An engine that promises `operations` counts them in `Cost`. What any algorithm of its kind must keep to is judged of
all of them; what an algorithm does exactly, of the engine that it is known of.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from crosscheck.checks.base import Laboratory
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Cost
from crosscheck.verdict import Judgement, bounded, round_off

#: Largest share by which a number of operations may differ from that of a run of the same scene that was looked at.
_SAME = 0.05
_WHY_STORED = (
    "the same scene gives the same numbers, but for rounding; they change with the algorithm, and are then looked at "
    "and written down anew"
)
_WHY_EXACT = "whole numbers, of which none is left to chance"
EQUATION = "operations = those that the algorithm needs"
CRITERION = f"exact where the algorithm says so; within bounds; {_SAME:.0%} around the known numbers of the engine"


def counting(needs: Needs) -> Needs:
    """`needs`, and that the engine counts its operations."""
    return replace(needs, promises=(*needs.promises, "operations"))


def counted(cost: Cost, name: str) -> float:
    """A count of the cost by its name; NaN, with which every judgement is red, where it was not counted."""
    value = getattr(cost, name)
    return float("nan") if value is None else float(value)


def exactly(quantity: str, count: float, expected: float) -> Judgement:
    """The judgement that a count is the expected whole number; quantity: its name."""
    return round_off(f"{quantity}, beyond {expected:g}", count - expected, 0.5, _WHY_EXACT)


def at_most(quantity: str, count: float, limit: float, why: str) -> Judgement:
    """The judgement count <= limit; quantity: its name; why: the reason for the limit."""
    return bounded(quantity, count, limit, why)


def as_known(laboratory: Laboratory, cost: Cost, known: Mapping[str, float], of: str = "refimpl") -> list[Judgement]:
    """The judgements that the counts of a run are those that are known.

    laboratory: no judgement is made of another engine than `of`, whose numbers they are. cost: of the run. known:
    counts by the names of `Cost`.
    """
    if laboratory.engine != of:
        return []
    return [alike(name, counted(cost, name), expected) for name, expected in known.items()]


def alike(name: str, count: float, expected: float) -> Judgement:
    """The judgement that a count of `refimpl` is within 5 % of that of a run that was looked at.

    name: of what is counted. expected: the known count of the same scene.
    """
    return bounded(
        f"{name}: share by which it differs from {expected:g}", abs(count / expected - 1), _SAME, _WHY_STORED
    )


#: Evaluations at the start and in a step, of schemes of `refimpl` that do not have one each.
_EVALUATIONS = {
    "euler": (0, 1),
    "modified_euler": (0, 1),
    "symplectic_euler": (0, 1),
    "euler_pc": (0, 2),
    "beeman": (2, 1),
    "beeman_pc": (2, 1),
}


def evaluations_of(scheme: str) -> tuple[int, int]:
    """Evaluations of the force at the start, and in each step, of a scheme of `refimpl`; scheme: its name."""
    return _EVALUATIONS.get(scheme, (1, 1))
