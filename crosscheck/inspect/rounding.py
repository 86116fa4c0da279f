"""How far rounding may move a sum over particles: that of the file, and that of the run.

Literature: W. Hoeffding, J. Am. Stat. Assoc. 58, 13 (1963).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement, within

#: Probability that rounding moves one sum further than the bound.
_EXCEEDED = 1e-9
_FACTOR = math.sqrt(2 * math.log(2 / _EXCEEDED))


def bound_of_sum(*largest: Any) -> Any:
    """What a sum of independent errors without bias exceeds with the probability 1e-9 at most: 6.5 (sum r^2)^(1/2).

    largest: the largest |error| r of each term, arrays of one shape along all axes but the first, along which terms are
    summed; all of them together. By Hoeffding's inequality, whatever the distribution of the errors.
    """
    return _FACTOR * np.sqrt(sum(np.sum(np.square(one), axis=0) for one in largest))


def furthest(quantity: str, change: Floats, allowed: Floats, size: float, why: str) -> Judgement:
    """The judgement of the frame whose change is the largest share of what rounding allows.

    quantity: what changes, over what. change: of each frame from the first, (F,). allowed: by rounding, (F,). size:
    what both are divided by. why: the reason of the bound.
    """
    at = int(np.argmax(np.abs(change) / np.where(allowed > 0, allowed, 1.0)))
    return within(
        "round_off",
        quantity,
        float(change[at]) / size,
        0.0,
        float(allowed[at]) / size or 1.0,
        why,
        note=f"in frame {at} (counted from 0)" if at else "",
    )
