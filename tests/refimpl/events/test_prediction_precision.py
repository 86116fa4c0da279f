"""Closed forms of the prediction against arithmetic of 50 digits, from nearby and from far, in any units.

A found time is judged by the exact path: until then it has not passed a surface, and then it is at one; both but for a
few roundings of the distances in the formula. So a time may be uncertain (grazing), a place never.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from refimpl.events.model import Well
from refimpl.events.prediction import (
    NEVER,
    TOUCH,
    approach,
    discriminant,
    falling_time,
    leaving_time,
    oscillating_time,
    pair_time,
    separation,
    squared_moment,
)
from refimpl.events.state import NEAR

EPS = 2.0**-52
MANY = settings(max_examples=400)
DIGITS = 50


def power_of_ten(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda power: 10.0**power)


def sign() -> st.SearchStrategy[float]:
    return st.sampled_from([-1.0, 1.0])


# -- pairs ----------------------------------------------------------------------------------------


def distances(r: np.ndarray, v: np.ndarray, until: float) -> tuple[Any, Any, Any]:
    """Least and largest distance of the straight path until then (NEVER: for ever), and the distance then."""
    x, u = [mpf(float(k)) for k in r], [mpf(float(k)) for k in v]
    b, w = sum(p * q for p, q in zip(x, u, strict=True)), sum(q * q for q in u)

    def at(t: Any) -> Any:
        return mp.sqrt(sum((p + q * t) ** 2 for p, q in zip(x, u, strict=True)))

    turn = max(-b / w, mpf(0)) if w > 0 else mpf(0)
    if until == NEVER:
        return at(turn), mp.inf if w > 0 else at(0), mpf(0)
    end = mpf(float(until))
    return at(min(turn, end)), max(at(0), at(end)), at(end)


def found(well: Well | None, bound: bool, r: np.ndarray, v: np.ndarray, s: float) -> float:
    """The time that the algorithms would find, from the same terms as they form them."""
    b, w, c = float(r @ v), float(v @ v), float(r @ r) - s * s
    bonds = np.array([[1, 1], [1, 0]], np.int32) if bound else np.zeros((2, 2), np.int32)
    return float(pair_time(well, bonds, 0, 1, b, c, w, s * s, squared_moment(*r, *v), NEAR))


def aimed(distance: float, aim: float, turn: float, tilt: float) -> tuple[np.ndarray, np.ndarray]:
    """A place and a direction of flight, in any orientation; aim: impact parameter."""
    along = -math.sqrt(max(distance**2 - aim**2, 0.0))
    ca, sa, cb, sb = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    first, second = np.array([ca * cb, sa * cb, sb]), np.array([-sa, ca, 0.0])
    return along * first + aim * second, first


#: Impact parameters from head-on to a miss, most of them grazing, in contact distances.
aims = st.one_of(
    st.floats(0, 2), st.builds(lambda k, side: 1 + side * 10.0**-k, st.floats(1, 15), sign()), st.just(1.0)
)


@MANY
@given(
    gap=power_of_ten(-12, 9), aim=aims, turn=st.floats(0, 6.3), tilt=st.floats(-1.5, 1.5), size=power_of_ten(-30, 30),
    speed=power_of_ten(-20, 20), back=st.booleans(),
)  # fmt: skip
@example(gap=1e6, aim=1 - 1e-5, turn=0.3, tilt=0.2, size=1.0, speed=1.0, back=False)
@example(gap=1e6, aim=1 + 1e-5, turn=0.3, tilt=0.2, size=1.0, speed=1.0, back=False)
@example(gap=1.999, aim=0.999999, turn=0.0, tilt=0.0, size=1.0, speed=1.0, back=False)
def test_hard_pairs(gap: float, aim: float, turn: float, tilt: float, size: float, speed: float, back: bool) -> None:
    assume(aim <= 1 + gap)
    r, direction = aimed(1 + gap, aim, turn, tilt)
    r, v = size * r, speed * (-direction if back else direction)
    with mp.workdps(DIGITS):
        near = 16 * EPS * size * (1 + gap)
        s = found(None, False, r, v, size)
        least, _, at = distances(r, v, s)
        assert least >= size - near
        assert s == NEVER or abs(at - size) <= near
        # where the whole path stays away by more than rounding, it is a miss; where it does not, a hit
        closest = distances(r, v, NEVER)[0]
        if s != NEVER:
            assert closest <= size + near


@MANY
@given(
    distance=st.one_of(st.floats(0, 1).map(lambda x: 1 + x), power_of_ten(0, 8)), aim=aims,
    turn=st.floats(0, 6.3), tilt=st.floats(-1.5, 1.5), width=st.one_of(st.floats(1.01, 2), power_of_ten(0.01, 4)),
    size=power_of_ten(-30, 30), speed=power_of_ten(-20, 20), edge=st.booleans(), back=st.booleans(),
)  # fmt: skip
def test_wells(
    distance: float, aim: float, turn: float, tilt: float, width: float, size: float, speed: float, edge: bool,
    back: bool,
) -> None:  # fmt: skip
    """Core and edge, from within and from without; `edge`: the impact parameter is one of the edge."""
    aim = aim * width if edge else aim
    assume(distance >= 1)
    assume(aim <= distance)
    assume(abs(distance**2 - width**2) > 2 * NEAR)  # nearer than that, the bond decides
    r, direction = aimed(distance, aim, turn, tilt)
    r, v = size * r, speed * (-direction if back else direction)
    outer = size * width
    inside = distance < width
    with mp.workdps(DIGITS):
        near = 16 * EPS * size * max(distance, width)
        s = found(Well(1.0, width), inside, r, v, size)
        least, largest, at = distances(r, v, s)
        if inside:
            assert s < NEVER
            assert least >= size - near
            assert largest <= outer + near
            assert min(abs(at - size), abs(at - outer)) <= near
        else:
            assert least >= outer - near
            assert s == NEVER or abs(at - outer) <= near


@MANY
@given(b=power_of_ten(-20, 20), c=power_of_ten(-20, 20), w=power_of_ten(-20, 20), inwards=st.booleans())
def test_roots_of_the_quadratic(b: float, c: float, w: float, inwards: bool) -> None:
    """`approach` and `separation` to some roundings, where the discriminant is a sum of positive terms or is given."""
    with mp.workdps(DIGITS):
        b = -b if inwards else b
        exact = mpf(b) ** 2 + mpf(w) * mpf(c)
        root = mpf(c) / (mp.sqrt(exact) + mpf(b)) if b > 0 else (mp.sqrt(exact) - mpf(b)) / mpf(w)
        assert abs(separation(b, -c, w, discriminant(b, -c, w, 0.0, math.nan)) - root) <= 8 * EPS * root
        apart = mpf(b) ** 2 - mpf(w) * mpf(c)
        if inwards and apart > 0:
            first = mpf(c) / (mp.sqrt(apart) - mpf(b))
            assert abs(approach(b, c, float(apart)) - first) <= 8 * EPS * first


# -- plane walls ----------------------------------------------------------------------------------


@MANY
@given(
    height=st.one_of(st.just(0.0), power_of_ten(-30, 30)), v=st.one_of(st.just(0.0), power_of_ten(-30, 30)),
    a=st.one_of(st.just(0.0), power_of_ten(-30, 30)), up=sign(), away=sign(), graze=st.one_of(st.none(), aims),
)  # fmt: skip
def test_falling(height: float, v: float, a: float, up: float, away: float, graze: float | None) -> None:
    """Onto a plane; graze: a start that turns near it, under a force away from it."""
    v, a = up * v, away * a
    if graze is not None and a != 0 and v != 0:
        v, a = -abs(v), abs(a)
        height = graze * v * v / (2 * a)
    s = falling_time(height, v, a)
    with mp.workdps(DIGITS):
        h, u, g = mpf(height), mpf(v), mpf(a)

        def at(t: Any) -> Any:
            return h + u * t + g * t * t / 2

        turn = -u / g if a != 0 else mpf(0)
        if s == NEVER:
            lowest = min(h, at(turn)) if a > 0 and turn > 0 else h
            assert a > 0 or (a == 0 and v >= 0)
            assert lowest >= -8 * EPS * h
            return
        t = mpf(s)
        near = 8 * EPS * (h + abs(u) * t + abs(g) * t * t / 2)
        assert abs(at(t)) <= near
        assert min(h, at(t), at(min(turn, t)) if turn > 0 else h) >= -near


@settings(max_examples=60)
@given(
    amplitude=power_of_ten(-6, 0), strength=power_of_ten(-3, 4), angle=st.floats(0, 6.28), height=power_of_ten(-6, 1),
    v=st.floats(-3, 1), a=st.sampled_from([0.0, -1.0, 1.0]),
)  # fmt: skip
def test_oscillating_wall(amplitude: float, strength: float, angle: float, height: float, v: float, a: float) -> None:
    """strength: A omega^2. The exact gap, with steps that pass no root of it, shows whether one was missed."""
    frequency, scale = math.sqrt(strength / amplitude), 10.0
    height += amplitude * math.cos(angle)
    horizon = min(20.0, 60 / frequency)
    s = oscillating_time(height, v, a, amplitude, frequency, angle, horizon, scale)
    with mp.workdps(DIGITS):
        h, u, g, top, omega, start = (mpf(x) for x in (height, v, a, amplitude, frequency, angle))
        end = mpf(min(s, horizon))
        size = h + abs(u) * end + abs(g) * end**2 / 2 + top * (1 + start + omega * end)
        near = TOUCH * (scale + top) + 8 * EPS * size

        def gap(t: Any) -> Any:
            return h + u * t + g * t * t / 2 - top * mp.cos(start + omega * t)

        def slope(t: Any) -> Any:
            return u + g * t + top * omega * mp.sin(start + omega * t)

        if s < NEVER:
            assert abs(gap(mpf(s))) <= 2 * near
        steepest, t = abs(g) + top * omega**2, mpf(0)
        for _ in range(2000):
            room, speed = gap(t) + 3 * near, slope(t)
            assert room > 0, "a contact was missed"
            t += (speed + mp.sqrt(speed**2 + 2 * steepest * room)) / steepest
            if t >= end:
                break
        else:
            raise AssertionError("the search of the test does not end")


# -- circles --------------------------------------------------------------------------------------


@MANY
@given(
    depth=st.one_of(st.just(0.0), power_of_ten(-15, 0)), place=st.floats(0, 6.3), fly=st.floats(0, 6.3),
    fall=st.floats(0, 6.3), radius=power_of_ten(-20, 20), speed=st.one_of(st.just(0.0), power_of_ten(-12, 6)),
    field=st.one_of(st.just(0.0), power_of_ten(-12, 6)),
)  # fmt: skip
def test_circles(
    depth: float, place: float, fly: float, fall: float, radius: float, speed: float, field: float
) -> None:
    """From within, with and without a field; lengths in radii."""
    assume(speed > 0 or field > 0)

    def vector(size: float, angle: float) -> np.ndarray:
        return size * np.array([math.cos(angle), math.sin(angle)])

    r, u, a = vector(radius * (1 - depth), place), vector(radius * speed, fly), vector(radius * field, fall)
    s = leaving_time(r @ r, r @ u, u @ u, r @ a, u @ a, a @ a, radius)
    assert s < NEVER
    with mp.workdps(DIGITS):
        t = mpf(float(s))
        (rx, ry), (ux, uy), (ax, ay) = ([mpf(float(k)) for k in vector] for vector in (r, u, a))

        def away(time: Any) -> Any:
            return mp.hypot(rx + ux * time + ax * time**2 / 2, ry + uy * time + ay * time**2 / 2)

        scale = mp.hypot(rx, ry) + mp.hypot(ux, uy) * t + mp.hypot(ax, ay) * t**2 / 2
        assert scale < 32 * radius  # no cancellation beyond that
        near = 16 * EPS * scale**2 / radius
        assert abs(away(t) - radius) <= near
        # where the distance is stationary, in units of the flight and the radius
        slope = [(rx * ux + ry * uy) * t, (ux * ux + uy * uy + rx * ax + ry * ay) * t**2,
                 (ux * ax + uy * ay) * t**3 * 3 / 2, (ax * ax + ay * ay) * t**4 / 2]  # fmt: skip
        for turn in np.polynomial.Polynomial([float(term / mpf(radius) ** 2) for term in slope]).roots():
            if abs(turn.imag) < 1e-6 and 0 < turn.real < 1:
                assert away(mpf(float(turn.real)) * t) <= radius + near


def test_a_start_beyond_the_circle_is_a_rounding_of_a_start_on_it() -> None:
    assert leaving_time(1 + 4 * EPS, 0.5, 1.0, 0.0, 0.0, 0.0, 1.0) == 0.0
    assert leaving_time(1 + 4 * EPS, -1.0, 1.0, 0.0, 0.0, 0.0, 1.0) == pytest.approx(2.0, rel=8 * EPS)
