"""The auditor of soft grains: its forces by symmetry and by single impacts, and what it sees in a run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.references.soft_grains import Contacts, audit, turned_first
from crosscheck.references.soft_impact import SoftContact, soft_impact
from crosscheck.scene import Contact, Scene
from crosscheck.scene.parts import Box, Cylinder, Explicit, Face, Friction, GrainFriction, HardSpheres, Output

MASSES, DIAMETERS = (0.7, 1.9, 1.2), (1.0, 0.8, 0.8)


def _scene(box: Box | None = None, **changes: Any) -> Scene:
    rough = GrainFriction(tangential_restitution=-0.4, static=0.5, sliding=0.5)
    entries: dict[str, Any] = {
        "name": "three grains",
        "dimension": 3,
        "duration": 0.1,
        "masses": MASSES,
        "species": (0, 1, 1),
        "hard_spheres": HardSpheres(diameter=(1.0, 0.8), restitution=0.7, friction=rough),
        "box": box,
        "initial": Explicit(positions=((1.0, 1.0, 1.0), (1.8, 1.2, 1.1), (1.2, 1.7, 1.3))),
        "output": Output(interval=0.01, trajectory=True),
    }
    return Scene(**(entries | changes))


def _state(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    r = np.array([[1.0, 1.0, 1.0], [1.8, 1.2, 1.1], [1.2, 1.7, 1.3]]) + rng.uniform(-0.02, 0.02, (3, 3))
    return r, rng.normal(size=(3, 3)), rng.normal(size=(3, 3))


CONTACTS = (
    Contact(stiffness=300.0),
    Contact(law="hertz", k_n=300.0, k_t=90.0, mu=0.2),
    Contact(law="hertz", k_n=300.0, k_t=90.0, gamma_n=5.0, gamma_t=2.0),
    Contact(law="hertz", E=300.0, nu=0.3, mu=0.3),
)


def _scene_for(contact: Contact, box: Box | None = None) -> Scene:
    alpha = 1.0 if contact.gamma_n is not None else 0.7
    limit = {} if contact.mu is not None else {"static": 0.5, "sliding": 0.5}
    rough = GrainFriction(tangential_restitution=-0.4, **limit)
    return _scene(box, hard_spheres=HardSpheres(diameter=(1.0, 0.8), restitution=alpha, friction=rough))


@given(seed=st.integers(0, 99), which=st.sampled_from(CONTACTS))
@settings(deadline=None, max_examples=20)
def test_forces_turn_with_the_grains_and_conserve_momentum_and_angular_momentum(seed: int, which: Contact) -> None:
    scene, (r, v, w) = _scene_for(which), _state(seed)
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    plain, turned = Contacts(scene, which), Contacts(scene, which)
    for _ in range(2):
        one = plain.evaluate(r, v, w, 0.0, 0.01)
        other = turned.evaluate(r @ turn.T, v @ turn.T, w @ turn.T, 0.0, 0.01)
        np.testing.assert_allclose(other.a, one.a @ turn.T, atol=1e-11)
        np.testing.assert_allclose(other.spins, one.spins @ turn.T, atol=1e-10)
        forces = plain.masses[:, None] * one.a
        np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-11)
        torques = np.cross(r, forces) + plain.inertias[:, None] * one.spins
        if turned_first(scene, which):  # else the arms R of a pair are longer together than its distance
            np.testing.assert_allclose(torques.sum(axis=0), 0.0, atol=1e-11)
        v = v + 0.01 * one.a
        r = r + 0.01 * v


@pytest.mark.parametrize("alpha", [1.0, 0.8, 0.4])
@pytest.mark.parametrize(("kind", "alpha_t"), [("history", -0.5), ("dashpot", 0.4)])
@pytest.mark.parametrize("theta", [0.3, 1.5, 6.0])
def test_an_impact_of_small_steps_has_the_outcome_in_closed_form(
    alpha: float, kind: Any, alpha_t: float, theta: float
) -> None:
    mu, k, dt = 0.4, math.pi**2 * 1e7, 1e-6
    friction = GrainFriction(tangential_restitution=alpha_t, static=mu, sliding=mu)
    scene = _scene(
        masses=1.0,
        species=None,
        hard_spheres=HardSpheres(restitution=alpha, friction=friction),
        initial=Explicit(positions=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
    )
    contact = Contact(stiffness=k, friction=kind)
    contacts = Contacts(scene, contact)
    r, v, w = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.array([[0.5, 0, 0], [-0.5, theta, 0]]), np.zeros((2, 3))
    now = contacts.evaluate(r, v, w, 0.0, 0.0)
    for _ in range(1000):
        v, w = v + dt / 2 * now.a, w + dt / 2 * now.spins
        r = r + dt * v
        now = contacts.evaluate(r, v, w, 0.0, dt)
        v, w = v + dt / 2 * now.a, w + dt / 2 * now.spins
        if not now.touching.any():
            break
    g, apart = v[1] - v[0], r[1] - r[0]
    n, along = apart / np.linalg.norm(apart), np.cross([0.0, 0.0, 1.0], apart / np.linalg.norm(apart))
    t_c = math.sqrt((math.pi**2 + math.log(alpha) ** 2) / 2 / k)
    error = 2 * (1 + theta) * t_c + dt / t_c  # of the line of centres, which turns; and of the step
    assert g @ n == pytest.approx(alpha, abs=error)
    slip = g @ along - 0.5 * (w[0, 2] + w[1, 2])
    exact = soft_impact(np.array([theta]), SoftContact(alpha, alpha_t, mu, 0.4, kind))
    assert slip == pytest.approx(float(np.ravel(exact.slip)[0]), abs=(1 + theta) * error)


def _run(scene: Scene, contact: Contact, dt: float) -> dict[str, np.ndarray]:
    """A run by the auditor's own forces."""
    contacts, state = Contacts(scene, contact), scene.initial_state(contact)
    r, v, w = state.positions, state.velocities, np.zeros((3, 3))
    now = contacts.evaluate(r, v, w, 0.0, 0.0)
    samples = [(r, v, w)]
    for step in range(scene.steps(dt)):
        v, w = v + dt / 2 * now.a, w + dt / 2 * now.spins
        r = r + dt * v
        now = contacts.evaluate(r, v, w, (step + 1) * dt, dt)
        v, w = v + dt / 2 * now.a, w + dt / 2 * now.spins
        samples.append((r, v, w))
    names = ("positions", "velocities", "angular_velocities")
    run = {name: np.array(values) for name, values in zip(names, zip(*samples, strict=True), strict=True)}
    return run | {f"final_{name}": run[name][-1] for name in names}


