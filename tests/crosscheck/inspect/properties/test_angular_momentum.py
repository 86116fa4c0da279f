"""Angular momentum about the origin, in open space."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import flying, judged, said

from crosscheck.scene import Explicit, Gravity, Method, Scene, Spring
from crosscheck.trajectories.memory import in_memory

NAME = "angular momentum"
METHOD = Method(scheme="velocity_verlet", dt=0.01)


def circling(precession: float = 0.0) -> object:
    """A body on an ellipse about the origin, by a spring; precession: growth of its angular momentum."""
    t = 0.1 * np.arange(80)
    x = np.stack([np.cos(t), 0.5 * np.sin(t), 0 * t], axis=1)[:, None]
    v = np.stack([-np.sin(t), 0.5 * np.cos(t), 0 * t], axis=1)[:, None]
    v = v * (1 + precession * t)[:, None, None]
    return in_memory("ellipse", t, x, v, masses=np.ones(1))


SPRING = Scene(
    name="s", dimension=2, duration=8.0, spring=Spring(k=1.0), method=METHOD,
    initial=Explicit(positions=((1.0, 0.0),), velocities=((0.0, 0.5),)),
)  # fmt: skip


@pytest.mark.parametrize(("precession", "outcome"), [(0.0, "pass"), (1e-6, "fail")])
def test_a_spring_conserves_it_about_the_origin(precession: float, outcome: str) -> None:
    (one,) = judged(circling(precession), NAME, SPRING)
    assert one.outcome == outcome
    (one,) = judged(circling(precession), NAME, ensemble="nve")
    assert one.outcome == outcome


def test_where_it_is_not_conserved() -> None:
    damped = SPRING.changed(spring=Spring(k=1.0, gamma=0.1))
    assert judged(circling(), NAME, damped) == ()
    assert "[spring.gamma] takes it" in said(circling(), NAME, damped)
    assert "gear4 is not symplectic" in said(circling(), NAME, SPRING.changed(method=Method(scheme="gear4", dt=0.01)))
    assert "there is a box" in said(flying(), NAME, ensemble="nve")
    assert "nothing says that the system is closed" in said(circling(), NAME)


def test_gravity_in_space() -> None:
    x = np.array([[[0.0, 0, 0], [1.0, 0, 0]]] * 30)
    v = np.array([[[0.0, 0, 0.1], [0, 1.0, 0]]] * 30)
    x = x + v * np.arange(30)[:, None, None]  # free flight conserves it, as far as it goes
    scene = Scene(
        name="s", dimension=3, duration=29.0, masses=(1.0, 1e-3), gravity=Gravity(), method=METHOD,
        initial=Explicit(positions=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
    )  # fmt: skip
    source = in_memory("pair", np.arange(30.0), x, v, masses=np.array([1.0, 1e-3]))
    assert [one.outcome for one in judged(source, NAME, scene)] == ["pass"]
