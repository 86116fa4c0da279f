"""SplitMix64 against its published sequence, and the avalanche that its authors ask of a finaliser."""

from __future__ import annotations

import random

import pytest

from crosscheck.references.splitmix import GAMMA, mix, phase_velocity, thermal_velocity, uniform

#: From the state 1234567 (Steele, Lea & Flood 2014; the same numbers test the generator of Java and of Rosetta Code).
PUBLISHED = [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431, 16408922859458223821]


def test_the_published_sequence() -> None:
    assert [mix(1234567 + n * GAMMA) for n in range(1, 6)] == PUBLISHED


def test_every_bit_of_the_input_changes_each_bit_of_the_output_half_of_the_time() -> None:
    """Of 400 numbers: 1/2 +- 0.025 each, of 4096 pairs of bits the furthest is within 5.5 standard errors."""
    rng = random.Random(1)
    numbers = [rng.getrandbits(64) for _ in range(400)]
    hashed = [mix(z) for z in numbers]
    for bit in range(64):
        flipped = [a ^ mix(z ^ (1 << bit)) for a, z in zip(hashed, numbers, strict=True)]
        for out in range(64):
            assert abs(sum(one >> out & 1 for one in flipped) / 400 - 0.5) < 5.5 * 0.025, (bit, out)


def test_neighbours_have_other_numbers() -> None:
    found = {uniform(seed, (i, j, k)) for seed in (0, 1) for i in range(4) for j in range(4) for k in range(4)}
    assert len(found) == 128
    assert 0 < min(found) < 0.1 < 0.9 < max(found) < 1


def test_what_walls_draw_is_possible() -> None:
    for hits in range(50):
        normal, *_ = thermal_velocity(5, 1, hits, 1.0)
        assert 0 < normal < 6
        assert thermal_velocity(5, 1, hits, 2.0)[1] == pytest.approx(2 * thermal_velocity(5, 1, hits, 1.0)[1])
        for law in ("uniform", "flux"):
            assert -0.3 < phase_velocity(5, 1, hits, 1.0, -0.3, law) <= 1.0  # type: ignore[arg-type]
