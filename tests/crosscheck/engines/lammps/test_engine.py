"""LAMMPS against closed forms and plain sums over pairs. It runs in its worker only, never in this process."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pair_sums import evaluate

from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing, Unsupported
from crosscheck.scene import (
    Box,
    Explicit,
    Gravity,
    HardSpheres,
    Kepler,
    LennardJones,
    Method,
    Output,
    Scene,
    Spring,
    Wall,
    explicit,
)

ALL = ("kinetic_energy", "potential_energy", "virial")
STEP = Method(scheme="velocity_verlet", dt=0.002)


def oscillator(**changes: Any) -> Scene:
    entries: dict[str, Any] = {
        "name": "oscillator",
        "dimension": 1,
        "duration": 2.0,
        "masses": 70.0,
        "spring": Spring(k=1e4, gamma=100.0),
        "initial": Explicit(positions=((1.0,), (-0.5,)), velocities=((-100 / 140,), (0.0,))),
        "output": Output(
            interval=0.1, observables=("kinetic_energy", "potential_energy"), trajectory=True, forces=True
        ),
    }
    return Scene(**(entries | changes))


def fluid(**changes: Any) -> Scene:
    """Particles near the sites of a cubic lattice of spacing 1.1, in a box of side 5.5, some outside of it."""
    dimension = changes.get("dimension", 3)
    rng = np.random.default_rng(20240501)
    sites = np.stack(np.meshgrid(*[np.arange(5)] * dimension), axis=-1).reshape(-1, dimension)[:70]
    positions = 1.1 * sites + 0.55 + rng.uniform(-0.1, 0.1, sites.shape)
    if "box" not in changes:
        positions += 5.5 * rng.integers(-2, 3, sites.shape)
    entries: dict[str, Any] = {
        "name": "fluid",
        "dimension": 3,
        "duration": 0.0,
        "lennard_jones": LennardJones(cutoff=2.5),
        "box": Box(lengths=(5.5,) * dimension),
        "initial": explicit(positions, rng.normal(size=sites.shape)),
        "output": Output(interval=0.1, observables=ALL, forces=True),
    }
    return Scene(**(entries | changes))


# -- springs ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma", [None, 100.0])
def test_oscillator_is_velocity_verlet_with_half_step_friction(lammps: Worker, gamma: float | None) -> None:
    scene = oscillator(spring=Spring(k=1e4, gamma=gamma))
    run = lammps.run(scene, STEP)
    r, v = scene.initial_state()[:2]
    friction, dt, rows = gamma or 0.0, STEP.dt, [(r, v)]
    f = -1e4 * r - friction * v
    for step in range(1, 1001):
        v = v + dt * f / 140.0
        r = r + dt * v
        f = -1e4 * r - friction * v
        v = v + dt * f / 140.0
        if step % 50 == 0:
            rows.append((r, v))
    positions, velocities = map(np.array, zip(*rows, strict=True))
    np.testing.assert_allclose(run["positions"], positions, atol=1e-13)
    np.testing.assert_allclose(run["velocities"], velocities, atol=1e-12)
    np.testing.assert_allclose(run["final_positions"], positions[-1], atol=1e-13)
    np.testing.assert_allclose(run["final_velocities"], velocities[-1], atol=1e-12)
    np.testing.assert_allclose(run["kinetic_energy"], 35.0 * np.sum(velocities**2, axis=(1, 2)), rtol=1e-12)
    np.testing.assert_allclose(run["potential_energy"], 5e3 * np.sum(positions**2, axis=(1, 2)), rtol=1e-12)
    # the forces at the end are those of the velocity at the end
    np.testing.assert_allclose(run["forces"], -1e4 * r - friction * v, atol=1e-9)
    assert run.cost.steps == 1000
    assert run.cost.evaluations == 1001


def test_springs_in_three_dimensions_with_unlike_masses(lammps: Worker) -> None:
    positions = np.array([[1.0, -2.0, 3.0], [0.5, 0.25, 0.0]])
    scene = oscillator(
        dimension=3, masses=(1.0, 4.0), spring=Spring(k=4.0), initial=explicit(positions, np.zeros_like(positions))
    )
    run = lammps.run(scene, STEP)
    for particle, omega in enumerate((2.0, 1.0)):
        expected = np.cos(omega * run["time"])[:, None] * positions[particle]
        np.testing.assert_allclose(run["positions"][:, particle], expected, atol=1e-5)


def test_unstable_step_diverges(lammps: Worker) -> None:
    scene = oscillator(spring=Spring(k=1e4), duration=1000.0, output=Output(interval=10.0, trajectory=True))
    run = lammps.run(scene, Method(scheme="velocity_verlet", dt=0.25))
    assert run.diverged
    assert np.isfinite(run["positions"][:2]).all()
    assert np.isnan(run["positions"][-1]).all()


# -- gravity ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("softening", [None, 0.3])
def test_gravity_of_several_bodies(lammps: Worker, dimension: int, softening: float | None) -> None:
    rng = np.random.default_rng(3)
    r, v = rng.normal(size=(2, 7, dimension))
    m = rng.uniform(0.1, 2.0, 7)
    scene = Scene(
        name="bodies",
        dimension=dimension,
        duration=0.0,
        masses=tuple(m.tolist()),
        gravity=Gravity(G=2.5, softening=softening),
        initial=explicit(r, v),
        output=Output(interval=1.0, observables=ALL, forces=True),
    )
    run = lammps.run(scene, STEP)
    apart = r[:, None] - r
    square = np.sum(apart**2, axis=-1) + (softening or 0.0) ** 2
    np.fill_diagonal(square, np.inf)
    products = 2.5 * np.outer(m, m)
    pulls = -(products / square**1.5)[:, :, None] * apart
    np.testing.assert_allclose(run["forces"], pulls.sum(axis=1), rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(run["potential_energy"], -0.5 * np.sum(products / np.sqrt(square)), rtol=1e-14)
    np.testing.assert_allclose(run["virial"], 0.5 * np.sum(apart * pulls), rtol=1e-14)
    np.testing.assert_allclose(run["kinetic_energy"], 0.5 * np.sum(m[:, None] * v**2), rtol=1e-14)


def test_kepler_orbit_closes_with_second_order(lammps: Worker) -> None:
    period = 2 * np.pi
    errors = []
    for steps in (2000, 4000):
        scene = Scene(
            name="orbit",
            dimension=2,
            duration=period,
            masses=(0.75, 0.25),
            gravity=Gravity(),
            initial=Kepler(kind="kepler", eccentricity=0.5),
        )
        run = lammps.run(scene, Method(scheme="velocity_verlet", dt=period / steps))
        errors.append(np.linalg.norm(run["final_positions"] - scene.initial_state().positions))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)
    assert errors[1] < 1e-4


def test_gravity_in_si_units(lammps: Worker) -> None:
    scene = Scene(
        name="earth",
        dimension=3,
        duration=0.0,
        masses=(1.98841e30, 5.97217e24),
        gravity=Gravity(G=6.6743e-11),
        initial=Explicit(positions=((0.0, 0.0, 0.0), (0.0, 1.495978707e11, 0.0))),
        output=Output(forces=True),
    )
    run = lammps.run(scene, Method(scheme="velocity_verlet", dt=3600.0))
    pull = 6.6743e-11 * 1.98841e30 * 5.97217e24 / 1.495978707e11**2
    np.testing.assert_allclose(run["forces"], [[0, pull, 0], [0, -pull, 0]], rtol=1e-14)


# -- Lennard-Jones ---------------------------------------------------------------------------------

MIXTURE = LennardJones(cutoff=2.0, epsilon=(1.0, 0.5), length=(1.0, 0.8), truncation="shifted")
SCENES = {
    "truncated": fluid(),
    "shifted": fluid(lennard_jones=LennardJones(cutoff=2.5, truncation="shifted")),
    "force-shifted": fluid(lennard_jones=LennardJones(cutoff=2.5, truncation="force_shifted")),
    "r_m": fluid(lennard_jones=LennardJones(cutoff=2.5, length=1.1, length_form="r_m", epsilon=0.7)),
    "mixture": fluid(lennard_jones=MIXTURE, species=(0, 1) * 35, masses=(1.0, 2.0) * 35),
    "plane": fluid(dimension=2, lennard_jones=LennardJones(cutoff=2.0)),
    "walls": fluid(
        box=Box(
            lengths=(5.5, 5.5, 5.5),
            boundaries=("wall", "periodic", "wall"),
            wall=Wall(epsilon=1.5, sigma=0.6, cutoff=2.0),
        )
    ),
    "open": fluid(box=None),
    "open axis": fluid(box=Box(lengths=(5.5, 5.5, 5.5), boundaries=("periodic", "open", "periodic"))),
}


@pytest.mark.parametrize("name", SCENES)
def test_forces_energy_and_virial(lammps: Worker, name: str) -> None:
    scene = SCENES[name]
    run, expected = lammps.run(scene, STEP), evaluate(scene)
    state = scene.initial_state()
    np.testing.assert_allclose(run["forces"], expected.forces, atol=1e-13 * np.abs(expected.forces).max())
    np.testing.assert_allclose(run["potential_energy"], expected.energy, rtol=1e-13)
    np.testing.assert_allclose(run["virial"], expected.virial, rtol=1e-13)
    np.testing.assert_allclose(
        run["kinetic_energy"], 0.5 * np.sum(state.masses[:, None] * state.velocities**2), rtol=1e-14
    )
    np.testing.assert_allclose(run["final_positions"], state.positions, rtol=1e-15, atol=1e-14)
    np.testing.assert_array_equal(run["final_velocities"], state.velocities)


def test_sampling_changes_nothing(lammps: Worker) -> None:
    scene = fluid(
        duration=2.0,
        lennard_jones=LennardJones(cutoff=2.5, truncation="shifted"),
        output=Output(interval=0.002, observables=ALL, trajectory=True),
    )
    often = lammps.run(scene, STEP)
    never = lammps.run(scene.changed(output=Output()), STEP)
    np.testing.assert_array_equal(often["final_positions"], never["final_positions"])
    np.testing.assert_array_equal(often["final_velocities"], never["final_velocities"])
    thermo = lammps.run(scene.changed(output=Output(interval=0.5, observables=ALL)), STEP)
    for name in ALL:
        np.testing.assert_array_equal(often[name][::250], thermo[name])
    # unwrapped: no jumps
    assert np.abs(np.diff(often["positions"], axis=0)).max() < 0.1
    total = often["kinetic_energy"] + often["potential_energy"]
    np.testing.assert_allclose(total, total[0], rtol=2e-3)


@pytest.mark.parametrize("samples", [1, 100])
def test_unwrapped_positions_beyond_the_range_of_the_counters_of_boxes(lammps: Worker, samples: int) -> None:
    """640 boxes in 10000 steps: LAMMPS's own counters wrap after 512 either way."""
    scene = Scene(
        name="streaming",
        dimension=2,
        duration=10.0,
        lennard_jones=LennardJones(cutoff=2.5),
        box=Box(lengths=(4.0, 4.0)),
        initial=Explicit(positions=((1.0, 1.0),), velocities=((256.0, -0.5),)),
        output=Output(interval=10.0 / samples, trajectory=True),
    )
    run = lammps.run(scene, Method(scheme="velocity_verlet", dt=2.0**-10 * 1.024))
    np.testing.assert_allclose(run["positions"][:, 0, 0], 1 + 256.0 * run["time"], rtol=1e-12)
    np.testing.assert_allclose(run["final_positions"], [[2561.0, -4.0]], rtol=1e-12)
    assert not run.diverged


