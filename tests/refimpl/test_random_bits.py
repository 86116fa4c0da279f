"""SplitMix64 against its published sequence, in numpy and compiled; its bits: lattice/test_randomness.py."""

from __future__ import annotations

import numpy as np
from numba import njit

from refimpl.random_bits import GAMMA, mix64

SEED = 1234567
#: The sequence from this state (Steele, Lea & Flood, OOPSLA 2014).
PUBLISHED = [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431, 16408922859458223821]


@njit
def compiled(z: np.uint64) -> np.uint64:
    return mix64(z)


def test_the_published_sequence() -> None:
    states = np.uint64(SEED) + np.arange(1, 6, dtype=np.uint64) * GAMMA
    assert mix64(states).tolist() == PUBLISHED
    assert [int(compiled(state)) for state in states] == PUBLISHED
