"""Times of events against dense scans, exact arithmetic and polynomial roots: none missed, none early."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from refimpl.events.model import Well
from refimpl.events.prediction import (
    FAR,
    NEVER,
    TOUCH,
    falling_time,
    leaving_time,
    oscillating_time,
    pair_time,
    rests,
    wrapped,
)
from refimpl.events.state import NEAR

EPS = 2.0**-52
MANY = settings(max_examples=1000)
speeds = st.floats(-1e3, 1e3, allow_subnormal=False).map(lambda v: v if abs(v) > 1e-6 else 0.0)
heights = st.floats(0, 1e3, allow_subnormal=False).map(lambda h: h if h > 1e-9 else 0.0)


# -- walls that stay ------------------------------------------------------------------------------


@MANY
@given(height=heights, v=speeds, a=speeds)
@example(height=0.0, v=1.0, a=-1.0)
@example(height=0.0, v=-1.0, a=1.0)
@example(height=0.0, v=0.0, a=-1.0)
@example(height=0.0, v=0.0, a=1.0)
@example(height=2.0, v=-2.0, a=1.0)  # grazing
def test_falling_time_is_the_first_root(height: float, v: float, a: float) -> None:
    s = falling_time(height, v, a)
    h, u, g = Fraction(height), Fraction(v), Fraction(a)
    assert s >= 0
    if s == NEVER:
        # no root on the way down; where the turn grazes the wall, rounding decides
        square = u * u - 2 * g * h
        assert (v >= 0 and a >= 0) or (a > 0 and square < EPS * (u * u + 2 * g * h))
        return
    time = Fraction(s)

    def gap(t: Fraction) -> Fraction:
        return h + u * t + g * t * t / 2

    rounding = 8 * EPS * (height + abs(v) * s + abs(a) * s * s / 2)
    assert abs(gap(time)) <= rounding
    assert u + g * time <= math.sqrt(8 * EPS) * (abs(v) + abs(a) * s)  # on its way down, or grazing
    # a parabola from h >= 0 that is first below 0 on its way down has its minimum on [0, s] at an end or at the turn
    if a > 0 and 0 < -u / g < time:
        assert gap(-u / g) >= -rounding


def test_a_height_below_zero_is_a_rounding_of_zero() -> None:
    assert falling_time(-1e-17, -1.0, 0.0) == falling_time(-1e-17, -1.0, -1.0) == falling_time(-1e-17, -1.0, 1.0) == 0.0
    assert falling_time(-1e-17, 1.0, -1.0) == 2.0
    assert falling_time(-1e-17, 1.0, 0.0) == falling_time(-1e-17, 1.0, 1.0) == NEVER


# -- a wall that oscillates -----------------------------------------------------------------------


def gap_and_speed(s: np.ndarray, height: float, v: float, a: float, wall: tuple[float, float, float]) -> np.ndarray:
    amplitude, frequency, angle = wall
    phase = angle + frequency * s
    return np.stack([
        height + s * (v + 0.5 * a * s) - amplitude * np.cos(phase),
        v + a * s + amplitude * frequency * np.sin(phase),
    ])  # fmt: skip


def check_first_contact(
    height: float, v: float, a: float, wall: tuple[float, float, float], horizon: float, samples: int = 20000
) -> float:
    """The time found, after a dense scan: no contact before it, and contact at it."""
    amplitude, frequency, angle = wall
    scale = 10.0
    s = oscillating_time(height, v, a, amplitude, frequency, angle, horizon, scale)
    assert s == NEVER or s >= 0
    times = np.linspace(0.0, min(s, horizon), samples)
    # the terms of the gap are rounded on top of the coordinates, and so is the phase
    size = height + abs(v) * times[-1] + 0.5 * abs(a) * times[-1] ** 2 + amplitude * (1 + angle + frequency * times[-1])
    touch = TOUCH * (scale + amplitude) + 4 * EPS * size
    gap, _ = gap_and_speed(times, height, v, a, wall)
    assert gap.min() >= -touch
    if s < NEVER:
        at, speed = gap_and_speed(np.array(s), height, v, a, wall)
        assert abs(at) <= 2 * touch
        assert speed <= 4 * EPS * (abs(v) + abs(a) * s + amplitude * frequency * (1 + angle + frequency * s))
    return float(s)


@settings(max_examples=300)
@given(
    strength=st.floats(-1, 2).map(lambda power: 10**power),
    frequency=st.floats(1, 100),
    angle=st.floats(0, 2 * math.pi),
    height=st.floats(0, 3),
    v=st.floats(-2, 2),
)
def test_oscillating_floor_under_gravity(
    strength: float, frequency: float, angle: float, height: float, v: float
) -> None:
    """strength: A omega^2/g."""
    amplitude = strength / frequency**2
    assume(amplitude < 3)
    height += amplitude * math.cos(angle)
    s = check_first_contact(height, v, -1.0, (amplitude, frequency, angle), horizon=50.0)
    assert s < NEVER  # what falls comes down


@settings(max_examples=300)
@given(
    a=st.sampled_from([0.0, 1.0]),
    frequency=st.floats(1, 30),
    angle=st.floats(0, 2 * math.pi),
    height=st.floats(0, 3),
    v=st.floats(-2, 2),
    amplitude=st.floats(1e-3, 1),
)
def test_oscillating_wall_without_a_force_or_with_one_away_from_it(
    a: float, frequency: float, angle: float, height: float, v: float, amplitude: float
) -> None:
    height += amplitude * math.cos(angle)
    check_first_contact(height, v, a, (amplitude, frequency, angle), horizon=5.0)


@pytest.mark.parametrize("angle", np.linspace(0, 2 * math.pi, 9))
def test_start_on_the_wall(angle: float) -> None:
    """Faster than the wall it flies; slower it hits at once."""
    amplitude, frequency = 0.1, 10.0  # A omega^2 = 10 g
    height, own = amplitude * math.cos(angle), -amplitude * frequency * math.sin(angle)
    for v in (0.3, 1e-3, 1e-6):
        s = check_first_contact(height, own + v, -1.0, (amplitude, frequency, angle), 50.0)
        # not before gap = v s - |gap''| s^2/2 can return to 0
        assert s >= 2 * v / (1 + amplitude * frequency**2) * (1 - 1e-6)
    assert oscillating_time(height, own - 1e-3, -1.0, amplitude, frequency, angle, 50.0, 10.0) == 0.0


def test_a_grain_at_rest_on_the_floor() -> None:
    # A omega^2 = 0.4 g presses it always; 10 g leaves it behind at the top, and meets it again within a period
    assert oscillating_time(0.1, 0.0, -1.0, 0.1, 2.0, 0.0, 50.0, 10.0) == 0.0
    assert 0.1 < check_first_contact(0.1, 0.0, -1.0, (0.1, 10.0, 0.0), 50.0) < 2 * math.pi / 10
    # at the lowest place sin(pi) is not 0: the grain leaves by a rounding, and has not moved when it is back
    assert oscillating_time(-0.1, 0.0, -1.0, 0.1, 10.0, math.pi, 50.0, 10.0) < math.sqrt(TOUCH)


@pytest.mark.parametrize("excess", [1e-3, 1e-6, 1e-9, -1e-9, -1e-6, -1e-3])
def test_grazing_the_top_of_the_wall(excess: float) -> None:
    """A force away from the wall turns the particle at height A + excess, just when the wall is at its top."""
    amplitude, frequency, away = 0.1, 6.0, 2.0
    turn = 2 * math.pi / frequency
    v = -away * turn
    height = amplitude + excess + 0.5 * away * turn**2
    s = check_first_contact(height, v, away, (amplitude, frequency, 0.0), 10.0, samples=200001)
    if excess > 0:
        assert s == NEVER
    else:
        # gap ~ excess + (away + A omega^2) (s - turn)^2/2
        early = math.sqrt(-2 * excess / (away + amplitude * frequency**2))
        assert s == pytest.approx(turn - early, abs=early**2 + 1e-6 * early)


def test_beyond_the_horizon_is_never() -> None:
    s = oscillating_time(1.0, 0.0, -1.0, 0.01, 10.0, 0.3, 50.0, 10.0)
    assert oscillating_time(1.0, 0.0, -1.0, 0.01, 10.0, 0.3, 0.9 * s, 10.0) == NEVER
    assert oscillating_time(1.0, 1.0, 0.0, 0.01, 10.0, 0.3, 50.0, 10.0) == NEVER


@pytest.mark.parametrize("a", [0.0, 1.0, -1e-12])
def test_what_flies_away_from_an_oscillating_wall(a: float) -> None:
    """No search up to the horizon, where nothing else ends the flight."""
    s = oscillating_time(0.0, 5.0, a, 0.1, 10.0, 1.5, NEVER, 10.0)
    assert s == (pytest.approx(10 / 1e-12, rel=1e-6) if a < 0 else NEVER)


# -- the circle -----------------------------------------------------------------------------------


def leaving(r: np.ndarray, u: np.ndarray, a: np.ndarray, radius: float) -> float:
    return leaving_time(r @ r, r @ u, u @ u, r @ a, u @ a, a @ a, radius)


@MANY
@given(seed=st.integers(0, 2**32), field=st.floats(-3, 2), speed=st.floats(-3, 1), depth=st.floats(-9, 0))
def test_leaving_a_circle_in_a_field(seed: int, field: float, speed: float, depth: float) -> None:
    """The smallest positive root of the quartic, where it is simple."""
    rng = np.random.default_rng(seed)
    radius = 2.0
    r, u, a = rng.normal(size=(3, 2))
    r *= radius * (1 - 10**depth) / np.hypot(*r)
    u, a = u * 10**speed, a * 10**field
    s = leaving(r, u, a, radius)
    # |r + u s + a s^2/2|^2 - R^2, with roots in units in which its coefficients are alike
    quartic = np.array([0.25 * a @ a, u @ a, u @ u + r @ a, 2 * r @ u, r @ r - radius**2])
    assert 0 <= s < NEVER
    scale = np.abs(quartic) @ [s**4, s**3, s**2, s, 1]
    assert abs(np.polyval(quartic, s)) <= 64 * EPS * (scale + radius**2)
    roots = np.roots(quartic)
    # a double root has an imaginary part of the square root of rounding
    real = np.sort(roots.real[(abs(roots.imag) < 1e-6 * abs(roots)) & (roots.real > 1e-6 * s)])
    slopes = np.polyval(np.polyder(quartic), real)
    simple = np.abs(slopes) * real > 1e-5 * np.array([np.abs(quartic) @ [t**4, t**3, t**2, t, 1] for t in real])
    outwards = real[simple & (slopes > 0)]
    if real[simple].size and simple.all():
        assert s == pytest.approx(outwards[0], rel=1e-9)


@MANY
@given(seed=st.integers(0, 2**32), depth=st.floats(-14, 0))
def test_leaving_a_circle_on_a_straight_line(seed: int, depth: float) -> None:
    rng = np.random.default_rng(seed)
    r, u = rng.normal(size=(2, 2))
    r *= 2.0 * (1 - 10**depth) / np.hypot(*r)
    s = leaving(r, u, np.zeros(2), 2.0)
    assert s > 0 or abs(r @ r - 4) < 8 * EPS
    assert np.hypot(*(r + u * s)) == pytest.approx(2.0, rel=8 * EPS)
    assert (r + u * s) @ u > -1e-7


def test_on_the_circle() -> None:
    out, still, field = np.array([1.0, 0.0]), np.zeros(2), np.array([0.0, -1.0])
    at = np.array([2.0, 0.0])
    assert leaving(at, out, still, 2.0) == leaving(at, out, field, 2.0) == 0.0
    assert leaving(at, -out, still, 2.0) == 4.0
    assert leaving(at, still, still, 2.0) == NEVER
    # thrown up at the bottom of the circle it comes back
    assert leaving(np.array([0.0, -2.0]), np.array([0.0, 1.0]), field, 2.0) == pytest.approx(2.0, rel=8 * EPS)
    # dropped from its middle
    assert leaving(still, still, field, 2.0) == pytest.approx(2.0, rel=8 * EPS)


# -- pairs ----------------------------------------------------------------------------------------


def exact_root(b: float, c: float, w: float) -> tuple[Decimal, Fraction]:
    """First root of w t^2 + 2 b t + c, and the discriminant."""
    disc = Fraction(b) ** 2 - Fraction(w) * Fraction(c)
    with localcontext(prec=80):
        numerator = Decimal(disc.numerator) / Decimal(disc.denominator)
        return Decimal(c) / (numerator.sqrt() - Decimal(b)), disc


def bare_pair_time(b: float, c: float, w: float) -> float:
    """Of two hard spheres that are near each other."""
    assert c < FAR
    return float(pair_time(None, None, 0, 1, b, c, w, 1.0, math.nan, NEAR))


@MANY
@given(
    gap=st.floats(-12, 0.3).map(lambda power: 10**power),
    aim=st.floats(0, 1).map(lambda x: 1 - 10 ** (-15 * x)),
    speed=st.floats(-9, 3).map(lambda power: 10**power),
)
@example(gap=1e-12, aim=0.0, speed=1e-9)
def test_pair_time_is_the_exact_root_to_rounding(gap: float, aim: float, speed: float) -> None:
    """Touching, grazing (impact parameter `aim` close to 1), nearly equal velocities; `_precision` has far ones."""
    r = 1.0 + gap
    c, w = gap * (2.0 + gap), speed * speed
    b = -speed * math.sqrt(max(r * r - aim * aim, 0.0))
    root, disc = exact_root(b, c, w) if Fraction(b) ** 2 > Fraction(w) * Fraction(c) else (Decimal(0), Fraction(0))
    assume(disc > Fraction(b) ** 2 * Fraction(4 * EPS))  # else whether they meet is in the rounding
    s = bare_pair_time(b, c, w)
    # of the discriminant b^2 - w c the roundings of two terms, and then of the root
    relative = 4 * EPS + EPS * float(Fraction(b) ** 2 / disc)
    assert abs(Decimal(s) - root) <= Decimal(relative) * root


def test_a_pair_that_rounding_let_overlap_meets_now() -> None:
    assert bare_pair_time(-1.0, -1e-16, 1.0) == 0.0


bonds_both = np.array([[1, 1], [1, 0]], np.int32)
bonds_none = np.zeros((2, 2), np.int32)


@pytest.mark.parametrize("bound", [True, False])
@pytest.mark.parametrize("nudge", [-1e-12, 0.0, 1e-12])
@pytest.mark.parametrize("outwards", [True, False])
def test_well_edge_belongs_to_the_bond_where_rounding_cannot_tell(bound: bool, nudge: float, outwards: bool) -> None:
    well = Well(1.0, 1.5)
    bonds = bonds_both if bound else bonds_none
    distance = 1.5 + nudge
    b, c, w = (1 if outwards else -1) * distance, distance**2 - 1, 1.0
    s = pair_time(well, bonds, 0, 1, b, c, w, 1.0, (c + 1.0) * w - b * b, NEAR)
    if bound and outwards:
        assert s == pytest.approx(max(-nudge, 0), abs=8 * EPS)
    elif bound:
        assert s == pytest.approx(0.5 + nudge, rel=8 * EPS)  # the core
    elif outwards:
        assert s == NEVER
    else:
        assert s == pytest.approx(max(nudge, 0), abs=8 * EPS)


@MANY
@given(distance=st.floats(1, 5), angle=st.floats(0, math.pi), speed=st.floats(-6, 3).map(lambda power: 10**power))
def test_well_events_against_geometry(distance: float, angle: float, speed: float) -> None:
    """Core, edge from within, edge from without: the first of the circles that the straight path meets."""
    well, edge = Well(1.0, 1.5), 1.5
    assume(abs(distance - edge) > 1e-6)
    r, v = np.array([distance, 0.0]), speed * np.array([-math.cos(angle), math.sin(angle)])
    b, w = r @ v, v @ v
    s = pair_time(
        well, bonds_both if distance < edge else bonds_none, 0, 1, b, r @ r - 1, w, 1.0, (r[0] * v[1]) ** 2, NEAR
    )
    nearest_time, aim = max(-b / w, 0.0), distance * math.sin(angle)
    nearest = aim if b < 0 else distance
    assume(abs(nearest - 1) > 1e-6)
    assume(abs(nearest - edge) > 1e-6)
    if distance > edge and nearest > edge:
        assert s == NEVER
        return
    radius = edge if distance > edge or nearest > 1 else 1.0
    # the path's time within `radius` of its nearest point; grazing by 1e-6 costs half of the digits
    half = math.sqrt(radius**2 - aim**2) / speed
    expected = nearest_time + half if distance < edge and radius == edge and b < 0 else None
    if expected is None:
        expected = -b / w - half if b < 0 else -b / w + half
    assert s == pytest.approx(expected, rel=1e-9, abs=1e-9 / speed)


def test_wells_of_pairs_at_rest() -> None:
    well = Well(1.0, 1.5)
    assert pair_time(well, bonds_both, 0, 1, 0.0, 0.5, 0.0, 1.0, 0.0, NEAR) == NEVER
    assert pair_time(well, bonds_none, 0, 1, 0.0, 2.0, 0.0, 1.0, 0.0, NEAR) == NEVER


@pytest.mark.parametrize(("approach", "resting"), [(0.0, True), (1e-17, True), (1e-13, False), (1.0, False)])
def test_an_approach_below_rounding_is_rest(approach: float, resting: bool) -> None:
    rows = np.zeros((2, 8))
    rows[:, 3:5] = [[1.0, 2.0], [1.0 - approach, 2.0]]
    assert rests(rows, 0, 1, -approach, 1.0) == resting


@given(st.floats(-9.99, 9.99))
def test_nearest_image(x: float) -> None:
    assert wrapped(x, 10.0, False) == x
    image = wrapped(x, 10.0, True)
    assert abs(image) <= 5.0
    assert (image - x) in (-10.0, 0.0, 10.0) or abs(abs(image - x) - 10) < 1e-14