def test_exploding_fluid_diverges(lammps: Worker) -> None:
    scene = fluid(
        duration=2.0,
        output=Output(interval=0.1, observables=ALL, trajectory=True, forces=True),
        box=Box(lengths=(5.5,) * 3, boundaries=("wall",) * 3, wall=Wall(sigma=0.5, cutoff=1.25)),
    )
    run = lammps.run(scene, Method(scheme="velocity_verlet", dt=0.1))
    assert run.diverged
    assert np.isfinite(run["positions"][0]).all()
    assert np.isnan(run["final_positions"]).all()
    np.testing.assert_array_equal(np.isnan(run["positions"]).all(axis=(1, 2)), np.isnan(run["potential_energy"]))


PAIR = Explicit(positions=((0.0, 0.0), (1.0, 0.0)))


# -- what it refuses, and how it fails -------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "scheme", "reason"),
    [
        (oscillator(), "beeman", "no scheme 'beeman'"),
        (oscillator(output=Output(interval=0.1, observables=("virial",))), "velocity_verlet", "no virial"),
        (oscillator(dimension=2, spring=None, gravity=Gravity(), masses=(1.0, 0.0), initial=PAIR), "velocity_verlet",
         "no masses=0"),
        (fluid(masses=tuple(np.arange(1.0, 71.0)), species=(0, 1) * 35), "velocity_verlet", None),
        (fluid(initial=explicit(np.arange(303.0).reshape(101, 3), np.zeros((101, 3))),
               masses=tuple(np.arange(1.0, 102.0))), "velocity_verlet", "at most 100"),
        (fluid(box=Box(lengths=(5.0,) * 3, boundaries=("wall",) * 3, wall=Wall(cutoff=1.0))), "velocity_verlet",
         "on or beyond a wall"),
        (fluid(lennard_jones=None, hard_spheres=HardSpheres(), output=Output()), "velocity_verlet", "method.contact"),
    ],
)  # fmt: skip
def test_reasons(lammps: Worker, scene: Scene, scheme: str, reason: str | None) -> None:
    found = lammps.supports(scene, Method(scheme=scheme, dt=0.1))
    assert (found is None) == (reason is None)
    assert (reason or "") in (found or "")


