"""Separations with known laws: rounding and chaos are told from what starts too large, and from jumps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from crosscheck.compare.growth import EPSILON, LEVEL, Rate, Separation, chaos_line, growth, measured_rate
from crosscheck.statistics import student_quantile
from crosscheck.trajectories.frames import Floats

TIMES = np.arange(0, 20, 0.1)
EXTENT, SPACING, STEP = 7.0, 1.06, 0.005


def separation(values: Floats, floor: float = 1e-15, times: Floats = TIMES, **known: Any) -> Separation:
    """Saturated at the distance of neighbours, and hidden below the rounding of the files."""
    shown = np.minimum(values, 1.5 * SPACING)
    entries = {
        "times": times, "values": np.where(shown > floor, shown, 0.0), "floor": np.full(len(times), floor),
        "velocities": None, "velocity_floor": None, "number": 256, "speed": 1.5, "extent": EXTENT, "spacing": SPACING,
        "step": STEP, "origin": 0.0,
    }  # fmt: skip
    return Separation(**(entries | known))


def chaotic(start: float, rate: float, scatter: float = 0.0, seed: int = 0) -> Floats:
    """start exp(rate t), ln s a walk about it."""
    walk = np.cumsum(np.random.default_rng(seed).standard_normal(len(TIMES))) * scatter * 0.1**0.5
    values: Floats = start * np.exp(rate * TIMES + walk - walk[0])
    values[0] = 0.0
    return values


@given(
    start=st.floats(-17.0, -14.3),
    rate=st.floats(1.0, 5.0),
    scatter=st.floats(0.0, 0.7),
    floor=st.sampled_from([1e-15, 4e-7, 3e-5]),
    seed=st.integers(0, 10_000),
)
def test_what_starts_from_rounding_is_never_called_different(
    start: float, rate: float, scatter: float, floor: float, seed: int
) -> None:
    found = growth(separation(chaotic(10**start, rate, scatter, seed), floor))
    assert found.kind in ("chaos", "rounding", "unclear")
    if floor < 1e-14 and scatter < 0.3:
        assert found.kind == "chaos"


@given(
    start=st.floats(-9.0, -4.0),
    rate=st.floats(1.0, 4.0),
    scatter=st.floats(0.0, 0.5),
    floor=st.sampled_from([1e-15, 4e-7]),
    seed=st.integers(0, 10_000),
)
def test_what_starts_from_more_is_never_called_chaos(
    start: float, rate: float, scatter: float, floor: float, seed: int
) -> None:
    found = growth(separation(chaotic(10**start, rate, scatter, seed), floor))
    assert found.kind in ("early", "unclear")


@pytest.mark.parametrize("scatter", [0.0, 0.2, 0.5])
def test_rate_and_start_are_those_of_the_separation(scatter: float) -> None:
    rates, starts = [], []
    for seed in range(40):
        law = growth(separation(chaotic(3e-16, 2.5, scatter, seed))).law
        assert law is not None
        assert law.error is not None
        rates.append((law.rate - 2.5) / max(law.error, 1e-9) if scatter else (law.rate - 2.5) / 1e-9)
        starts.append(math.log(law.start / 3e-16))
    assert abs(np.mean(rates)) < 4 / 40**0.5
    # the window ends where s is first large, so rates are a little too large: within their own error
    assert np.std(rates) < 1.4
    assert abs(np.mean(starts)) < 0.3


def test_the_horizon_is_where_rounding_reaches_neighbours() -> None:
    found = growth(separation(chaotic(3e-16, 2.5)))
    assert found.law is not None
    limit = EPSILON["double"] * EXTENT / (2.5 * STEP)
    assert found.law.limit == pytest.approx(limit)
    assert found.law.horizon == pytest.approx(math.log(0.1 * SPACING / limit) / 2.5)
    line = chaos_line(separation(chaotic(3e-16, 2.5)), found)
    assert line is not None
    assert line[0] == pytest.approx(limit + 1e-15)
    assert line[40] == pytest.approx(limit * math.exp(10), rel=1e-3)


def test_single_precision_explains_more() -> None:
    values = chaotic(1e-7, 2.0)
    assert growth(separation(values)).kind == "early"
    assert growth(separation(values, arithmetic="single")).kind == "chaos"


@pytest.mark.parametrize("at", [1, 30, 60])
@pytest.mark.parametrize("factor", [1e4, 1e7])
def test_a_jump_is_found_at_its_frame(at: int, factor: float) -> None:
    values = chaotic(1e-16, 2.0, 0.2)
    if values[at] * factor > 0.05:
        pytest.skip("the jump would go beyond the distance of neighbours")
    values[at:] *= factor
    found = growth(separation(values))
    assert found.kind == ("early" if at == 1 else "jump")
    assert found.parting is not None
    assert found.parting.frame == at
    assert found.parting.expected < values[at]


def test_bits_that_part_late_from_rounding_are_chaos_and_from_more_a_jump() -> None:
    for start, kind in ((1e-16, "chaos"), (1e-5, "jump")):
        values = np.zeros(len(TIMES))
        values[50:] = start * np.exp(2.0 * (TIMES[50:] - TIMES[49]))
        found = growth(separation(values))
        assert found.kind == kind
        if kind == "jump":
            assert found.parting is not None
            assert found.parting.frame == 50


@pytest.mark.parametrize("power", [0.5, 1.0, 1.5])
def test_rounding_explains_powers_of_time_in_regular_motion(power: float) -> None:
    steps = TIMES / STEP
    values = EPSILON["double"] * EXTENT * steps**power
    assert growth(separation(values)).kind == "rounding"
    assert growth(separation(1e6 * values)).kind == "early"


def test_a_start_that_differs_counts_as_it_is() -> None:
    values = chaotic(1e-12, 2.0)
    values[0] = 1e-12
    assert growth(separation(values)).kind == "chaos"
    values[0] = 0.0
    assert growth(separation(values)).kind == "early"
    # velocities that differ by v move particles by v/lambda (exp(lambda t) - 1)
    moved = 1e-12 * np.expm1(2.0 * TIMES)
    assert growth(separation(moved)).kind == "early"
    assert growth(separation(moved, start_velocity=2e-12)).kind == "chaos"


def test_velocities_must_go_with_positions() -> None:
    values = chaotic(1e-16, 2.0)
    for velocity, kind in ((50.0, "chaos"), (500.0, "velocities")):  # in units of s; 2/dt is 400
        velocities = velocity * np.minimum(values, SPACING)
        known = {"velocities": velocities, "velocity_floor": np.full(len(TIMES), 1e-15)}
        assert growth(separation(values, **known)).kind == kind


def test_few_frames_say_nothing_unless_the_rate_is_known() -> None:
    few = np.array([0, 70, 140, 199])
    for start, kind in ((1e-16, "chaos"), (1e-8, "early")):
        values = chaotic(start, 2.0)[few]
        assert growth(separation(values, times=TIMES[few])).kind == "unclear"
        assert growth(separation(values, times=TIMES[few]), Rate(2.0, 0.3, 50.0)).kind == kind


def test_what_hardly_shows_above_the_rounding_of_the_files_is_chaos_at_a_known_rate() -> None:
    values = np.zeros(len(TIMES))
    values[-3:] = 1.5e-6
    assert growth(separation(values, 1e-6)).kind == "unclear"
    assert growth(separation(values, 1e-6), Rate(2.0, 0.3, 50.0)).kind == "chaos"


def test_a_particle_at_the_origin_has_no_rounding() -> None:
    assert growth(separation(chaotic(1e-16, 2.0), extent=0.0)).kind == "early"


def test_the_rate_alone() -> None:
    shown = separation(chaotic(1e-16, 3.0)).values
    found = measured_rate(TIMES, shown, 1e-15, SPACING)
    assert found is not None
    assert found.value == pytest.approx(3.0)
    assert measured_rate(TIMES, np.full(len(TIMES), 1e-9), 1e-15, SPACING) is None


def test_frames_count_from_twice_the_rounding_of_the_files() -> None:
    values = chaotic(1e-16, 2.5)
    law = growth(separation(values, 1e-12)).law
    assert law is not None
    assert law.frames is not None
    assert law.frames[0] == np.flatnonzero(values > 2e-12)[0]
    assert law.frames[1] == np.flatnonzero(values > 0.1 * SPACING)[0] - 1


def test_without_growth_a_start_is_too_large_if_no_drift_within_its_error_makes_it_from_rounding() -> None:
    """Seven frames from t = 1 on, whose ln s goes up and down by 2 a: no drift, with an error in proportion to a."""
    times = np.arange(17) * 0.1
    shown = np.arange(17) >= 10

    def kind(a: float) -> str:
        values = np.where(shown, 1e-6 * np.exp(-a * (-1.0) ** np.arange(17)), 0.0)
        return growth(separation(values, times=times)).kind

    error_of_one = 2 * math.sqrt(6 / 0.1 / 5) / math.sqrt(0.6)  # of the drift, for a = 1
    explained = EPSILON["double"] * EXTENT * 200**1.5 + 1e-15
    most = (math.log(1e-6) - math.log(explained)) / (1 + student_quantile(2 * LEVEL, 5.0) * error_of_one)
    assert kind(0.99 * most) == "early"
    assert kind(1.01 * most) == "unclear"


@pytest.mark.parametrize("at", [20, 40])
def test_a_jump_begins_where_the_tail_of_the_other_steps_ends(at: int) -> None:
    """Steps of ln s of 0.2 +- 0.05 in turn, but for one: the others tell the rate, their scatter, and its doubt."""
    steps = 0.2 + 0.05 * (-1.0) ** np.arange(len(TIMES))
    steps[0] = 0.0
    floor = 1e-15

    def found(jump: float) -> Any:
        values = 2e-14 * np.exp(np.cumsum(np.where(np.arange(len(TIMES)) == at, jump, steps)))
        return growth(separation(np.where(np.arange(len(TIMES)) == 0, 0.0, values), floor, number=1))

    def most(jump: float) -> tuple[float, float]:
        values = 2e-14 * np.exp(np.cumsum(np.where(np.arange(len(TIMES)) == at, jump, steps)))
        last = int(np.flatnonzero(values > 0.1 * SPACING)[0]) - 1
        others = np.delete(steps[: last + 1], [0, 1, at])  # of the frames that tell the rate
        value, freedom = others.mean() / 0.1, len(others) - 1
        scatter = math.sqrt(((others - value * 0.1) ** 2).sum() / 0.1 / freedom)
        raised = scatter * math.sqrt(freedom / chi2.ppf(1e-3, freedom))
        before = values[at - 1] + floor + EPSILON["double"] * EXTENT * 0.1 / STEP
        tail = math.log(len(TIMES) / LEVEL) * min(raised, max(scatter, math.sqrt(value))) * math.sqrt(0.1)
        pairs = 100.0 * (0.1 / STEP) * before / SPACING
        cutoff = 0.0 if pairs < LEVEL else 2 * 1.5 / 0.1 * STEP**2 * math.sqrt(2.0)
        return float(before * math.exp(value * 0.1 + tail) + cutoff * math.exp(value * 0.1)), values[at - 1]

    lowest, highest = 0.2, 40.0
    for _ in range(60):  # the jump that is just explained
        jump = (lowest + highest) / 2
        explained, before = most(jump)
        inside = before * math.exp(jump) <= explained + 2 * floor
        lowest, highest = (jump, highest) if inside else (lowest, jump)
    assert found(lowest - 1e-3).kind != "jump"
    parted = found(lowest + 1e-3)
    assert parted.kind == "jump"
    assert parted.parting.frame == at
    assert parted.parting.expected == pytest.approx(most(lowest + 1e-3)[0], rel=1e-6, abs=0)


def test_chaos_is_not_claimed_where_the_start_is_larger_than_rounding_but_not_for_certain() -> None:
    limit = EPSILON["double"] * EXTENT / (2.5 * STEP)
    kinds = []
    for seed in range(20):
        found = growth(separation(chaotic(3 * limit, 2.5, 0.4, seed), 1e-9))
        assert found.law is not None
        if found.law.start > found.law.limit:
            kinds.append(found.kind)
    assert len(kinds) > 5
    assert set(kinds) == {"unclear"}


def test_chaos_is_not_claimed_after_a_step_that_is_unlikely() -> None:
    """Growth by e^1.8 in one frame, where the others grow by e^(0.2 +- 0.1), is no jump for certain, but no proof."""
    steps = 0.2 + 0.1 * (-1.0) ** np.arange(len(TIMES))
    kinds = []
    for jump in (0.3, 1.8, 9.0):
        steps[60] = jump
        values = 2e-14 * np.exp(np.cumsum(steps))
        values[0] = 0.0
        kinds.append(growth(separation(values, number=1)).kind)
    assert kinds == ["chaos", "unclear", "jump"]


@pytest.mark.parametrize("unit", [1e-12, 1e6])
def test_what_is_said_does_not_depend_on_the_unit_of_time(unit: float) -> None:
    for start in (1e-16, 1e-8):
        values = chaotic(start, 2.0, 0.2)
        here = growth(separation(values))
        there = growth(separation(values, times=TIMES * unit, step=STEP * unit, speed=1.5 / unit))
        assert there.kind == here.kind
        assert here.law is not None
        assert there.law is not None
        assert there.law.rate * unit == pytest.approx(here.law.rate)
        assert there.law.limit == pytest.approx(here.law.limit, rel=1e-9, abs=0)
        assert there.law.horizon == pytest.approx(here.law.horizon * unit, rel=1e-9, abs=0)


def test_what_rounding_and_chaos_explain_where_a_start_that_was_too_large_first_shows() -> None:
    found = growth(separation(chaotic(1e-10, 2.5), 1e-6))
    assert found.kind == "early"
    assert found.law is not None
    assert found.parting is not None
    assert found.parting.frame > 20
    explained = found.law.limit * math.exp(found.law.rate * TIMES[found.parting.frame])
    assert found.parting.expected == pytest.approx(explained, rel=1e-9, abs=0)
