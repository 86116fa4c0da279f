"""A run without a break beside the same one in two halves: what checks compare where an engine promises `restarts`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Kind
from crosscheck.references import EPSILON
from crosscheck.scene import Method, Scene
from crosscheck.scene.observables import TABLE
from crosscheck.verdict import Judgement, round_off

EQUATION = "x(t) = x(t - t/2 | x(t/2))"
CRITERION = "not one bit of a state differs; sums over the run to rounding"
_SAME_BITS = "the state that is handed on is all that decides what follows: not one bit may differ"
_OF_SUMS = "two parts of a sum, against the whole: rounding, relative to the largest"
#: Roundings of a sum over a run that is added up in two parts: it has fewer terms than these, each rounded once.
ROUNDINGS = 1000.0


def restarting(needs: Needs) -> Needs:
    """`needs`, and that the engine goes on from where a run ended."""
    return replace(needs, promises=(*needs.promises, "restarts"))


def halves(laboratory: Laboratory, scene: Scene, method: Method | Kind, name: str) -> list[Judgement]:
    """The judgements that states are the same to the last bit after a break, and sums over the run to rounding.

    laboratory, method: as of `Laboratory.run`. scene: its number of samples is odd, so that one is in the middle. name:
    of the scene, in the quantities' names.
    """
    whole = laboratory.run(scene, method)
    first, second = laboratory.run_in_two(scene, method)
    middle = (len(whole["time"]) - 1) // 2
    off, apart = [], {}
    for key in [name for name in whole if name != "time"]:
        sampled = TABLE[key].axes[0] == "sample"
        asked, found_then = whole[key][middle:] if sampled else whole[key], second[key]
        if key.startswith("field_initial_"):  # of the first half, and of the second one what the first has left
            asked = np.stack([asked, first[key.replace("initial", "final")]])
            found_then = np.stack([first[key], found_then])
        if TABLE[key].cumulative:
            total = found_then + (first[key][-1] if sampled else first[key])
            size = float(np.abs(whole[key]).max())
            apart[key] = float(np.abs(total - asked).max()) / (size or 1.0)
        elif not np.array_equal(asked, found_then, equal_nan=True):
            off.append(key)
    found = [
        round_off(
            f"{name}: arrays that differ",
            float(len(off)),
            0.5,
            _SAME_BITS,
            note=f"they are {', '.join(off)}" * bool(off),
        )
    ]
    if apart:
        farthest = max(apart, key=lambda key: apart[key])
        quantity = f"{name}: sums over the run, largest relative difference"
        found.append(round_off(quantity, apart[farthest], ROUNDINGS * EPSILON, _OF_SUMS, note=f"in {farthest}"))
    return found
