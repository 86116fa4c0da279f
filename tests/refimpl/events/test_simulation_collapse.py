"""When a ball on a floor counts as collapsed: after how many flights in a row, and how short they are."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

#: Flights in a row, each shorter than a limit, that are a collapse: more than 100.
FLIGHTS = 101

Ball = Callable[[int, tuple[float, ...], Any, float], tuple[np.ndarray, str]]


@pytest.fixture
def model(plain_module: Any) -> Any:
    """The words of a scene. A ball hits its floor some hundred times: that is less than to compile a loop for it."""
    return plain_module("refimpl.events.model")


@pytest.fixture
def flights_of_a_ball(plain_module: Any, model: Any) -> Ball:
    """Times between the hits of a ball that falls on the lower wall across `axis`, and why the run ended."""

    def flights(axis: int, lengths: tuple[float, ...], floor: Any, gravity: float) -> tuple[np.ndarray, str]:
        faces: list[Any] = [None] * (2 * len(lengths))
        faces[2 * axis] = floor
        periodic = [k != axis for k in range(len(lengths))]
        faces[2 * axis + 1] = model.Face()
        scene = model.hard_spheres(
            lengths=lengths, periodic=periodic, diameters=0.1, faces=faces,
            acceleration=tuple(-gravity if k == axis else 0.0 for k in range(len(lengths))),
        )  # fmt: skip
        x = np.full((1, len(lengths)), 0.4)
        x[0, axis] = 0.5
        simulation = plain_module("refimpl.events.simulation").Simulation(
            scene, x, np.zeros((1, len(lengths))), trace=True
        )
        simulation.run(until=100.0)
        return np.diff([time for time, *_ in simulation.trace()]), simulation.stopped

    return flights


@pytest.mark.parametrize("axis", [0, 1])
def test_a_floor_at_rest(model: Any, flights_of_a_ball: Ball, axis: int) -> None:
    """Below 2^-33 of the shorter of the times for a diameter: at the speed, and in free fall."""
    flights, stopped = flights_of_a_ball(axis, (1.0, 1.0), model.Face(restitution=0.5), 2.0)
    limit = 2.0**-33 * math.sqrt(0.1 / 2.0)
    assert stopped.startswith("inelastic collapse of particle 0 with a wall at t = ")
    # the start is at rest: the speed says nothing
    assert (flights[-FLIGHTS:] < limit).all()
    assert (flights[:-FLIGHTS] > limit).all()
    assert flights[-FLIGHTS] > limit / 2 * 0.99


@pytest.mark.parametrize(("axis", "lengths"), [(0, (1.0, 400.0)), (1, (400.0, 1.0)), (1, (1.0, 400.0))])
def test_an_oscillating_floor(model: Any, flights_of_a_ball: Ball, axis: int, lengths: tuple[float, ...]) -> None:
    """Below 4 sqrt(s/M): s the rounding of the coordinate along the axis, M the largest relative acceleration."""
    amplitude, frequency, gravity = 0.01, 3.0, 2.0
    floor = model.Face(restitution=0.3, oscillation=model.Oscillation(amplitude, frequency, 0.4))
    flights, stopped = flights_of_a_ball(axis, lengths, floor, gravity)
    steepest = gravity + amplitude * frequency**2
    limit = 4 * math.sqrt(2.0**-50 * (lengths[axis] + amplitude) / steepest)
    assert stopped.startswith("inelastic collapse of particle 0 with a wall at t = ")
    short = flights < limit
    assert short[-FLIGHTS:].all()
    assert not short[-FLIGHTS - 1]


def test_a_particle_that_creeps_to_a_wall_that_pushes_does_not_collapse(plain_module: Any, model: Any) -> None:
    """What is one instant at its speed is a second at that of the wall: hits of the wall are not a collapse."""
    faces = [model.Face(velocity=1.0), model.Face(restitution=0.5), None, None]
    scene = model.hard_spheres(lengths=(8.0, 4.0), periodic=[False, True], diameters=1.0, faces=faces)
    creeping = np.array([[-(2.0**-38), 0.0]])
    simulation = plain_module("refimpl.events.simulation").Simulation(scene, np.array([[4.0, 2.0]]), creeping)
    simulation.run(until=3.5 * 2.0**38 + 1000.0)
    assert simulation.stopped == ""
    assert simulation.interactions > 200
