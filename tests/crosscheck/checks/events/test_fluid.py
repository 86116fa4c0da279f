"""What the checks of elastic gases compute of their own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from crosscheck.checks.events import fluid
from crosscheck.engines.protocol import Run
from crosscheck.references import hard_spheres as reference
from crosscheck.scene import Box, HardSpheres, Scene, explicit


def test_distance_is_that_of_scipy() -> None:
    speeds = np.random.default_rng(1).rayleigh(1.1, size=500)
    expected = kstest(speeds, "rayleigh").statistic  # of scale 1: Maxwell in two dimensions, T = 1
    assert fluid._distance(speeds, 2, 1.0) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_maxwell_is_no_further_from_itself_than_allowed(dimension: int) -> None:
    speeds = np.linalg.norm(np.random.default_rng(2).normal(size=(40000, dimension)), axis=1)
    assert fluid._distance(speeds, dimension, 1.0) < fluid._largest_distance(40000)
    assert fluid._distance(1.05 * speeds, dimension, 1.0) > fluid._largest_distance(40000)


def test_pressure_of_one_disk_that_bounces_to_and_fro() -> None:
    """v = 3/7 along x in a box of 10: a hit of 2 v every (L - sigma)/v; the virial theorem holds at any time."""
    length, v = 10.0, 3 / 7
    time = np.linspace(0.0, 10000.0, 61)
    way = (5.0 - 0.5 + v * time) / (length - 1)  # in crossings
    hits, phase = np.floor(way), way % 2
    x = 0.5 + (length - 1) * np.where(phase < 1, phase, 2 - phase)
    impulse = np.zeros((61, 4, 2))
    impulse[:, 1, 0], impulse[:, 0, 0] = 2 * v * np.ceil(hits / 2), -2 * v * np.floor(hits / 2)
    counts = np.zeros((61, 4))
    counts[:, 0] = hits
    scene = Scene(
        name="one",
        dimension=2,
        duration=10000.0,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(length, length), boundaries=("hard", "hard")),
        initial=explicit(np.array([[5.0, 5.0]]), np.array([[v, 0.0]])),
    )
    positions = np.stack([x, np.full(61, 5.0)], axis=1)[:, None, :]
    velocities = np.stack([np.where(phase < 1, v, -v), np.zeros(61)], axis=1)[:, None, :]
    tallies = {
        "wall_impulse": impulse,
        "wall_collisions": counts,
        "collisional_virial": np.zeros(61),
        "collisions": np.zeros(61),
    }
    run = Run(time, positions[-1], velocities[-1], positions=positions, velocities=velocities, tallies=tallies)
    found = fluid._wall_pressure(scene, run)
    assert found.residual < 1e-12
    # the ideal gas in (L - sigma)^2, here with v^2/2 in the place of T; without noise
    ideal = reference.ideal_wall_pressure(1, length, 2, 0.5 * v * v, 1.0)
    assert found.mean.value == pytest.approx(ideal, rel=1e-12)
    assert found.mean.error < 1e-12
    assert found.impulse.value == pytest.approx(2 * v)


def test_squares_of_straight_flight() -> None:
    rng = np.random.default_rng(3)
    velocities = rng.normal(size=(50, 3))
    positions = rng.normal(size=(50, 3)) + 0.1 * np.arange(30)[:, None, None] * velocities
    expected = (velocities**2).sum(axis=1).mean() * (0.1 * 7) ** 2
    assert fluid._squares(positions, 7, 20) == pytest.approx(np.full(20, expected))


@pytest.mark.parametrize("variant", sorted(fluid.MIXTURES))
def test_mixture_starts_as_said(variant: str) -> None:
    d, eta = fluid.MIXTURES[variant]
    scene, known = fluid._mixture_scene(d, eta, 5)
    state = scene.initial_state()  # refuses overlaps
    assert state.diameters is not None
    assert state.lengths is not None
    assert known.packing_fraction[d - 2] == pytest.approx(eta)
    assert np.pi / (2 * d) * (state.diameters**d).sum() / state.lengths.prod() == pytest.approx(eta)
    assert (state.masses[:, None] * state.velocities).sum(axis=0) == pytest.approx(np.zeros(d), abs=1e-11)
    kinetic = 0.5 * (state.masses[:, None] * state.velocities**2).sum()
    assert 2 * kinetic / reference.degrees_of_freedom(scene.number, d, True) == pytest.approx(1.0)
    assert not state.velocities[np.array(scene.species) == 1].any()
