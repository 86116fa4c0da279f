"""A particle between a wall that pushes and one that takes: against a simulation in small steps of its own."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references.long_wait import driven_flight


def test_it_waits_exactly() -> None:
    flight = driven_flight(3.5, -(2.0**-38), 1.0, 7.0, 0.5, 3.5 * 2.0**38 + 0.25)
    assert flight.impacts == 1
    assert flight.velocity == 2 + Fraction(1, 2**38)
    assert flight.place == flight.velocity / 4


@given(share=st.floats(0.05, 0.95), speed=st.floats(0.5, 2.0), restitution=st.floats(0.3, 1.0))
def test_impacts_and_speeds_by_hand(share: float, speed: float, restitution: float) -> None:
    room, wall = 3.0, 0.25
    flight = driven_flight(share * room, speed, wall, room, restitution, 20.0)
    x, v, time, hits = share * room, speed, 0.0, 0
    while True:
        step = (room - x) / v if v > 0 else -x / v
        if time + step > 20.0:
            break
        time += step
        hits += 1
        x, v = (room, -restitution * v) if v > 0 else (0.0, 2 * wall - v)
    assert flight.impacts == hits
    assert abs(float(flight.place) - (x + v * (20.0 - time))) < 1e-11
