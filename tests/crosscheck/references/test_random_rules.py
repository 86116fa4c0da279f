"""Distribution functions of random walls, by quadrature; tests of chance, on what is random and what is not."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from crosscheck.references.random_rules import (
    flux_of_maxwell,
    independent,
    maxwell_component,
    random_direction_component,
    random_phase,
    repeats,
    uniform,
    uniform_in_groups,
)

RNG = np.random.default_rng(5)


@pytest.mark.parametrize(("temperature", "mass"), [(1.0, 1.0), (0.3, 4.0), (5.0, 0.2)])
def test_thermal_velocities_are_those_that_pass_a_plane(temperature: float, mass: float) -> None:
    weight = quad(lambda v: v * math.exp(-mass * v * v / 2 / temperature), 0, np.inf)[0]
    for speed in (0.2, 1.0, 3.0):
        share = quad(lambda v: v * math.exp(-mass * v * v / 2 / temperature), 0, speed)[0] / weight
        assert flux_of_maxwell(speed, temperature, mass) == pytest.approx(share, rel=1e-7)
        below = quad(lambda v: math.exp(-mass * v * v / 2 / temperature), -np.inf, speed)[0]
        norm = math.sqrt(2 * math.pi * temperature / mass)
        assert maxwell_component(speed, temperature, mass) == pytest.approx(below / norm, rel=1e-7)


@given(v=st.floats(-3.0, -0.01), law=st.sampled_from(["uniform", "flux"]), share=st.floats(0.01, 0.99))
def test_the_phase_of_a_wall_is_weighted_by_the_approach(
    v: float, law: Literal["uniform", "flux"], share: float
) -> None:
    top = 1.3
    # in the phase itself, where the density has no pole
    last = math.acos(max(v, -top) / top)

    def weight(phase: float) -> float:
        return 1.0 if law == "uniform" else top * math.cos(phase) - v

    phase = share * last
    expected = 1 - quad(weight, 0, phase)[0] / quad(weight, 0, last)[0]
    assert random_phase(top * math.cos(phase), v, top, law) == pytest.approx(expected, abs=1e-7)
    assert random_phase(top, v, top, law) == pytest.approx(1.0)
    assert random_phase(max(v, -top), v, top, law) == pytest.approx(0.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_components_of_random_directions_are_uniform(dimension: int) -> None:
    vectors = RNG.normal(size=(4000, dimension))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    assert uniform(random_direction_component(vectors[:, 0], dimension)) > 1e-3
    assert uniform(random_direction_component(vectors[:, 0], 5 - dimension)) < 1e-6


def test_probabilities_of_random_numbers_are_themselves_uniform() -> None:
    found = []
    for _ in range(300):
        u, x = RNG.random(400), RNG.normal(size=400)
        found.append([uniform(u), uniform_in_groups(u, np.arange(400) % 7), independent(u, x)])
    for probabilities in np.array(found).T:
        assert uniform(probabilities) > 1e-4


def test_what_is_not_random_is_seen() -> None:
    u = RNG.random(2000)
    assert uniform(0.9 * u) < 1e-6
    assert uniform(u**1.2) < 1e-6
    assert uniform(np.append(u, np.nan)) == 0.0
    assert uniform(np.append(u, 1.1)) == 0.0
    assert uniform(np.zeros(0)) == 0.0
    other = np.where(np.arange(2000) % 5 == 0, u, RNG.random(2000))
    assert independent(other, u) < 1e-6
    assert independent(np.abs(2 * u - 1), u) < 1e-6
    assert uniform_in_groups(np.where(np.arange(2000) % 4 == 0, u**1.4, u), np.arange(2000) % 4) < 1e-4
    assert repeats(u) == 0
    assert repeats(np.append(u, u[7])) == 1
