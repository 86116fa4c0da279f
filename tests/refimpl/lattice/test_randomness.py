"""Random bits by counter: the published sequence, and bits that are fair and know nothing of each other.

The seeds are fixed. False-alarm rates are those of other seeds: |z| < 5.5 fails by chance once in 3e7 tests of a z.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from refimpl.lattice.randomness import COLLISION, FORCING, ROW, WALLS, random_word, row_key

LIMIT = 5.5
#: SplitMix64 (Steele, Lea & Flood, OOPSLA 2014) from the state 1234567.
SEED = 1234567
PUBLISHED = (
    6457827717110365317,
    3203168211198807973,
    9817491932198370423,
    4593380528125082431,
    16408922859458223821,
)
words = st.integers(0, 2**64 - 1)


@njit(cache=True)
def compiled_words(key: int, numbers: np.ndarray) -> np.ndarray:
    found = np.empty_like(numbers)
    for i, number in enumerate(numbers):
        found[i] = random_word(key, number)
    return found


@njit(cache=True)
def compiled_key(seed: int, purpose: int, step: int, row: int) -> int:
    return row_key(seed, purpose, step, row)


def keys(seed: int, purpose: np.uint64, steps: object, rows: object) -> np.ndarray:
    """Of all rows at all steps, (steps, rows)."""
    step, row = np.asarray(steps, dtype=np.uint64)[:, None], np.asarray(rows, dtype=np.uint64)
    return row_key(np.array([seed], dtype=np.uint64), np.array([purpose]), step, row)


def bits_of(key: np.ndarray, numbers: object) -> np.ndarray:
    """(..., words, 64)."""
    found = random_word(key[..., None], np.asarray(numbers, dtype=np.uint64))
    return found[..., None] >> np.arange(64, dtype=np.uint64) & np.uint64(1)


def deviations(bits: np.ndarray) -> np.ndarray:
    """z of the number of ones at each place of a word, and, last, of all: independent fair bits are N(0, 1)."""
    ones = bits.reshape(-1, 64).sum(axis=0, dtype=np.int64)
    number = bits.size // 64
    each = (ones - number / 2) / (number / 4) ** 0.5
    return np.append(each, each.sum() / 8)


# -- the sequence --------------------------------------------------------------------------------------------------


def test_the_sequence_is_the_published_one() -> None:
    numbers = np.arange(5, dtype=np.uint64)
    assert tuple(random_word(np.array([SEED], dtype=np.uint64), numbers).tolist()) == PUBLISHED
    assert tuple(compiled_words(np.uint64(SEED), numbers).tolist()) == PUBLISHED


@given(key=words, number=words)
def test_the_sequence_in_python_s_integers(key: int, number: int) -> None:
    z = (key + (number + 1) * 0x9E3779B97F4A7C15) % 2**64
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
    z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
    both = np.array([[key], [number]], dtype=np.uint64)
    assert random_word(*both).tolist() == [z ^ z >> 31]
    assert compiled_words(np.uint64(key), both[1]).tolist() == [z ^ z >> 31]


@given(seed=words, purpose=st.integers(0, 2), step=words, row=words)
def test_keys_of_arrays_and_compiled_ones_are_the_same(seed: int, purpose: int, step: int, row: int) -> None:
    numbers = [np.array([number], dtype=np.uint64) for number in (seed, purpose, step, row)]
    assert row_key(*numbers).tolist() == [compiled_key(*(np.uint64(n) for n in (seed, purpose, step, row)))]


def test_no_two_keys_are_equal() -> None:
    """120 000 of 2^64: by chance, once in 3e9 seeds."""
    found = [keys(1, purpose, range(200), range(200)) for purpose in (COLLISION, FORCING, WALLS)]
    assert np.unique(found).size == 120_000


# -- fairness ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("purpose", [COLLISION, FORCING, WALLS])
def test_bits_are_fair(purpose: np.uint64) -> None:
    bits = bits_of(keys(SEED, purpose, range(64), range(64)), range(16))
    assert np.abs(deviations(bits)).max() < LIMIT


def test_neighbours_in_a_row_are_independent() -> None:
    """Bits up to 128 columns apart agree in half of the cases."""
    rows = bits_of(keys(SEED, COLLISION, range(32), range(64)), range(8)).reshape(2048, 512)
    for lag in range(1, 129):
        differ = rows[:, lag:] != rows[:, :-lag]
        assert abs(2 * differ.mean() - 1) * differ.size**0.5 < LIMIT, lag


#: Purpose, seed, offsets of step and row, and first word: of what is compared with the collisions of SEED.
OTHERS = {
    "next step": (COLLISION, SEED, 1, 0, 0),
    "next row": (COLLISION, SEED, 0, 1, 0),
    "next row of the step before": (COLLISION, SEED, -1, 1, 0),
    "next word": (COLLISION, SEED, 0, 0, 1),
    "next draw": (COLLISION, SEED, 0, 0, ROW),
    "draw after the next": (COLLISION, SEED, 0, 0, 2 * ROW),
    "force": (FORCING, SEED, 0, 0, 0),
    "walls": (WALLS, SEED, 0, 0, 0),
    "force of the step before": (FORCING, SEED, -1, 0, 0),
    "next seed": (COLLISION, SEED + 1, 0, 0, 0),
    "next seed, step before": (COLLISION, SEED + 1, -1, 0, 0),
}


@pytest.mark.parametrize("other", OTHERS)
def test_bits_of_other_places_and_purposes_are_independent(other: str) -> None:
    purpose, seed, later, above, word = OTHERS[other]
    steps, rows, numbers = np.arange(64) + 1, np.arange(64), np.arange(16)
    here = bits_of(keys(SEED, COLLISION, steps, rows), numbers)
    there = bits_of(keys(seed, purpose, steps + later, rows + above), numbers + word)
    assert np.abs(deviations(here ^ there)).max() < LIMIT


def test_steps_and_rows_are_not_exchanged() -> None:
    pairs = [(s, r) for s, r in product(range(128), repeat=2) if s < r]
    step, row = np.array(pairs, dtype=np.uint64).T
    seed, purpose = np.array([SEED], dtype=np.uint64), np.array([COLLISION])
    here, there = (bits_of(row_key(seed, purpose, *both), range(8)) for both in ((step, row), (row, step)))
    assert np.abs(deviations(here ^ there)).max() < LIMIT
