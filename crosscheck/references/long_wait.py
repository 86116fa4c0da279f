"""A particle that creeps to a wall for a long time, and then flies to and fro: its place at any time, exactly.

The wall at 0 moves with the velocity V into the room at every impact, but stays in place, and is elastic: the speed u
towards it becomes 2 V + u. The wall at the other end, at a distance `room`, is at rest: u becomes a u. Computed in
rational numbers: a clock of 1e12 has no rounding here.

Derivation: the frame of the wall, in which the speed is reversed.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import NamedTuple


class Flight(NamedTuple):
    """place: distance from the wall at 0, length. velocity: away from it, length/time. impacts: on either wall."""

    place: Fraction
    velocity: Fraction
    impacts: int


@cache
def driven_flight(place: float, velocity: float, wall: float, room: float, restitution: float, time: float) -> Flight:
    """Where a point particle is at a time.

    place: from the wall at 0, length. velocity: at the start, not 0; negative: towards the wall at 0. wall: V,
    length/time. room: between the walls, length. restitution: a. time: from the start. All are taken without rounding.
    Each flight is computed once: thousands of impacts make long fractions.
    """
    x, v, push, width, a, left = map(Fraction, (place, velocity, wall, room, restitution, time))
    impacts = 0
    while True:
        until = (-x / v) if v < 0 else (width - x) / v
        if until > left:
            return Flight(x + v * left, v, impacts)
        left -= until
        impacts += 1
        x, v = (Fraction(0), 2 * push - v) if v < 0 else (width, -a * v)
