"""Gains on floors by quadrature and by drawing phases; impact times and flights by brute force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from crosscheck.references import floors


@given(u=st.floats(0.05, 4), e=st.floats(0, 1))
def test_floor_laws_by_quadrature(u: float, e: float) -> None:
    """Over the phase: V = V0 cos, so that the density's poles are gone."""
    v0 = 1.3

    def mean(law: str, what: str) -> float:
        # p(V) dV = p(V) pi sqrt(V0^2 - V^2) dphase/pi; uniform: 1
        def integrand(phase: float) -> float:
            plate = v0 * math.cos(phase)
            weight = 1.0 if law == "uniform" else max(u + plate, 0) / floors.flux_mean_approach(u, v0)
            gain = 0.5 * (float(floors.rebound(u, plate, e)) ** 2 - u * u)
            return weight * {"one": 1.0, "gain": gain, "plate": plate}[what]

        edge = [math.acos(-u / v0)] if u < v0 else None
        return quad(integrand, 0, math.pi, points=edge, epsabs=1e-12, epsrel=1e-10)[0] / math.pi

    assert mean("flux", "one") == pytest.approx(1, rel=1e-9)
    assert mean("uniform", "gain") == pytest.approx(floors.uniform_phase_gain(u, v0, e), abs=1e-9)
    assert mean("flux", "gain") == pytest.approx(floors.flux_phase_gain(u, v0, e), abs=1e-9)
    if u >= v0:
        assert mean("flux", "plate") == pytest.approx(v0**2 / (2 * u), rel=1e-9)


@given(u=st.floats(0.05, 4), plate=st.floats(-1.2, 1.2))
def test_floor_densities(u: float, plate: float) -> None:
    v0 = 1.3
    uniform = 1 / (math.pi * (v0**2 - plate**2) ** 0.5)
    assert floors.uniform_phase_density(plate, v0) == pytest.approx(uniform, rel=1e-12)
    expected = uniform * max(u + plate, 0) / floors.flux_mean_approach(u, v0)
    assert floors.flux_phase_density(plate, u, v0) == pytest.approx(expected, rel=1e-12)
    assert floors.uniform_phase_density(1.4, v0) == 0


def test_elastic_gains() -> None:
    assert floors.uniform_phase_gain(0.3, 1.3) == pytest.approx(1.3**2)
    assert floors.flux_phase_gain(1.5, 1.3) == pytest.approx(2 * 1.3**2)
    assert floors.flux_phase_gain(1.3 - 1e-9, 1.3) == pytest.approx(floors.flux_phase_gain(1.3, 1.3), rel=1e-6)
    assert floors.sawtooth_gain(0.5, 1.3) == pytest.approx(2 * 1.3 * 1.8)


@given(
    height=st.floats(1.0, 5.0),
    velocity=st.floats(-5, 5),
    time=st.floats(0, 10),
    omega=st.floats(0.3, 8),
    gravity=st.floats(0.5, 3),
)
def test_plate_impact_is_the_first_crossing(
    height: float, velocity: float, time: float, omega: float, gravity: float
) -> None:
    found = floors.plate_impact_time(height, velocity, time, 0.9, omega, gravity)
    s = np.linspace(0, found - time, 4000)

    def gap(x: np.ndarray) -> np.ndarray:
        return height + velocity * x - gravity * x * x / 2 - 0.9 * np.cos(omega * (time + x))

    scale = height + abs(velocity) * s[-1] + gravity * s[-1] ** 2
    steepness = abs(velocity) + gravity * s[-1] + 0.9 * omega
    rounding = 8 * np.finfo(float).eps * (scale + steepness * (found + 1))
    assert gap(s)[:-1].min() > -rounding
    assert abs(gap(s)[-1]) < rounding


def test_plate_impact_finds_a_graze_and_the_hit_beside_it() -> None:
    """A straight path that touches the crest, raised and lowered by 1e-10."""
    # z = h - u s touches z = cos t where sin t = u: h = cos t + u t
    u = 0.4
    crest = math.asin(u)
    height, start = math.cos(crest) + u * crest, -3.0
    above, below = (
        floors.plate_impact_time(height + shift - u * start, -u, start, 1.0, 1.0) for shift in (1e-10, -1e-10)
    )
    assert below == pytest.approx(crest, abs=2e-5)
    assert above > 2


