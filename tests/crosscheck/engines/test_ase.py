"""ASE against plain sums over pairs and against conservation laws."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from pair_sums import evaluate

from crosscheck.engines.workers.pool import Worker
from crosscheck.scene import Box, Explicit, HardSpheres, LennardJones, Method, Output, Scene, Spring, Wall, explicit

ALL = ("kinetic_energy", "potential_energy", "virial")
STEP = Method(scheme="velocity_verlet", dt=0.002)


@pytest.fixture(scope="module")
def ase() -> Iterator[Worker]:
    worker = Worker("ase", time_limit=60)
    yield worker
    worker.close()


def fluid(**changes: Any) -> Scene:
    dimension = changes.get("dimension", 3)
    rng = np.random.default_rng(11)
    sites = np.stack(np.meshgrid(*[np.arange(4)] * dimension), axis=-1).reshape(-1, dimension)[:16]
    positions = 1.2 * sites + 0.6 + rng.uniform(-0.1, 0.1, sites.shape) + 4.8 * rng.integers(-1, 2, sites.shape)
    entries: dict[str, Any] = {
        "name": "fluid",
        "dimension": 3,
        "duration": 0.0,
        "masses": 2.0,
        "lennard_jones": LennardJones(cutoff=2.3, epsilon=1.5),
        "box": Box(lengths=(4.8,) * dimension),
        "initial": explicit(positions, rng.normal(size=sites.shape)),
        "output": Output(interval=0.1, observables=ALL, forces=True),
    }
    return Scene(**(entries | changes))


SCENES = {
    "truncated": fluid(),
    "shifted": fluid(lennard_jones=LennardJones(cutoff=2.3, truncation="shifted")),
    "r_m": fluid(lennard_jones=LennardJones(cutoff=2.3, length=1.1, length_form="r_m")),
    "plane": fluid(dimension=2),
    "open": fluid(box=None),
    "open axis": fluid(box=Box(lengths=(4.8,) * 3, boundaries=("periodic", "open", "periodic"))),
    "unlike masses": fluid(masses=tuple(np.linspace(1.0, 4.0, 16))),
}


@pytest.mark.parametrize("name", SCENES)
def test_forces_energy_and_virial(ase: Worker, name: str) -> None:
    scene = SCENES[name]
    run, expected = ase.run(scene, STEP), evaluate(scene)
    state = scene.initial_state()
    np.testing.assert_allclose(run["forces"], expected.forces, atol=1e-13 * np.abs(expected.forces).max())
    np.testing.assert_allclose(run["potential_energy"], expected.energy, rtol=1e-13)
    np.testing.assert_allclose(run["virial"], expected.virial, rtol=1e-13)
    np.testing.assert_allclose(
        run["kinetic_energy"], 0.5 * np.sum(state.masses[:, None] * state.velocities**2), rtol=1e-14
    )
    np.testing.assert_array_equal(run["final_positions"], state.positions)


def test_oscillating_pair(ase: Worker) -> None:
    # two particles near the minimum of phi: an oscillator of frequency (2 phi''/m)^(1/2), phi'' = 72/2^(1/3)
    apart, amplitude = 2 ** (1 / 6), 1e-4
    positions = np.array([[0.0, 0, 0], [apart + amplitude, 0, 0]])
    scene = Scene(
        name="pair",
        dimension=3,
        duration=1.0,
        lennard_jones=LennardJones(cutoff=5.0, truncation="shifted"),
        initial=explicit(positions, np.zeros((2, 3))),
        output=Output(interval=0.05, observables=("kinetic_energy", "potential_energy"), trajectory=True),
    )
    run = ase.run(scene, STEP)
    stretch = run["positions"][:, 1, 0] - run["positions"][:, 0, 0] - apart
    omega = (2 * 72 / 2 ** (1 / 3)) ** 0.5
    np.testing.assert_allclose(stretch, amplitude * np.cos(omega * run["time"]), atol=0.01 * amplitude)
    np.testing.assert_allclose(run["kinetic_energy"], 0.5 * np.sum(run["velocities"] ** 2, axis=(1, 2)), rtol=1e-14)
    assert run.cost.steps == 500
    assert run.cost.evaluations == 501


def test_collision_at_a_huge_step_diverges(ase: Worker) -> None:
    close = np.array([[0.0, 0, 0], [1e-30, 0, 0]])
    scene = fluid(box=None, duration=1.0, initial=explicit(close, np.zeros((2, 3))))
    run = ase.run(scene, Method(scheme="velocity_verlet", dt=0.1))
    assert run.diverged
    assert np.isnan(run["final_positions"]).all()
    assert np.isnan(run["kinetic_energy"][-1])


@pytest.mark.parametrize(
    ("scene", "scheme", "reason"),
    [
        (fluid(), "verlet", "no scheme 'verlet'"),
        (fluid(lennard_jones=LennardJones(cutoff=2.0, truncation="force_shifted")), "", "truncation=force_shifted"),
        (fluid(lennard_jones=LennardJones(cutoff=2.0, length=(1.0, 2.0)), species=(0, 1) * 8), "", "_jones.length[]"),
        (fluid(lennard_jones=LennardJones(cutoff=2.5e-10, length=1e-10)), "", None),
        (fluid(box=Box(lengths=(4.8,) * 3, boundaries=("wall",) * 3, wall=Wall(cutoff=1.0))), "",
         "no box.boundaries=wall, no box.wall"),
        (fluid(masses=0.5), "", None),
        (Scene(name="spring", dimension=1, duration=1.0, spring=Spring(k=1.0),
               initial=Explicit(positions=((1.0,),))), "", "is for [lennard_jones], not for"),
        (Scene(name="disks", dimension=2, duration=1.0, hard_spheres=HardSpheres(),
               initial=Explicit(positions=((1.0, 1.0),))), "", "is for [lennard_jones], not for"),
    ],
)  # fmt: skip
def test_reasons(ase: Worker, scene: Scene, scheme: str, reason: str | None) -> None:
    found = ase.supports(scene, Method(scheme=scheme or "velocity_verlet", dt=0.1))
    assert (found is None) == (reason is None)
    assert (reason or "") in (found or "")
