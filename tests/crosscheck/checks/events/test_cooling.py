"""The logic that the checks of granular gases and of floors bring with them, by independent routes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks.events.cooling import (
    APART,
    CONTACT,
    _pairs,
    clustering_length,
    line_collisions,
    reported_time,
    vortex_excess,
)
from crosscheck.checks.events.floors import flight, random_visit_gain
from crosscheck.engines.protocol import Run
from crosscheck.references import granular as reference
from crosscheck.references.hard_spheres import collision_rate, packing_fraction

# -- particles on a line -----------------------------------------------------------------------------------------------


def _plain(gaps: list[float], velocities: list[float], alpha: float, wall: bool) -> list[float]:
    """Times of the collisions from positions and velocities; the wall is a particle of mass 1e30."""
    x = np.cumsum([0.0, *gaps])
    v = np.array([0.0] * wall + velocities)
    masses = np.ones(v.size)
    masses[0] = 1e30 if wall else 1.0
    now, times = 0.0, []
    while (np.diff(v) < -1e-12).any():
        closing = np.diff(v) < -1e-12
        spans = np.where(closing, np.diff(x) / np.where(closing, -np.diff(v), 1), np.inf)
        k = int(spans.argmin())
        now, x = now + spans[k], x + v * spans[k]
        momentum = (1 + alpha) * (v[k] - v[k + 1]) / (1 / masses[k] + 1 / masses[k + 1])
        v[k] -= momentum / masses[k]
        v[k + 1] += momentum / masses[k + 1]
        x[k + 1] = x[k]
        times.append(now)
    return times


@given(
    st.lists(st.floats(0.1, 2.0), min_size=4, max_size=4),
    st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=5),
    st.floats(0.8, 1.0),
    st.booleans(),
)
@settings(deadline=None, max_examples=50)
def test_line_agrees_with_positions_and_velocities(
    gaps: list[float], velocities: list[float], alpha: float, wall: bool
) -> None:
    velocities = velocities[wall:]
    times = _plain(gaps, velocities, alpha, wall)
    line = line_collisions(gaps, velocities, alpha, wall)
    assert not line.collapsed
    common = min(len(times), line.times.size)
    np.testing.assert_allclose(line.times[:common], times[:common], rtol=1e-6)


def test_elastic_particles_pass_on_their_velocities() -> None:
    # five that all approach each other meet ten times, as if they went through each other
    assert line_collisions([1.0, 1.1, 0.9, 1.3], [5.0, 3.0, 0.0, -2.0, -7.0], 1.0, False).pairs == 10


@pytest.mark.parametrize("share", [0.9, 0.98, 1.02, 1.1])
def test_three_collapse_below_the_limit_only(share: float) -> None:
    line = line_collisions([1.0, 1.3], [1.0, 0.0, -0.8], share * reference.THREE_PARTICLE_COLLAPSE, False)
    assert line.collapsed == (share < 1)
    assert line.wall == 0
    assert (np.diff(line.times) >= 0).all()


@pytest.mark.parametrize("number", [2, 3, 5])
@pytest.mark.parametrize("share", [0.95, 1.05])
def test_a_row_collapses_on_a_wall_below_the_limit_only(number: int, share: float) -> None:
    alpha = share * reference.wall_collapse(number)
    line = line_collisions(np.linspace(1.0, 2.0, number), np.full(number, -1.0), alpha, True)
    assert line.collapsed == (share < 1)


@pytest.mark.parametrize(
    ("text", "time"),
    [
        ("inelastic collapse of particles 3 and 7 at t = 1.25", 1.25),
        ("inelastic collapse of particle 0 with a wall at t = 1.5e-07", 1.5e-7),
        ("", np.nan),
        ("inelastic collapse at t = 3.0", np.nan),
    ],
)
def test_reported_time(text: str, time: float) -> None:
    nothing = np.zeros((1, 2))
    np.testing.assert_equal(reported_time(Run(np.zeros(1), nothing, nothing, stopped=text)), time)


# -- homogeneous cooling -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
def test_clustering_length_from_the_viscosity(dimension: int) -> None:
    # nu k^2 = zeta/2; viscosities of dilute disks and spheres, sqrt(T m/pi)/2 sigma and 5 sqrt(T m/pi)/16 sigma^2
    density, loss, temperature = 1e-4, 0.1, 1.7
    nu = {2: 0.5, 3: 5 / 16}[dimension] * (temperature / np.pi) ** 0.5 / density
    zeta = loss * collision_rate(packing_fraction(density, dimension), dimension, temperature).value
    expected = 2 * np.pi * (2 * nu / zeta) ** 0.5
    assert clustering_length(loss, density, dimension) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("dimension", "shells"), [(2, [(4, 1), (4, 2), (4, 4)]), (3, [(6, 1), (12, 2), (8, 3), (6, 4)])]
)
def test_vortex_excess_sums_the_shells(dimension: int, shells: list[tuple[int, int]]) -> None:
    expected = sum(vectors / (4 * square - 1) for vectors, square in shells) * (dimension - 1) / (dimension * 100)
    assert vortex_excess(100, 0.5, dimension) == pytest.approx(expected)


@pytest.mark.parametrize("dimension", [2, 3])
def test_pairs_touch_at_every_angle(dimension: int) -> None:
    pairs = _pairs(dimension, 1)
    cosines = []
    for pair in pairs:
        one, two = pair.bodies
        assert np.linalg.norm(pair.normal) == pytest.approx(1)
        assert np.linalg.norm(pair.touching[0] - pair.touching[1]) == pytest.approx(one.radius + two.radius)
        g = reference.contact_velocity(one, two, pair.normal)
        assert np.linalg.norm(g) == pytest.approx(1)
        cosines.append(-g @ pair.normal)
        # nobody comes near another pair
        for body in pair.bodies:
            assert np.linalg.norm(body.velocity) * CONTACT + 1 < APART / 2
            if dimension == 2:
                assert body.velocity[2] == body.spin[0] == body.spin[1] == 0
    angles = np.degrees(np.arccos(cosines))
    np.testing.assert_allclose(np.diff(angles), 90 / len(pairs))


# -- floors ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["uniform", "flux"])
@pytest.mark.parametrize("speed", [0.7, 1.0, 1.5])
def test_random_visit_gain_against_monte_carlo(law: str, speed: float) -> None:
    rng = np.random.default_rng(3)
    v = np.full(200_000, -speed)
    here = np.arange(v.size)
    while here.size:
        plate = np.cos(2 * np.pi * rng.random(here.size))
        chance = rng.random(here.size)
        hit = plate > v[here]
        if law == "flux":
            hit &= chance * (1 - v[here]) < plate - v[here]
        v[here[hit]] = 2 * plate[hit] - v[here[hit]]
        here = here[v[here] < 0]
    gains = 0.5 * (v**2 - speed**2)
    expected = random_visit_gain(speed, law)  # type: ignore[arg-type]
    assert abs(gains.mean() - expected) < 4 * gains.std() / v.size**0.5 + 1e-3


@pytest.mark.parametrize("speed", [2.0, 3.0])
def test_random_visit_gain_is_that_of_one_impact_above_two(speed: float) -> None:
    assert random_visit_gain(speed, "uniform") == pytest.approx(reference.uniform_phase_gain(speed, 1.0))
    assert random_visit_gain(speed, "flux") == pytest.approx(reference.flux_phase_gain(speed, 1.0))


def test_flight_over_a_floor_that_hardly_moves() -> None:
    # falls 1/2 in time 1, and is back after 2
    end = flight(0.5 + 1e-9, 0.0, 0.0, 4.0, 1e-9, 0.1)
    assert end.impacts == 2
    assert end.height == pytest.approx(0.5, abs=1e-8)
    assert end.velocity == pytest.approx(0.0, abs=1e-7)


@given(st.floats(1.1, 5.0), st.floats(-3.0, 3.0), st.floats(0.0, 10.0), st.floats(0.2, 3.0))
@settings(deadline=None, max_examples=20)
def test_a_flight_is_two_flights_of_half_the_time(height: float, velocity: float, time: float, omega: float) -> None:
    whole = flight(height, velocity, time, 2.0, 1.0, omega)
    half = flight(height, velocity, time, 1.0, 1.0, omega)
    rest = flight(half.height, half.velocity, time + 1.0, 1.0, 1.0, omega)
    assert half.impacts + rest.impacts == whole.impacts
    np.testing.assert_allclose(rest[:2], whole[:2], atol=1e-7)
