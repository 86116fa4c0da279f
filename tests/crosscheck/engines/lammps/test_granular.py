"""Soft grains in LAMMPS against impacts whose outcome is known. It runs in its worker only, never in this process."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosscheck.engines.lammps import granular
from crosscheck.engines.soft_spheres import soft_spheres
from crosscheck.engines.workers.pool import Worker
from crosscheck.scene import (
    Box,
    Contact,
    Cylinder,
    Explicit,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Method,
    Oscillation,
    Output,
    Scene,
    explicit,
)

ROUGH = GrainFriction(tangential_restitution=0.3, static=0.3, sliding=0.3)
K = 1e4


def method(dt: float | None = None, **contact: Any) -> Method:
    return Method(scheme="velocity_verlet", dt=dt, contact=Contact(**({"stiffness": K} | contact)))


def duration(alpha: float, k: float = K, reduced: float = 0.5) -> float:
    """t_c of "hooke"."""
    return math.sqrt((math.pi**2 + math.log(alpha) ** 2) * reduced / k)


def moved(vectors: Any) -> np.ndarray:
    """Vectors of the plane or of space, or spins of the plane, in three dimensions."""
    vectors = np.asarray(vectors, dtype=float)
    before = 2 if vectors.shape[-1] == 1 else 0
    return np.pad(vectors, ((0, 0), (before, 3 - before - vectors.shape[-1])))


# -- coefficients of a contact's own ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("contact", "pairs", "walls"),
    [
        (
            {"k_n": 7.0, "k_t": 2.0, "gamma_n": 0.5, "gamma_t": 0.25, "mu": 0.3},
            "gran/hooke/history 7.0 2.0 0.5 0.25 0.3 1",
            "hooke 7.0 0.5 damping mass_velocity tangential linear_history 2.0 0.5 0.3",
        ),
        (
            {"k_n": 7.0, "friction": "dashpot", "gamma_n": 0.0, "gamma_t": 2.0, "mu": 0.3},
            "gran/hooke 7.0 0.0 0.0 2.0 0.3 1",
            f"hooke 7.0 {2.0**-59!r} damping mass_velocity tangential linear_nohistory {2.0**60!r} 0.3",
        ),
        (
            {"law": "hertz", "k_n": 7.0, "k_t": 2.0, "gamma_n": 0.5, "mu": 0.3},
            "gran/hertz/history 7.0 2.0 0.5 0.0 0.3 1",
            "hertz 7.0 0.5 damping viscoelastic tangential mindlin 2.0 0.0 0.3",
        ),
        (
            {"law": "hertz", "E": 9.0, "nu": 0.5, "gamma_n": 0.5, "gamma_t": 0.5},
            "hertz/material 9.0 0.5 0.5 damping viscoelastic tangential mindlin NULL 1.0 10000.0",
            "hertz 8.0 0.5 damping viscoelastic tangential mindlin 8.0 1.0 10000.0",
        ),
        (
            {"law": "hertz", "E": 9.0, "nu": 0.5},
            "hertz/material 9.0 1.0 0.5 damping coeff_restitution tangential mindlin NULL 0.0 10000.0",
            "hertz 8.0 1.0 damping coeff_restitution tangential mindlin 8.0 0.0 10000.0",
        ),
    ],
)
def test_styles(contact: dict[str, Any], pairs: str, walls: str) -> None:
    rough = {"tangential_restitution": -1.0}
    scene = Scene(
        name="s",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(friction=GrainFriction(**rough)),
        box=Box(lengths=(5.0, 5.0), boundaries=("open", "hard"), faces={"y-": Face(friction=Friction(**rough))}),
        initial=explicit(np.ones((1, 2)), np.ones((1, 2))),
    )
    how = Method(scheme="velocity_verlet", dt=0.1, contact=Contact(**contact))
    assert how.contact is not None
    laws = soft_spheres(scene, how.contact)
    commands = " ".join(granular._pairs(scene, laws, how.contact, scene.initial_state()))
    assert pairs in commands
    assert f"granular {walls} yplane" in next(iter(granular._walls(scene, laws, how)))


@pytest.mark.parametrize("friction", ["history", "dashpot"])
def test_starts_in_contact_with_each_other_and_with_a_cylinder(
    lammps: Worker, interpreted: Worker, friction: Any
) -> None:
    """The same motion as in refimpl: one grain deep in the cylinder's wall, and two in each other."""
    rough = {"tangential_restitution": -1.0}
    own = {"k_n": K, "gamma_n": 20.0, "gamma_t": 10.0, "mu": 0.4, "friction": friction}
    scene = Scene(
        name="begun",
        dimension=2,
        duration=0.05,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(friction=GrainFriction(**rough)),
        box=Box(
            lengths=(8.0, 8.0),
            boundaries=("open", "open"),
            cylinder=Cylinder(radius=3.0, friction=Friction(**rough)),
        ),
        initial=explicit(
            np.array([[4.0, 1.45], [3.5, 4.0], [4.45, 4.0]]),
            np.array([[0.3, 0.1], [0.1, 0.2], [-0.1, -0.3]]),
            np.array([[1.0], [2.0], [-0.5]]),
        ),
        output=Output(interval=0.05, observables=("kinetic_energy", "contact_time")),
    )
    how = method(1e-3, stiffness=None, **own, **({"k_t": K / 3} if friction == "history" else {}))
    runs = [worker.run(scene, how) for worker in (interpreted, lammps)]
    for name in ("final_positions", "final_velocities", "final_angular_velocities"):
        # rounding of coordinates of 4, times omega^2 t, over 50 steps
        np.testing.assert_allclose(runs[1][name], runs[0][name], atol=50 * 1e-15 * K * 0.05)
    assert runs[0]["kinetic_energy"][-1] > 2 * runs[0]["kinetic_energy"][0]


