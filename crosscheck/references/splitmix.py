"""Random numbers as SplitMix64 draws them (Steele, Lea and Flood 2014), and what walls make of them, in integers.

The number of a draw is a hash of what it is for, so anybody can compute it again: the seed, the particle, the number of
its hits on walls before, and the number of the draw at this hit, each taken up by one step of the sequence,

    z = mix(seed + (particle + 1) G),  z = mix(z + (hits + 1) G),  z = mix(z + (draw + 1) G),  G = 0x9E3779B97F4A7C15,

modulo 2^64; u = (floor(z/2^11) + 1/2)/2^53 is uniform in (0, 1).

Literature: G. L. Steele, D. Lea and C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014, ACM
SIGPLAN Notices 49 (10), 453 (2014): `mix` is its variant 13 of D. Stafford's finalisers of MurmurHash3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

GAMMA = 0x9E3779B97F4A7C15
#: Right shifts, and the factors after the first two of them.
_SHIFTS, _FACTORS = (30, 27, 31), (0xBF58476D1CE4E5B9, 0x94D049BB133111EB, 1)
_WORDS = 2**64


def mix(z: int) -> int:
    """The finaliser of SplitMix64, a bijection of the numbers below 2^64.

    z: any whole number, taken modulo 2^64.
    """
    z %= _WORDS
    for shift, factor in zip(_SHIFTS, _FACTORS, strict=True):
        z = (z ^ (z // 2**shift)) * factor % _WORDS
    return z


def uniform(seed: int, numbers: Sequence[int]) -> float:
    """The uniform number in (0, 1) of a seed and of the numbers that say what it is for, each 0 or more."""
    z = seed
    for number in numbers:
        z = mix(z + (number + 1) * GAMMA)
    return (z // 2**11 + 0.5) / 2.0**53


def thermal_velocity(seed: int, particle: int, hits: int, width: float) -> tuple[float, float, float]:
    """Velocity that a thermal wall gives: into the box, and along the two axes that follow its own, in cyclic order.

    In the plane the first of the two is that along the wall. Draws 0 and 1 give the sizes, 2 the direction.

    seed: of the scene. particle: its number. hits: of the particle on walls before. width: sqrt(T/m).
    """
    one, other, turn = (uniform(seed, (particle, hits, draw)) for draw in range(3))
    along = width * math.sqrt(-2 * math.log(other))
    angle = 2 * math.pi * turn
    return width * math.sqrt(-2 * math.log(one)), along * math.cos(angle), along * math.sin(angle)


def phase_velocity(
    seed: int, particle: int, hits: int, speed: float, incoming: float, law: Literal["uniform", "flux"]
) -> float:
    """Velocity V = V0 cos(2 pi u) of a wall of random phase, into the box: of the first pair of draws that is accepted.

    Accepted is V > v, with the law "flux" only if the second number of the pair is below (V - v)/(V0 - v).

    seed, particle, hits: as in `thermal_velocity`. speed: V0 > 0. incoming: v < 0, of the particle. law: of the phase.
    """
    draw = 0
    while True:
        own = speed * math.cos(2 * math.pi * uniform(seed, (particle, hits, draw)))
        chance = uniform(seed, (particle, hits, draw + 1))
        if own > incoming and (law == "uniform" or chance * (speed - incoming) < own - incoming):
            return own
        draw += 2