@given(
    name=st.sampled_from(["positions", "velocities", "angular_velocities"]),
    step=st.integers(0, 10),
    grain=st.integers(0, 2),
    axis=st.integers(0, 2),
    off=st.sampled_from([1e-9, -1e-6, 1.0, math.nan]),
)
@settings(deadline=None, max_examples=30)
def test_one_wrong_number_is_seen_where_it_is(name: str, step: int, grain: int, axis: int, off: float) -> None:
    box = Box(lengths=(3.0, 3.0, 3.0), boundaries=("periodic", "hard", "hard"), faces={})
    contact = CONTACTS[0]
    scene, dt = _scene_for(contact, box), 0.01
    run = _run(scene, contact, dt)
    assert audit(scene, contact, dt, run).worst[1].share < 0.5
    run[name][step, grain, axis] += off
    if math.isnan(off) and name == "positions":
        with pytest.raises(ValueError, match="finite"):
            audit(scene, contact, dt, run)
        return
    found = audit(scene, contact, dt, run)
    assert not found.worst[1].share <= 1
    assert found.findings[name].sample in (step, step + 1) or name != "velocities"


def test_a_run_that_is_not_whole_is_refused() -> None:
    scene = _scene_for(CONTACTS[0])
    run = {name: values[:-1] for name, values in _run(scene, CONTACTS[0], 0.01).items()}
    with pytest.raises(ValueError, match="every one of 10 steps"):
        audit(scene, CONTACTS[0], 0.01, run)


def test_friction_of_a_face_is_its_own() -> None:
    smooth = Box(lengths=(3.0, 3.0, 3.0), boundaries=("hard",) * 3)
    friction = Friction(tangential_restitution=0.0, static=0.2, sliding=0.2)
    rough = smooth.model_copy(update={"faces": {"x-": Face(friction=friction)}})
    (r, v, w), spins = _state(1), []
    r[:, 0] -= 0.55
    for box in (smooth, rough):
        contacts = Contacts(_scene_for(CONTACTS[0], box), CONTACTS[0])
        contacts.evaluate(r, v, w, 0.0, 0.0)
        spins.append(contacts.evaluate(r, v, w, 0.01, 0.01))
    assert (spins[0].walls[0, 1:] == 0).all()
    assert (spins[1].walls[0, 1:] != 0).all()
    assert spins[0].walls[0, 0] == spins[1].walls[0, 0] < 0


@pytest.mark.parametrize("curved", [False, True])
def test_when_springs_turn_matters_at_curved_walls_alone(curved: bool) -> None:
    rough = Friction(tangential_restitution=-0.4, static=0.5, sliding=0.5)
    box = Box(lengths=(4.0, 4.0, 4.0), boundaries=("open", "hard", "open"), faces={"y-": Face(friction=rough)})
    if curved:
        cylinder = Cylinder(radius=1.5, axis="z", friction=rough)
        box = Box(lengths=(4.0, 4.0, 4.0), boundaries=("open",) * 3, cylinder=cylinder)
    scene = _scene(box, masses=1.0)
    after = []
    for turned in (False, True):
        contacts = Contacts(scene, CONTACTS[0], turned)
        for step in range(20):
            # one grain slides along the wall, the others are far from all
            angle = 0.05 * step
            place = [2 - 1.1 * math.cos(angle), 2 + 1.1 * math.sin(angle), 2.0] if curved else [2.0 + angle, 0.45, 2.0]
            velocity = [math.sin(angle), math.cos(angle), 0.3] if curved else [1.0, 0.0, 0.3]
            r = np.array([place, [2.3, 2.0, 5.0], [2.3, 2.0, 9.0]])
            now = contacts.evaluate(r, np.array([velocity, [0.0] * 3, [0.0] * 3]), np.zeros((3, 3)), 0.0, 0.01)
        assert now.touching.sum() == 1
        after.append(now.a[0])
    assert np.allclose(*after, rtol=1e-12, atol=0) is not curved