# -- pairs -----------------------------------------------------------------------------------------


def impacts(alpha: float, dt: float, span: float, masses: tuple[float, float] = (1.0, 1.0), **output: Any) -> Scene:
    """16 pairs that meet head-on with relative speed 2, at 16 places of the time step."""
    n = 16
    gaps = 1e-2 + 2 * dt * (np.arange(n) + 0.5) / n
    y = 2.0 * np.arange(n) + 1
    positions = np.concatenate([np.stack([0 * y + 1, y], 1), np.stack([2 + gaps, y], 1)])
    velocities = np.repeat([[1.0, 0.0], [-1.0, 0.0]], n, axis=0)
    steps = math.ceil((0.5e-2 + span) / dt)
    return Scene(
        name="impacts",
        dimension=2,
        duration=steps * dt,
        masses=tuple(np.repeat(masses, n).tolist()),
        hard_spheres=HardSpheres(restitution=alpha),
        box=Box(lengths=(5.0, 2.0 * n)),
        initial=explicit(positions, velocities),
        output=Output(interval=steps * dt, observables=("collisional_virial", "contact_time", "kinetic_energy")),
    )


@pytest.mark.parametrize("masses", [(1.0, 1.0), (1.0, 3.0)])
@pytest.mark.parametrize("alpha", [1.0, 0.8, 0.3])
def test_restitution_and_duration(lammps: Worker, alpha: float, masses: tuple[float, float]) -> None:
    reduced = masses[0] * masses[1] / sum(masses)
    span = duration(alpha, reduced=reduced)
    errors = []
    for resolution in (20, 80):
        dt = span / resolution
        scene = impacts(alpha, dt, 2 * span, masses)
        run = lammps.run(scene, method(dt))
        v = run["final_velocities"][:, 0].reshape(2, 16)
        found = (v[1] - v[0]) / 2
        errors.append(np.sqrt(np.mean((found - alpha) ** 2)))
        # the impulse of the dashpot, which acts at once, in a step; and Verlet's frequency, off by (omega dt)^2/24
        step = 2 * abs(math.log(alpha)) / resolution
        assert np.abs(found - alpha).max() < step + (math.pi / resolution) ** 2 / 24
        # a contact begins and ends within a step
        assert run["contact_time"][-1] / 16 == pytest.approx(span, rel=1 / resolution)
        # trapezoids are the impulses exactly, here at distances from 1 - deepest overlap to 1
        impulse = masses[0] * float(np.sum(1 - v[0]))
        deepest = 2 * math.sqrt(reduced / K)
        assert (1 - deepest) * impulse < run["collisional_virial"][-1] < impulse
        np.testing.assert_allclose(masses[0] * v[0] + masses[1] * v[1], masses[0] - masses[1], atol=1e-12)
    # 4 by the first order of the dashpot, but 16 places in the step scatter
    assert errors[0] / errors[1] > 3


