"""The same run compiled and as plain Python: what checks compare where an engine promises `interpretable`.

Audits of small scenes run as plain Python. What they find holds for the compiled kernels where both give the same.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Kind, Run
from crosscheck.references import EPSILON
from crosscheck.scene import Method, Scene
from crosscheck.verdict import Judgement, round_off

EQUATION = "x(compiled) = x(interpreted)"
_SAME_BITS = "the same operations in the same order, and none of them fused: not one bit may differ"


def interpretable(needs: Needs) -> Needs:
    """`needs`, and that the engine runs as plain Python too."""
    return replace(needs, promises=(*needs.promises, "interpretable"))


def _both(laboratory: Laboratory, scene: Scene, method: Method | Kind) -> tuple[Run, Run]:
    return (
        laboratory.run(scene, method, interpreted=False),
        laboratory.run(scene, method, interpreted=True),
    )


def same_bits(laboratory: Laboratory, scene: Scene, method: Method | Kind, name: str) -> Judgement:
    """The judgement that every number of a run is the same to the last bit in both modes.

    laboratory, scene, method: as of `Laboratory.run`. name: of the scene, in the quantity's name.
    """
    one, other = _both(laboratory, scene, method)
    counts = {key: int((~_equal(one[key], other[key])).sum()) for key in one}
    differing = [f"{count} of {key}" for key, count in counts.items() if count]
    note = f"they differ in {', '.join(differing)}" if differing else ""
    return round_off(f"{name}: numbers that differ", float(sum(counts.values())), 0.5, _SAME_BITS, note=note)


def same_to_rounding(
    laboratory: Laboratory, scene: Scene, method: Method | Kind, name: str, roundings: float, why: str
) -> Judgement:
    """The judgement that the numbers of a run agree in both modes to some roundings of the largest of their kind.

    laboratory, scene, method: as of `Laboratory.run`. name: of the scene, in the quantity's name. roundings: number of
    them that are allowed, in units of the last place of the largest number. why: the reason for that.
    """
    one, other = _both(laboratory, scene, method)
    apart = {key: float(abs(one[key] - other[key]).max() / abs(one[key]).max()) for key in one if one[key].any()}
    farthest = max(apart, key=lambda key: apart[key])
    return round_off(
        f"{name}: largest relative difference", apart[farthest], roundings * EPSILON, why, note=f"in {farthest}"
    )


def _equal(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Where two arrays have the same numbers, NaN being one; nowhere if their shapes differ."""
    if one.shape != other.shape:
        return np.zeros(max(one.size, 1), dtype=bool)
    return np.asarray((one == other) | (np.isnan(one) & np.isnan(other)))
