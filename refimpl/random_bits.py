"""SplitMix64: random bits as a hash of numbers, for kernels and arrays alike.

A hash needs no history: the random number of a collision or of a lattice site depends on what it is for alone, not on
the order in which numbers are drawn.

Literature: G. L. Steele, D. Lea and C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014, ACM
SIGPLAN Notices 49 (10), 453 (2014).
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numba.extending import register_jitable

#: uint64 scalars, arrays of them, or in a kernel the wide words of `refimpl.lattice.kernels.words`.
Words = TypeVar("Words")

#: The increment of the sequence: 2^64 over the golden ratio, to the next odd number.
GAMMA = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_S27, _S30, _S31 = np.uint64(27), np.uint64(30), np.uint64(31)


@register_jitable(forceinline=True)
def mix64(z: Words) -> Words:
    """The finaliser of SplitMix64: a bijection of 64 bits, in which every bit of `z` moves about half of the others.

    z: uint64, one or many (numpy arrays; wide words in a kernel). Element n of the sequence that starts at s is
    mix64(s + (n + 1) GAMMA).
    """
    z = (z ^ (z >> _S30)) * _FIRST  # type: ignore[operator]
    z = (z ^ (z >> _S27)) * _SECOND  # type: ignore[operator]
    return z ^ (z >> _S31)  # type: ignore[operator]