@pytest.mark.parametrize("masses", [(1.0, 1.0), (1.0, 3.0)])
def test_hertz_has_the_restitution_too(lammps: Worker, masses: tuple[float, float]) -> None:
    alpha, dt = 0.6, 1e-4
    scene = impacts(alpha, dt, 0.2, masses)
    run = lammps.run(scene, method(dt, law="hertz"))
    v = run["final_velocities"][:, 0].reshape(2, 16)
    # the impulse of the dashpot in the first step, at an overlap of 2 dt
    reduced, log = masses[0] * masses[1] / sum(masses), abs(math.log(alpha))
    damping = math.sqrt(5 * K / reduced) * log / math.sqrt(math.pi**2 + log**2)
    np.testing.assert_allclose((v[1] - v[0]) / 2, alpha, atol=damping * (0.25 * 2 * dt) ** 0.25 * dt)


@pytest.mark.parametrize("masses", [1.0, (1.0, 2.0)])
@pytest.mark.parametrize("alpha", [1.0, 0.8])
@pytest.mark.parametrize(("friction", "alpha_t"), [("history", -0.4), ("dashpot", 0.5)])
@pytest.mark.parametrize(("dimension", "inertia"), [(2, 0.5), (2, 0.4), (3, 0.4)])
def test_sticking_contact(
    lammps: Worker, dimension: int, inertia: float, friction: str, alpha_t: float, alpha: float, masses: Any
) -> None:
    """The slip becomes alpha_t times itself, momentum and angular momentum stay."""
    gap, k = 1e-6, 1e6
    z = (0.0,) * (dimension - 2)
    spins = ((0.7,), (0.2,)) if dimension == 2 else ((0.1, 0.3, 0.7), (0.0, -0.4, 0.2))
    scene = Scene(
        name="stick",
        dimension=dimension,
        duration=0.01,
        masses=masses,
        hard_spheres=HardSpheres(
            restitution=alpha, friction=GrainFriction(tangential_restitution=alpha_t, inertia=inertia)
        ),
        initial=Explicit(
            positions=((0.0, 0.0, *z), (1 + gap, 0.0, *z)),
            velocities=((1.0, 0.3, *z), (-1.0, -0.1, *z)),
            angular_velocities=spins,
        ),
        output=Output(interval=0.005, observables=("kinetic_energy", "rotational_energy"), trajectory=True),
    )
    dt = 1e-5
    run = lammps.run(scene, method(dt, stiffness=k, friction=friction))
    m = np.broadcast_to(masses, 2)[:, None]
    n = np.array([1.0, 0.0, 0.0])

    def slip(v: np.ndarray, omega: np.ndarray) -> np.ndarray:
        """Of the surface of the first over that of the second."""
        return ((v[0] - v[1]) + np.cross(omega[0] + omega[1], 0.5 * n))[1:]

    before = slip(moved(run["velocities"][0]), moved(run["angular_velocities"][0]))
    v, omega = moved(run["final_velocities"]), moved(run["final_angular_velocities"])
    # a step's turn of the tangential spring, at most pi in t_c; levers shorter by the overlap, at most sqrt(m_eff/k) 2
    reduced = 0.5 if masses == 1.0 else 2 / 3
    error = math.pi * dt / duration(alpha, k, reduced) + 2 * math.sqrt(reduced / k) / 0.5
    np.testing.assert_allclose(slip(v, omega), alpha_t * before, atol=error * np.abs(before).max())
    np.testing.assert_allclose((m * v).sum(axis=0), (m * moved(run["velocities"][0])).sum(axis=0), atol=1e-12)
    rotation = 0.5 * inertia * 0.25 * np.sum(m * omega**2)
    np.testing.assert_allclose(run["rotational_energy"][-1], rotation, rtol=1e-13)
    np.testing.assert_allclose(run["kinetic_energy"][-1], rotation + 0.5 * np.sum(m * v**2), rtol=1e-13)


