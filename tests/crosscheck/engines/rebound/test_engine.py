"""REBOUND against Kepler's closed orbit and plain sums over pairs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from crosscheck.engines.workers.pool import Worker
from crosscheck.scene import Explicit, Gravity, HardSpheres, Kepler, Method, Output, Scene, Spring, explicit

ALL = ("kinetic_energy", "potential_energy", "virial")
PERIOD = 2 * np.pi


@pytest.fixture(scope="module")
def rebound() -> Iterator[Worker]:
    worker = Worker("rebound", time_limit=60)
    yield worker
    worker.close()


def orbit(**changes: Any) -> Scene:
    entries: dict[str, Any] = {
        "name": "orbit",
        "dimension": 2,
        "duration": PERIOD,
        "masses": (0.75, 0.25),
        "gravity": Gravity(),
        "initial": Kepler(kind="kepler", eccentricity=0.5),
        "output": Output(interval=PERIOD / 20, observables=ALL, trajectory=True),
    }
    return Scene(**(entries | changes))


def bodies(number: int = 6, **changes: Any) -> Scene:
    rng = np.random.default_rng(17)
    r, v = rng.normal(size=(2, number, 3))
    masses = tuple(rng.uniform(0.1, 1.0, number).tolist())
    entries: dict[str, Any] = {
        "name": "bodies",
        "dimension": 3,
        "duration": 0.0,
        "masses": masses,
        "gravity": Gravity(G=0.5),
        "initial": explicit(r, v),
        "output": Output(interval=0.1, observables=ALL, forces=True),
    }
    return Scene(**(entries | changes))


@pytest.mark.parametrize(("scheme", "tolerance"), [("whfast", 1e-11), ("ias15", 1e-11)])
def test_two_bodies_exactly(rebound: Worker, scheme: str, tolerance: float) -> None:
    scene = orbit()
    run = rebound.run(scene, Method(scheme=scheme, dt=PERIOD / 1000))
    np.testing.assert_allclose(run["final_positions"], scene.initial_state().positions, atol=tolerance)
    np.testing.assert_allclose(run["final_velocities"], scene.initial_state().velocities, atol=tolerance)
    np.testing.assert_allclose(run["positions"][10, 1], [-0.375, 0.0], atol=tolerance)  # pericentre: a (1 - e) 3/4
    distance = np.linalg.norm(run["positions"][:, 0] - run["positions"][:, 1], axis=1)
    np.testing.assert_allclose(run["potential_energy"], -0.1875 / distance, rtol=1e-13)
    np.testing.assert_allclose(run["virial"], run["potential_energy"], rtol=0)
    np.testing.assert_allclose(run["kinetic_energy"] + run["potential_energy"], -0.09375, rtol=1e-11)
    assert run.cost.evaluations == (0 if scheme == "ias15" else 1000)


def test_leapfrog_is_position_verlet(rebound: Worker) -> None:
    scene = orbit(duration=1.0, output=Output())
    run = rebound.run(scene, Method(scheme="leapfrog", dt=0.01))
    r, v, m, *_ = scene.initial_state()
    for _ in range(100):
        r = r + 0.005 * v
        apart = r[0] - r[1]
        pull = -m[0] * m[1] * apart / np.linalg.norm(apart) ** 3
        v = v + 0.01 * np.array([pull / m[0], -pull / m[1]])
        r = r + 0.005 * v
    np.testing.assert_allclose(run["final_positions"], r, atol=1e-13)
    np.testing.assert_allclose(run["final_velocities"], v, atol=1e-13)
    assert run.cost.evaluations == run.cost.steps == 100


@pytest.mark.parametrize("scheme", ["leapfrog", "whfast"])
def test_second_order(rebound: Worker, scheme: str) -> None:
    scene = bodies(
        number=3,
        dimension=2,
        duration=2.0,
        masses=(1.0, 0.1, 0.2),
        gravity=Gravity(),
        initial=Explicit(
            positions=((0.0, 0.0), (1.0, 0.0), (-2.0, 0.0)), velocities=((0.0, 0.0), (0.0, 1.0), (0.0, -0.8))
        ),
        output=Output(),
    )
    exact = rebound.run(scene, Method(scheme="ias15", dt=0.01))["final_positions"]
    errors = [
        np.linalg.norm(rebound.run(scene, Method(scheme=scheme, dt=dt))["final_positions"] - exact)
        for dt in (0.01, 0.005)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("softening", [None, 0.3])
def test_forces_and_energies(rebound: Worker, softening: float | None) -> None:
    observables = ALL if softening is None else ("kinetic_energy",)
    scene = bodies(
        gravity=Gravity(G=0.5, softening=softening), output=Output(interval=0.1, observables=observables, forces=True)
    )
    run = rebound.run(scene, Method(scheme="leapfrog", dt=0.1))
    r, v, m, *_ = scene.initial_state()
    apart = r[:, None] - r
    square = np.sum(apart**2, axis=-1) + (softening or 0.0) ** 2
    np.fill_diagonal(square, np.inf)
    products = 0.5 * np.outer(m, m)
    pulls = -(products / square**1.5)[:, :, None] * apart
    np.testing.assert_allclose(run["forces"], pulls.sum(axis=1), rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(run["kinetic_energy"], 0.5 * np.sum(m[:, None] * v**2), rtol=1e-14)
    if softening is None:
        np.testing.assert_allclose(run["potential_energy"], -0.5 * np.sum(products / np.sqrt(square)), rtol=1e-13)
        np.testing.assert_allclose(run["virial"], 0.5 * np.sum(apart * pulls), rtol=1e-13)


def test_test_particles_pull_nothing(rebound: Worker) -> None:
    run = rebound.run(orbit(masses=(1.0, 0.0), output=Output()), Method(scheme="leapfrog", dt=PERIOD / 1000))
    np.testing.assert_array_equal(run["final_positions"][0], [0.0, 0.0])
    assert np.linalg.norm(run["final_positions"][1] - [1.5, 0.0]) < 1e-2


def test_bodies_in_one_place_diverge(rebound: Worker) -> None:
    # the first half step puts both bodies at the origin
    meeting = Explicit(positions=((-1.0, 0.0), (1.0, 0.0)), velocities=((1.0, 0.0), (-1.0, 0.0)))
    scene = orbit(masses=(1.0, 1.0), duration=2.0, initial=meeting, output=Output())
    assert rebound.run(scene, Method(scheme="leapfrog", dt=2.0)).diverged


@pytest.mark.parametrize(
    ("scene", "scheme", "reason"),
    [
        (orbit(), "velocity_verlet", "no scheme"),
        (orbit(gravity=Gravity(softening=0.1)), "leapfrog", "energy does not contain the softening"),
        (orbit(gravity=Gravity(softening=0.1), output=Output()), "whfast", "no softening"),
        (orbit(gravity=Gravity(softening=0.1), output=Output()), "ias15", None),
        (orbit(masses=(0.0, 1.0)), "whfast", "first body with mass"),
        (orbit(masses=(1.0, 0.0)), "whfast", None),
        (Scene(name="spring", dimension=1, duration=1.0, spring=Spring(k=1.0),
               initial=Explicit(positions=((1.0,),))), "leapfrog", "is for [gravity], not for [spring]"),
        (Scene(name="disks", dimension=2, duration=1.0, hard_spheres=HardSpheres(),
               initial=Explicit(positions=((1.0, 1.0),))), "leapfrog", "is for [gravity], not for [hard_spheres]"),
    ],
)  # fmt: skip
def test_reasons(rebound: Worker, scene: Scene, scheme: str, reason: str | None) -> None:
    found = rebound.supports(scene, Method(scheme=scheme, dt=PERIOD / 1000))
    assert (found is None) == (reason is None)
    assert (reason or "") in (found or "")
