"""Random bits by counter: the bit of any site, at any step, for any purpose, without a history.

The word of 64 sites is mix64(key + (number + 1) GAMMA): element `number` of the SplitMix64 sequence that starts at key
(refimpl.random_bits); the key is mixed from seed, purpose, step and row. So neither the order of the sites nor the
number of threads matters, and all evolvers draw the same bits. The functions run on uint64 scalars, on numpy arrays of
them, and, compiled, on the wide words of `kernels.words`: one text for all.

Literature: G. L. Steele, D. Lea and C. H. Flood, OOPSLA 2014, ACM SIGPLAN Notices 49 (10), 453 (2014).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import register_jitable

from refimpl.random_bits import GAMMA, mix64

#: What random words are for.
COLLISION, FORCING, WALLS = np.uint64(0), np.uint64(1), np.uint64(2)
#: Words of one purpose in a row at a step: draw j of the word w of a row is number j * ROW + w.
ROW = 1 << 32
#: Binary digits of a probability.
DIGITS = 24
_ONE = np.uint64(1)


@register_jitable(forceinline=True)
def row_key(seed: Any, purpose: Any, step: Any, row: Any) -> Any:
    """The key of the random words of a row at a step.

    seed: of the run. purpose: COLLISION, FORCING or WALLS. step: number of the time step. row: number of the row. All
    uint64, scalars or arrays that can be broadcast; the key has their common shape.
    """
    key = mix64(seed + GAMMA)
    key = mix64(key + purpose * GAMMA)
    key = mix64(key + step * GAMMA)
    return mix64(key + (row + _ONE) * GAMMA)


@register_jitable(forceinline=True)
def random_word(key: Any, number: Any) -> Any:
    """Word `number` of the SplitMix64 sequence that starts at `key`: 64 random bits.

    key: of `row_key`, uint64. number: draw * ROW + word of the row, uint64; scalars, arrays, or wide words in a kernel.
    """
    return mix64((number + _ONE) * GAMMA + key)