def test_across_the_edge_of_the_box(lammps: Worker) -> None:
    """A pair that meets through a periodic edge does as one inside, and counts once."""
    runs = []
    for shift in (0.0, 2.2):
        scene = Scene(
            name="edge",
            dimension=2,
            duration=1.0,
            hard_spheres=HardSpheres(restitution=0.7, friction=ROUGH),
            box=Box(lengths=(4.0, 4.0)),
            initial=Explicit(positions=((1.2 + shift, 2.0), (2.3 + shift, 2.1)), velocities=((3.0, 0.0), (0.0, 0.0))),
            output=Output(
                interval=0.05, observables=("kinetic_energy", "collisional_virial", "contact_time"), trajectory=True
            ),
        )
        runs.append(lammps.run(scene, method(1e-3)))
        runs[-1]["positions"][:, :, 0] -= shift
    inside, through = runs
    assert np.abs(np.diff(through["positions"], axis=0)).max() < 0.2
    # rounding of the coordinates, through a contact as stiff as K dt
    for name in ("positions", "velocities", "angular_velocities", "kinetic_energy"):
        np.testing.assert_allclose(through[name], inside[name], atol=1e-11)
    for name in ("collisional_virial", "contact_time"):
        assert inside[name][-1] > 0
        np.testing.assert_allclose(through[name], inside[name], atol=1e-11)


def test_walls_that_are_not_there_take_up_no_momentum(lammps: Worker) -> None:
    scene = Scene(
        name="gas",
        dimension=2,
        duration=0.1,
        hard_spheres=HardSpheres(),
        box=Box(packing_fraction=0.4),
        initial=Lattice(kind="lattice", structure="triangular", number=8, temperature=1.0, seed=3),
        output=Output(interval=0.05, observables=("wall_impulse",)),
    )
    np.testing.assert_array_equal(lammps.run(scene, method(1e-3))["wall_impulse"], np.zeros((3, 4, 2)))


def test_sampling_changes_nothing(lammps: Worker) -> None:
    scene = Scene(
        name="gas",
        dimension=2,
        duration=0.5,
        hard_spheres=HardSpheres(restitution=0.8, friction=ROUGH),
        box=Box(packing_fraction=0.4),
        initial=Lattice(kind="lattice", structure="triangular", number=80, temperature=1.0, seed=3),
    )
    never = lammps.run(scene, method(1e-3))
    observables = ("kinetic_energy", "collisional_virial", "contact_time")
    often = lammps.run(
        scene.changed(output=Output(interval=1e-3, observables=observables, trajectory=True)), method(1e-3)
    )
    seldom = lammps.run(scene.changed(output=Output(interval=0.05, observables=observables)), method(1e-3))
    for name in ("final_positions", "final_velocities", "final_angular_velocities"):
        np.testing.assert_array_equal(often[name], never[name])
        np.testing.assert_array_equal(seldom[name], never[name])
    assert never.keys() == {"time", "final_positions", "final_velocities", "final_angular_velocities"}
    for name in ("collisional_virial", "contact_time"):
        np.testing.assert_allclose(seldom[name], often[name][::50], rtol=1e-12)
    # the pairs that touch, at every step
    lengths = scene.lengths()
    assert lengths is not None
    touching = []
    for x in often["positions"]:
        apart = x[:, None] - x
        apart -= lengths * np.round(apart / lengths)
        touching.append((np.count_nonzero(np.sum(apart**2, axis=-1) < 1) - 80) / 2)
    assert often["contact_time"][-1] == pytest.approx(np.trapezoid(touching, dx=1e-3), rel=1e-12)
    assert max(touching) > 1


# -- walls -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("masses", [2.0, (2.0, 1.0, 1.0, 1.0, 1.0, 1.0)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_grain_on_each_wall(lammps: Worker, dimension: int, masses: Any) -> None:
    """A grain flies at each face: every face has its restitution, and takes its impulse."""
    m = np.broadcast_to(masses, 6)[: 2 * dimension]
    alpha, dt = 0.9 - 0.1 * np.arange(2 * dimension), 1e-4
    toward = np.repeat(np.eye(dimension), 2, axis=0) * np.tile([-1.0, 1.0], dimension)[:, None]
    names = [f"{axis}{side}" for axis in "xyz"[:dimension] for side in "-+"]
    scene = Scene(
        name="walls",
        dimension=dimension,
        duration=0.2,
        masses=2.0 if masses == 2.0 else tuple(m.tolist()),
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(6.0,) * dimension,
            boundaries=("hard",) * dimension,
            faces={name: Face(restitution=value) for name, value in zip(names, alpha.tolist(), strict=True)},
        ),
        initial=explicit(3 + 2.4 * toward, 3 * toward),
        output=Output(interval=0.1, observables=("wall_impulse", "collisional_virial", "contact_time")),
    )
    run = lammps.run(scene, method(dt))
    left = np.sum(run["final_velocities"] * toward, axis=1)
    spans = np.array([duration(a, reduced=mass) for a, mass in zip(alpha, m, strict=True)])
    # the impulse of the dashpot in a step
    assert (np.abs(-left / 3 - alpha) < 2 * np.abs(np.log(alpha)) * dt / spans).all()
    expected = m[:, None] * (3 * toward - run["final_velocities"])
    np.testing.assert_allclose(run["wall_impulse"][-1], expected, atol=1e-11)
    assert run["contact_time"][-1] == 0  # of pairs
    assert run["collisional_virial"][-1] == 0


