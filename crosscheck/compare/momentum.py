"""Whether one of two runs keeps its total momentum and the other does not: forces between particles cannot part them
so.

A kick of one particle that a file's rounding hides in the growth of separations shows here: pairs that feel each other
in one run alone, as at a cutoff, exchange momentum, and keep its sum.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crosscheck.compare.differences import Gap
from crosscheck.compare.growth import EPSILON, Parting

#: Steps between two frames, where the files do not tell it.
_STEPS = 1000.0


def momentum_parting(gaps: Sequence[Gap], steps: Sequence[int] | None, arithmetic: str) -> Parting | None:
    """The first frame at which one run has not kept its momentum, and the other has kept it up to there.

    `expected` is the largest change that rounding explains. gaps: of all pairs of frames. steps: of the frames, or
    None. arithmetic: "double" or "single".
    """
    if any(gap.momentum is None for gap in gaps):
        return None
    sums = np.array([gap.momentum for gap in gaps])  # (K, 2, 3)
    files = np.array([gap.momentum_rounding for gap in gaps])
    scale = np.array([gap.momentum_scale for gap in gaps])
    count = np.arange(len(gaps)) * _STEPS if steps is None else np.asarray(steps, dtype=np.float64) - steps[0]
    allowed = files + files[0] + EPSILON[arithmetic] * scale * np.maximum(count, 1.0)
    changed = np.linalg.norm(sums - sums[0], axis=2) > allowed[:, None]
    one, other = (int(np.argmax(side)) if side.any() else len(gaps) for side in changed.T)
    first = min(one, other)
    if first == max(one, other):
        return None
    return Parting(first, float(allowed[first]))
