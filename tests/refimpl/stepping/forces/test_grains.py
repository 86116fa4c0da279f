"""Soft grains against the plain sum over contacts, against closed forms, and against the laws of mechanics."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    NEEDS_CAPACITY,
    accelerate,
    energy_and_virial,
    enlarge,
    kinetic_energy,
    status,
)
from refimpl.stepping.forces.grains import ContactLaw, Grains, SoftCylinder, SoftPlane, coordinates, grains
from refimpl.stepping.integrate import integrate
from refimpl.stepping.kernels.contact_lists import BUILDS, CONTACTS, EVALUATIONS
from refimpl.stepping.schemes import SCHEMES

EPSILON = np.finfo(float).eps
#: Roundings in one term of a sum over contacts, and in one number carried from one evaluation to the next.
ROUNDINGS = 4
#: (dimension, rough): each is a compilation of its own, all else is data.
KINDS = [(2, True), (3, True), (2, False), (3, False)]


# -- the equations of the module, without any list ---------------------------------------------------------------------


class Contact(NamedTuple):
    """Of grains i and j, or of grain i and the wall of index -1 - j. force: on i, with the tangential part."""

    i: int
    j: int
    delta: float
    normal: np.ndarray
    force: np.ndarray
    tangential: np.ndarray
    arms: tuple[float, float]
    virial: float
    size: float


class Plain:
    """Grains of the same keyword arguments as `grains`, all pairs and walls one by one; it keeps the stretches.

    Vectors have three components. `size` of a contact bounds its force times what rounding of the places does to it.
    """

    def __init__(self, **arguments: Any) -> None:
        self.arguments = {
            "inertia": None,
            "gravity": None,
            "walls": (),
            "cylinder": None,
            "hertz": False,
            "damping": "restitution",
            "history": True,
            "granular": False,
            "tallies": False,
        } | arguments
        self.radii, self.masses = self.arguments["radii"], self.arguments["masses"]
        self.dimension, self.number = len(self.arguments["lengths"]), len(self.radii)
        self.rough = self.arguments["inertia"] is not None
        self.stretches: dict[tuple[int, int], np.ndarray] = {}
        self.clock = None

    def unpacked(self, flat: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Vectors of the grains' places and turns, (N, 3) both, and the rest, which the clock begins."""
        d, number = self.dimension, self.number
        places, turns = np.zeros((number, 3)), np.zeros((number, 3))
        places[:, :d] = flat[: d * number].reshape(number, d)
        spin = (3 if d == 3 else 1) * self.rough
        turns[:, 3 - spin :] = flat[d * number : (d + spin) * number].reshape(number, spin)
        return places, turns, flat[(d + spin) * number :]

    def contacts(self, r: np.ndarray, v: np.ndarray) -> list[Contact]:
        """All contacts; the stretches are brought forward to the clock in r."""
        x, _, (time, *_) = self.unpacked(r)
        velocities, spins, _ = self.unpacked(v)
        elapsed = 0.0 if self.clock is None else time - self.clock
        self.clock = time
        arguments, radii, masses = self.arguments, self.radii, self.masses
        sides = np.full(3, np.inf)
        for axis, (length, periodic) in enumerate(zip(arguments["lengths"], arguments["periodic"], strict=True)):
            sides[axis] = length if periodic else np.inf
        before, self.stretches = self.stretches, {}
        found = []
        place = 1 + np.abs(x).max()

        def touch(i, j, law, delta, n, g, turning, mass, radius, arms, distance):  # type: ignore[no-untyped-def]
            if delta <= 0:
                return
            normal, tangential, stretch, size = self.force(
                law, delta, n, g, turning, mass, radius, before.get((i, j), np.zeros(3)), elapsed
            )
            self.stretches[i, j] = stretch
            size *= 1 + place / delta
            found.append(Contact(i, j, delta, n, normal * n + tangential, tangential, arms, distance * normal, size))

        for i in range(self.number):
            for j in range(i + 1, self.number):
                apart = x[i] - x[j]
                images = np.where(np.isfinite(sides), np.rint(apart / sides), 0.0)
                apart = apart - np.where(images != 0, images * np.where(images != 0, sides, 0.0), 0.0)
                distance = np.linalg.norm(apart)
                delta = radii[i] + radii[j] - distance
                shorter = delta / 2 if arguments["granular"] else 0.0
                touch(
                    i,
                    j,
                    arguments["law"],
                    delta,
                    apart / distance,
                    velocities[i] - velocities[j],
                    radii[i] * spins[i] + radii[j] * spins[j],
                    masses[i] * masses[j] / (masses[i] + masses[j]),
                    1 / (1 / radii[i] + 1 / radii[j]),
                    (radii[i] - shorter, radii[j] - shorter),
                    distance,
                )
            for index, wall in enumerate(arguments["walls"]):
                n = np.zeros(3)
                n[wall.axis] = wall.sign
                angle = wall.frequency * time + wall.phase
                face = wall.place * abs(n) + wall.amplitude * np.cos(angle) * n
                speed = -wall.amplitude * wall.frequency * np.sin(angle) * n
                delta, g = radii[i] - (x[i] - face) @ n, velocities[i] - speed
                touch(i, -1 - index, wall.law, delta, n, g, radii[i] * spins[i], masses[i], radii[i], (radii[i], 0), 0)
            if arguments["cylinder"] is not None:
                cylinder = arguments["cylinder"]
                along = np.zeros(3)
                along[cylinder.axis] = 1
                first, second = (axis for axis in range(3) if axis != cylinder.axis)
                # turns from `first` to `second`
                turn = np.zeros(3)
                turn[cylinder.axis] = cylinder.angular_velocity * (-1 if cylinder.axis == 1 else 1)
                middle = np.zeros(3)
                middle[[first, second]] = cylinder.centre
                off = (x[i] - middle) - ((x[i] - middle) @ along) * along
                distance = np.linalg.norm(off)
                n = -off / distance
                delta = radii[i] - (cylinder.radius - distance)
                g = velocities[i] - np.cross(turn, -cylinder.radius * n)
                j = -1 - len(arguments["walls"])
                touch(i, j, cylinder.law, delta, n, g, radii[i] * spins[i], masses[i], radii[i], (radii[i], 0), 0)
        return found

    def force(self, law, delta, n, g, turning, mass, radius, stretch, elapsed):  # type: ignore[no-untyped-def]
        """F_n, F_t, the stretch, and the sum of the sizes of the terms of both forces."""
        arguments = self.arguments
        s = np.sqrt(radius * delta) if arguments["hertz"] else 1.0
        if arguments["damping"] == "mass":
            eta, eta_t = law.damping * s * mass, law.tangential_damping * s * mass
        else:
            root = np.sqrt(s * mass * law.stiffness)
            eta, eta_t = law.damping * root, law.tangential_damping * root
        v_n = g @ n
        normal = s * law.stiffness * delta - eta * v_n
        speed = np.linalg.norm(g) + np.linalg.norm(turning)
        size = s * law.stiffness * delta + (eta + eta_t) * speed
        if not self.rough:
            return normal, np.zeros(3), stretch, size
        u = g - v_n * n - np.cross(turning, n)
        limit = law.friction * abs(normal)
        if not arguments["history"]:
            f = -eta_t * u
            return normal, f * min(1.0, limit / max(np.linalg.norm(f), 1e-300)), stretch, size
        if arguments["granular"]:
            flat = stretch - (stretch @ n) * n
            if flat.any():
                stretch = flat * np.linalg.norm(stretch) / np.linalg.norm(flat)
        stretch = stretch + u * elapsed
        unloaded = not stretch.any()
        stretch = stretch - (stretch @ n) * n
        stiffness = s * law.tangential_stiffness
        f = -stiffness * stretch - eta_t * u
        size += stiffness * (np.linalg.norm(stretch) + speed * elapsed)
        if np.linalg.norm(f) > limit:
            # LAMMPS: a dashpot beyond the limit does nothing as long as there is no stretch
            f = f * (0.0 if unloaded else limit / np.linalg.norm(f))
            stretch = stretch if unloaded else -(f + eta_t * u) / stiffness
        return normal, f, stretch, size

    def accelerations(self, r: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What `accelerate` returns, and the bound of its rounding, both of the shape of r."""
        d, arguments, radii, masses = self.dimension, self.arguments, self.radii, self.masses
        walls = len(arguments["walls"]) + 1
        forces, torques, sizes = np.zeros((self.number, 3)), np.zeros((self.number, 3)), np.zeros(self.number)
        count, virial, on_walls, torque, wall_sizes = 0, 0.0, np.zeros((walls, 3)), 0.0, 0.0
        for contact in self.contacts(r, v):
            i, j = contact.i, contact.j
            twist = np.cross(contact.normal, contact.tangential)
            forces[i] += contact.force
            torques[i] -= contact.arms[0] * twist
            sizes[i] += contact.size
            if j >= 0:
                forces[j] -= contact.force
                torques[j] -= contact.arms[1] * twist
                sizes[j] += contact.size
                count, virial = count + 1, virial + contact.virial
            else:
                on_walls[-1 - j] -= contact.force
            wall_sizes += contact.size * 2 * radii.max()
            if -1 - j == len(arguments["walls"]):
                cylinder = arguments["cylinder"]
                # the grain's surface, where its arm R ends
                reach = cylinder.radius + contact.delta
                side = np.cross(-reach * contact.normal, contact.tangential)[cylinder.axis]
                torque += side * (-1 if cylinder.axis == 1 else 1)
                wall_sizes += contact.size * cylinder.radius
        gravity = np.zeros(d) if arguments["gravity"] is None else np.asarray(arguments["gravity"])
        parts = [(forces[:, :d] / masses[:, None] + gravity).ravel()]
        bounds = [np.repeat(sizes / masses + np.abs(gravity).max(), d)]
        if self.rough:
            spin = 3 if d == 3 else 1
            inertias = arguments["inertia"] * masses * radii**2
            parts.append((torques[:, 3 - spin :] / inertias[:, None]).ravel())
            bounds.append(np.repeat(sizes * radii / inertias, spin))
        parts.append(np.zeros(1))
        if arguments["tallies"]:
            parts += [np.array([count, virial]), on_walls[:, :d].ravel(), np.array([torque])]
        bounds.append(np.full(sum(map(len, parts)) - sum(map(len, bounds)), wall_sizes))
        return np.concatenate(parts), ROUNDINGS * EPSILON * np.concatenate(bounds)


def evaluated(force: Grains, r: np.ndarray, v: np.ndarray) -> tuple[Grains, np.ndarray]:
    """Accelerations, and the force, enlarged as often as it asks."""
    a = accelerate(force, r, v)
    while status(force) == NEEDS_CAPACITY:
        assert np.isnan(a).all()
        force = enlarge(force)
        a = accelerate(force, r, v)
    return force, a


def moved(
    force: Any, r: np.ndarray, v: np.ndarray, dt: float, steps: int, scheme: str = "velocity_verlet"
) -> tuple[Any, list[tuple[np.ndarray, np.ndarray]]]:
    """The force and all states of so many steps, taken in Python: nothing but the force is compiled."""
    record = SCHEMES[scheme].record
    force = evaluated(force, r, v)[0]
    memory = record.start(force, r, v, dt)
    states = [(r, v)]
    for _ in range(steps):
        r_new, v_new, memory_new = record.step(force, r, v, memory, dt)
        while status(force) == NEEDS_CAPACITY:
            force = enlarge(force)
            r_new, v_new, memory_new = record.step(force, r, v, memory, dt)
        assert status(force) == GOOD
        r, v, memory = r_new, v_new, memory_new
        states.append((r, v))
    return force, states


def jittered(rng: np.random.Generator, number: int, dimension: int, spacing: float) -> np.ndarray:
    """`number` sites of a square or cubic lattice in random order, displaced by up to 0.12 spacings, (N, d)."""
    edge = max(3, int(np.ceil(number ** (1 / dimension))))
    sites = np.stack(np.meshgrid(*[np.arange(edge)] * dimension), axis=-1).reshape(-1, dimension)
    return (rng.permutation(sites)[:number] + 0.5 + rng.uniform(-0.12, 0.12, (number, dimension))) * spacing


def random_law(rng: np.random.Generator) -> ContactLaw:
    mu = rng.choice([0.0, 0.2, 0.7, np.inf])
    return ContactLaw(*rng.uniform([50.0, 0.0, 10.0, 0.0], [200.0, 0.5, 100.0, 0.5]), mu)


def random_arguments(rng: np.random.Generator, dimension: int, rough: bool, number: int) -> dict[str, Any]:
    """A bed of overlapping grains of unlike sizes and masses, everything but its dimension and roughness at random."""
    lengths = np.full(dimension, 0.85 * max(3, int(np.ceil(number ** (1 / dimension)))))
    periodic = rng.integers(0, 2, dimension).astype(bool)
    walls = [
        SoftPlane(axis, sign, 0.0 if sign > 0 else lengths[axis], random_law(rng), *motion)
        for axis in range(dimension)
        for sign in (1, -1)
        for motion in ((), (0.1, 7.0, rng.uniform(0, 6)))
        if not periodic[axis] and rng.random() < 0.5
    ]
    cylinder = None
    axis = 2 if dimension == 2 else int(rng.integers(3))
    across = [k for k in range(dimension) if k != axis]
    if not periodic[across].any() and rng.random() < 0.7:
        middle = tuple(lengths[across] / 2 + rng.uniform(-0.1, 0.1, 2))
        cylinder = SoftCylinder(0.5 * lengths[0], middle, random_law(rng), axis, rng.uniform(-2, 2))
    return {
        "radii": rng.uniform(0.35, 0.55, number),
        "masses": rng.uniform(0.5, 2.0, number),
        "lengths": lengths.tolist(),
        "periodic": periodic.tolist(),
        "law": random_law(rng),
        "inertia": rng.uniform(0.2, 0.6) if rough else None,
        "gravity": None if rng.random() < 0.3 else rng.normal(size=dimension),
        "walls": walls,
        "cylinder": cylinder,
        "hertz": bool(rng.integers(2)),
        "damping": str(rng.choice(["mass", "restitution"])),
        "history": bool(rng.integers(2)),
        "granular": bool(rng.integers(2)),
        "tallies": bool(rng.integers(2)),
    }


def random_state(
    rng: np.random.Generator, force: Grains, places: np.ndarray, speed: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    number, dimension = places.shape
    spins = None
    if force.inverse_inertias is not None:
        spins = speed * rng.normal(size=(number, 3 if dimension == 3 else 1))
    return coordinates(force, places, speed * rng.normal(size=places.shape), spins)


# -- against the plain sum ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("dimension", "rough"), KINDS)
@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(1, 14), images_away=st.sampled_from([0, 2]))
def test_fast_equals_plain(dimension, rough, seed, number, images_away):
    rng = np.random.default_rng(seed)
    arguments = random_arguments(rng, dimension, rough, number)
    # 0.02: boxes of three spacings have two cells a side, larger skins one
    force, plain = grains(**arguments, skin=rng.choice([0.02, 0.3])), Plain(**arguments)
    places = jittered(rng, number, dimension, 0.85)
    away = images_away * rng.integers(-1, 2, places.shape) * np.where(arguments["periodic"], arguments["lengths"], 0.0)
    r, v = random_state(rng, force, places + away)
    clock = r.size - force.auxiliary
    for _ in range(4):
        expected, bound = plain.accelerations(r, v)
        force, a = evaluated(force, r, v)
        assert status(force) == GOOD
        assert (np.abs(a - expected) <= bound).all()
        r, v = r.copy(), v.copy()
        r[: number * dimension] += rng.uniform(-0.06, 0.06, number * dimension)
        v[:clock] += rng.normal(size=clock)
        r[clock] += rng.uniform(0.005, 0.02)


@pytest.mark.parametrize("dimension", [2, 3])
@settings(max_examples=25)
@given(
    seed=st.integers(0, 2**32 - 1),
    number=st.integers(1, 120),
    skin=st.sampled_from([None, 0.0, 0.01, 1.0]),
    shape=st.sampled_from(["cube", "rod", "flat", "scattered"]),
)
def test_no_pair_is_missed(dimension, seed, number, skin, shape):
    rng = np.random.default_rng(seed)
    lengths = rng.uniform(4.1, 9.0, dimension)
    lengths[0] *= {"cube": 1, "rod": 20, "flat": 1, "scattered": 100}[shape]
    periodic = rng.integers(0, 2, dimension).astype(bool)
    radii, masses = rng.uniform(0.3, 1.0, number), rng.uniform(0.5, 2.0, number)
    force = grains(
        radii=radii,
        masses=masses,
        lengths=lengths.tolist(),
        periodic=periodic.tolist(),
        law=ContactLaw(10.0),
        skin=skin,
    )
    x = rng.uniform(-1, 2, (number, dimension)) * lengths
    if shape == "flat":
        x[:, -1] = 1.0
    apart = x[:, None] - x
    apart -= np.where(periodic, lengths * np.rint(apart / lengths), 0.0)
    distance = np.linalg.norm(apart, axis=2) + np.eye(number)
    delta = np.maximum(radii[:, None] + radii - distance, 0.0) * (1 - np.eye(number))
    forces = ((10 * delta / distance)[:, :, None] * apart).sum(axis=1)
    rounding = (10 * (delta > 0) * (1 + delta / distance)).sum(axis=1)[:, None] * (1 + np.abs(x).max())
    _, a = evaluated(force, *coordinates(force, x, np.zeros_like(x)))
    bound = ROUNDINGS * EPSILON * rounding / masses[:, None]
    assert (np.abs(a[:-1].reshape(x.shape) - forces / masses[:, None]) <= bound).all()


@pytest.mark.parametrize("hertz", [False, True])
def test_a_pair_in_numbers(hertz):
    """delta = 0.01, v_n = -2, m_eff = 3/4, R_eff = 1/6: F_n with k = 100 and c = 0.2, and sliding with mu = 1/2."""
    force = grains(
        radii=np.array([0.5, 0.25]),
        masses=np.array([1.0, 3.0]),
        lengths=[9.0, 9.0],
        periodic=[False, False],
        law=ContactLaw(100.0, 0.2, 0.0, 3.0, 0.5),
        inertia=0.5,
        hertz=hertz,
        history=False,
    )
    s = np.sqrt(0.01 / 6) if hertz else 1.0
    normal = 100 * s * 0.01 + 0.2 * np.sqrt(0.75 * 100 * s) * 2
    r, v = coordinates(force, np.array([[0.0, 0.0], [0.74, 0.0]]), np.array([[2.0, 7.0], [0.0, 0.0]]))
    _, a = evaluated(force, r, v)
    # the left one moves up: it is held back, the right one is taken along, and both turn anticlockwise
    expected = [-normal, -normal / 2, normal / 3, normal / 6]
    torques = [-normal / 2 * 0.5 / (0.5 * 1 * 0.25), -normal / 2 * 0.25 / (0.5 * 3 * 0.0625)]
    np.testing.assert_allclose(a, [*expected, *torques, 0.0], rtol=100 * EPSILON)
    # rolling on each other, they do not rub
    v[:] = [0, 0, 0, 0, 2.0, -4.0, 1.0]
    np.testing.assert_allclose(evaluated(force, r, v)[1][4:], 0.0, atol=0)


# -- laws --------------------------------------------------------------------------------------------------------------


def inner_arguments(
    rng: np.random.Generator, dimension: int, rough: bool, number: int, **changes: Any
) -> dict[str, Any]:
    """Grains that only other grains act on, in open space."""
    absent = {"walls": (), "cylinder": None, "gravity": None, "tallies": False, "periodic": [False] * dimension}
    return random_arguments(rng, dimension, rough, number) | absent | changes


@pytest.mark.parametrize(("dimension", "rough"), KINDS)
@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(2, 14), periodic=st.booleans())
def test_momentum_is_kept(dimension, rough, seed, number, periodic):
    rng = np.random.default_rng(seed)
    arguments = inner_arguments(rng, dimension, rough, number, periodic=[periodic] * dimension)
    force, plain = grains(**arguments), Plain(**arguments)
    r, v = random_state(rng, force, jittered(rng, number, dimension, 0.85))
    for _ in range(2):
        force, a = evaluated(force, r, v)
        weights = arguments["masses"][:, None]
        rate = (weights * a[: number * dimension].reshape(number, dimension)).sum(axis=0)
        bound = plain.accelerations(r, v)[1][: number * dimension].reshape(number, dimension)
        assert (np.abs(rate) <= (weights * bound).sum(axis=0)).all()
        r = r + 0.01 * v


def rotation(rng: np.random.Generator, dimension: int) -> np.ndarray:
    """A random rotation of three-vectors, about z for the plane."""
    q, upper = np.linalg.qr(rng.normal(size=(dimension, dimension)))
    q = q * np.sign(np.diag(upper))
    q[:, 0] *= np.sign(np.linalg.det(q))
    turn = np.eye(3)
    turn[:dimension, :dimension] = q
    return turn


@pytest.mark.parametrize("dimension", [2, 3])
@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(2, 10))
def test_axes_labels_and_frame_do_not_matter(dimension, seed, number):
    rng = np.random.default_rng(seed)
    arguments = inner_arguments(rng, dimension, True, number)
    order, turn, boost = rng.permutation(number), rotation(rng, dimension), np.zeros(3)
    boost[:dimension] = rng.normal(size=dimension)
    relabelled = {name: arguments[name][order] for name in ("radii", "masses")}
    force, plain, other = grains(**arguments), Plain(**arguments), grains(**(arguments | relabelled))

    def seen(flat: np.ndarray, shift: np.ndarray) -> np.ndarray:
        places, turns, rest = plain.unpacked(flat)
        places, turns = (places @ turn.T + shift)[order, :dimension], (turns @ turn.T)[order]
        return np.concatenate([places.ravel(), turns[:, 0 if dimension == 3 else 2 :].ravel(), rest])

    r, v = random_state(rng, force, jittered(rng, number, dimension, 0.85))
    for step in range(3):
        force, a = evaluated(force, r, v)
        other, b = evaluated(other, seen(r, boost * step), seen(v, boost))
        # three coordinates mix in each, so that a bound of all holds for each; the frame moves the places by a boost
        bound = plain.accelerations(r, v)[1].max() * 3 * (1 + 2 * np.abs(boost).max())
        np.testing.assert_allclose(b, seen(a, np.zeros(3)), rtol=0, atol=bound)
        r, v = r + 0.01 * v, v.copy()
        r[-1] = 0.01 * (step + 1)
        v[:-1] += 0.1 * rng.normal(size=v.size - 1)


def angular_momentum(plain: Plain, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    x, _, _ = plain.unpacked(r)
    velocities, spins, _ = plain.unpacked(v)
    inertias = plain.arguments["inertia"] * plain.masses * plain.radii**2
    return (plain.masses[:, None] * np.cross(x, velocities) + inertias[:, None] * spins).sum(axis=0)


@pytest.mark.parametrize("history", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_angular_momentum_is_kept_with_granular_arms(dimension, history):
    """The arms of a granular pair add up to r_ij; velocity Verlet is the trapezoidal rule, exact for r x v too."""
    rng = np.random.default_rng(dimension)
    arguments = inner_arguments(
        rng, dimension, True, 10, history=history, granular=True, law=ContactLaw(1e3, 0.2, 3e2, 0.1, 0.5)
    )
    plain = Plain(**arguments)
    _, states = moved(*started(rng, arguments), 1e-3, 200)
    momenta = np.array([angular_momentum(plain, *state) for state in states])
    size = max(np.abs(v).max() * np.abs(r).max() for r, v in states) * plain.masses.sum()
    assert np.abs(momenta - momenta[0]).max() <= ROUNDINGS * EPSILON * size * np.sqrt(len(states))
    assert np.abs(states[-1][1] - states[0][1]).max() > 0.1


def started(
    rng: np.random.Generator, arguments: dict[str, Any], **options: Any
) -> tuple[Grains, np.ndarray, np.ndarray]:
    force = grains(**arguments, **options)
    dimension, number = len(arguments["lengths"]), len(arguments["radii"])
    return force, *random_state(rng, force, jittered(rng, number, dimension, 0.85))


@pytest.mark.parametrize("dimension", [2, 3])
def test_classic_arms_lose_angular_momentum_at_the_rate_of_the_overlap(dimension):
    """Arms R_i + R_j = r_ij + delta: dL/dt = - sum of delta n x F."""
    rng = np.random.default_rng(dimension)
    arguments = inner_arguments(rng, dimension, True, 10, granular=False, law=ContactLaw(1e3, 0.2, 3e2, 0.1, 0.5))
    force, r, v = started(rng, arguments)
    plain = Plain(**arguments)
    for _ in range(2):
        force, a = evaluated(force, r, v)
        x, _, _ = plain.unpacked(r)
        forces, turns, _ = plain.unpacked(a)
        inertias = arguments["inertia"] * plain.masses * plain.radii**2
        rate = (plain.masses[:, None] * np.cross(x, forces) + inertias[:, None] * turns).sum(axis=0)
        contacts = plain.contacts(r, v)
        expected = -sum(contact.delta * np.cross(contact.normal, contact.tangential) for contact in contacts)
        bound = ROUNDINGS * EPSILON * sum(contact.size for contact in contacts) * (1 + np.abs(x).max())
        assert np.abs(rate - expected).max() <= bound
        r = r + 0.01 * v
    assert np.abs(expected).max() > 1e6 * bound


def packing(hertz: bool) -> tuple[Grains, np.ndarray, np.ndarray]:
    """A dense periodic triangular lattice whose contacts all last, elastic and smooth, near its rest."""
    edge, spacing = 6, 0.9
    rows, columns = np.divmod(np.arange(edge * edge), edge)
    x = spacing * np.stack([columns + 0.5 * (rows % 2), np.sqrt(0.75) * rows], axis=1)
    force = grains(
        radii=np.full(len(x), 0.5),
        masses=np.ones(len(x)),
        lengths=[edge * spacing, edge * spacing * np.sqrt(0.75)],
        periodic=[True, True],
        law=ContactLaw(1e3),
        hertz=hertz,
    )
    return force, *coordinates(force, x, 0.2 * np.random.default_rng(3).normal(size=x.shape))


@pytest.mark.parametrize("hertz", [False, True])
def test_energy_of_lasting_contacts_is_bounded_and_of_second_order(hertz):
    spread = []
    for dt, steps in ((4e-3, 150), (2e-3, 300)):
        force, states = moved(*packing(hertz), dt, steps)
        energies = np.array([kinetic_energy(force, v) + energy_and_virial(force, r)[0] for r, v in states])
        spread.append(np.std(energies))
        # ten periods of the lattice: a drift as large as the scatter would show in the means of the two halves
        first, second = np.array_split(energies, 2)
        assert abs(second.mean() - first.mean()) < 0.2 * spread[-1]
    # the next term is smaller by (omega dt)^2, omega^2 = 6 k/m
    assert spread[0] / spread[1] == pytest.approx(4, rel=6e3 * 4e-3**2)


@pytest.mark.parametrize(("hertz", "order"), [(False, 2.0), (True, 2.5)])
def test_energy_of_elastic_impacts_by_order(hertz, order):
    """The shadow energy differs from the energy by dt^2 times terms in F^2 and F': at the first touch delta = O(dt),
    F' = k leaves dt^2, and F' ~ sqrt(delta) leaves dt^2.5. Either end of a contact has a phase of its own.
    """
    number, loss = 256, []
    place = np.arange(number)
    for dt in (4e-3, 1e-3):
        x, v = np.zeros((2 * number, 2)), np.zeros((2 * number, 2))
        x[:, 1] = np.repeat(2.0 * place, 2)
        # the golden section: even phases of the first touch; by the masses, of the last
        x[1::2, 0] = 1 + 2 * dt * ((place * 0.5 * (np.sqrt(5) - 1)) % 1)
        v[::2, 0], v[1::2, 0] = 1.0, -1.0
        force = grains(
            radii=np.full(2 * number, 0.5),
            masses=np.repeat(np.linspace(0.5, 1.5, number), 2),
            lengths=[9.0, 9.0],
            periodic=[False, False],
            law=ContactLaw(1e3),
            hertz=hertz,
        )
        _, states = moved(force, *coordinates(force, x, v), dt, round((0.35 if hertz else 0.12) / dt))
        after = states[-1][1][:-1].reshape(-1, 2)[::2, 0]
        assert (after < 0).all()
        loss.append(np.sqrt(np.mean((after**2 - 1) ** 2)))
    # of phases at random, a root mean square of n would scatter by 1/sqrt(2 n): the order by four times this
    error = 4 * np.sqrt(2 / (2 * number)) / np.log(4)
    assert np.log(loss[0] / loss[1]) / np.log(4) == pytest.approx(order, abs=error)


@pytest.mark.parametrize("hertz", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_elastic_force_is_minus_the_gradient_of_the_energy(dimension, hertz):
    rng = np.random.default_rng(dimension)
    lengths = [0.85 * 3] * dimension
    middle = (lengths[0] / 2, lengths[0] / 2)
    force = grains(
        radii=rng.uniform(0.35, 0.55, 8),
        masses=rng.uniform(0.5, 2.0, 8),
        lengths=lengths,
        periodic=[False] * dimension,
        law=ContactLaw(100.0),
        gravity=rng.normal(size=dimension),
        walls=[SoftPlane(axis, 1, 0.3, ContactLaw(150.0), 0.2, 3.0, 1.0) for axis in range(dimension)],
        cylinder=SoftCylinder(1.2, middle, ContactLaw(70.0)),
        hertz=hertz,
        tallies=True,
    )
    r, v = coordinates(force, jittered(rng, 8, dimension, 0.85), np.zeros((8, dimension)))
    force, a = evaluated(force, r, v)
    step = 1e-5
    for k in range(8 * dimension):
        nearby = np.array([r] * 4)
        nearby[:, k] += step * np.array([-2, -1, 1, 2])
        u = [energy_and_virial(force, places)[0] for places in nearby]
        gradient = (u[0] - 8 * u[1] + 8 * u[2] - u[3]) / (12 * step)
        # the rounding of energies of some hundreds, over the step
        assert force.masses[k // dimension] * a[k] == pytest.approx(-gradient, abs=1e3 * EPSILON / step)


@pytest.mark.parametrize("dimension", [2, 3])
def test_kinetic_energy_counts_masses_and_inertias(dimension):
    rng = np.random.default_rng(9)
    arguments = inner_arguments(rng, dimension, True, 5, tallies=True)
    force, _, v = started(rng, arguments)
    # integrals do not count
    v[-force.auxiliary :] = 7.0
    velocities, spins, _ = Plain(**arguments).unpacked(v)
    inertias = arguments["inertia"] * arguments["masses"] * arguments["radii"] ** 2
    parts = [arguments["masses"] @ (velocities**2).sum(axis=1), inertias @ (spins**2).sum(axis=1)]
    assert kinetic_energy(force, v) == pytest.approx(0.5 * sum(parts), rel=100 * EPSILON)


# -- the stretch of a contact ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("friction", [10.0, np.inf])
@pytest.mark.parametrize("granular", [False, True])
def test_a_stretch_turns_with_its_contact(granular, friction):
    """Two grains stuck to each other turn by a right angle: the stretch stays tangential. `granular` keeps its length,
    otherwise each step of 1 degree takes a share of 1 - cos off.
    """
    force = grains(
        radii=np.full(2, 0.5),
        masses=np.ones(2),
        lengths=[9.0, 9.0],
        periodic=[False, False],
        law=ContactLaw(100.0, 0.0, 50.0, 0.0, friction),
        inertia=0.5,
        granular=granular,
    )
    r, v = coordinates(force, np.array([[0.0, 0.0], [0.95, 0.0]]), np.array([[0.0, 0.0], [0.0, 1.0]]))
    accelerate(force, r, v)
    r[-1] = 0.01
    accelerate(force, r, v)
    v[:-1] = 0.0
    for degrees in range(1, 91):
        angle = np.deg2rad(degrees)
        r[2:4] = 0.95 * np.cos(angle), 0.95 * np.sin(angle)
        r[-1] += 0.01
        a = accelerate(force, r, v)
    kept = 1.0 if granular else np.cos(np.deg2rad(1)) ** 90
    # 100 x 0.05 along -y, and 50 x 0.01 against the slip, which was to +y and is to -x by now, on the second grain
    np.testing.assert_allclose(a[:4], [-0.5 * kept, -5.0, 0.5 * kept, 5.0], rtol=0, atol=1e3 * EPSILON * 100)


def test_a_dashpot_beside_springs_of_no_stiffness():
    """k_t = 0 with history is the law without history, but for the first evaluation."""
    forces = []
    for history in (False, True):
        force = grains(
            radii=np.full(2, 0.5),
            masses=np.ones(2),
            lengths=[9.0, 9.0],
            periodic=[False, False],
            law=ContactLaw(100.0, 0.0, 0.0, 0.5, 0.1),
            inertia=0.5,
            history=history,
        )
        r, v = coordinates(force, np.array([[0.0, 0.0], [0.95, 0.0]]), np.array([[0.0, 0.0], [0.0, 5.0]]))
        for time in (0.0, 0.01, 0.02):
            r[-1] = time
            a = accelerate(force, r, v)
        forces.append(a)
    np.testing.assert_allclose(forces[1], forces[0], rtol=100 * EPSILON)


@pytest.mark.parametrize("dimension", [2, 3])
@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(2, 10))
def test_an_evaluation_at_the_same_clock_changes_nothing(dimension, seed, number):
    rng = np.random.default_rng(seed)
    arguments = random_arguments(rng, dimension, True, number) | {"history": True}
    force, plain = grains(**arguments), Plain(**arguments)
    r, v = random_state(rng, force, jittered(rng, number, dimension, 0.85))
    for _ in range(3):
        force, first = evaluated(force, r, v)
        _, bound = plain.accelerations(r, v)
        for _ in range(2):
            assert (np.abs(accelerate(force, r, v) - first) <= bound).all()
        r = r + 0.01 * v


# -- the pair list -----------------------------------------------------------------------------------------------------


def gathering(dimension: int, **changes: Any) -> tuple[dict[str, Any], np.ndarray, np.ndarray, np.ndarray]:
    """Rough grains that fly towards each other and stay together: keyword arguments, places, velocities and spins."""
    rng = np.random.default_rng(20 + dimension)
    number = 12
    arguments = inner_arguments(rng, dimension, True, number, history=True, law=ContactLaw(400.0, 1.2, 200.0, 0.1, 0.4))
    x = jittered(rng, number, dimension, 1.3)
    return arguments | changes, x, -2.0 * (x - x.mean(axis=0)), rng.normal(size=(number, 3 if dimension == 3 else 1))


def plain_path(
    arguments: dict[str, Any], r: np.ndarray, v: np.ndarray, dt: float, steps: int
) -> list[tuple[np.ndarray, np.ndarray]]:
    """States of velocity Verlet with the plain sum."""
    plain = Plain(**arguments)
    a, _ = plain.accelerations(r, v)
    states = [(r, v)]
    for _ in range(steps):
        half = v + 0.5 * dt * a
        r = r + dt * half
        a, _ = plain.accelerations(r, half)
        v = half + 0.5 * dt * a
        states.append((r, v))
    return states


@pytest.mark.parametrize("granular", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_stretches_survive_new_lists_and_larger_ones(dimension, granular):
    arguments, x, velocities, spins = gathering(dimension, granular=granular)
    # the first list has room, later ones have not
    wide = 0.8 if dimension == 2 else 1.0
    force = grains(**arguments, skin=wide)
    r, v = coordinates(force, x, velocities, spins)
    steps, dt, nudge = 30, 8e-3, 1e-9
    expected = plain_path(arguments, r, v, dt, steps)[-1]
    disturbed = plain_path(arguments, r, v + nudge * np.cos(np.arange(v.size)) * (v != 1), dt, steps)[-1]
    # an error of rounding in every step, grown as a small change at the start has grown
    growth = 1 + max(np.abs(one - other).max() for one, other in zip(expected, disturbed, strict=True)) / nudge
    bound = ROUNDINGS * EPSILON * steps * growth * np.abs(np.concatenate(expected)).max()
    later, states = moved(force, r, v, dt, steps)
    assert len(later.lists.pairs) > len(force.lists.pairs)
    assert later.lists.bookkeeping[BUILDS] >= 2
    assert np.abs(list(stretched(later).values())).max() > 1e-3
    assert len(stretched(later)) > 8
    for skin in (wide, 0.0, 0.05, None):
        _, states = moved(grains(**arguments, skin=skin), r, v, dt, steps)
        assert np.abs(np.array(states[-1]) - np.array(expected)).max() <= bound


def test_the_compiled_loop_takes_the_same_path():
    arguments, x, velocities, spins = gathering(2)
    force = grains(**arguments, skin=0.8)
    r, v = coordinates(force, x, velocities, spins)
    run = integrate("velocity_verlet", force, r, v, 8e-3, 30, every=10, thermo=True)
    assert len(run.force.lists.pairs) > len(force.lists.pairs)
    later, states = moved(grains(**arguments, skin=0.8), r, v, 8e-3, 30)
    # the same operations in the same order
    np.testing.assert_array_equal([run.r, run.v], states[-1])
    assert run.thermo is not None
    for sample, (r_then, v_then) in enumerate(states[::10]):
        energies = [kinetic_energy(later, v_then), *energy_and_virial(later, r_then)]
        np.testing.assert_allclose(run.thermo[sample], energies, rtol=100 * EPSILON)


def test_a_list_without_room_says_so_and_keeps_what_touches():
    rng = np.random.default_rng(2)
    arguments = inner_arguments(rng, 2, True, 12, law=ContactLaw(400.0, 0.6, 200.0, 0.1, 0.4), history=True)
    force = grains(**arguments, skin=0.05)
    r, v = random_state(rng, force, jittered(rng, 12, 2, 0.95))
    for time in (0.0, 0.01):
        r[-1] = time
        force, _ = evaluated(force, r, v)
    assert len(force.lists.pairs) < 66  # of all pairs
    touching = stretched(force)
    assert len(touching) > 3
    near = r.copy()
    near[:24] *= 0.3
    for _ in range(2):
        assert np.isnan(accelerate(force, near, v)).all()
        assert status(force) == NEEDS_CAPACITY
        assert np.isnan(energy_and_virial(force, near)).all()
    # back where there is room, and with more of it: nothing was lost
    for again in (force, enlarge(force)):
        accelerate(again, r, v)
        assert status(again) == GOOD
        assert stretched(again) == touching


def stretched(force: Grains) -> dict[tuple[int, ...], tuple[float, ...]]:
    """The stretches of the contacts of the last evaluation, by their pairs."""
    lists = force.lists
    last, contacts = lists.bookkeeping[EVALUATIONS] % 2, lists.bookkeeping[CONTACTS]
    rows = zip(lists.ends[last, :contacts].tolist(), lists.stretches[last, :contacts].tolist(), strict=True)
    return {tuple(pair): tuple(stretch) for pair, stretch in rows}


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1e200])
def test_a_lost_grain_is_divergence_and_is_forgiven(bad):
    rng = np.random.default_rng(4)
    arguments = inner_arguments(rng, 2, True, 6)
    force, r, v = started(rng, arguments)
    force, a = evaluated(force, r, v)
    lost = r.copy()
    lost[3] = bad
    assert np.isnan(accelerate(force, lost, v)).all()
    assert status(force) == DIVERGED
    with np.errstate(invalid="ignore"):
        assert np.isnan(energy_and_virial(force, lost)).all()
    np.testing.assert_allclose(accelerate(force, r, v), a, rtol=0, atol=Plain(**arguments).accelerations(r, v)[1].max())
    assert status(force) == GOOD


def test_far_grains_are_not_lost_whatever_their_size_but_leaping_ones_are():
    """Radii 1 : 1e7, the small one first, places of 1e8 small radii; and a whole scene a billion diameters away."""
    radii = np.array([1e-7, 1.0, 1.0])
    arguments = inner_arguments(np.random.default_rng(4), 2, False, 3)
    arguments |= {"radii": radii, "masses": np.ones(3), "law": ContactLaw(1e3, 0.1)}
    for away in (0.0, 2.0e9):
        force = grains(**arguments)
        places = np.array([[10.0, 0.0], [11.5, 0.0], [13.0, 0.0]]) + away
        r, v = coordinates(force, places, np.zeros((3, 2)))
        force, a = evaluated(force, r, v)
        assert status(force) == GOOD
        np.testing.assert_allclose(a[:6], [0, 0, -500, 0, 500, 0], rtol=0, atol=1e3 * EPSILON * (16 + 2 * away))
        reach = 2 + 0.3 * 2
        for leap, outcome in ((0.99e6, GOOD), (1.01e6, DIVERGED)):
            accelerate(force, r, v)
            far = r.copy()
            far[0] += leap * reach
            assert np.isnan(accelerate(force, far, v)).all() == (outcome == DIVERGED)
            assert status(force) == outcome


@pytest.mark.parametrize("boxes", [2**20, 10**9])
def test_contacts_across_faces_are_found_however_many_boxes_away(boxes):
    """Sides and places that wrapping does not round."""
    rng = np.random.default_rng(6)
    arguments = inner_arguments(rng, 2, False, 12, periodic=[True, True], lengths=[4.0, 4.0])
    arguments |= {"radii": np.full(12, 0.5), "masses": np.ones(12)}
    force = grains(**arguments)
    places = rng.integers(0, 2**12, (12, 2)) * 2.0**-10
    r, v = coordinates(force, places, np.zeros((12, 2)))
    far, _ = coordinates(force, places + 4.0 * boxes * rng.integers(-1, 2, (12, 2)), np.zeros((12, 2)))
    force, near = evaluated(force, r, v)
    again, a = evaluated(grains(**arguments), far, v)
    assert status(again) == GOOD
    assert abs(near).max() > 0
    np.testing.assert_allclose(a, near, rtol=0, atol=100 * EPSILON * abs(near).max())


# -- clock, spins and tallies ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["velocity_verlet", "leapfrog", "verlet", "symplectic_euler"])
def test_every_scheme_moves_clock_spins_and_tallies(scheme):
    """A rough disk hits a wall at rest: alpha of its dashpot, alpha_t of its tangential spring, and the wall's push."""
    alpha, alpha_t, k, dt, steps = 0.8, -0.3, 1e4, 1e-4, 600
    decay = np.pi**2 + np.log(alpha) ** 2
    c = -2 * np.log(alpha) / np.sqrt(decay)
    law = ContactLaw(k, c, k * (0.5 / 1.5) * np.arccos(alpha_t) ** 2 / decay, 0.0, np.inf)
    force = grains(
        radii=np.full(1, 0.5),
        masses=np.ones(1),
        lengths=[9.0, 9.0],
        periodic=[True, False],
        law=law,
        inertia=0.5,
        walls=[SoftPlane(1, 1, 0.0, law)],
        tallies=True,
    )
    r, v = coordinates(force, np.array([[0.0, 0.5093]]), np.array([[2.0, -1.0]]), np.array([[3.0]]))
    _, states = moved(force, r, v, dt, steps, scheme)
    r_end, v_end = states[-1]
    assert r_end[3] == pytest.approx(steps * dt, rel=steps * EPSILON)
    w = np.sqrt(k) * dt
    # the dashpot sets in and ends with a jump, up to half a step off; its force lags by half a step
    assert v_end[1] == pytest.approx(alpha, abs=c * w * (1 + alpha) + w**2)
    # the slip 2 + 3/2 turns through arccos(alpha_t) in t_c, whose ends are up to half a step off
    turned = np.arccos(alpha_t) / np.sqrt(decay) * w
    assert v_end[0] + 0.5 * v_end[2] == pytest.approx(alpha_t * 3.5, abs=3.5 * turned)
    # one impulse J: m v_x' - m v_x = J, I omega' - I omega = R J
    assert 0.125 * (v_end[2] - 3) == pytest.approx(0.5 * (v_end[0] - 2), rel=ROUNDINGS * EPSILON * steps / dt)
    # every coordinate goes by the same formula
    np.testing.assert_allclose(v_end[6:8], -(v_end[:2] - v[:2]), rtol=0, atol=ROUNDINGS * EPSILON * steps / dt)
    assert not v_end[8:].any()


def test_tallies_are_the_trapezoids_of_their_rates():
    """Velocity Verlet changes velocities and integrals by the same trapezoids; contacts and virial are of pairs."""
    rng = np.random.default_rng(6)
    law = ContactLaw(1e3, 0.2, 3e2, 0.1, 0.5)
    arguments = random_arguments(rng, 2, True, 12) | {
        "periodic": [False, False],
        "law": law,
        "gravity": None,
        "walls": [SoftPlane(0, 1, 0.3, law), SoftPlane(1, -1, 3.1, law, 0.2, 20.0, 0.3)],
        "cylinder": None,
        "tallies": True,
        "granular": True,
    }
    force, r, v = started(rng, arguments)
    plain = Plain(**arguments)
    force, states = moved(force, r, v, 2e-3, 150)
    momentum = [(plain.masses[:, None] * plain.unpacked(w)[0]).sum(axis=0)[:2] for _, w in states]
    tallies = np.array([w[-force.auxiliary :] for _, w in states])
    on_walls = tallies[:, 3:7].reshape(-1, 2, 2).sum(axis=1)
    bound = ROUNDINGS * EPSILON * len(states) * np.abs(momentum).max() * plain.number
    assert np.abs(on_walls[-1]).min() > 0.1
    assert np.abs(np.array(momentum) - momentum[0] + on_walls).max() <= bound
    rates = np.array(plain_rates(arguments, states, 2e-3))[:, 1 - force.auxiliary :][:, :2]
    expected = 2e-3 * np.cumsum((rates[1:] + rates[:-1]) / 2, axis=0)
    bound = ROUNDINGS * EPSILON * len(states) * np.abs(expected).max()
    assert np.abs(tallies[1:, 1:3] - expected).max() <= bound


def plain_rates(arguments: dict[str, Any], states: list[tuple[np.ndarray, np.ndarray]], dt: float) -> list[np.ndarray]:
    """Accelerations that velocity Verlet has met on its way."""
    plain = Plain(**arguments)
    rates = [plain.accelerations(*states[0])[0]]
    for (_, before), (r, _) in pairwise(states):
        rates.append(plain.accelerations(r, before + 0.5 * dt * rates[-1])[0])
    return rates


@pytest.mark.parametrize(("dimension", "axis"), [(2, 2), (3, 0), (3, 1), (3, 2)])
def test_the_torque_of_a_cylinder_is_what_turns_the_grains(dimension, axis):
    """Angular momentum about the axis, of a bed whose pairs keep it: exact with velocity Verlet."""
    rng = np.random.default_rng(7)
    law = ContactLaw(1e3, 0.2, 3e2, 0.1, 0.5)
    cylinder = SoftCylinder(1.3, (1.2, 1.35), law, axis, 2.0)
    arguments = inner_arguments(rng, dimension, True, 8, law=law, cylinder=cylinder, tallies=True, granular=True)
    force, r, v = started(rng, arguments)
    plain = Plain(**arguments)
    first, second = (k for k in range(3) if k != axis)
    middle = np.zeros(3)
    middle[[first, second]] = cylinder.centre
    force, states = moved(force, r, v, 2e-3, 100)

    def about_the_axis(r: np.ndarray, v: np.ndarray) -> float:
        x, _, _ = plain.unpacked(r)
        velocities, spins, _ = plain.unpacked(v)
        inertias = arguments["inertia"] * plain.masses * plain.radii**2
        momentum = plain.masses[:, None] * np.cross(x - middle, velocities) + inertias[:, None] * spins
        return float(momentum.sum(axis=0)[axis]) * (-1 if axis == 1 else 1)

    momenta = np.array([about_the_axis(*state) for state in states])
    torques = np.array([w[-1] for _, w in states])
    bound = ROUNDINGS * EPSILON * len(states) * np.abs(momenta).max() * plain.number
    assert np.abs(momenta - momenta[0] - torques).max() <= bound


def test_the_contact_time_of_an_impact():
    """t_c = sqrt((pi^2 + ln^2 alpha) m_eff/k): either end is off by a step at most."""
    alpha, k, dt = 0.7, 1e4, 2e-5
    decay = np.pi**2 + np.log(alpha) ** 2
    force = grains(
        radii=np.full(2, 0.5),
        masses=np.array([1.0, 3.0]),
        lengths=[9.0, 9.0],
        periodic=[False, False],
        law=ContactLaw(k, -2 * np.log(alpha) / np.sqrt(decay)),
        tallies=True,
    )
    r, v = coordinates(force, np.array([[0.0, 0.0], [1.001, 0.0]]), np.array([[1.0, 0.0], [0.0, 0.0]]))
    _, states = moved(force, r, v, dt, 2500)
    assert states[-1][1][-force.auxiliary + 1] == pytest.approx(np.sqrt(decay * 0.75 / k), abs=2 * dt)


# -- what is refused ---------------------------------------------------------------------------------------------------

GOOD_ARGUMENTS: dict[str, Any] = {
    "radii": np.full(3, 0.5),
    "masses": np.ones(3),
    "lengths": [9.0, 9.0],
    "periodic": [True, False],
    "law": ContactLaw(1.0),
}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"lengths": [9.0]}, "2 or 3 values"),
        ({"lengths": [9.0] * 4, "periodic": [True] * 4}, "2 or 3 values"),
        ({"periodic": [True]}, "2 or 3 values"),
        ({"masses": np.ones(2)}, "one each for every grain"),
        ({"masses": np.array([1.0, 0.0, 1.0])}, "positive and finite"),
        ({"radii": np.array([0.5, np.nan, 0.5])}, "positive and finite"),
        ({"radii": np.array([0.5, -0.5, 0.5])}, "positive and finite"),
        ({"gravity": (0.0, 0.0, -1.0)}, "gravity must have 2 finite components"),
        ({"inertia": 0.0}, "inertia is q"),
        ({"inertia": 1.5}, "inertia is q"),
        ({"damping": "viscous"}, "damping must be"),
        ({"lengths": [2.0, 9.0]}, "must exceed two diameters"),
        ({"law": ContactLaw(0.0)}, "a contact law needs"),
        ({"law": ContactLaw(1.0, -0.1)}, "a contact law needs"),
        ({"law": ContactLaw(1.0, np.nan)}, "a contact law needs"),
        ({"law": ContactLaw(np.inf)}, "a contact law needs"),
        ({"law": ContactLaw(1.0, friction=-0.1)}, "a contact law needs"),
        ({"walls": [SoftPlane(0, 1, 0.0, ContactLaw(-1.0))]}, "a contact law needs"),
        ({"cylinder": SoftCylinder(2.0, (0.0, 0.0), ContactLaw(1.0, friction=np.nan))}, "a contact law needs"),
    ],
)
def test_bad_arguments_are_named(change, message):
    with pytest.raises(ValueError, match=message):
        grains(**(GOOD_ARGUMENTS | change))


@pytest.mark.parametrize(
    "change",
    [
        {"skin": -0.2},
        {"skin": np.nan},
        {"lengths": [np.nan, 9.0]},
        {"lengths": [-9.0, 9.0]},
        {"lengths": [0.0, 9.0]},
        {"gravity": (np.nan, 0.0)},
        {"walls": [SoftPlane(2, 1, 0.0, ContactLaw(1.0))]},
        {"walls": [SoftPlane(0, 3, 0.0, ContactLaw(1.0))]},
        {"walls": [SoftPlane(0, 1, np.nan, ContactLaw(1.0))]},
        {"cylinder": SoftCylinder(-1.0, (0.0, 0.0), ContactLaw(1.0))},
        {"cylinder": SoftCylinder(1.0, (0.0, 0.0), ContactLaw(1.0), axis=1)},
    ],
)
def test_numbers_out_of_range_are_refused(change):
    with pytest.raises(ValueError, match=r"."):
        grains(**(GOOD_ARGUMENTS | change))