@pytest.mark.parametrize("masses", [(1.0, 1.0), (1.0, 2.0)])
@pytest.mark.parametrize(("friction", "alpha_t"), [("history", -0.4), ("dashpot", 0.5)])
@pytest.mark.parametrize("alpha", [1.0, 0.8])
def test_sticking_on_walls(
    lammps: Worker, alpha: float, friction: str, alpha_t: float, masses: tuple[float, float]
) -> None:
    """A spinning grain that meets a plane or a cylinder keeps alpha_t of its slip R omega."""
    k, dt, radius = 1e6, 1e-5, 2.5
    sticking = Friction(tangential_restitution=alpha_t)
    plane = Box(lengths=(5.0, 5.0), boundaries=("hard", "periodic"),
                faces={"x-": Face(restitution=alpha, friction=sticking)})  # fmt: skip
    drum = Box(lengths=(5.0, 5.0), boundaries=("open", "open"),
               cylinder=Cylinder(radius=radius, restitution=alpha, friction=sticking))  # fmt: skip
    for box in (plane, drum):
        scene = Scene(
            name="stick",
            dimension=2,
            duration=0.01,
            masses=masses,
            hard_spheres=HardSpheres(friction=ROUGH),
            box=box,
            initial=Explicit(
                positions=((0.5 + 1e-6, 2.5), (2.5, 2.5)),
                velocities=((-1.0, 0.0), (0.0, 0.0)),
                angular_velocities=((0.7,), (0.0,)),
            ),
        )
        run = lammps.run(scene, method(dt, stiffness=k, friction=friction))
        # the surface at the wall moves along y with v_y - R omega
        slip = run["final_velocities"][0, 1] - 0.5 * run["final_angular_velocities"][0, 0]
        # a step's turn of the tangential spring, at most pi in t_c; in the drum the normal turns by the way along it
        error = math.pi * dt / duration(alpha, k, 1.0) + duration(alpha, k, 1.0) / (radius - 0.5) * (box is drum)
        assert slip == pytest.approx(alpha_t * -0.35, abs=error * 0.35)
        if box is plane:  # m v_y = -I (omega - 0.7)/R, I = m R^2/2
            spin = run["final_angular_velocities"][0, 0]
            assert run["final_velocities"][0, 1] == pytest.approx(-0.25 * (spin - 0.7), rel=1e-12)


def test_sliding_on_a_wall_is_coulombs(lammps: Worker) -> None:
    """On an elastic wall, a dashpot that always slides: J_t = mu J_n."""
    mu = 0.05
    scene = Scene(
        name="slide",
        dimension=2,
        duration=0.1,
        hard_spheres=HardSpheres(friction=ROUGH),
        box=Box(
            lengths=(4.0, 4.0),
            boundaries=("periodic", "hard"),
            faces={"y-": Face(friction=Friction(tangential_restitution=0.1, static=mu, sliding=mu))},
        ),
        initial=Explicit(positions=((2.0, 0.51),), velocities=((20.0, -1.0),)),
        output=Output(interval=0.1, observables=("wall_impulse",)),
    )
    run = lammps.run(scene, method(1e-4, friction="dashpot"))
    along, into = run["wall_impulse"][-1, 2]
    assert into < -1.9
    assert along == pytest.approx(-mu * into, rel=1e-12)
    # I = m R^2/2: R J_t/I
    np.testing.assert_allclose(run["final_angular_velocities"], -along * 0.5 / 0.125, rtol=1e-12)