BROKEN = """
import ctypes
from crosscheck.engines.lammps import LammpsEngine, instance, particles

class Engine(LammpsEngine):
    def run(self, scene, method):
        if method.dt == 0.1:
            particles._lennard_jones = lambda *_: ["pair_style no/such/style 2.5"]
        if method.dt == 0.05:
            instance.load().lammps(cmdargs=["-log", "none"])
            ctypes.CDLL(None).MPI_Abort(0x44000000, 3)  # MPICH's MPI_COMM_WORLD
        if method.dt == 0.025:
            instance._MPI = "libmpi.so.of-nowhere"
        return super().run(scene, method)
"""


def test_errors_aborts_and_no_mpi(tmp_path: Path) -> None:
    file = tmp_path / "broken.py"
    file.write_text(BROKEN)
    worker = Worker(f"{file}:Engine", time_limit=60)
    with pytest.raises(EngineError, match=r"ended with exit status 3(.|\n)*application called MPI_Abort"):
        worker.run(fluid(), Method(scheme="velocity_verlet", dt=0.05))
    assert not worker.run(fluid(), STEP).diverged
    with pytest.raises(EngineError, match="ERROR: Unrecognized pair style 'no/such/style'"):
        worker.run(fluid(), Method(scheme="velocity_verlet", dt=0.1))
    assert not worker.run(oscillator(), STEP).diverged
    with pytest.raises(EngineMissing, match="no MPI library for LAMMPS: pip install mpich"):
        worker.run(fluid(), Method(scheme="velocity_verlet", dt=0.025))
    worker.close()


def test_unsupported_is_raised(lammps: Worker) -> None:
    with pytest.raises(Unsupported, match="lammps: no scheme 'gear5'"):
        lammps.run(oscillator(), Method(scheme="gear5", dt=0.002))


def test_version(lammps: Worker) -> None:
    assert lammps.version().startswith("20")