def test_plate_impact_after_leaving() -> None:
    """A particle that leaves the plate finds its next impact, not the one it comes from."""
    start = 0.3
    nxt = floors.plate_impact_time(math.cos(start), 2.0, start, 1.0, 1.0, gravity=1.0)
    assert nxt > start + 1
    assert floors.plate_impact_time(math.cos(start), 2.0, start, 1.0, 1.0, horizon=50.0) == math.inf
    for height, velocity in ((0.5, 1.0), (1.0, -1.0)):
        with pytest.raises(ValueError, match="must start above the plate"):
            floors.plate_impact_time(height, velocity, 0.0, 1.0, 1.0, gravity=1.0)


@pytest.mark.parametrize("u", [1.0, 1.5, 3.5])
def test_first_impacts_follow_the_flux_law(u: float) -> None:
    """u >= V0: <V> = V0^2/2u, the cumulative distribution, and for fast particles one impact a visit."""
    phases = 2 * np.pi * (np.arange(800) + 0.5) / 800
    visits = [floors.plate_visit(u, phase) for phase in phases]
    plates = np.sort([visit.plate for visit in visits])
    # equally spaced phases of a smooth function of the phase; at u = V0 it has a square-root kink
    assert plates.mean() == pytest.approx(1 / (2 * u), abs=1e-12 if u > 1 else 1e-4)
    cumulative = 0.5 + (np.arcsin(plates) - (1 - plates**2) ** 0.5 / u) / np.pi
    np.testing.assert_allclose(cumulative, (np.arange(800) + 0.5) / 800, atol=2 / 800)
    if u > 3:
        assert max(visit.impacts for visit in visits) == 1
        gain = floors.visit_gain(u, phases=400)
        assert gain.value == pytest.approx(floors.flux_phase_gain(u, 1.0), abs=1e-9)


def test_visits_gain_more_than_single_impacts() -> None:
    for u, expected in ((0.25, 1.667), (0.5, 2.060), (1.5, 2.140)):
        gain = floors.visit_gain(u, phases=800)
        assert abs(gain.value - expected) < gain.doubt
        assert gain.value > floors.flux_phase_gain(u, 1.0) + 0.05
        assert gain.value > floors.uniform_phase_gain(u, 1.0) + 0.5


def test_a_particle_may_settle_on_the_plate() -> None:
    """Without rebound it leaves when the plate slows down, and is back at once."""
    with pytest.raises(RuntimeError, match="50 impacts in one visit"):
        floors.plate_visit(0.5, 1.0, restitution=0.0, most=50)


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
    expected = floors.random_visit_gain(speed, law)  # type: ignore[arg-type]
    assert abs(gains.mean() - expected) < 4 * gains.std() / v.size**0.5 + 1e-3


@pytest.mark.parametrize("speed", [2.0, 3.0])
def test_random_visit_gain_is_that_of_one_impact_above_two(speed: float) -> None:
    assert floors.random_visit_gain(speed, "uniform") == pytest.approx(floors.uniform_phase_gain(speed, 1.0))
    assert floors.random_visit_gain(speed, "flux") == pytest.approx(floors.flux_phase_gain(speed, 1.0))


def test_flight_over_a_floor_that_hardly_moves() -> None:
    # falls 1/2 in time 1, and is back after 2
    end = floors.flight(0.5 + 1e-9, 0.0, 0.0, 4.0, 1e-9, 0.1)
    assert end.impacts == 2
    assert end.height == pytest.approx(0.5, abs=1e-8)
    assert end.velocity == pytest.approx(0.0, abs=1e-7)


@given(st.floats(1.1, 5.0), st.floats(-3.0, 3.0), st.floats(0.0, 10.0), st.floats(0.2, 3.0))
@settings(deadline=None, max_examples=20)
def test_a_flight_is_two_flights_of_half_the_time(height: float, velocity: float, time: float, omega: float) -> None:
    whole = floors.flight(height, velocity, time, 2.0, 1.0, omega)
    half = floors.flight(height, velocity, time, 1.0, 1.0, omega)
    rest = floors.flight(half.height, half.velocity, time + 1.0, 1.0, 1.0, omega)
    assert half.impacts + rest.impacts == whole.impacts
    np.testing.assert_allclose(rest[:2], whole[:2], atol=1e-7)