@pytest.mark.parametrize("phase", [0.0, math.pi, 2.0])
@pytest.mark.parametrize("face", ["y-", "y+"])
def test_oscillating_wall(lammps: Worker, face: str, phase: float) -> None:
    """The grain meets the wall where that is, and leaves with (1 + alpha) V + alpha v."""
    amplitude, omega, alpha, k, speed = 0.1, 5.0, 0.8, 1e7, 2.0
    scene = Scene(
        name="shaken",
        dimension=2,
        duration=0.6,
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(4.0, 4.0),
            boundaries=("periodic", "hard"),
            faces={
                face: Face(
                    restitution=alpha, oscillation=Oscillation(amplitude=amplitude, frequency=omega, phase=phase)
                )
            },
        ),
        initial=Explicit(
            positions=((1.0, 1.2 if face == "y-" else 2.8),),
            velocities=((0.0, -speed if face == "y-" else speed),),
        ),
        output=Output(interval=0.6, observables=("wall_impulse",)),
    )
    dt = 1e-5
    run = lammps.run(scene, method(dt, stiffness=k))

    def gap(t: float) -> float:
        return 1.2 - 0.5 - speed * t - amplitude * math.cos(omega * t + phase)

    early, late = 0.0, 0.5
    for _ in range(60):
        middle = (early + late) / 2
        early, late = (middle, late) if gap(middle) > 0 else (early, middle)
    velocity = -amplitude * omega * math.sin(omega * early + phase)
    leaving = (1 + alpha) * velocity + alpha * speed
    place = 1.2 - speed * early + leaving * (0.6 - early)
    inward = 1 if face == "y-" else -1
    span = duration(alpha, k, 1.0)
    # in t_c the wall gains A omega^2 t_c; the first step of the dashpot, as for walls at rest
    slack = (1 + alpha) * (amplitude * omega**2 * span + 2 * abs(math.log(alpha)) * dt / span * (speed + 0.5))
    assert inward * run["final_velocities"][0, 1] == pytest.approx(leaving, abs=slack)
    found = run["final_positions"][0, 1] if face == "y-" else 4.0 - run["final_positions"][0, 1]
    # leaves up to t_c later
    assert found == pytest.approx(place, abs=slack + (speed + leaving) * span)
    row = 2 if face == "y-" else 3
    assert -inward * run["wall_impulse"][-1, row, 1] == pytest.approx(inward * run["final_velocities"][0, 1] + speed)


@pytest.mark.parametrize(("dimension", "axis"), [(2, None), (3, "x"), (3, "y"), (3, "z")])
def test_turning_drum_drags_a_rough_grain(lammps: Worker, dimension: int, axis: str | None) -> None:
    """It turns from the first axis across to the second; its torque is what the grain's angular momentum gains."""
    along = 2 if axis is None else "xyz".index(axis)
    across = [i for i in range(dimension) if i != along]
    boundaries, lengths = ["open"] * dimension, [5.0] * dimension
    start, velocity = np.full((1, dimension), 1.5), np.full((1, dimension), 0.4)
    start[0, across] = 2.5
    velocity[0, across[0]] = 1.1
    if dimension == 3:
        boundaries[along], lengths[along] = "periodic", 3.0
    sticking = Friction(tangential_restitution=-0.2, static=0.8, sliding=0.8)
    scene = Scene(
        name="drum",
        dimension=dimension,
        duration=4.0,
        hard_spheres=HardSpheres(friction=ROUGH),
        box=Box(
            lengths=tuple(lengths),
            boundaries=tuple(boundaries),
            cylinder=Cylinder(radius=2.5, axis=axis, angular_velocity=2.0, restitution=0.9, friction=sticking),
        ),
        initial=explicit(start, velocity),
        output=Output(interval=0.5, observables=("wall_torque", "wall_impulse"), trajectory=True),
    )
    run = lammps.run(scene, method(0.5 / 1000, stiffness=1e3))
    r, v = run["positions"][:, 0, across] - 2.5, run["velocities"][:, 0, across]
    # x to z is left-handed
    spin = (-1 if along == 1 else 1) * run["angular_velocities"][:, 0, along if dimension == 3 else 0]
    inertia = (0.5 if dimension == 2 else 0.4) * 0.25
    momentum = r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0] + inertia * spin
    assert momentum[-1] > 2.0
    np.testing.assert_allclose(momentum - momentum[0], run["wall_torque"], atol=1e-11)
    impulse = run["wall_impulse"]
    np.testing.assert_allclose(impulse[:, -1], run["velocities"][0, 0] - run["velocities"][:, 0], atol=1e-11)
    assert not impulse[:, :-1].any()


