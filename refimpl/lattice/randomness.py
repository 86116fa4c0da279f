"""Random bits by counter: the bit of any site, at any step, for any purpose, without a history.

The word of 64 sites is mix64(key + (number + 1) gamma): element `number` of the SplitMix64 sequence (Steele, Lea &
Flood, OOPSLA 2014) that starts at key; the key is mixed from seed, purpose, step and row. So neither the order of the
sites nor the number of threads matters, and all evolvers draw the same bits. The functions run on uint64 scalars, on
numpy arrays of them, and, compiled, on the wide words of `kernels.words`: one text for all.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import register_jitable

_U = np.uint64
_GAMMA, _FIRST, _SECOND = _U(0x9E3779B97F4A7C15), _U(0xBF58476D1CE4E5B9), _U(0x94D049BB133111EB)
_S30, _S27, _S31 = _U(30), _U(27), _U(31)

#: What random words are for.
COLLISION, FORCING, WALLS = _U(0), _U(1), _U(2)
#: Words of one purpose in a row at a step: draw j of the word w of a row is number j * ROW + w.
ROW = 1 << 32
#: Binary digits of a probability.
DIGITS = 24


@register_jitable(forceinline=True)
def mix64(z: Any) -> Any:
    """The finaliser of SplitMix64."""
    z = (z ^ (z >> _S30)) * _FIRST
    z = (z ^ (z >> _S27)) * _SECOND
    return z ^ (z >> _S31)


@register_jitable(forceinline=True)
def row_key(seed: Any, purpose: Any, step: Any, row: Any) -> Any:
    """The key of a row at a step."""
    key = mix64(seed + _GAMMA)
    key = mix64(key + purpose * _GAMMA)
    key = mix64(key + step * _GAMMA)
    return mix64(key + (row + _U(1)) * _GAMMA)


@register_jitable(forceinline=True)
def random_word(key: Any, number: Any) -> Any:
    """Word `number` of the sequence of this key."""
    return mix64((number + _U(1)) * _GAMMA + key)
