"""Kinetic and total energy: to rounding, within a band, with a drift and with a step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hard_disks import disks
from inspected import flying, judged, said

from crosscheck.scene import Box, Explicit, HardSpheres, Method, Scene, Spring
from crosscheck.trajectories.memory import in_memory

NAME = "energy"


def elastic(number: int = 20) -> Scene:
    """Hard disks, which are far apart."""
    rng = np.random.default_rng(1)
    x = rng.uniform(0, 5, (number, 3))
    entries = {
        "dimension": 3,
        "box": Box(lengths=(5.0, 5.0, 5.0)),
        "hard_spheres": HardSpheres(diameter=0.0),
        "initial": Explicit(positions=tuple(map(tuple, x.tolist()))),
    }
    return disks(**entries)


@pytest.mark.parametrize(("growth", "outcome"), [(0.0, "pass"), (1e-14, "pass"), (1e-7, "fail")])
def test_particles_that_are_free_between_collisions(growth: float, outcome: str) -> None:
    v = np.array(flying().velocities) * (1 + growth * np.arange(60))[:, None, None]
    (one,) = judged(flying(velocities=v), NAME, elastic())
    assert one.outcome == outcome
    assert one.sensitivity < 1e-10


SPRINGS = 12


def springs(noise: float = 0.0, drift: float = 0.0, step: float = 0.0) -> tuple[Any, Scene]:
    """Particles on springs of one frequency, whose velocities are changed by these shares."""
    rng = np.random.default_rng(2)
    t = 0.13 * np.arange(300)
    phase, size = rng.uniform(0, 2 * np.pi, (SPRINGS, 2)), rng.uniform(0.5, 1.0, (SPRINGS, 2))
    x = size * np.cos(t[:, None, None] + phase)
    v = -size * np.sin(t[:, None, None] + phase)
    change = noise * rng.normal(size=300) + drift * np.linspace(0, 1, 300) + step * (np.arange(300) >= 200)
    v = v * (1 + change)[:, None, None]
    space = ((0, 0), (0, 0), (0, 1))
    scene = Scene(
        name="s", dimension=2, duration=t[-1], spring=Spring(k=1.0), method=Method(scheme="velocity_verlet", dt=0.13),
        initial=Explicit(positions=tuple(map(tuple, x[0].tolist())), velocities=tuple(map(tuple, v[0].tolist()))),
    )  # fmt: skip
    return in_memory("springs", t, np.pad(x, space), np.pad(v, space), masses=np.ones(SPRINGS)), scene


def outcomes(**changes: float) -> dict[str, str]:
    source, scene = springs(**changes)
    found = judged(source, NAME, scene, ensemble="nve")
    return {one.quantity.partition(" of")[0]: one.outcome for one in found}


def test_a_symplectic_scheme_oscillates() -> None:
    assert outcomes(noise=1e-4) == {"drift": "pass", "largest step": "pass"}


def test_a_drift_beyond_the_oscillations_is_red() -> None:
    assert outcomes(noise=1e-4, drift=1e-2)["drift"] == "fail"
    assert outcomes(noise=1e-4, drift=1e-5)["drift"] == "pass", "it is within them"


def test_a_step_is_red_and_says_where() -> None:
    source, scene = springs(noise=1e-4, step=5e-3)
    (step,) = [one for one in judged(source, NAME, scene, ensemble="nve") if "step" in one.quantity]
    assert step.outcome == "fail"
    at = int(step.note.split("at frame ")[1].split(" ")[0])
    assert at == pytest.approx(200, abs=4)


def test_schemes_that_drift_by_their_order_are_told() -> None:
    source, scene = springs(noise=1e-4, drift=1e-2)
    assert judged(source, NAME, scene.changed(method=Method(scheme="gear4", dt=0.13))) == ()
    assert "gear4 is not symplectic, and its energy may drift" in said(
        source, NAME, scene.changed(method=Method(scheme="gear4", dt=0.13))
    )


def test_what_keeps_it_from_being_judged() -> None:
    source, scene = springs()
    assert "the interaction is not known" in said(flying(), NAME, ensemble="nve")
    assert "nothing says that the system is closed" in said(flying(), NAME)
    assert "[spring.gamma] takes or gives energy" in said(source, NAME, scene.changed(spring=Spring(k=1.0, gamma=0.1)))
    inelastic = elastic().changed(hard_spheres=HardSpheres(diameter=0.0, restitution=0.9))
    assert "hard_spheres.restitution" in said(flying(), NAME, inelastic)
    assert "no velocities" in said(flying(velocities=None), NAME)