@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_of_grains_among_all_kinds_of_walls(lammps: Worker, dimension: int) -> None:
    rng = np.random.default_rng(7)
    sites = np.stack(np.meshgrid(*[np.arange(3) * 1.3 + 0.75] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    number = len(sites)
    field = (0.3, -1.0, 0.1)[:dimension]
    rough = Friction(tangential_restitution=-0.2, static=0.4, sliding=0.4)
    shaken = Oscillation(amplitude=0.05, frequency=20.0, phase=math.pi)
    scene = Scene(
        name="box",
        dimension=dimension,
        duration=1.0,
        acceleration=field,
        masses=tuple(rng.uniform(0.5, 2.0, number).tolist()),
        species=tuple(rng.integers(0, 2, number).tolist()),
        hard_spheres=HardSpheres(diameter=(1.0, 0.7), restitution=0.9, friction=ROUGH),
        box=Box(
            lengths=(4.1,) * dimension,
            boundaries=("hard", "hard", "periodic")[:dimension],
            faces={
                "x-": Face(restitution=0.8, friction=rough, oscillation=shaken),
                "x+": Face(oscillation=shaken.model_copy(update={"phase": 2.0})),
                "y-": Face(restitution=0.9),
                "y+": Face(open=True),
            },
        ),
        initial=explicit(sites, 2 * rng.normal(size=sites.shape)),
        output=Output(interval=0.1, observables=("wall_impulse",), trajectory=True),
    )
    run = lammps.run(scene, method(2e-4))
    m = np.array(scene.masses)[:, None]
    momentum = (m * run["velocities"]).sum(axis=1)
    gain = m.sum() * np.array(field) * run["time"][:, None] - run["wall_impulse"].sum(axis=1)
    np.testing.assert_allclose(momentum, momentum[0] + gain, atol=1e-10)
    assert not run["wall_impulse"][:, 3].any()
    assert (np.abs(run["wall_impulse"][-1, :3]).max(axis=1) > 1).all()


def test_pipe(lammps: Worker) -> None:
    """Smooth grains in a smooth pipe fall freely along it, through many boxes."""
    scene = Scene(
        name="pipe",
        dimension=3,
        duration=4.0,
        acceleration=(3.0, 0.0, 0.0),
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(3.0, 4.0, 4.0), boundaries=("periodic", "open", "open"), cylinder=Cylinder(radius=2.0, axis="x")
        ),
        initial=Explicit(positions=((1.0, 1.0, 2.0), (2.5, 2.5, 3.0)), velocities=((0.0, 0.7, 1.0), (0.0, -1.0, 0.4))),
        output=Output(interval=1.0, observables=("wall_impulse",), trajectory=True),
    )
    run = lammps.run(scene, method(1e-3))
    assert np.abs(run["wall_impulse"][-1, -1, 1:]).max() > 1
    # the two are 1.5 apart along the pipe, for good: only the field acts along it
    np.testing.assert_allclose(
        run["positions"][:, :, 0] - [1.0, 2.5], 1.5 * np.stack([run["time"] ** 2] * 2, axis=1), atol=1e-9
    )


# -- what it refuses, and how it fails -------------------------------------------------------------


def test_step_far_too_long_diverges(lammps: Worker) -> None:
    scene = Scene(
        name="lost",
        dimension=2,
        duration=10.0,
        hard_spheres=HardSpheres(friction=ROUGH),
        box=Box(lengths=(4.0, 4.0), boundaries=("hard", "hard")),
        initial=Explicit(positions=((2.0, 2.0),), velocities=((100.0, 0.0),)),
        output=Output(interval=1.0, observables=("wall_impulse", "kinetic_energy"), trajectory=True),
    )
    run = lammps.run(scene, method(0.1))
    assert run.diverged
    assert np.isfinite(run["positions"][0]).all()
    for values in (
        run["final_velocities"],
        run["final_angular_velocities"],
        run["positions"][-1],
        run["kinetic_energy"][-1],
    ):
        assert np.isnan(values).all()
    assert np.isnan(run["wall_impulse"][-1]).all()


def grains(**changes: Any) -> Scene:
    entries: dict[str, Any] = {
        "name": "grains",
        "dimension": 2,
        "duration": 1.0,
        "hard_spheres": HardSpheres(restitution=0.9),
        "box": Box(lengths=(5.0, 5.0)),
        "initial": Explicit(positions=((2.5, 2.5),)),
    }
    return Scene(**(entries | changes))


DRUM = Box(lengths=(5.0, 5.0), boundaries=("open", "open"), cylinder=Cylinder(radius=2.5))


@pytest.mark.parametrize(
    ("scene", "how", "reason"),
    [
        (grains(), method(0.1), None),
        (grains(), Method(scheme="velocity_verlet", dt=0.1), "method.contact"),
        (grains(hard_spheres=HardSpheres(restitution=0.0)), method(0.1), "restitution 0"),
        (grains(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0, inertia=0.3))), method(0.1),
         "not q = 0.3"),
        (grains(dimension=3, box=Box(lengths=(5.0,) * 3), initial=Explicit(positions=((2.5,) * 3,)),
                hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0, inertia=0.5))), method(0.1),
         "not q = 0.5"),
        (grains(output=Output(interval=0.1, observables=("potential_energy",))), method(0.1), "no potential_energy"),
        (grains(box=DRUM), method(0.1), None),
        (grains(box=DRUM), method(0.1, law="hertz"), "curvature"),
    ],
)  # fmt: skip
def test_reasons(lammps: Worker, scene: Scene, how: Method, reason: str | None) -> None:
    found = lammps.supports(scene, how)
    assert (found is None) == (reason is None)
    assert (reason or "") in (found or "")


# -- bare contact laws -----------------------------------------------------------------------------


def test_contact_script(tmp_path: Path) -> None:
    """Two overlapping grains by hand: the force at the start, and after a step with its stretched spring."""
    source, target = tmp_path / "in.npz", tmp_path / "out.npz"
    k, kt, gamma, dt = 1000.0, 500.0, 4.0, 1e-4
    m, x = np.array([[1.0], [3.0]]), np.array([[0.0, 0.0, 0.0], [0.95, 0.0, 0.0]])
    v, omega = np.array([[0.2, 0.1, 0.0], [-0.3, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.3], [0.0, 0.5, -0.1]])
    np.savez(
        source,
        positions=x,
        velocities=v,
        spins=omega,
        radii=[0.5, 0.5],
        masses=m[:, 0],
        dimension=3,
        pair_style=f"pair_style gran/hooke/history {k} {kt} {gamma} 0.0 0.5 1",
        pair_coeff="pair_coeff * *",
        steps=1,
        dt=dt,
    )
    script = Path(__file__).parents[3] / "support" / "lammps_contacts.py"
    subprocess.run([sys.executable, "-P", str(script), str(source), str(target)], check=True, timeout=60)
    out = dict(np.load(target))

    def normal(x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Direction to the first grain, and the normal force on it."""
        r = float(np.linalg.norm(x[0] - x[1]))
        n = (x[0] - x[1]) / r
        return n, (k * (1 - r) - 0.75 * gamma * ((v[0] - v[1]) @ n)) * n

    _, push = normal(x, v)
    np.testing.assert_allclose(out["forces"], [push, -push], rtol=1e-13)
    np.testing.assert_allclose(out["torques"], 0.0, atol=1e-13)
    v = v + dt / 2 * out["forces"] / m
    x = x + dt * v
    n, push = normal(x, v)
    apart = v[0] - v[1]
    slip = apart - (apart @ n) * n - np.cross(0.5 * (omega[0] + omega[1]), n)
    drag = -kt * dt * slip
    np.testing.assert_allclose(out["x"][1], x, atol=1e-15)
    np.testing.assert_allclose(out["f"][1], [push + drag, -push - drag], atol=1e-12 * k * 0.05)
    np.testing.assert_allclose(out["torque"][1], np.tile(-0.5 * np.cross(n, drag), (2, 1)), atol=1e-14)
    assert out["omega"].shape == out["v"].shape == (2, 2, 3)
